//! What to do about chatter: words, and the speeds as a strip.

use super::ReportInput;
use super::text::{escape, px};
use crate::advice::{AdviceRecord, missing_words, sentences};

/// Alarms whose advice is on the page; that of the others is alike as a rule.
const SHOWN: usize = 3;
/// Width and height of the strip, pixels.
const SIZE: (f64, f64) = (1000.0, 76.0);
/// Its ends.
const ENDS: (f64, f64) = (40.0, 960.0);

/// The section; nothing where there was no alarm, or nobody asks.
pub(super) fn section(job: &ReportInput<'_>) -> String {
    let alarms = &job.summary.alarms;
    let Some(missing) = job.missing.filter(|_| !alarms.is_empty()) else {
        return String::new();
    };
    let mut html = "<section>\n<h2>What to do</h2>\n".to_owned();
    if let Some(text) = missing_words(missing) {
        put!(html, "<p>{}</p>\n</section>\n", escape(&text));
        return html;
    }
    let with = alarms.iter().filter_map(|a| Some((a, a.advice.as_ref()?)));
    let all = with.clone().count();
    for (alarm, advice) in with.take(SHOWN) {
        let words = sentences(advice).join(" ");
        put!(
            html,
            "<p>Chatter at {:.1} Hz from {:.3} s: {}</p>\n{}",
            alarm.f,
            alarm.on,
            escape(&words),
            strip(advice)
        );
    }
    if all > SHOWN {
        put!(html, "<p>And {} alarms more.</p>\n", all - SHOWN);
    }
    html.push_str("</section>\n");
    html
}

/// The reach as a line, pockets as blocks on it, the present speed as a mark; nothing where
/// there is no pocket, which the words say.
fn strip(advice: &AdviceRecord) -> String {
    let [low, high] = advice.reach_rpm;
    if !(high > low) || advice.speeds.is_empty() {
        return String::new();
    }
    let at = |rpm: f64| ENDS.0 + (ENDS.1 - ENDS.0) * ((rpm - low) / (high - low)).clamp(0.0, 1.0);
    let mut svg = String::new();
    put!(svg, r#"<path class="tick" d="M{} 40H{}"/>"#, ENDS.0, ENDS.1);
    for speed in &advice.speeds {
        let [from, to] = speed.pocket_rpm.map(at);
        put!(
            svg,
            r#"<rect class="c2-area" x="{}" y="30" width="{}" height="20" fill="currentColor" fill-opacity="{:.2}"/>"#,
            px(from),
            px((to - from).max(2.0)),
            0.1 + 0.4 * speed.chance
        );
        label(&mut svg, at(speed.rpm), 68.0, &format!("{:.0}", speed.rpm));
    }
    let now = at(advice.rpm);
    put!(
        svg,
        r#"<path class="pointer" d="M{} 28l-5 -9h10z"/>"#,
        px(now)
    );
    label(&mut svg, now, 14.0, &format!("now {:.0}", advice.rpm));
    for (end, rpm) in [(ENDS.0, low), (ENDS.1, high)] {
        label(&mut svg, end, 14.0, &format!("{rpm:.0}"));
    }
    format!(
        "<figure><div class=\"scroll\"><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Speeds within reach, 1/min, with the pockets that are proposed\">{svg}</svg></div>\
         <figcaption>Speeds within reach, 1/min. Blocks: where the cut is likely stable, the darker the likelier.</figcaption></figure>\n",
        SIZE.0, SIZE.1
    )
}

fn label(svg: &mut String, x: f64, y: f64, text: &str) {
    put!(
        svg,
        r#"<text x="{}" y="{}" class="number" text-anchor="middle">{}</text>"#,
        px(x),
        px(y),
        escape(text)
    );
}
