//! Promise: docs/bench.md shows every bar that this version misses, asked against got.

use host_tests::{bars, page};

#[test]
fn page_holds_the_missed_bars() {
    page::holds("docs/bench.md", "bars", &bars::markdown());
}
