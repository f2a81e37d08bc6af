//! A monitor beside a signal, and what it said in the end.

use rarma_core::Monitor;
use rarma_core::decide::{AlarmEvent, State};
use rarma_core::monitor::MonitorConfig;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Reasons by which a monitor says that it cannot tell, by the start of their names.
/// A vibration that is hidden by a forced line may be declared so instead of called.
pub const BLIND: [&str; 1] = ["Blind"];

/// One alarm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Call {
    /// Called at, s.
    pub on_s: f64,
    /// Released at, s; none if it stands at the end.
    pub off_s: Option<f64>,
    /// Frequency it was called at, Hz.
    pub f_hz: f64,
}

/// What a monitor said of one signal.
#[derive(Debug, Clone, Default)]
pub struct Watched {
    /// Alarms in order of time.
    pub calls: Vec<Call>,
    /// Length of the signal, s.
    pub length_s: f64,
    /// Modes of the last report: frequency (Hz), damping ratio, amplitude.
    pub modes: Vec<(f64, f64, f64)>,
    /// Changes of state and reason, by name: from when on, s.
    verdicts: Vec<(f64, State, String)>,
}

/// Runs a monitor of these settings over samples, in single precision as the box.
///
/// # Panics
/// A setting is out of range.
pub fn watch(config: &MonitorConfig, samples: impl IntoIterator<Item = f64>) -> Watched {
    let mut monitor = Monitor::<f32>::new(config).expect("settings in range");
    let mut out = Watched::default();
    let mut last = None;
    for x in samples {
        let Some(report) = monitor.push(x as f32) else {
            continue;
        };
        let t = report.sample as f64 / config.fs_hz;
        match report.event {
            AlarmEvent::On { frequency, .. } => out.calls.push(Call {
                on_s: t,
                off_s: None,
                f_hz: f64::from(frequency),
            }),
            AlarmEvent::Off { .. } => {
                if let Some(call) = out.calls.last_mut() {
                    call.off_s = Some(t);
                }
            }
            AlarmEvent::None => {}
        }
        out.modes.clear();
        out.modes.extend(report.modes.iter().flatten().map(|m| {
            let [f, zeta, amplitude] = [m.frequency, m.damping, m.amplitude].map(f64::from);
            (f, zeta, amplitude)
        }));
        if last != Some((report.state, report.reason)) {
            last = Some((report.state, report.reason));
            let reason = format!("{:?}", report.reason);
            out.verdicts.push((t, report.state, reason));
        }
    }
    out.length_s = monitor.samples() as f64 / config.fs_hz;
    out
}

/// The same work for each of these, side by side; the order is kept.
pub fn each<I: Send, O: Send>(items: Vec<I>, work: impl Fn(I) -> O + Sync + Send) -> Vec<O> {
    items.into_par_iter().map(work).collect()
}

impl Watched {
    /// Alarms raised in `from..to`, s.
    #[must_use]
    pub fn called(&self, from_s: f64, to_s: f64) -> usize {
        let inside = |call: &&Call| (from_s..to_s).contains(&call.on_s);
        self.calls.iter().filter(inside).count()
    }

    /// First alarm raised in `from..to`, s, near `f_hz` by this much.
    #[must_use]
    pub fn first(&self, from_s: f64, to_s: f64, near: Option<(f64, f64)>) -> Option<Call> {
        let fits = |call: &Call| {
            (from_s..to_s).contains(&call.on_s)
                && near.is_none_or(|(f, by)| (call.f_hz - f).abs() <= by)
        };
        self.calls.iter().copied().find(fits)
    }

    /// Seconds for which verdicts that `wanted` picks stood in `from..to`, s.
    pub fn seconds(&self, from_s: f64, to_s: f64, wanted: impl Fn(State, &str) -> bool) -> f64 {
        let mut sum = 0.0;
        for (k, (t, state, reason)) in self.verdicts.iter().enumerate() {
            let end = self.verdicts.get(k + 1).map_or(self.length_s, |v| v.0);
            if wanted(*state, reason) {
                sum += (end.min(to_s) - t.max(from_s)).max(0.0);
            }
        }
        sum
    }

    /// First instant of `from..to` at which the monitor said that it cannot tell
    /// ([`BLIND`]), s.
    #[must_use]
    pub fn declared(&self, from_s: f64, to_s: f64) -> Option<f64> {
        let mut spans = self.verdicts.iter().enumerate();
        spans.find_map(|(k, (t, _, reason))| {
            let end = self.verdicts.get(k + 1).map_or(self.length_s, |v| v.0);
            let blind = BLIND.iter().any(|word| reason.starts_with(word));
            (blind && *t < to_s && end > from_s).then(|| t.max(from_s))
        })
    }

    /// Part of `from..to`, s, in this state, 0 to 1.
    #[must_use]
    pub fn share(&self, from_s: f64, to_s: f64, state: State) -> f64 {
        self.seconds(from_s, to_s, |s, _| s == state) / (to_s - from_s)
    }

    /// Seconds by reason in `from..to`, s, the longest first.
    #[must_use]
    pub fn reasons(&self, from_s: f64, to_s: f64) -> Vec<(String, f64)> {
        let mut by: BTreeMap<&str, f64> = BTreeMap::new();
        for (_, _, reason) in &self.verdicts {
            by.entry(reason)
                .or_insert_with(|| self.seconds(from_s, to_s, |_, r| r == reason));
        }
        let mut out: Vec<_> = by.into_iter().map(|(r, s)| (r.to_owned(), s)).collect();
        out.retain(|(_, s)| *s > 0.0);
        out.sort_by(|a, b| b.1.total_cmp(&a.1));
        out
    }
}
