//! Parts of a whole as bars, the largest on top.

use super::text::{escape, px, significant};

const WIDTH: f64 = 1000.0;
const TOP: f64 = 34.0;
const LINE: f64 = 24.0;
/// Where names end, and bars begin and end at most.
const NAMES: f64 = 330.0;
const BARS: (f64, f64) = (340.0, 780.0);

/// One bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// What it is.
    pub name: String,
    /// How large; nothing below 0.
    pub value: f64,
    /// Its part of the whole, 0 to 1.
    pub share: f64,
}

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Bars {
    /// Title.
    pub title: String,
    /// Unit of the values.
    pub unit: String,
    /// The bars, in the order in which they are drawn.
    pub bars: Vec<Bar>,
    /// What is to be seen.
    pub caption: String,
}

impl Bars {
    /// The figure as HTML.
    pub fn figure(&self) -> String {
        let most = self.bars.iter().fold(0.0, |m: f64, b| m.max(b.value));
        let mut svg = format!(
            r#"<text x="84" y="18" class="title">{}</text>"#,
            escape(&self.title)
        );
        for (k, bar) in self.bars.iter().enumerate() {
            let middle = TOP + LINE * (k as f64 + 0.5);
            let part = if most > 0.0 {
                (bar.value / most).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let end = BARS.0 + part * (BARS.1 - BARS.0);
            put!(
                svg,
                r#"<text x="{NAMES}" y="{base}" class="legend" text-anchor="end">{}</text><path class="bar-of c0" d="M{} {}H{}v14H{}z"/><text x="{}" y="{base}" class="number">{} {}, {:.0} %</text>"#,
                escape(&bar.name),
                px(BARS.0),
                px(middle - 7.0),
                px(end),
                px(BARS.0),
                px(end + 8.0),
                significant(bar.value),
                escape(&self.unit),
                100.0 * bar.share,
                base = px(middle + 4.5),
            );
        }
        let height = TOP + LINE * self.bars.len() as f64 + 8.0;
        format!(
            "<figure><div class=\"scroll\"><svg viewBox=\"0 0 {WIDTH} {}\" role=\"img\" aria-label=\"{}\">{svg}</svg></div><figcaption>{}</figcaption></figure>\n",
            px(height),
            escape(&format!("{}. {}", self.title, self.caption)),
            escape(&self.caption)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_is_as_long_as_there_is_room_and_names_stay_text() {
        let bar = |name: &str, value, share| Bar {
            name: name.to_owned(),
            value,
            share,
        };
        let bars = Bars {
            title: "T".to_owned(),
            unit: "µm".to_owned(),
            bars: vec![
                bar("<a>", 4.0, 0.8),
                bar("b", 1.0, 0.2),
                bar("none", 0.0, 0.0),
            ],
            caption: "c".to_owned(),
        };
        let html = bars.figure();
        assert!(html.contains("&lt;a&gt;") && !html.contains("<a>"));
        for end in ["H780v14H340z", "H450v14H340z", "H340v14H340z"] {
            assert!(html.contains(end), "{end}: {html}");
        }
        assert!(html.contains("4 µm, 80 %"));
        let empty = Bars {
            bars: vec![bar("none", 0.0, 0.0)],
            ..bars
        };
        assert!(!empty.figure().contains("NaN"));
    }
}
