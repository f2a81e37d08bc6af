//! What to do about chatter: words, and the speeds as a strip.

use super::ReportInput;
use crate::advice::{AdviceRecord, SpeedRecord, missing_words, sentences};
use rarma_core::advice::{Lobes, Side};
use rarma_pictures::put;
use rarma_pictures::text::{escape, px};
use rarma_pictures::{Chart, Mark, Scale, Series};

/// Alarms whose advice is on the page; that of the others is alike as a rule.
const SHOWN: usize = 3;
/// Width of the strip, pixels.
const WIDTH: f64 = 1000.0;
/// Its title.
const TITLE: &str = "Speeds within reach (1/min)";
/// The ends of its line, below those of the lobes, and how deep it lies.
const ENDS: (f64, f64) = (84.0, 924.0);
const LINE: f64 = 68.0;
/// The lobes: height of the picture, how deep it goes over this cut's depth, and points along it.
const HEIGHT: f64 = 180.0;
const DEEPEST: f64 = 3.0;
const POINTS: usize = 800;
/// Less than that is not asked for.
const LEAST: f64 = 0.1;
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
            "<p>Chatter at {:.1} Hz from {:.3} s: {}</p>\n{}{}",
            alarm.f,
            alarm.on,
            escape(&words),
            lobes(advice, job.teeth.unwrap_or(1)),
            strip(advice)
        );
    }
    if all > SHOWN {
        put!(html, "<p>And {} alarms more.</p>\n", all - SHOWN);
    }
    html.push_str("</section>\n");
    html
}

/// The likeliest lobes over the reach, this cut, and what was known of others; nothing where a machine that is told
/// has more modes than one.
fn lobes(advice: &AdviceRecord, teeth: u32) -> String {
    let [low, high] = advice.reach_rpm;
    let Some(of) = advice.lobes.as_ref().filter(|_| high > low) else {
        return String::new();
    };
    let side = if of.above { Side::Above } else { Side::Below };
    let lobes = Lobes::new(advice.mode, of.zeta, of.load, side, teeth);
    let limit = |k: usize| {
        let rpm = low + (high - low) * k as f64 / POINTS as f64;
        (rpm, lobes.limit(rpm / 60.0, LEAST))
    };
    let limit: Vec<(f64, f64)> = (0..=POINTS).map(limit).collect();
    let of_known = |stable: bool| {
        let those = advice.known.iter().filter(|cut| cut.stable == stable);
        those.map(|cut| (cut.rpm, cut.depth)).collect()
    };
    let of_speed = |s: &SpeedRecord| (s.rpm, 1.0);
    let named = |name, points: Vec<_>, mark, colour| {
        // The legend names only what is there.
        Series::new(
            if points.is_empty() { "" } else { name },
            points,
            mark,
            colour,
        )
    };
    Chart {
        title: "Lobes, as heard".to_owned(),
        x: Scale::linear("speed (1/min)", low, high),
        y: Scale::linear("depth over this cut's", 0.0, DEEPEST),
        height: HEIGHT,
        series: vec![
            Series::new("", limit.clone(), Mark::Above, 1),
            Series::new("limit", limit, Mark::Line, 1),
            Series::new("this depth", vec![(low, 1.0), (high, 1.0)], Mark::Dashes, 5),
            named("chattered", of_known(false), Mark::Dots, 1),
            named("was stable", of_known(true), Mark::Dots, 2),
            named("to turn", advice.speeds.iter().map(of_speed).collect(), Mark::Dots, 0),
            Series::new("now", vec![(advice.rpm, 1.0)], Mark::Place, 0),
        ],
        caption: format!(
            "Likeliest limit of one mode ({:.1} Hz, damping {:.1} %): above it the cut chatters. The chances below are of all that is \
             likely, not of this one curve.",
            advice.mode,
            100.0 * of.zeta
        ),
    }
    .figure()
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

    fn advice(speeds: &[f64]) -> AdviceRecord {
        let speed = |rpm: &f64| {
            json!({"rpm": rpm, "rpm_sd": 1.0, "pocket_rpm": [rpm - 10.0, rpm + 10.0], "pocket": 1,
                "chance": 0.5, "margin": 2.0, "ratio": 1.0, "feed_ratio": 1.0})
        };
        let speeds: Vec<_> = speeds.iter().map(speed).collect();
        let advice = json!({"rpm": 1500.0, "reach_rpm": [1000.0, 2000.0], "waves": 1.0,
            "most_waves": 9.0, "mode": 100.0, "of_structure": false, "beyond_rpm": null, "helps": [],
            "speeds": speeds, "lobes": {"zeta": 0.02, "load": 0.08, "above": true},
            "known": [{"rpm": 1800.0, "depth": 1.0, "stable": false}]});
        serde_json::from_value(advice).expect("an advice")
    }

    #[test]
    fn the_lobes_are_drawn_also_where_no_speed_is_stable() {
        let none = advice(&[]);
        let figure = lobes(&none, 3);
        for word in ["Lobes, as heard", "limit", "this depth", "chattered", "now"] {
            assert!(figure.contains(word), "{word}");
        }
        assert!(!figure.contains("to turn") && !figure.contains("was stable"));
        assert_eq!(strip(&none), "");
        assert!(lobes(&advice(&[1900.0]), 3).contains("to turn"));
        // A machine that is told has more modes than one.
        let by_machine = AdviceRecord {
            lobes: None,
            ..none
        };
        assert_eq!(lobes(&by_machine, 3), "");
    }

    #[test]
    fn speeds_that_are_close_stand_below_each_other() {
        let svg = strip(&advice(&[1900.0, 1210.0, 1200.0, 1215.0]));
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
