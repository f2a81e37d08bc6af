//! The colours of curves. Here they are numbers and classes; what a class looks like on a
//! screen, in the dark and on paper stands in one place, the top of `style.css`.
//!
//! Those of unrelated curves are told apart by the colour-blind (Okabe and Ito's set), and
//! each has a mark of its own shape, so that a black and white print does. Those of curves in
//! an order, such as rising loads, run from pale to dark in one hue.

use super::text::px;

/// Colours of unrelated curves; more of them begin anew.
const UNRELATED: usize = 6;
/// From here on numbers are steps of the scale for curves in an order.
const ORDERED: usize = 100;
/// Steps there are.
const STEPS: usize = 8;

/// The colour of the `k`-th of `n` curves in an order.
pub fn step(k: usize, n: usize) -> usize {
    ORDERED + k * (STEPS - 1) / n.saturating_sub(1).max(1)
}

/// Its class in the style sheet.
pub(super) fn class(colour: usize) -> String {
    match colour.checked_sub(ORDERED) {
        Some(step) => format!("s{}", step.min(STEPS - 1)),
        None => format!("c{}", colour % UNRELATED),
    }
}

/// Whether it is a step of the scale.
pub(super) fn ordered(colour: usize) -> bool {
    colour >= ORDERED
}

/// The outline of a colour's mark about a place, a few pixels wide.
pub(super) fn mark(colour: usize, x: f64, y: f64) -> String {
    let at = |dx: f64, dy: f64| format!("{} {}", px(x + dx), px(y + dy));
    match colour % UNRELATED {
        0 => format!(
            "M{}a3.2 3.2 0 1 0 6.4 0a3.2 3.2 0 1 0 -6.4 0z",
            at(-3.2, 0.0)
        ),
        1 => format!("M{}h6v6h-6z", at(-3.0, -3.0)),
        2 => format!("M{}l4 7h-8z", at(0.0, -4.0)),
        3 => format!("M{}l4 4l-4 4l-4 -4z", at(0.0, -4.0)),
        4 => format!("M{}h8l-4 7z", at(-4.0, -3.0)),
        _ => format!(
            "M{}h2.4v2.8h2.8v2.4h-2.8v2.8h-2.4v-2.8h-2.8v-2.4h2.8z",
            at(-1.2, -4.0)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_in_an_order_go_from_the_first_step_to_the_last() {
        for n in [1, 2, 8, 30] {
            let classes: Vec<String> = (0..n).map(|k| class(step(k, n))).collect();
            assert_eq!(classes[0], "s0");
            assert!(n == 1 || classes[n - 1] == "s7", "{classes:?}");
            assert!(classes.is_sorted(), "{classes:?}");
        }
        assert_eq!(class(7), "c1");
    }

    #[test]
    fn every_class_has_its_colour_and_every_colour_its_own_mark() {
        let style = include_str!("style.css");
        for colour in (0..UNRELATED).chain(ORDERED..ORDERED + STEPS) {
            let class = class(colour);
            assert!(style.contains(&format!("--{class}:")), "{class}");
            assert!(style.contains(&format!(".{class} {{")), "{class}");
        }
        let marks: std::collections::BTreeSet<String> =
            (0..UNRELATED).map(|c| mark(c, 0.0, 0.0)).collect();
        assert_eq!(marks.len(), UNRELATED);
    }
}
