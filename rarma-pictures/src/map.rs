//! Levels over two axes as a bitmap, for pages that are not about time.

use super::axis::{Axis, grid};
use super::colours::{SHADES, bitmap};
use super::text::{escape, px};

const WIDTH: f64 = 1000.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 924.0;
const TOP: f64 = 30.0;
const FOOT: f64 = 42.0;

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Title.
    pub title: String,
    /// Name with unit and ends of the horizontal axis.
    pub x: (String, f64, f64),
    /// The same of the vertical axis.
    pub y: (String, f64, f64),
    /// Height of the plot, pixels.
    pub height: f64,
    /// Columns of the levels.
    pub columns: usize,
    /// Levels row by row from the top.
    pub level: Vec<f64>,
    /// Lines drawn over it, in the axes' units.
    pub lines: Vec<[(f64, f64); 2]>,
    /// What is to be seen, and what it does not show.
    pub caption: String,
}

impl Map {
    /// The figure as HTML; dark to bright from the lowest twentieth to the highest level.
    pub fn figure(&self) -> String {
        let mut sorted: Vec<f64> = self
            .level
            .iter()
            .copied()
            .filter(|l| l.is_finite())
            .collect();
        sorted.sort_by(f64::total_cmp);
        let (Some(low), Some(high)) = (sorted.get(sorted.len() / 20), sorted.last()) else {
            return String::new();
        };
        let span = (high - low).max(1e-12);
        let shades: Vec<u8> = self
            .level
            .iter()
            .map(|v| (((v - low) / span).clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as u8)
            .collect();
        let rows = self.level.len() / self.columns.max(1);
        let Some(data) = bitmap(self.columns, rows, &shades[..rows * self.columns]) else {
            return String::new();
        };
        let bottom = TOP + self.height;
        let x = Axis::linear(self.x.1, self.x.2, LEFT, RIGHT);
        let y = Axis::linear(self.y.1, self.y.2, bottom, TOP);
        let mut svg = String::new();
        put!(
            svg,
            r#"<text x="{LEFT}" y="18" class="title">{}</text>"#,
            escape(&self.title)
        );
        grid(&mut svg, (&x, 10), (&y, 6));
        put!(
            svg,
            r#"<image class="inks" x="{LEFT}" y="{TOP}" width="{}" height="{}" preserveAspectRatio="none" aria-hidden="true" href="{data}"/>"#,
            px(RIGHT - LEFT),
            px(self.height)
        );
        for [from, to] in &self.lines {
            put!(
                svg,
                r#"<path class="multiple" d="M{} {}L{} {}"/>"#,
                px(x.at(from.0)),
                px(y.at(from.1)),
                px(x.at(to.0)),
                px(y.at(to.1))
            );
        }
        put!(
            svg,
            r#"<rect class="frame" x="{LEFT}" y="{TOP}" width="{}" height="{}"/><text class="name" x="{}" y="{}" text-anchor="middle">{}</text><text class="name" text-anchor="middle" transform="translate(18 {}) rotate(-90)">{}</text>"#,
            px(RIGHT - LEFT),
            px(self.height),
            px(0.5 * (LEFT + RIGHT)),
            px(bottom + 36.0),
            escape(&self.x.0),
            px(0.5 * (TOP + bottom)),
            escape(&self.y.0)
        );
        let ends = format!("{low:.0} to {high:.0} dB").replace('-', "−");
        let caption = format!("{} Dark to bright: {ends}.", self.caption);
        format!(
            "<figure><div class=\"scroll\"><svg viewBox=\"0 0 {WIDTH} {}\" role=\"img\" aria-label=\"{}\">{svg}</svg></div><figcaption>{}</figcaption></figure>\n",
            px(bottom + FOOT),
            escape(&format!("{}. {caption}", self.title)),
            escape(&caption)
        )
    }
}
