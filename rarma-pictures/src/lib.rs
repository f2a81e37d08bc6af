//! Pictures and pages as text: curves, maps, polar diagrams, bars and tables, in SVG inside HTML that loads
//! nothing from elsewhere and follows dark mode and print by one style sheet.
//!
//! Nothing here knows what is drawn: values come with names and units, and leave as a figure.
//!
//! | figure | what it shows |
//! |---|---|
//! | [`Chart`] | series over two axes, linear or logarithmic |
//! | [`Map`] | levels over two axes |
//! | [`Polar`] | quantities all round |
//! | [`Bars`] | parts of a whole |
//! | [`Panel`] | anything over a [`Time`] that several pictures share |
//!
//! [`sheet`] makes a page of them, [`table`] a table; [`text`] writes numbers with their units and keeps what comes
//! from outside from being markup; [`palette`] tells curves apart, also for the colour-blind and in print.
//!
//! ```
//! use rarma_pictures::{Chart, Mark, Scale, Series, sheet};
//!
//! let decay = (0..=100).map(|k| f64::from(k) / 100.0).map(|t| (t, (-5.0 * t).exp())).collect();
//! let chart = Chart {
//!     title: "A vibration dies away".into(),
//!     x: Scale::linear("time (s)", 0.0, 1.0),
//!     y: Scale::linear("amplitude (µm)", 0.0, 1.0),
//!     height: 200.0,
//!     series: vec![Series::new("envelope", decay, Mark::Line, 0)],
//!     caption: "Its envelope.".into(),
//! };
//! let page = sheet("Decay", "It is damped", &chart.figure(), "0.1.0");
//! assert!(page.starts_with("<!doctype html>") && page.contains("<svg"));
//! ```

/// Writes into a `String`, which cannot fail.
#[macro_export]
macro_rules! put {
    ($out:expr, $($what:tt)*) => {{
        use std::fmt::Write as _;
        let _ = write!($out, $($what)*);
    }};
}

mod axis;
mod bars;
mod chart;
mod colours;
mod map;
mod page;
pub mod palette;
mod panel;
mod polar;
mod series;
pub mod text;

pub use axis::{Axis, grid};
pub use bars::{Bar, Bars};
pub use chart::{Chart, Scale};
pub use colours::{SHADES, bitmap, gradient_stops};
pub use map::Map;
pub use page::{STYLE, sheet, table};
pub use panel::{APART, LEFT, Panel, RIGHT, TOP, Time, free};
pub use polar::{Polar, PolarSeries};
pub use series::{Mark, Series};
