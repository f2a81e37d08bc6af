//! Small tests of the parts; what the whole finds in a plant: `tests/changes.rs`.

use super::change::{above, threshold};

#[test]
fn chances_are_those_of_the_tables() {
    // Quantiles of χ² as every table prints them.
    for (x, degrees, chance) in [
        (3.841, 1, 0.05),
        (6.635, 1, 0.01),
        (7.815, 3, 0.05),
        (16.266, 3, 0.001),
    ] {
        let found = above(x, degrees);
        assert!(
            (found / chance - 1.0).abs() < 2e-3,
            "{x} {degrees}: {found}"
        );
    }
}

#[test]
fn fewer_false_changes_need_more_evidence() {
    let usual = threshold(0.02, 26.0, 26, 1);
    assert!(threshold(0.002, 26.0, 26, 1) > usual);
    assert!(threshold(0.02, 26.0, 26, 3) > usual);
    let sum = above(usual, 1) * 26.0 * 26.0 * 2.0;
    assert!((sum - 0.02).abs() < 1e-6, "{sum}");
}
