//! Figures of the population for programs.

use super::changed::CHANGES;
use super::detectors::ALL;
use super::score::Sum;
use super::{Answer, Asked, Judged, Tally, Told};
use rarma_plants::population::before::Before;
use serde_json::{Value, json};

fn round(x: Option<f64>, digits: i32) -> Value {
    let unit = 10f64.powi(digits);
    x.map_or(Value::Null, |x| json!((x * unit).round() / unit))
}

/// One cut with its truth, and what each detector made of it at its usual threshold.
pub fn cut_record(one: &Judged) -> Value {
    let cut = &one.cut;
    let (f, zeta) = cut.operational();
    let results: Vec<Value> = one
        .answers
        .iter()
        .filter(|answer| answer.question.2 == 0)
        .map(|Answer { question, said, score }| {
            let alarms = said.alarms.iter().map(|a| {
                [a.on_s, a.off_s, a.f_hz].map(|x| round(Some(x), 2))
            });
            json!({
                "told": question.0.name(), "detector": ALL[question.1].name(), "hit": score.hit,
                "covered": round(Some(score.covered), 3), "latency_s": round(score.latency_s, 3),
                "false_alarms": score.false_alarms, "warned_s": round(Some(score.warned_s), 2),
                "alarms": alarms.collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "seed": cut.seed, "rpm": round(Some(60.0 * cut.spindle_hz()), 1), "teeth": cut.teeth(),
        "fs": one.heard.fs_hz, "length_s": round(Some(cut.length_s()), 2),
        "f": round(Some(f), 1), "zeta": round(Some(zeta), 5),
        "chatter_s": one.heard.chatter_s.iter().map(|c| [round(Some(c.0), 2), round(Some(c.1), 2)]).collect::<Vec<_>>(),
        "quiet_s": round(Some(cut.quiet_s(&one.heard, 0.0, cut.length_s())), 2),
        "undecidable": cut.undecidable(), "kinds": cut.kinds(), "results": results,
        "took_s": one.took_s.map(|t| round(Some(t), 3)),
    })
}

fn figures(sum: &Sum) -> Value {
    json!({
        "cuts": sum.cuts, "chatters": sum.chatters, "detected": round(sum.detected(), 4),
        "called_or_warned": round(sum.told(), 4), "covered": round(sum.coverage(), 4),
        "latency_s": round(sum.latency_s(), 3), "false_alarms": sum.false_alarms, "false_in_air": sum.false_in_air, "alarmed_before": sum.alarmed_before,
        "quiet_h": round(Some(sum.quiet_h()), 4), "false_per_hour": round(sum.false_per_hour(), 2),
        "quiet_alarmed": round(sum.alarmed(), 4), "quiet_warned": round(sum.warned(), 4),
    })
}

/// The whole run.
pub fn summary(seeds: (u64, u64), asked: &Asked, tally: &Tally) -> Value {
    let row = |told: Told, detector: usize, what: (&str, Value), sum: &Sum| {
        let mut row = figures(sum);
        row["told"] = json!(told.name());
        row["detector"] = json!(ALL[detector].name());
        row[what.0] = what.1;
        row
    };
    let curve: Vec<Value> = tally
        .sums
        .iter()
        .map(|((told, detector, k), sum)| {
            row(
                *told,
                *detector,
                ("threshold", json!(ALL[*detector].thresholds()[*k])),
                sum,
            )
        })
        .collect();
    let kinds: Vec<Value> = tally
        .kinds
        .iter()
        .map(|((told, detector, kind), sum)| row(*told, *detector, ("kind", json!(kind)), sum))
        .collect();
    let variants = asked.variants.iter().zip(&tally.variants);
    let sensitivity: Vec<Value> = variants
        .map(|(variant, sum)| {
            let mut row = figures(sum);
            row["name"] = json!(variant.name);
            row["value"] = json!(variant.value);
            row
        })
        .collect();
    let changed: Vec<Value> = CHANGES
        .iter()
        .zip(&tally.flips)
        .map(|(change, flips)| {
            json!({
                "change": change.name(), "chatters": flips.chatters,
                "other_chatters": flips.other_chatters, "quiet": flips.quiet,
                "other_quiet": flips.other_quiet,
            })
        })
        .collect();
    json!({
        "seeds": [seeds.0, seeds.1], "heard_before": asked.before.map(Before::name), "cuts": tally.cuts,
        "chatters": tally.chatters, "undecidable": tally.undecidable, "curve": curve, "kinds": kinds,
        "sensitivity": sensitivity, "changed": changed,
    })
}
