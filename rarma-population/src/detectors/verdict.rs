//! The verdict by the lines of the spectrum, which is to take the monitor's place.

use super::{Detector, Recording, Said};
use crate::Defect;
use rarma_core::condition::{Band, BandFilter};
use rarma_core::verdict::{Caller, HOP_S, Listening, Verdict, VerdictConfig, number};

/// Lower edge of the band it listens to, a part of the upper one: the first multiples of a
/// slow spindle tell its speed.
const LOW_EDGE: f64 = 0.03;

/// The sum of evidence.
pub(super) struct Lines;

impl Detector for Lines {
    fn name(&self) -> &'static str {
        "verdict"
    }

    fn threshold(&self) -> &'static str {
        "sum of evidence at which it calls, natural log-odds"
    }

    fn thresholds(&self) -> &'static [f64] {
        &[
            number::call.usual,
            -2.5,
            -2.0,
            -1.5,
            -0.5,
            0.0,
            0.5,
            1.0,
            1.5,
            2.0,
            2.5,
            2.9,
        ]
    }

    fn listen(&self, recording: &Recording, thresholds: &[f64]) -> Result<Vec<Said>, Defect> {
        let failed = |why: String| Defect(why);
        let high_hz = Band::usual(recording.fs_hz()).high_hz;
        let band = Band {
            low_hz: LOW_EDGE * high_hz,
            high_hz,
        };
        let mut filter = BandFilter::<f32>::new(band, recording.fs_hz())
            .map_err(|why| failed(why.to_string()))?;
        let fs_hz = recording.fs_hz() / filter.factor() as f64;
        let listening = Listening {
            fs_hz,
            spindle_hz: recording.speed.first_hz(),
            teeth: recording.teeth,
            folding_hz: recording.aliased.then(|| recording.fs_hz()),
        };
        let numbers = &recording.numbers;
        let mut verdict =
            Verdict::<f32>::new(numbers, &listening).map_err(|why| failed(why.to_string()))?;
        let mut told = listening.spindle_hz;
        let mut callers: Vec<(Caller<f32>, Said)> = thresholds
            .iter()
            .map(|call| {
                let numbers = VerdictConfig {
                    call: *call,
                    ..*numbers
                };
                (Caller::new(&numbers), Said::default())
            })
            .collect();
        for (n, x) in recording.samples().iter().enumerate() {
            let Some(y) = filter.process(*x) else {
                continue;
            };
            let Some(judgement) = verdict.process(y) else {
                continue;
            };
            let t_s = n as f64 / recording.fs_hz();
            for (caller, said) in &mut callers {
                if !caller.hear(judgement.evidence) {
                    continue;
                }
                if told.is_some() {
                    said.calls(t_s, t_s + HOP_S, f64::from(judgement.f_hz));
                } else {
                    said.warns(t_s, t_s + HOP_S);
                }
            }
            let now = recording.speed.known_hz(t_s);
            if now != told
                && let Some(hz) = now
            {
                verdict.tell_speed(hz as f32);
                told = now;
            }
        }
        Ok(callers.into_iter().map(|(_, said)| said).collect())
    }
}
