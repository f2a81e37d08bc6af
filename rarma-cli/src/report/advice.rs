//! What to do about chatter: words, and the speeds as a strip.

use super::ReportInput;
use crate::advice::{AdviceRecord, missing_words, sentences};
use rarma_pictures::put;
use rarma_pictures::text::{escape, px};

/// Alarms whose advice is on the page; that of the others is alike as a rule.
const SHOWN: usize = 3;
/// Width of the strip, pixels.
const WIDTH: f64 = 1000.0;
/// Its title.
const TITLE: &str = "Speeds within reach (1/min)";
/// The ends of its line, and how deep it lies.
const ENDS: (f64, f64) = (50.0, 950.0);
const LINE: f64 = 68.0;
/// Room that a speed takes along the line, and below another.
const WORD: f64 = 50.0;
const ROW: f64 = 15.0;

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
    put!(
        svg,
        r#"<text x="84" y="18" class="title">{TITLE}</text><path class="tick" d="M{} {LINE}H{}"/>"#,
        ENDS.0,
        ENDS.1
    );
    let mut speeds: Vec<_> = advice.speeds.iter().collect();
    speeds.sort_by(|a, b| a.rpm.total_cmp(&b.rpm));
    let mut rows: Vec<f64> = Vec::new();
    for speed in speeds {
        let [from, to] = speed.pocket_rpm.map(at);
        put!(
            svg,
            r#"<rect class="bar-of c2" x="{}" y="{}" width="{}" height="20" style="fill-opacity:{:.2}"/>"#,
            px(from),
            px(LINE - 10.0),
            px((to - from).max(2.0)),
            0.15 + 0.85 * speed.chance
        );
        // Those that are close stand below each other.
        let x = at(speed.rpm);
        let free = rows.iter().position(|last| x - last >= WORD);
        let row = free.unwrap_or(rows.len());
        rows.resize(rows.len().max(row + 1), x);
        rows[row] = x;
        let y = LINE + 28.0 + ROW * row as f64;
        label(&mut svg, x, y, "middle", &format!("{:.0}", speed.rpm));
    }
    let now = at(advice.rpm);
    put!(
        svg,
        r#"<path class="pointer" d="M{} {}l-5 -9h10z"/>"#,
        px(now),
        px(LINE - 12.0)
    );
    let word = format!("now {:.0}", advice.rpm);
    label(&mut svg, now, LINE - 26.0, "middle", &word);
    for (x, anchor, rpm) in [(ENDS.0 - 6.0, "end", low), (ENDS.1 + 6.0, "start", high)] {
        label(&mut svg, x, LINE + 4.0, anchor, &format!("{rpm:.0}"));
    }
    format!(
        "<figure><div class=\"scroll\"><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Speeds within reach, 1/min, with the pockets that are proposed\">{svg}</svg></div>\
         <figcaption>Blocks: where the cut is likely stable, the stronger the colour the likelier; below them the speed to turn.</figcaption></figure>\n",
        WIDTH,
        px(LINE + 36.0 + ROW * rows.len() as f64)
    )
}

fn label(svg: &mut String, x: f64, y: f64, anchor: &str, text: &str) {
    put!(
        svg,
        r#"<text x="{}" y="{}" class="number" text-anchor="{anchor}">{}</text>"#,
        px(x),
        px(y),
        escape(text)
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn speeds_that_are_close_stand_below_each_other() {
        let speed = |rpm: f64| {
            json!({"rpm": rpm, "rpm_sd": 1.0, "pocket_rpm": [rpm - 10.0, rpm + 10.0], "pocket": 1,
                "chance": 0.5, "margin": 2.0, "ratio": 1.0, "feed_ratio": 1.0})
        };
        let speeds = [1900.0, 1210.0, 1200.0, 1215.0].map(speed);
        let advice = json!({"rpm": 1500.0, "reach_rpm": [1000.0, 2000.0], "waves": 1.0,
            "most_waves": 9.0, "mode": 900.0, "of_structure": false, "beyond_rpm": null, "helps": [],
            "speeds": speeds});
        let advice: AdviceRecord = serde_json::from_value(advice).expect("an advice");
        let svg = strip(&advice);
        let height = |rpm: &'static str| {
            let before = svg
                .split(&format!(">{rpm}</text>"))
                .next()
                .expect("a label");
            let y = before.rsplit(" y=\"").next().expect("its place");
            y.split('"').next().expect("a number").to_owned()
        };
        let close = ["1200", "1210", "1215"].map(height);
        assert!(close[0] != close[1] && close[1] != close[2] && close[0] != close[2]);
        assert_eq!(height("1200"), height("1900"));
    }
}
