//! Alarms and settings as tables.

use super::Scene;
use super::text::{count, escape, hertz, percent, seconds, significant, with_unit};
use super::timeline::name;

/// One row per alarm.
pub(super) fn alarms(scene: &Scene<'_>) -> String {
    let alarms = &scene.job.run.summary.alarms;
    let mut html = String::from("<section aria-label=\"Alarms\">\n<h2>Alarms</h2>\n");
    if alarms.is_empty() {
        html.push_str("<p>None.</p>\n</section>\n");
        return html;
    }
    let forcing = scene.forcing();
    html.push_str(
        "<div class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">No.</th>\
         <th scope=\"col\">from</th><th scope=\"col\">to</th><th scope=\"col\">lasted</th>\
         <th scope=\"col\">frequency</th>",
    );
    if let Some((_, name)) = forcing {
        put!(html, "<th scope=\"col\">in multiples of {name}</th>");
    }
    html.push_str("<th scope=\"col\">lowest damping ratio ζ</th></tr></thead>\n<tbody>\n");
    for (i, alarm) in alarms.iter().enumerate() {
        let end = alarm.off.unwrap_or(scene.t_end);
        put!(
            html,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
            i + 1,
            seconds(alarm.on),
            match alarm.off {
                Some(off) => seconds(off),
                None => "still on at the end".into(),
            },
            seconds(end - alarm.on),
            hertz(alarm.f),
        );
        if let Some((f, _)) = forcing {
            put!(html, "<td>{}</td>", with_unit(alarm.f / f, "×"));
        }
        put!(html, "<td>{}</td></tr>\n", percent(alarm.zeta));
    }
    html.push_str("</tbody>\n</table></div>\n</section>\n");
    html
}

/// What the run was made with, and how long it was in which state.
pub(super) fn settings(scene: &Scene<'_>) -> String {
    let job = scene.job;
    let summary = &job.run.summary;
    let [p, q] = summary.order;
    let mut rows = vec![
        ("Source", escape(job.source_name)),
        (
            "Samples",
            format!(
                "{} at {}, {}",
                count(job.samples.len() as u64),
                hertz(job.fs),
                seconds(job.samples.len() as f64 / scene.fs)
            ),
        ),
        (
            "Samples analysed",
            format!("{} at {}", count(summary.samples), hertz(summary.fs)),
        ),
        (
            "Model",
            format!("ARMA({p}, {q}), identified again at every sample"),
        ),
        ("Threshold", format!("ζ = {}", percent(job.threshold))),
        (
            "Band",
            format!("{} to {}", hertz(job.band_hz.0), hertz(job.band_hz.1)),
        ),
        (
            "Spindle speed",
            match job.rpm {
                Some(rpm) => format!("{} ({})", with_unit(rpm, "1/min"), hertz(rpm / 60.0)),
                None => "not given".into(),
            },
        ),
        (
            "Teeth",
            job.teeth.map_or("not given".into(), |z| z.to_string()),
        ),
    ];
    if let Some((f, name)) = scene.forcing().filter(|(_, name)| *name != "spindle") {
        let name = if name == "tooth passing" {
            "Tooth passing"
        } else {
            name
        };
        rows.push((name, hertz(f)));
    }
    if let Some(onset) = job.truth_onset_s {
        let note = job.truth_note.as_deref().unwrap_or_default();
        let note = if note.is_empty() {
            String::new()
        } else {
            format!(" ({})", escape(note))
        };
        rows.push(("True onset", format!("{}{note}", seconds(onset))));
    }
    let states: Vec<String> = summary
        .state_seconds
        .iter()
        .filter(|(_, t)| t.is_finite() && **t > 0.0)
        .map(|(state, t)| format!("{} {}", name(*state), seconds(*t)))
        .collect();
    if !states.is_empty() {
        rows.push(("Time in each state", states.join(", ")));
    }
    let most = strongest(scene);
    if let Some(amplitude) = most {
        rows.push((
            "Strongest mode",
            format!("{} input units, peak", significant(amplitude)),
        ));
    }
    let mut html = String::from(
        "<section aria-label=\"Settings\">\n<h2>Settings</h2>\n<div class=\"scroll\">\
         <table class=\"pairs\">\n<tbody>\n",
    );
    for (key, value) in rows {
        put!(
            html,
            "<tr><th scope=\"row\">{key}</th><td>{value}</td></tr>\n"
        );
    }
    html.push_str("</tbody>\n</table></div>\n</section>\n");
    html
}

/// Largest amplitude any mode reached.
fn strongest(scene: &Scene<'_>) -> Option<f64> {
    let modes = scene.job.run.lines.iter().flat_map(|l| &l.modes);
    modes
        .map(|m| m.amplitude)
        .filter(|a| a.is_finite())
        .max_by(f64::total_cmp)
}
