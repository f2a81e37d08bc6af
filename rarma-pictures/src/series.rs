//! One series of a chart: its path, and its sample in the legend.

use super::axis::Axis;
use super::palette;
use super::text::{escape, px};

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Joined, and cut where it leaves the plot; a value that is not finite breaks the line.
    Line,
    /// Joined and dashed, likewise.
    Dashes,
    /// Dots.
    Dots,
    /// Everything above the curve is tinted; a value that is not finite lies above the plot.
    Above,
    /// Everything below it, likewise.
    Below,
    /// One place, ringed.
    Place,
    /// The series' name, written at its first point; not in the legend.
    Word,
}

/// One series.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// What the legend calls it; empty: it is not in the legend.
    pub name: String,
    /// Points; dots outside the axes are left out.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub mark: Mark,
    /// Number of its colour ([`palette`]); series of one case share one.
    pub colour: usize,
}

impl Series {
    /// A series of these points.
    pub fn new(name: &str, points: Vec<(f64, f64)>, mark: Mark, colour: usize) -> Self {
        Self {
            name: name.to_owned(),
            points,
            mark,
            colour,
        }
    }
}

/// Distance of a line's marks, and by how much those of the next colour are moved, pixels.
const APART: f64 = 150.0;
const MOVED: f64 = 24.0;

impl Series {
    /// Whether it stands in the legend.
    pub(super) fn named(&self) -> bool {
        !self.name.is_empty() && self.mark != Mark::Word
    }

    fn joined(&self) -> bool {
        matches!(self.mark, Mark::Line | Mark::Dashes)
    }

    /// Whether marks along its line would help to tell it from others.
    pub(super) fn wants_marks(&self) -> bool {
        self.joined() && self.named() && !palette::ordered(self.colour)
    }

    fn class(&self) -> String {
        let colour = palette::class(self.colour);
        match self.mark {
            Mark::Line => format!("curve {colour}"),
            Mark::Dashes => format!("curve {colour} dashed"),
            Mark::Dots => format!("dots {colour}"),
            Mark::Above | Mark::Below => format!("area {colour}"),
            Mark::Place => "place".to_owned(),
            Mark::Word => "word".to_owned(),
        }
    }

    /// Its sample for the legend, 28 pixels wide from a place on.
    pub(super) fn sample(&self, (x, y): (f64, f64), marked: bool) -> String {
        let class = self.class();
        let d = match self.mark {
            Mark::Dots => dot(x + 15.0, y),
            Mark::Place => ring(x + 14.0, y),
            Mark::Above | Mark::Below => format!("M{} {}h28v10h-28z", px(x), px(y - 5.0)),
            Mark::Line | Mark::Dashes | Mark::Word => format!("M{} {}h28", px(x), px(y)),
        };
        let mut svg = format!(r#"<path class="{class}" d="{d}"/>"#);
        if marked && self.wants_marks() {
            svg += &self.shapes(&palette::mark(self.colour, x + 14.0, y));
        }
        svg
    }

    fn shapes(&self, d: &str) -> String {
        format!(
            r#"<path class="dots {}" d="{d}"/>"#,
            palette::class(self.colour)
        )
    }

    /// The series over its axes, with marks along its line where `marked`.
    pub(super) fn drawn(&self, x: &Axis, y: &Axis, marked: bool) -> String {
        let d = match self.mark {
            Mark::Line | Mark::Dashes => line(&self.points, x, y),
            Mark::Above => area(&self.points, x, y, y.at(y.hi())),
            Mark::Below => area(&self.points, x, y, y.at(y.lo())),
            Mark::Dots | Mark::Place => self
                .points
                .iter()
                .filter(|(a, b)| x.holds(*a) && y.holds(*b))
                .map(|(a, b)| match self.mark {
                    Mark::Dots => dot(x.at(*a), y.at(*b)),
                    _ => ring(x.at(*a), y.at(*b)),
                })
                .collect(),
            Mark::Word => return self.word(x, y),
        };
        let mut svg = format!(r#"<path class="{}" d="{d}"/>"#, self.class());
        if marked && self.wants_marks() {
            svg += &self.shapes(&self.along(x, y));
        }
        svg
    }

    fn word(&self, x: &Axis, y: &Axis) -> String {
        self.points.first().map_or(String::new(), |&(a, b)| {
            format!(
                r#"<text class="word" x="{}" y="{}" text-anchor="middle">{}</text>"#,
                px(x.at(a)),
                px(y.at(b)),
                escape(&self.name)
            )
        })
    }

    /// Marks along the line, at the points nearest to even distances.
    fn along(&self, x: &Axis, y: &Axis) -> String {
        let mut d = String::new();
        // Where the last mark stands, and how far away the next one may: a line may run either way.
        let mut last = None;
        let mut apart = 12.0 + MOVED * (self.colour % 6) as f64;
        for &(a, b) in self.points.iter().filter(|p| x.holds(p.0) && y.holds(p.1)) {
            let at = x.at(a);
            if (at - *last.get_or_insert(at)).abs() >= apart {
                d += &palette::mark(self.colour, at, y.at(b));
                (last, apart) = (Some(at), APART);
            }
        }
        d
    }
}

fn dot(x: f64, y: f64) -> String {
    format!("M{} {}a3 3 0 1 0 6 0a3 3 0 1 0 -6 0z", px(x - 3.0), px(y))
}

/// A ring with a cross through it.
fn ring(x: f64, y: f64) -> String {
    format!(
        "M{} {y}a6 6 0 1 0 12 0a6 6 0 1 0 -12 0zM{} {y}h20M{} {}v20",
        px(x - 6.0),
        px(x - 10.0),
        px(x),
        px(y - 10.0),
        y = px(y),
    )
}

/// A place in the picture, pixels.
type Place = (f64, f64);

/// A line, cut at the lower and upper edge of the plot.
fn line(points: &[(f64, f64)], x: &Axis, y: &Axis) -> String {
    let edges = (y.at(y.hi()), y.at(y.lo()));
    let mut d = String::new();
    let mut before: Option<Place> = None;
    let mut pen: Option<Place> = None;
    for &(a, b) in points {
        if !(x.holds(a) && b.is_finite()) {
            before = None;
            continue;
        }
        let here = (x.at(a), y.beyond(b));
        if let Some((from, to)) = before.and_then(|before| cut(before, here, edges)) {
            if pen != Some(from) {
                put!(d, "M{} {}", px(from.0), px(from.1));
            }
            put!(d, "L{} {}", px(to.0), px(to.1));
            pen = Some(to);
        }
        before = Some(here);
    }
    d
}

/// The part of a stroke between two heights.
fn cut(from: Place, to: Place, (top, bottom): (f64, f64)) -> Option<(Place, Place)> {
    let inside = |p: Place| (top..=bottom).contains(&p.1);
    let at = |edge: f64| {
        let share = (edge - from.1) / (to.1 - from.1);
        (from.0 + share * (to.0 - from.0), edge)
    };
    let end = |p: Place| {
        if inside(p) {
            p
        } else if p.1 < top {
            at(top)
        } else {
            at(bottom)
        }
    };
    let apart = (from.1 < top && to.1 < top) || (from.1 > bottom && to.1 > bottom);
    (!apart).then(|| (end(from), end(to)))
}

/// The area from a curve to a height.
fn area(points: &[(f64, f64)], x: &Axis, y: &Axis, edge: f64) -> String {
    let mut seen = points.iter().filter(|p| x.holds(p.0)).peekable();
    let Some(first) = seen.peek() else {
        return String::new();
    };
    let mut d = format!("M{} {}", px(x.at(first.0)), px(edge));
    let mut last = first.0;
    for &(a, b) in seen {
        let value = if b.is_finite() { b } else { y.hi() };
        put!(d, "L{} {}", px(x.at(a)), px(y.at(value)));
        last = a;
    }
    put!(d, "L{} {}z", px(x.at(last)), px(edge));
    d
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(mark: Mark) -> Series {
        Series {
            name: "a".to_owned(),
            points: vec![
                (0.0, 1.0),
                (1.0, 2.0),
                (2.0, f64::NAN),
                (3.0, 1.0),
                (4.0, 5.0),
            ],
            mark,
            colour: 0,
        }
    }

    fn path(mark: Mark) -> String {
        let x = Axis::linear(0.0, 4.0, 0.0, 400.0);
        let y = Axis::linear(0.0, 3.0, 300.0, 0.0);
        let svg = series(mark).drawn(&x, &y, false);
        let d = svg.split("d=\"").nth(1).expect("a path");
        d[..d.find('"').expect("its end")].to_owned()
    }

    #[test]
    fn a_line_is_cut_where_it_leaves_the_plot() {
        // From 1 at 3 to 5 at 4: 3, the top, half way.
        assert_eq!(path(Mark::Line), "M0 200L100 100M300 200L350 0");
    }

    #[test]
    fn an_area_reaches_to_the_edge_of_the_plot() {
        assert_eq!(
            path(Mark::Above),
            "M0 0L0 200L100 100L200 0L300 200L400 0L400 0z"
        );
        assert_eq!(
            path(Mark::Below),
            "M0 300L0 200L100 100L200 0L300 200L400 0L400 300z"
        );
    }

    #[test]
    fn a_line_has_its_marks_whichever_way_it_runs() {
        let axis = || Axis::linear(0.0, 10.0, 0.0, 1000.0);
        let marks = |points: Vec<(f64, f64)>| {
            let line = Series {
                points,
                ..series(Mark::Line)
            };
            line.along(&axis(), &axis()).matches('M').count()
        };
        let up: Vec<(f64, f64)> = (0..=10).map(|k| (f64::from(k), 1.0)).collect();
        let down = up.iter().rev().copied().collect();
        assert_eq!((marks(up), marks(down)), (5, 5));
    }

    #[test]
    fn dots_outside_are_left_out_and_a_word_is_no_legend() {
        assert_eq!(path(Mark::Dots).matches('z').count(), 3);
        assert!(!series(Mark::Word).named() && series(Mark::Line).named());
    }
}
