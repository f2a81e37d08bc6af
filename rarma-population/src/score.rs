//! Alarms against the truth, cut by cut, and sums of many cuts.

use super::detectors::Said;
use rarma_plants::population::heard::Heard;
use rarma_plants::population::{Cut, SLACK_S};

/// What came of one cut.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Score {
    /// Chatter could be heard.
    pub chatter: bool,
    /// An alarm meets it.
    pub hit: bool,
    /// An alarm or a warning meets it.
    pub told: bool,
    /// Part of the chatter's time in alarm, 1.
    pub covered: f64,
    /// From what can be heard to the first alarm, s, where chatter began within the
    /// recording.
    pub latency_s: Option<f64>,
    /// False alarms.
    pub false_alarms: u32,
    /// Of them, begun in air.
    pub false_in_air: u32,
    /// Alarms begun before the recording of the cut, where something was heard before and nothing was cut; they are no
    /// [`Self::false_alarms`].
    pub before: u32,
    /// Clearly stable cutting, s.
    pub quiet_s: f64,
    /// Of it, in alarm, s.
    pub alarmed_s: f64,
    /// Of it, in warning, s.
    pub warned_s: f64,
}

fn overlap(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.1.min(b.1) - a.0.max(b.0)).max(0.0)
}

/// Judges what one setting of one detector said of one cut. For so long before it, `alone_s`, nothing was cut.
pub fn judge(cut: &Cut, heard: &Heard, said: &Said, alone_s: f64) -> Score {
    let chatter = &heard.chatter_s;
    let near = |from: f64, to: f64| {
        chatter
            .iter()
            .any(|c| from < c.1 + SLACK_S && to > c.0 - SLACK_S)
    };
    let quiet = |from, to| cut.quiet_s(heard, from, to);
    let length: f64 = chatter.iter().map(|c| c.1 - c.0).sum();
    let covered: f64 = chatter
        .iter()
        .flat_map(|c| said.alarms.iter().map(|a| overlap(*c, (a.on_s, a.off_s))))
        .sum();
    let first = said.alarms.iter().find(|a| near(a.on_s, a.off_s));
    // A chatter of the first window was under way: nobody knows since when.
    let began = chatter.first().map(|c| c.0).filter(|t| *t > SLACK_S);
    // False is what begins where there is nothing to call, wherever it ends.
    let false_s: Vec<f64> = said
        .alarms
        .iter()
        .map(|a| a.on_s)
        .filter(|t| *t >= 0.0 && !near(*t, *t) && !cut.excuses(*t, *t))
        .collect();
    let is_before = |t: f64| t < 0.0 && t >= -alone_s;
    let before = said.alarms.iter().filter(|a| is_before(a.on_s)).count();
    let in_air = false_s.iter().filter(|t| cut.in_air(**t)).count();
    Score {
        chatter: !chatter.is_empty(),
        hit: first.is_some(),
        told: first.is_some() || said.warnings_s.iter().any(|w| near(w.0, w.1)),
        covered: if length > 0.0 { covered / length } else { 0.0 },
        latency_s: began.and_then(|t| first.map(|a| (a.on_s - t).max(0.0))),
        false_alarms: false_s.len() as u32,
        false_in_air: in_air as u32,
        before: before as u32,
        quiet_s: quiet(0.0, cut.length_s()),
        alarmed_s: said.alarms.iter().map(|a| quiet(a.on_s, a.off_s)).sum(),
        warned_s: said.warnings_s.iter().map(|w| quiet(w.0, w.1)).sum(),
    }
}

/// Many cuts together.
#[derive(Debug, Clone, Default)]
pub struct Sum {
    /// Cuts.
    pub cuts: u32,
    /// Of them, with chatter that can be heard.
    pub chatters: u32,
    hits: u32,
    told: u32,
    covered: f64,
    latencies_s: Vec<f64>,
    /// False alarms.
    pub false_alarms: u32,
    /// Of them, begun in air.
    pub false_in_air: u32,
    /// Cuts with an alarm before them, see [`Score::before`].
    pub alarmed_before: u32,
    quiet_s: f64,
    alarmed_s: f64,
    warned_s: f64,
}

impl Sum {
    /// What [`Self::cells`] are.
    pub const HEAD: [&str; 8] = [
        "called",
        "called or warned",
        "covered",
        "latency (s)",
        "false alarms an hour",
        "quiet time in alarm",
        "in warning",
        "chatters",
    ];

    /// The figures of a line of a table.
    pub fn cells(&self) -> Vec<String> {
        let part = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.3}"));
        vec![
            part(self.detected()),
            part(self.told()),
            part(self.coverage()),
            self.latency_s()
                .map_or("-".to_owned(), |x| format!("{x:.2}")),
            self.false_per_hour()
                .map_or("-".to_owned(), |x| format!("{x:.1}")),
            part(self.alarmed()),
            part(self.warned()),
            self.chatters.to_string(),
        ]
    }

    /// Adds a cut.
    pub fn add(&mut self, score: &Score) {
        self.cuts += 1;
        self.chatters += u32::from(score.chatter);
        self.hits += u32::from(score.chatter && score.hit);
        self.told += u32::from(score.chatter && score.told);
        self.covered += if score.chatter { score.covered } else { 0.0 };
        self.latencies_s.extend(score.latency_s);
        self.false_alarms += score.false_alarms;
        self.false_in_air += score.false_in_air;
        self.alarmed_before += u32::from(score.before > 0);
        self.quiet_s += score.quiet_s;
        self.alarmed_s += score.alarmed_s;
        self.warned_s += score.warned_s;
    }

    fn of_chatters(&self, sum: f64) -> Option<f64> {
        (self.chatters > 0).then(|| sum / f64::from(self.chatters))
    }

    /// Part of the chatters that were called, 1.
    pub fn detected(&self) -> Option<f64> {
        self.of_chatters(f64::from(self.hits))
    }

    /// Part of the chatters that were called or warned of, 1.
    pub fn told(&self) -> Option<f64> {
        self.of_chatters(f64::from(self.told))
    }

    /// Mean part of a chatter's time in alarm, 1.
    pub fn coverage(&self) -> Option<f64> {
        self.of_chatters(self.covered)
    }

    /// Median delay of the first alarm, s.
    pub fn latency_s(&self) -> Option<f64> {
        let mut sorted = self.latencies_s.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied()
    }

    /// Clearly stable cutting, h.
    pub fn quiet_h(&self) -> f64 {
        self.quiet_s / 3600.0
    }

    /// False alarms in an hour of stable cutting.
    pub fn false_per_hour(&self) -> Option<f64> {
        (self.quiet_s > 0.0).then(|| f64::from(self.false_alarms) / self.quiet_h())
    }

    /// Part of stable cutting in alarm, 1.
    pub fn alarmed(&self) -> Option<f64> {
        (self.quiet_s > 0.0).then(|| self.alarmed_s / self.quiet_s)
    }

    /// Part of stable cutting in warning, 1.
    pub fn warned(&self) -> Option<f64> {
        (self.quiet_s > 0.0).then(|| self.warned_s / self.quiet_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detectors::Alarm;

    #[test]
    fn the_truth_itself_scores_full_and_silence_scores_nothing() {
        let mut seen = (0, 0);
        for seed in 0..6 {
            let cut = Cut::draw(seed).expect("drawn");
            let heard = cut.hear().expect("heard");
            let perfect = Said {
                alarms: heard
                    .chatter_s
                    .iter()
                    .map(|c| Alarm {
                        on_s: c.0,
                        off_s: c.1,
                        f_hz: cut.operational().0,
                    })
                    .collect(),
                warnings_s: Vec::new(),
            };
            let score = judge(&cut, &heard, &perfect, 0.0);
            assert_eq!(score.false_alarms, 0, "{seed}");
            assert_eq!(score.hit, score.chatter);
            if score.chatter {
                seen.0 += 1;
                assert!((score.covered - 1.0).abs() < 1e-9);
            }
            let silent = judge(&cut, &heard, &Said::default(), 0.0);
            assert!(!silent.hit && silent.covered == 0.0 && silent.false_alarms == 0);
            // An alarm over the whole recording is false where it begins with nothing to call.
            let always = Said {
                alarms: vec![Alarm {
                    on_s: 0.0,
                    off_s: cut.length_s(),
                    f_hz: 0.0,
                }],
                warnings_s: Vec::new(),
            };
            let score = judge(&cut, &heard, &always, 0.0);
            let early = heard.chatter_s.first().is_some_and(|c| c.0 < SLACK_S);
            let nothing = !early && !cut.excuses(0.0, 0.0);
            assert_eq!(score.false_alarms, u32::from(nothing), "{seed}");
            assert_eq!(score.false_in_air, u32::from(nothing && cut.in_air(0.0)));
            assert_eq!(score.hit, score.chatter);
            seen.1 += u32::from(nothing);
        }
        assert!(seen.0 > 0 && seen.1 > 0, "{seen:?}");
    }
}
