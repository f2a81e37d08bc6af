//! Curves and points over two axes, for pages that are not about time.

use super::axis::{Axis, grid};
use super::palette;
use super::scene::APART;
use super::text::{escape, px};

const WIDTH: f64 = 1000.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 924.0;
const TOP: f64 = 30.0;
const FOOT: f64 = 42.0;
/// Letters of a name that fit into half of the width.
const HALF: usize = 58;
/// Letters of a name that fit right of the plot.
const MARGIN: usize = 10;
/// Height of a line of the legend.
const LEGEND: f64 = 18.0;

pub use super::series::{Mark, Series};

/// One axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// Name with unit.
    pub name: String,
    /// Ends.
    pub range: (f64, f64),
    /// Logarithmic.
    pub log: bool,
}

impl Scale {
    /// A linear axis.
    pub fn linear(name: &str, low: f64, high: f64) -> Self {
        Self {
            name: name.to_owned(),
            range: (low, high),
            log: false,
        }
    }

    /// A logarithmic axis.
    pub fn log(name: &str, low: f64, high: f64) -> Self {
        Self {
            log: true,
            ..Self::linear(name, low, high)
        }
    }

    fn axis(&self, from: f64, to: f64) -> Axis {
        let (low, high) = self.range;
        if self.log {
            Axis::log(low, high, from, to)
        } else {
            Axis::linear(low, high, from, to)
        }
    }
}

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Horizontal axis.
    pub x: Scale,
    /// Vertical axis.
    pub y: Scale,
    /// Height of the plot, pixels.
    pub height: f64,
    /// What is drawn.
    pub series: Vec<Series>,
    /// What is to be seen, and what it does not show.
    pub caption: String,
}

impl Chart {
    /// Whether a series has its name at its end instead of in the legend: one of an order that
    /// goes to the right edge, if there is room for it.
    fn labelled(&self, s: &Series) -> bool {
        palette::ordered(s.colour)
            && s.name.chars().count() <= MARGIN
            && s.points
                .last()
                .is_some_and(|p| p.0 > self.x.range.0 + 0.97 * (self.x.range.1 - self.x.range.0))
    }

    /// Names of series in an order, right of their ends; those that would overlap are moved down.
    fn end_labels(&self, svg: &mut String, x: &Axis, y: &Axis) {
        let those = self.series.iter().filter(|s| s.named() && self.labelled(s));
        let mut ends: Vec<(f64, &str)> = those
            .filter_map(|s| Some((s.points.last()?, s.name.as_str())))
            .filter(|(p, _)| x.holds(p.0) && y.holds(p.1))
            .map(|(p, name)| (y.at(p.1), name))
            .collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut next = f64::MIN;
        for (at, name) in ends {
            let at = at.max(next);
            next = at + APART;
            put!(
                svg,
                r#"<text x="{}" y="{}" class="small">{}</text>"#,
                px(RIGHT + 7.0),
                px(at + 4.0),
                escape(name)
            );
        }
    }

    /// The figure as HTML.
    pub fn figure(&self) -> String {
        let named = self
            .series
            .iter()
            .filter(|s| s.named() && !self.labelled(s));
        let longest = named.clone().map(|s| s.name.chars().count()).max();
        let columns = if longest.unwrap_or(0) > HALF { 1 } else { 2 };
        let legend = LEGEND * named.clone().count().div_ceil(columns) as f64;
        let marked = self.series.iter().filter(|s| s.wants_marks()).count() > 1;
        let top = TOP + legend;
        let bottom = top + self.height;
        let (x, y) = (self.x.axis(LEFT, RIGHT), self.y.axis(bottom, top));
        let mut svg = String::new();
        put!(
            svg,
            r#"<text x="{LEFT}" y="18" class="title">{}</text>"#,
            escape(&self.title)
        );
        for (k, s) in named.enumerate() {
            let at = (
                LEFT + 430.0 * (k % columns) as f64,
                TOP + LEGEND * (k / columns) as f64 + 4.0,
            );
            put!(
                svg,
                r#"{}<text x="{}" y="{}" class="legend">{}</text>"#,
                s.sample(at, marked),
                px(at.0 + 34.0),
                px(at.1 + 4.0),
                escape(&s.name)
            );
        }
        grid(&mut svg, (&x, 10), (&y, 6));
        for s in &self.series {
            svg.push_str(&s.drawn(&x, &y, marked));
        }
        self.end_labels(&mut svg, &x, &y);
        put!(
            svg,
            r#"<rect class="frame" x="{LEFT}" y="{}" width="{}" height="{}"/><text class="name" x="{}" y="{}" text-anchor="middle">{}</text><text class="name" text-anchor="middle" transform="translate(18 {}) rotate(-90)">{}</text>"#,
            px(top),
            px(RIGHT - LEFT),
            px(self.height),
            px(0.5 * (LEFT + RIGHT)),
            px(bottom + 36.0),
            escape(&self.x.name),
            px(0.5 * (top + bottom)),
            escape(&self.y.name)
        );
        format!(
            "<figure><div class=\"scroll\"><svg viewBox=\"0 0 {WIDTH} {}\" role=\"img\" aria-label=\"{}\">{svg}</svg></div><figcaption>{}</figcaption></figure>\n",
            px(bottom + FOOT),
            escape(&format!("{}. {}", self.title, self.caption)),
            escape(&self.caption)
        )
    }
}

/// A page of headed figures and tables, in the same dress as a run's report.
///
/// `body` is HTML.
pub fn sheet(title: &str, headline: &str, body: &str, version: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<header>\n<p class=\"job\">{title}</p>\n<h1>{headline}</h1>\n</header>\n<main>\n{body}</main>\n<footer><p>rarma {version}</p></footer>\n</body>\n</html>\n",
        title = escape(title),
        headline = escape(headline),
        style = include_str!("style.css"),
        version = escape(version),
    )
}

/// A table; cells are plain text.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut html = String::from("<div class=\"scroll\"><table>\n<thead><tr>");
    for h in head {
        put!(html, "<th scope=\"col\">{}</th>", escape(h));
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in rows {
        html.push_str("<tr>");
        for cell in row {
            put!(html, "<td>{}</td>", escape(cell));
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table></div>\n");
    html
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_at_the_ends_are_all_there_and_do_not_overlap() {
        let line = |k: usize| Series {
            name: format!("line {k}"),
            points: vec![(0.0, 1.0), (4.0, 1.0 + 0.01 * k as f64)],
            mark: Mark::Line,
            colour: palette::step(k, 5),
        };
        let chart = Chart {
            title: "T".to_owned(),
            x: Scale::linear("x", 0.0, 4.0),
            y: Scale::linear("y", 0.0, 3.0),
            height: 100.0,
            series: (0..5).map(line).collect(),
            caption: "c".to_owned(),
        };
        let html = chart.figure();
        let places: Vec<f64> = html
            .split(r#"<text x="931" y=""#)
            .skip(1)
            .filter_map(|rest| rest.split('"').next()?.parse().ok())
            .collect();
        assert_eq!(places.len(), 5, "{html}");
        assert!(
            places.windows(2).all(|w| w[1] - w[0] >= APART),
            "{places:?}"
        );
        assert!(!html.contains("class=\"legend\""), "none is named twice");
    }

    #[test]
    fn lines_break_where_there_is_nothing_and_dots_stay_inside() {
        let series = |mark| Series {
            name: "a & b".to_owned(),
            points: vec![
                (0.0, 1.0),
                (1.0, 2.0),
                (2.0, f64::NAN),
                (3.0, 1.0),
                (4.0, 99.0),
            ],
            mark,
            colour: 7,
        };
        let chart = Chart {
            title: "T".to_owned(),
            x: Scale::linear("x", 0.0, 4.0),
            y: Scale::linear("y", 0.0, 3.0),
            height: 100.0,
            series: vec![series(Mark::Line), series(Mark::Dots)],
            caption: "c".to_owned(),
        };
        let html = chart.figure();
        assert!(html.contains("a &amp; b") && html.contains("curve c1"));
        let line = html
            .split("curve c1\" d=\"")
            .nth(2)
            .expect("the drawn line");
        let d = &line[..line.find('"').expect("end")];
        assert_eq!(
            (d.matches('M').count(), d.matches('L').count()),
            (2, 2),
            "{d}"
        );
        let dots = html.rsplit("dots c1\" d=\"").next().expect("the dots");
        assert_eq!(dots[..dots.find('"').expect("end")].matches('z').count(), 3);
    }
}
