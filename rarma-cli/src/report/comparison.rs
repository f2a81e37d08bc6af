//! Several recordings on one page: a row and a bar each, and the way to the page of each.

use super::Provenance;
use super::tables;
use super::timeline::STATES;
use crate::record::{Alarm, Summary};
use rarma_core::named::Named;
use rarma_pictures::put;
use rarma_pictures::sheet;
use rarma_pictures::text::{escape, hertz, instant, px, seconds};

/// One recording.
#[derive(Debug, Clone)]
pub struct Compared {
    /// Its file.
    pub name: String,
    /// Its page, from this page's folder.
    pub page: String,
    /// What was heard, or why nothing was.
    pub heard: Result<Summary, String>,
}

impl Compared {
    fn alarms(&self) -> &[Alarm] {
        self.heard.as_ref().map_or(&[], |s| &s.alarms)
    }

    /// Length, s.
    fn length(&self) -> f64 {
        self.heard.as_ref().map_or(0.0, |s| s.samples as f64 / s.fs)
    }
}

/// The page.
pub fn comparison(all: &[Compared], provenance: &Provenance, version: &str) -> String {
    let chattered = all.iter().filter(|c| !c.alarms().is_empty()).count();
    let unread = all.iter().filter(|c| c.heard.is_err()).count();
    let mut headline = match chattered {
        0 => format!("No chatter in {} recordings", all.len() - unread),
        n => format!("Chatter in {n} of {} recordings", all.len() - unread),
    };
    if unread > 0 {
        headline.push_str(&format!(", {unread} could not be read"));
    }
    let mut body = provenance.line();
    body += &table(all);
    body += &bars(all);
    body += "<h2>How they were made</h2>\n<div class=\"scroll\"><table class=\"pairs\">\n<tbody>\n";
    for (key, value) in provenance.rows() {
        put!(
            body,
            "<tr><th scope=\"row\">{key}</th><td>{value}</td></tr>\n"
        );
    }
    body += "</tbody>\n</table></div>\n";
    sheet("Recordings compared", &headline, &body, version)
}

fn table(all: &[Compared]) -> String {
    let mut html = String::from(
        "<div class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">recording</th>\
         <th scope=\"col\">length</th><th scope=\"col\">alarms</th>\
         <th scope=\"col\">first from</th><th scope=\"col\">in alarm for</th>\
         <th scope=\"col\">frequency of the longest</th>\
         <th scope=\"col\">its damping ratio ζ</th></tr></thead>\n<tbody>\n",
    );
    for one in all {
        let summary = match &one.heard {
            Ok(summary) => summary,
            Err(why) => {
                put!(
                    html,
                    "<tr><th scope=\"row\">{}</th><td colspan=\"6\">{}</td></tr>\n",
                    escape(&one.name),
                    escape(why)
                );
                continue;
            }
        };
        let length = one.length();
        let lasted = |a: &Alarm| a.off.unwrap_or(length) - a.on;
        let longest = summary
            .alarms
            .iter()
            .max_by(|a, b| lasted(a).total_cmp(&lasted(b)));
        let of = |text: Option<String>| text.unwrap_or_else(|| "–".into());
        put!(
            html,
            "<tr><th scope=\"row\"><a href=\"{}\">{}</a></th><td>{}</td><td>{}</td><td>{}</td>\
             <td>{}</td><td>{}</td><td>{}</td></tr>\n",
            escape(&one.page),
            escape(&one.name),
            seconds(length),
            summary.alarms.len() as u64 + summary.alarms_left_out,
            of(summary.alarms.first().map(|a| instant(a.on))),
            of(longest.map(|_| seconds(summary.alarms.iter().map(lasted).sum()))),
            of(longest.map(|a| hertz(a.f))),
            of(longest.map(tables::damping_words)),
        );
    }
    html.push_str("</tbody>\n</table></div>\n");
    html
}

/// Height of a row, and where bars begin and end, pixels.
const ROW: f64 = 30.0;
const BARS: (f64, f64) = (300.0, 960.0);
const TOP: f64 = 54.0;
/// Letters of a name that fit left of the bars.
const LETTERS: usize = 36;

/// Time in each state, one bar a recording, all on one scale.
fn bars(all: &[Compared]) -> String {
    let longest = all.iter().map(Compared::length).fold(0.0, f64::max);
    if !(longest > 0.0) {
        return String::new();
    }
    let mut svg = String::from(r#"<text x="84" y="18" class="title">Time in each state</text>"#);
    let mut x = 84.0;
    let spent = |summary: &Summary, state| {
        let spent = summary.state_seconds.get(&state).copied().unwrap_or(0.0);
        Some(spent).filter(|t| *t > 0.0 && t.is_finite())
    };
    let there = |state| {
        let mut heard = all.iter().filter_map(|one| one.heard.as_ref().ok());
        heard.any(|summary| spent(summary, state).is_some())
    };
    for state in STATES.into_iter().filter(|state| there(*state)) {
        let word = state.name();
        put!(
            svg,
            r#"<path class="state-{word}" stroke-width="12" d="M{} 38h18"/><text x="{}" y="42" class="legend">{}</text>"#,
            px(x),
            px(x + 24.0),
            word
        );
        x += 110.0;
    }
    for (k, one) in all.iter().enumerate() {
        let Ok(summary) = &one.heard else { continue };
        let middle = TOP + ROW * (k as f64 + 0.5);
        put!(
            svg,
            r#"<text x="{}" y="{}" class="legend" text-anchor="end">{}</text>"#,
            px(BARS.0 - 10.0),
            px(middle + 4.5),
            escape(&end_of(&one.name))
        );
        let mut from = BARS.0;
        for state in STATES {
            let Some(spent) = spent(summary, state) else {
                continue;
            };
            let word = state.name();
            let to = from + spent / longest * (BARS.1 - BARS.0);
            put!(
                svg,
                r#"<path class="state-{word}" stroke-width="16" d="M{} {}H{}"/>"#,
                px(from),
                px(middle),
                px(to)
            );
            from = to;
        }
    }
    let height = TOP + ROW * all.len() as f64 + 8.0;
    format!(
        "<figure><div class=\"scroll\"><svg viewBox=\"0 0 1000 {}\" role=\"img\" aria-label=\"Time in each state, one bar a recording; the table has the alarms\">{svg}</svg></div><figcaption>Seconds in each state, added up and not in their order; the longest recording is {} long.</figcaption></figure>\n",
        px(height),
        seconds(longest)
    )
}

/// The last letters of a file's name.
fn end_of(name: &str) -> String {
    let letters: Vec<char> = name.chars().collect();
    match letters.len().checked_sub(LETTERS) {
        None | Some(0) => name.to_owned(),
        Some(over) => format!("…{}", letters[over + 1..].iter().collect::<String>()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::State;
    use crate::report::tests::{alarm, summary};

    #[test]
    fn every_recording_has_its_row_and_the_worst_is_the_headline() {
        let mut loud = summary();
        loud.samples = 10_000;
        loud.alarms = vec![alarm(1.0, Some(1.2), 500.0), alarm(1.4, None, 898.0)];
        (loud.alarms[1].zeta_median, loud.alarms[1].zeta_deviation) = (Some(0.002), Some(0.001));
        loud.state_seconds = [(State::Stable, 1.2), (State::Chatter, 0.8)].into();
        let mut quiet = summary();
        quiet.samples = 5_000;
        quiet.state_seconds = [(State::Stable, 1.0)].into();
        let one = |name: &str, heard| Compared {
            name: name.to_owned(),
            page: format!("{name}/index.html"),
            heard,
        };
        let all = [
            one("a<b>.wav", Ok(loud)),
            one("quiet.wav", Ok(quiet)),
            one(
                "gone.wav",
                Err("gone.wav: open: no such file & no way".to_owned()),
            ),
        ];
        let html = comparison(&all, &Provenance::default(), "test");
        for text in [
            "<h1>Chatter in 1 of 2 recordings, 1 could not be read</h1>",
            "<a href=\"a&lt;b&gt;.wav/index.html\">a&lt;b&gt;.wav</a>",
            "<td>2</td><td>1\u{a0}s</td><td>0.8\u{a0}s</td><td>898\u{a0}Hz</td>",
            "0.20 ± 0.10\u{a0}%",
            "no such file &amp; no way",
            "<td>0</td><td>–</td>",
        ] {
            assert!(html.contains(text), "{text}\n{html}");
        }
        // 0.8 s of 2 s, and the whole of the other's 1 s.
        assert!(
            html.contains("stroke-width=\"16\" d=\"M300 69H564\""),
            "{html}"
        );
        assert!(
            html.contains("stroke-width=\"16\" d=\"M300 99H630\""),
            "{html}"
        );
        assert_eq!(html.matches("stroke-width=\"16\"").count(), 3);
    }

    #[test]
    fn a_long_name_keeps_its_end() {
        let name = "x".repeat(80) + "cut-17.wav";
        let short = end_of(&name);
        assert!(short.starts_with('…') && short.ends_with("cut-17.wav"));
        assert_eq!(short.chars().count(), LETTERS);
    }
}
