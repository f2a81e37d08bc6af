//! Quantities all round: a polar diagram in the dress of the other pictures.

use super::axis::Axis;
use super::palette;
use super::text::{escape, px, significant};

const WIDTH: f64 = 1000.0;
const RADIUS: f64 = 230.0;
const CENTRE: (f64, f64) = (360.0, 290.0);
const HEIGHT: f64 = 580.0;
/// Letters of a name that fit right of the circle.
const LETTERS: usize = 44;

/// One curve.
#[derive(Debug, Clone, PartialEq)]
pub struct PolarSeries {
    /// What the legend calls it.
    pub name: String,
    /// Angle in degrees from the right, counter-clockwise, and radius. A radius that is not
    /// finite or beyond the rim breaks the curve.
    pub points: Vec<(f64, f64)>,
    /// Number of its colour.
    pub colour: usize,
    /// Dashed.
    pub dashed: bool,
}

/// A polar picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Polar {
    /// Title.
    pub title: String,
    /// What the radius is, with its unit.
    pub radius: String,
    /// Radius of the rim.
    pub most: f64,
    /// Curves.
    pub series: Vec<PolarSeries>,
    /// What is to be seen, and what it does not show.
    pub caption: String,
}

impl Polar {
    /// The figure as HTML.
    pub fn figure(&self) -> String {
        let axis = Axis::linear(0.0, self.most, 0.0, RADIUS);
        let (cx, cy) = CENTRE;
        let mut svg = String::new();
        put!(
            svg,
            r#"<text x="84" y="18" class="title">{}</text><circle class="frame" cx="{cx}" cy="{cy}" r="{RADIUS}"/>"#,
            escape(&self.title)
        );
        for (value, label) in axis.ticks(5) {
            let r = axis.at(value);
            // The centre needs no name: its label would lie on the spokes.
            if r <= 0.0 {
                continue;
            }
            if r < RADIUS - 1.0 {
                put!(
                    svg,
                    r#"<path class="grid" d="M{} {cy}a{r} {r} 0 1 0 {} 0a{r} {r} 0 1 0 {} 0z"/>"#,
                    px(cx - r),
                    px(2.0 * r),
                    px(-2.0 * r),
                    r = px(r)
                );
            }
            // Along 15°, away from the axes.
            let (s, c) = 15_f64.to_radians().sin_cos();
            put!(
                svg,
                r#"<text x="{}" y="{}" class="small">{label}</text>"#,
                px(cx + r * c + 3.0),
                px(cy - r * s + 4.0)
            );
        }
        for k in 0..12 {
            let (s, c) = (30.0 * f64::from(k)).to_radians().sin_cos();
            put!(
                svg,
                r#"<path class="grid" d="M{cx} {cy}L{} {}"/><text x="{}" y="{}" class="number" text-anchor="middle">{}°</text>"#,
                px(cx + RADIUS * c),
                px(cy - RADIUS * s),
                px(cx + (RADIUS + 20.0) * c),
                px(cy - (RADIUS + 18.0) * s + 4.0),
                30 * k
            );
        }
        let mut at = 60.0;
        for s in &self.series {
            let dashed = if s.dashed { " dashed" } else { "" };
            let class = format!("curve {}{dashed}", palette::class(s.colour));
            put!(
                svg,
                r#"<path class="{class}" d="{}"/><path class="{class}" d="M660 {}h28"/>"#,
                path(&s.points, &axis),
                px(at),
            );
            for line in lines(&s.name) {
                put!(
                    svg,
                    r#"<text x="694" y="{}" class="legend">{}</text>"#,
                    px(at + 4.0),
                    escape(&line)
                );
                at += 17.0;
            }
            at += 4.0;
        }
        put!(
            svg,
            r#"<text class="name" x="660" y="{}">radius: {}</text><text class="name" x="660" y="{}">rim: {}</text>"#,
            px(HEIGHT - 60.0),
            escape(&self.radius),
            px(HEIGHT - 40.0),
            significant(self.most)
        );
        format!(
            "<figure><div class=\"scroll\"><svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">{svg}</svg></div><figcaption>{}</figcaption></figure>\n",
            escape(&format!("{}. {}", self.title, self.caption)),
            escape(&self.caption)
        )
    }
}

/// A name in lines that fit.
fn lines(name: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in name.split(' ') {
        let full = lines
            .last()
            .map_or(0, |l| l.chars().count() + 1 + word.chars().count());
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if full <= LETTERS => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

fn path(points: &[(f64, f64)], axis: &Axis) -> String {
    let mut d = String::new();
    let mut joined = false;
    let whole = points.iter().all(|p| axis.holds(p.1));
    for &(angle, r) in points {
        let seen = axis.holds(r);
        if seen {
            let (s, c) = angle.to_radians().sin_cos();
            let r = axis.at(r);
            put!(
                d,
                "{}{} {}",
                if joined { 'L' } else { 'M' },
                px(CENTRE.0 + r * c),
                px(CENTRE.1 - r * s)
            );
        }
        joined = seen;
    }
    if whole && !d.is_empty() {
        d.push('z');
    }
    d
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_name_is_broken_between_words() {
        let name = "force and chip thickness 45° apart, of a very long machine";
        let broken = lines(name);
        assert_eq!(broken.len(), 2);
        assert!(
            broken.iter().all(|l| l.chars().count() <= LETTERS),
            "{broken:?}"
        );
        assert_eq!(broken.join(" "), name);
    }

    #[test]
    fn right_is_zero_and_up_is_a_quarter() {
        let axis = Axis::linear(0.0, 2.0, 0.0, RADIUS);
        let d = path(
            &[
                (0.0, 2.0),
                (90.0, 1.0),
                (180.0, f64::INFINITY),
                (270.0, 2.0),
            ],
            &axis,
        );
        assert_eq!(d, "M590 290L360 175M360 520");
        let closed = path(&[(0.0, 1.0), (120.0, 1.0), (240.0, 1.0)], &axis);
        assert!(closed.ends_with('z'));
    }
}
