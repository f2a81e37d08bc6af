//! Picture (e): the state at every instant, one lane per state.
//!
//! Lanes instead of one coloured strip: a state is told by its height, so the
//! picture reads without colour and a flicker of one line stays visible.

use super::Scene;
use crate::record::State;
use rarma_core::named::Named;
use rarma_pictures::Axis;
use rarma_pictures::put;
use rarma_pictures::text::{px, seconds};
use rarma_pictures::{LEFT, TOP};

const LANE: f64 = 20.0;

/// Worst on top.
pub(super) const STATES: [State; 6] = [
    State::Chatter,
    State::Warning,
    State::Stable,
    State::Idle,
    State::Starting,
    State::Invalid,
];

/// Draws the figure.
pub(super) fn figure(scene: &Scene<'_>) -> String {
    let course = scene.job.course;
    let total = |state| scene.job.summary.state_seconds.get(&state).copied();
    let shown: Vec<State> = STATES
        .into_iter()
        .filter(|s| {
            // The three that a cut goes through are always there to compare.
            matches!(s, State::Chatter | State::Warning | State::Stable)
                || course.moments().any(|m| m.has(*s))
                || total(*s).is_some_and(|t| t > 0.0)
        })
        .collect();
    let mut panel = scene.panel(LANE * shown.len() as f64, "(e) State");
    panel.spans();
    let mut spoken = Vec::new();
    for (i, state) in shown.iter().enumerate() {
        let name = state.name();
        let middle = TOP + LANE * (i as f64 + 0.5);
        let d = runs(scene, &panel.x, *state, middle);
        panel.add(&format!(
            r#"<path class="state state-{name}" stroke-width="{}" d="{d}"/>"#,
            px(LANE - 6.0)
        ));
        if i > 0 {
            panel.level(TOP + LANE * i as f64, "grid");
        }
        panel.label(LEFT - 8.0, middle + 4.0, "number", "end", name);
        if let Some(t) = total(*state).filter(|t| t.is_finite()) {
            panel.margin(middle, "small", &seconds(t));
            spoken.push(format!("{name} {}", seconds(t)));
        }
    }
    let alt = format!(
        "State against time. In all: {}. {}",
        if spoken.is_empty() {
            "nothing".into()
        } else {
            spoken.join(", ")
        },
        scene.spans_in_words()
    );
    let of_all = match scene.job.window_s {
        Some(_) => " in all of the recording",
        None => "",
    };
    panel.finish(
        &alt,
        &format!(
            "What the monitor believed at each instant; on the right, the time spent in each state{of_all}."
        ),
    )
}

/// Stretches of one state as horizontal strokes. Strokes that a viewer could
/// not tell apart are joined.
fn runs(scene: &Scene<'_>, x: &Axis, state: State, y: f64) -> String {
    let mut moments = scene.job.course.moments().peekable();
    let mut strokes: Vec<(f64, f64)> = Vec::new();
    while let Some(moment) = moments.next() {
        if !moment.has(state) {
            continue;
        }
        // A line holds until the next one speaks.
        let until = moments.peek().map_or(scene.t_end, |next| next.t);
        let (from, to) = (x.at(moment.t), x.at(until));
        let to = to.max(from + 0.5);
        match strokes.last_mut() {
            Some(last) if from - last.1 < 0.3 => last.1 = last.1.max(to),
            _ => strokes.push((from, to)),
        }
    }
    let mut d = String::new();
    for (from, to) in strokes {
        put!(d, "M{} {}H{}", px(from), px(y), px(to));
    }
    d
}
