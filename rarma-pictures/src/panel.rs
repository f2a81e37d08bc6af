//! The frame that pictures over one time share: title line, axes, tinted spans, a marked instant.
//!
//! All pictures have the same width and margins, so that one instant lies on
//! one vertical line down the page. They are written as SVG by hand and not by
//! `plotters`, because colours must follow the page (dark, light, print) by
//! style sheet, which a drawing library that writes colours out cannot offer.

use super::axis::Axis;
use super::text::{escape, px};

/// Width of every picture, in its own pixels.
const WIDTH: f64 = 1000.0;
/// Left edge of every plot.
pub const LEFT: f64 = 84.0;
/// Right edge of every plot.
pub const RIGHT: f64 = 924.0;
/// Top edge of every plot; titles stand above it.
pub const TOP: f64 = 30.0;
/// Room for the time axis below the plot.
const FOOT: f64 = 42.0;

/// Distance of two labels above each other at which both can be read, pixels.
pub const APART: f64 = 13.0;

/// Narrower spans have no edges of their own, which would hide what is in them, pixels.
const EDGED: f64 = 8.0;

/// The time that the pictures of a page share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Time<'a> {
    /// Its beginning, s.
    pub start_s: f64,
    /// Its end, s.
    pub end_s: f64,
    /// Spans that are tinted in every picture, from and to, s.
    pub spans: &'a [(f64, f64)],
    /// An instant that is marked in every picture, s.
    pub mark_s: Option<f64>,
}

/// One picture over time on its way to SVG.
#[derive(Debug)]
pub struct Panel<'a> {
    time: Time<'a>,
    /// Bottom edge of the plot.
    pub bottom: f64,
    /// Time axis.
    pub x: Axis,
    svg: String,
}

impl<'a> Panel<'a> {
    /// An empty picture with a plot of `height`, entitled `title`.
    pub fn new(time: Time<'a>, height: f64, title: &str) -> Self {
        let mut panel = Self {
            time,
            bottom: TOP + height,
            x: Axis::linear(time.start_s, time.end_s, LEFT, RIGHT),
            svg: String::new(),
        };
        panel.label(LEFT, TOP - 11.0, "title", "start", title);
        panel
    }

    /// Adds markup.
    pub fn add(&mut self, markup: &str) {
        self.svg.push_str(markup);
    }

    /// Adds a text; `anchor` is start, middle or end.
    pub fn label(&mut self, x: f64, y: f64, class: &str, anchor: &str, text: &str) {
        put!(
            self.svg,
            r#"<text x="{}" y="{}" class="{class}" text-anchor="{anchor}">{}</text>"#,
            px(x),
            px(y),
            escape(text)
        );
    }

    /// A label in the margin right of the plot, level with `y`.
    pub fn margin(&mut self, y: f64, class: &str, text: &str) {
        self.label(RIGHT + 7.0, y + 4.0, class, "start", text);
    }

    /// A straight line across the plot.
    pub fn level(&mut self, y: f64, class: &str) {
        put!(
            self.svg,
            r#"<path class="{class}" d="M{LEFT} {}H{RIGHT}"/>"#,
            px(y)
        );
    }

    /// Time grid, and value grid with labels and a name along the left.
    pub fn axes(&mut self, y: &Axis, ticks: usize, name: &str) {
        for value in if name.contains('%') {
            y.between_decades()
        } else {
            Vec::new()
        } {
            put!(
                self.svg,
                r#"<path class="tick" d="M{LEFT} {}h-3"/>"#,
                px(y.at(value))
            );
        }
        for (value, label) in y.ticks(ticks) {
            self.level(y.at(value), "grid");
            self.label(LEFT - 8.0, y.at(value) + 4.0, "number", "end", &label);
        }
        put!(
            self.svg,
            r#"<text class="name" text-anchor="middle" transform="translate(18 {}) rotate(-90)">{}</text>"#,
            px(0.5 * (TOP + self.bottom)),
            escape(name)
        );
    }

    /// The spans, below whatever is drawn next.
    pub fn spans(&mut self) {
        for &(on, off) in self.time.spans {
            let (x0, x1) = (self.x.at(on), self.x.at(off));
            put!(
                self.svg,
                r#"<rect class="span" x="{}" y="{TOP}" width="{}" height="{}"/>"#,
                px(x0),
                px((x1 - x0).max(1.0)),
                px(self.bottom - TOP)
            );
        }
    }

    /// Edges of the spans and the marked instant, above the rest, and the
    /// closing frame with the time axis.
    fn close(&mut self) {
        for &(on, off) in self.time.spans {
            let (x0, x1) = (self.x.at(on), self.x.at(off));
            if x1 - x0 >= EDGED {
                put!(
                    self.svg,
                    r#"<path class="edge" d="M{} {TOP}V{b}M{} {TOP}V{b}"/>"#,
                    px(x0),
                    px(x1),
                    b = px(self.bottom),
                );
            }
            put!(
                self.svg,
                r#"<path class="bar" d="M{} {}H{}"/>"#,
                px(x0),
                px(TOP - 2.5),
                px(x1.max(x0 + 1.0)),
            );
        }
        if let Some(onset) = self.time.mark_s {
            put!(
                self.svg,
                r#"<path class="truth-case" d="M{x} {TOP}V{b}"/><path class="truth" d="M{x} {}V{b}"/>"#,
                px(TOP - 5.0),
                x = px(self.x.at(onset)),
                b = px(self.bottom),
            );
        }
        put!(
            self.svg,
            r#"<rect class="frame" x="{LEFT}" y="{TOP}" width="{}" height="{}"/>"#,
            px(RIGHT - LEFT),
            px(self.bottom - TOP)
        );
        for (value, label) in self.x.ticks(10) {
            let x = self.x.at(value);
            put!(
                self.svg,
                r#"<path class="tick" d="M{} {}v5"/>"#,
                px(x),
                px(self.bottom)
            );
            self.label(x, self.bottom + 18.0, "number", "middle", &label);
        }
        let middle = 0.5 * (LEFT + RIGHT);
        self.label(middle, self.bottom + 36.0, "name", "middle", "time (s)");
    }

    /// The whole figure. `alt` says in words what is to be seen, `caption` how
    /// it was drawn; neither may hold markup.
    pub fn finish(mut self, alt: &str, caption: &str) -> String {
        self.close();
        format!(
            "<figure><div class=\"scroll\"><svg viewBox=\"0 0 {WIDTH} {}\" role=\"img\" \
             aria-label=\"{}\">{}</svg></div><figcaption>{}</figcaption></figure>\n",
            px(self.bottom + FOOT),
            escape(alt),
            self.svg,
            escape(caption)
        )
    }

    /// Legend entries in the title line, against the right edge. Each is a mark,
    /// drawn around the origin, and a text.
    pub fn legend(&mut self, entries: &[(String, &str)]) {
        // Text is measured by its length: 6.6 pixels a letter are on the safe
        // side for the fonts asked for.
        let width = |text: &str| 6.6 * text.chars().count() as f64 + 44.0;
        let total: f64 = entries.iter().map(|(_, text)| width(text)).sum();
        let mut x = RIGHT + 16.0 - total;
        for (mark, text) in entries {
            put!(
                self.svg,
                r#"<g transform="translate({} {})">{mark}</g>"#,
                px(x + 12.0),
                px(TOP - 15.5)
            );
            self.label(x + 28.0, TOP - 11.0, "legend", "start", text);
            x += width(text);
        }
    }
}

/// Whether a label at `at` overlaps none of those already there.
pub fn free(taken: &[f64], at: f64) -> bool {
    taken.iter().all(|other| (other - at).abs() >= APART)
}
