//! Curves and points over two axes, for pages that are not about time.

use super::axis::{Axis, grid};
use super::text::{escape, px};

const WIDTH: f64 = 1000.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 924.0;
const TOP: f64 = 30.0;
const FOOT: f64 = 42.0;
/// Colours there are, `c0` to `c5` in the style sheet.
const COLOURS: usize = 6;
/// Height of a line of the legend.
const LEGEND: f64 = 18.0;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Joined; a value that is not finite breaks the line.
    Line,
    /// Joined and dashed.
    Dashes,
    /// Dots.
    Dots,
}

/// One series.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// What the legend calls it; empty: it is not in the legend.
    pub name: String,
    /// Points; those outside the axes are left out.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub mark: Mark,
    /// Number of its colour; series of one case share one.
    pub colour: usize,
}

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
    /// The figure as HTML.
    pub fn figure(&self) -> String {
        let named = self.series.iter().filter(|s| !s.name.is_empty());
        let legend = LEGEND * named.clone().count().div_ceil(2) as f64;
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
                LEFT + 430.0 * (k % 2) as f64,
                TOP + LEGEND * (k / 2) as f64 + 4.0,
            );
            put!(
                svg,
                r#"{}<text x="{}" y="{}" class="legend">{}</text>"#,
                sample(s, at),
                px(at.0 + 34.0),
                px(at.1 + 4.0),
                escape(&s.name)
            );
        }
        grid(&mut svg, (&x, 10), (&y, 6));
        for s in &self.series {
            svg.push_str(&drawn(s, &x, &y));
        }
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

fn class(s: &Series) -> String {
    let dashed = if s.mark == Mark::Dashes {
        " dashed"
    } else {
        ""
    };
    let kind = if s.mark == Mark::Dots {
        "dots"
    } else {
        "curve"
    };
    format!("{kind} c{}{dashed}", s.colour % COLOURS)
}

fn sample(s: &Series, (x, y): (f64, f64)) -> String {
    let class = class(s);
    match s.mark {
        Mark::Dots => format!(r#"<path class="{class}" d="{}"/>"#, dot(x + 15.0, y)),
        _ => format!(r#"<path class="{class}" d="M{} {}h28"/>"#, px(x), px(y)),
    }
}

fn dot(x: f64, y: f64) -> String {
    format!("M{} {}a3 3 0 1 0 6 0a3 3 0 1 0 -6 0z", px(x - 3.0), px(y))
}

fn drawn(s: &Series, x: &Axis, y: &Axis) -> String {
    let mut d = String::new();
    let mut joined = false;
    for &(a, b) in &s.points {
        let seen = x.holds(a) && y.holds(b);
        if seen && s.mark == Mark::Dots {
            d.push_str(&dot(x.at(a), y.at(b)));
        } else if seen {
            put!(
                d,
                "{}{} {}",
                if joined { 'L' } else { 'M' },
                px(x.at(a)),
                px(y.at(b))
            );
        }
        joined = seen;
    }
    format!(r#"<path class="{}" d="{d}"/>"#, class(s))
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
            (2, 1),
            "{d}"
        );
        let dots = html.rsplit("dots c1\" d=\"").next().expect("the dots");
        assert_eq!(dots[..dots.find('"').expect("end")].matches('z').count(), 3);
    }
}
