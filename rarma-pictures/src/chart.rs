//! Curves and points over two axes, for pages that are not about time.

use super::axis::{Axis, grid};
use super::palette;
use super::panel::APART;
use super::series::Series;
use super::text::{escape, px};

const TOP: f64 = 30.0;
const FOOT: f64 = 42.0;
/// A letter of the legend on the safe side for the fonts asked for, and what stands beside a name.
const LETTER: f64 = 6.6;
const SAMPLE: f64 = 54.0;
/// Letters of a name that fit right of the plot.
const MARGIN: usize = 10;
/// Height of a line of the legend.
const LEGEND: f64 = 18.0;

/// How wide a picture is, and where its plot lies in it, pixels; about how many ticks go along.
#[derive(Debug, Clone, Copy)]
struct Layout {
    width: f64,
    left: f64,
    right: f64,
    ticks: usize,
}

/// Over the whole width of a page.
const WIDE: Layout = Layout {
    width: 1000.0,
    left: 84.0,
    right: 924.0,
    ticks: 10,
};

/// Three of them beside each other.
const SMALL: Layout = Layout {
    width: 400.0,
    left: 62.0,
    right: 388.0,
    ticks: 5,
};

/// One axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// Name with unit.
    pub name: String,
    /// Ends.
    pub range: (f64, f64),
    /// Logarithmic.
    pub log: bool,
    /// Only whole numbers mean anything.
    pub counted: bool,
}

impl Scale {
    /// A linear axis.
    pub fn linear(name: &str, low: f64, high: f64) -> Self {
        Self {
            name: name.to_owned(),
            range: (low, high),
            log: false,
            counted: false,
        }
    }

    /// An axis of whole numbers.
    pub fn counted(name: &str, low: f64, high: f64) -> Self {
        Self {
            counted: true,
            ..Self::linear(name, low, high)
        }
    }

    /// A logarithmic axis.
    pub fn log(name: &str, low: f64, high: f64) -> Self {
        Self {
            log: true,
            ..Self::linear(name, low, high)
        }
    }

    /// How many ticks it should have of so many, so that their step is whole where it must be.
    fn ticks(&self, wanted: usize) -> usize {
        if self.counted {
            wanted.min((self.range.1 - self.range.0).max(1.0) as usize)
        } else {
            wanted
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
    fn end_labels(&self, svg: &mut String, x: &Axis, y: &Axis, right: f64) {
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
                px(right + 7.0),
                px(at + 4.0),
                escape(name)
            );
        }
    }

    /// The figure as HTML.
    pub fn figure(&self) -> String {
        self.laid_out(WIDE)
    }

    /// The same as [`Self::figure`] with less than half of its width, for few points.
    pub fn small_figure(&self) -> String {
        self.laid_out(SMALL)
    }

    fn laid_out(&self, layout: Layout) -> String {
        let Layout {
            width,
            left,
            right,
            ticks,
        } = layout;
        let named = self
            .series
            .iter()
            .filter(|s| s.named() && !self.labelled(s));
        let longest = named.clone().map(|s| s.name.chars().count()).max();
        let column = SAMPLE + LETTER * longest.unwrap_or(0) as f64;
        // Names come in pairs, or not: two of a pair stay beside each other.
        let columns = [4, 2]
            .into_iter()
            .find(|n| *n as f64 * column <= right - left)
            .unwrap_or(1);
        let legend = LEGEND * named.clone().count().div_ceil(columns) as f64;
        let marked = self.series.iter().filter(|s| s.wants_marks()).count() > 1;
        let top = TOP + legend;
        let bottom = top + self.height;
        let (x, y) = (self.x.axis(left, right), self.y.axis(bottom, top));
        let mut svg = String::new();
        put!(
            svg,
            r#"<text x="{left}" y="18" class="title">{}</text>"#,
            escape(&self.title)
        );
        for (k, s) in named.enumerate() {
            let at = (
                left + column * (k % columns) as f64,
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
        grid(&mut svg, (&x, self.x.ticks(ticks)), (&y, 6));
        for s in &self.series {
            svg.push_str(&s.drawn(&x, &y, marked));
        }
        self.end_labels(&mut svg, &x, &y, right);
        put!(
            svg,
            r#"<rect class="frame" x="{left}" y="{}" width="{}" height="{}"/><text class="name" x="{}" y="{}" text-anchor="middle">{}</text><text class="name" text-anchor="middle" transform="translate(18 {}) rotate(-90)">{}</text>"#,
            px(top),
            px(right - left),
            px(self.height),
            px(0.5 * (left + right)),
            px(bottom + 36.0),
            escape(&self.x.name),
            px(0.5 * (top + bottom)),
            escape(&self.y.name)
        );
        format!(
            "<figure><div class=\"scroll\"><svg viewBox=\"0 0 {width} {}\" role=\"img\" aria-label=\"{}\">{svg}</svg></div><figcaption>{}</figcaption></figure>\n",
            px(bottom + FOOT),
            escape(&format!("{}. {}", self.title, self.caption)),
            escape(&self.caption)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::series::Mark;
    use super::*;

    #[test]
    fn whole_numbers_have_whole_ticks_and_short_names_share_a_row() {
        let chart = |n: usize, name: &str| Chart {
            title: "T".to_owned(),
            x: Scale::counted("rank", 0.5, n as f64 + 0.5),
            y: Scale::linear("y", 0.0, 3.0),
            height: 100.0,
            series: (0..4)
                .map(|k| Series::new(&format!("{name} {k}"), vec![(1.0, 1.0)], Mark::Dots, k))
                .collect(),
            caption: "c".to_owned(),
        };
        for n in [1, 2, 3, 9, 40] {
            let html = chart(n, "a").figure();
            let (_, ticks) = html.split_once("<path class=\"tick\"").expect("ticks");
            assert!(ticks.contains(">1</text>") || n > 9, "{n}: {ticks}");
            assert!(!ticks.contains(".5</text>"), "{n}: {ticks}");
        }
        let rows = |name: &str| {
            let html = chart(2, name).figure();
            let tops: std::collections::BTreeSet<&str> = html
                .split("class=\"legend\"")
                .filter_map(|before| before.rsplit_once(" y=\"")?.1.strip_suffix("\" "))
                .collect();
            tops.len()
        };
        assert_eq!(rows("short"), 1);
        assert_eq!(rows(&"l".repeat(40)), 2);
        assert_eq!(rows(&"l".repeat(80)), 4);
    }

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
