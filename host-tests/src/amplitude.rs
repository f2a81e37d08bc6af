//! The amplitude criterion on whole signals: envelope and statistic beside a monitor,
//! as the box would run them.

use crate::signal::white;
use core::f64::consts::TAU;
use rarma_core::Order;
use rarma_core::condition::{Band, BandFilter, KnownLines};
use rarma_core::decide::{Amplitude, AmplitudeReading, Fpk, Label, Mode};
use rarma_core::monitor::{DECISION_PERIOD_S, Monitor, MonitorConfig};
use rarma_core::spectrum::Envelope;

/// Spindle lines removed at most, and the memory of that, s.
const LINES: usize = 24;
const LINES_MEMORY_S: f64 = 0.5;

/// How a signal is listened to.
#[derive(Debug, Clone)]
pub struct Listening {
    /// Rate, Hz.
    pub fs_hz: f64,
    /// Band, Hz.
    pub band: Band,
    /// Order of the monitor.
    pub order: Order,
    /// Memory of the statistic, s.
    pub memory_s: f64,
    /// Spindle frequency, Hz, if its multiples are to be labelled.
    pub spindle_hz: Option<f64>,
    /// Whether these multiples in the band are subtracted ahead of everything.
    pub remove_lines: bool,
}

/// What was found at the end of a signal, and on the way.
#[derive(Debug, Clone)]
pub struct Heard {
    /// The last reading.
    pub last: AmplitudeReading<f64>,
    /// Median of S over all decisions after the memory had filled.
    pub scintillation: f64,
    /// Medians of frequency, Hz, and damping ratio that were fed to it.
    pub mode: (f64, f64),
    /// Verdicts after the memory had filled, one a decision.
    pub verdicts: Vec<Amplitude>,
}

impl Heard {
    /// Part of the decisions with this verdict.
    #[must_use]
    pub fn share(&self, verdict: Amplitude) -> f64 {
        let n = self.verdicts.iter().filter(|v| **v == verdict).count();
        n as f64 / self.verdicts.len().max(1) as f64
    }

    /// The parts of all verdicts for a table, %: forced, suspicious, self-excited, not
    /// stationary, too short.
    #[must_use]
    pub fn shares(&self) -> String {
        [
            Amplitude::Forced,
            Amplitude::Suspicious,
            Amplitude::SelfExcited,
            Amplitude::NotStationary,
            Amplitude::TooShort,
        ]
        .map(|verdict| format!("{:.0}", 100.0 * self.share(verdict)))
        .join(" / ")
    }
}

/// Runs a monitor, and the statistic of one mode that is no forced line: the least
/// damped after half a second, and then that one for as long as it is there.
///
/// Without such a mode there are no verdicts, and the medians are NaN.
///
/// # Panics
/// The monitor refuses its settings.
#[must_use]
pub fn listen(how: &Listening, samples: &[f64]) -> Heard {
    let config = MonitorConfig {
        band: Some(how.band),
        order: how.order,
        spindle_hz: how.spindle_hz,
        ..MonitorConfig::new(how.fs_hz)
    };
    let mut monitor = Monitor::<f32>::new(&config).expect("settings in range");
    let mut filter = BandFilter::<f32>::new(how.band, how.fs_hz).expect("a band");
    let fs = how.fs_hz / filter.factor() as f64;
    let lines: Vec<f64> = how
        .spindle_hz
        .filter(|_| how.remove_lines)
        .into_iter()
        .flat_map(|spindle| (1..).map(move |k| spindle * f64::from(k)))
        .skip_while(|f| *f < how.band.low_hz)
        .take_while(|f| *f < how.band.high_hz)
        .collect();
    let forgetting = 1.0 - 1.0 / (LINES_MEMORY_S * how.fs_hz);
    let mut known = KnownLines::<f64, LINES, { 2 * LINES }>::new(&lines, how.fs_hz, forgetting)
        .expect("lines in the band");
    let mut envelope = Envelope::<f32>::new(fs);
    let mut fpk = Fpk::<f32>::with_memory(DECISION_PERIOD_S, how.memory_s);
    let mut followed = Followed::default();
    let (mut s, mut f, mut zeta) = (Vec::new(), Vec::new(), Vec::new());
    let mut verdicts = Vec::new();
    for (n, x) in samples.iter().enumerate() {
        let x = if how.remove_lines {
            known.process(*x) as f32
        } else {
            *x as f32
        };
        if let Some(y) = filter.process(x) {
            envelope.process(y);
        }
        let Some(report) = monitor.push(x) else {
            continue;
        };
        if (n as f64) < 0.5 * how.fs_hz {
            continue;
        }
        let Some(mode) = followed.mode(&report.modes) else {
            continue;
        };
        envelope.steer(mode.frequency, mode.damping);
        fpk.push(envelope.squared(), mode.frequency, mode.damping);
        if n as f64 > (how.memory_s + 0.5) * how.fs_hz {
            let reading = fpk.reading();
            s.push(f64::from(reading.scintillation));
            f.push(f64::from(mode.frequency));
            zeta.push(f64::from(mode.damping));
            verdicts.push(reading.verdict);
        }
    }
    let median = |v: &[f64]| match v {
        [] => f64::NAN,
        v => crate::statistics::quantile(v, 0.5),
    };
    Heard {
        last: widened(&fpk.reading()),
        scintillation: median(&s),
        mode: (median(&f), median(&zeta)),
        verdicts,
    }
}

/// The mode that is being followed: its last frequency, and the decisions without it.
#[derive(Debug, Default)]
struct Followed {
    f_hz: Option<f32>,
    missing: u32,
}

impl Followed {
    /// The mode within 5 % of the last one; without it for 0.1 s, the least damped.
    fn mode(&mut self, modes: &[Option<Mode<f32>>]) -> Option<Mode<f32>> {
        // Beyond 0.2 a pole is the background's, not a mode's.
        let free = || {
            let candidates = modes.iter().flatten();
            // A line of unknown origin is labelled forced, too, and is followed.
            let explained = |m: &Mode<f32>| m.label == Label::Forced && m.origin.explains();
            candidates.filter(move |m| !explained(m) && m.damping < 0.2)
        };
        let off = |m: &Mode<f32>, f: f32| (m.frequency / f - 1.0).abs();
        let found = match self.f_hz {
            Some(f) => free()
                .filter(|m| off(m, f) < 0.05)
                .min_by(|a, b| off(a, f).total_cmp(&off(b, f))),
            None => free().min_by(|a, b| a.damping.total_cmp(&b.damping)),
        };
        self.missing = found.map_or(self.missing + 1, |_| 0);
        if self.missing > 50 {
            self.f_hz = None;
        }
        self.f_hz = found.map(|m| m.frequency).or(self.f_hz);
        found.copied()
    }
}

fn widened(r: &AmplitudeReading<f32>) -> AmplitudeReading<f64> {
    AmplitudeReading {
        scintillation: r.scintillation.into(),
        scintillation_sd: r.scintillation_sd.into(),
        effective: r.effective.into(),
        mean: r.mean.into(),
        verdict: r.verdict,
        z: r.z.into(),
        drift_z: r.drift_z.into(),
    }
}

/// A van der Pol oscillator in white force noise (eq. 23 of the thesis without the
/// noise on the stiffness).
///
/// ```text
/// x″ + 2ω(−ζ₀ + 4k·x²)x′ + ω²x = n(t),   x in units of the amplitude's scale
/// averaged: h ∝ −ζ₀A + kA³,   w(V) ∝ exp((2ω/c)(ζ₀V − kV²/2)),  c the noise's strength
/// ```
#[derive(Debug, Clone, Copy)]
pub struct VanDerPol {
    /// Natural frequency, Hz.
    pub f_hz: f64,
    /// ζ₀: damping ratio lost at rest, ≥ 0.
    pub lost: f64,
    /// k: gained back at V = 1.
    pub gained: f64,
    /// Standard deviation of the Gaussian bell of which w(V) is the part above 0.
    pub sd: f64,
}

impl VanDerPol {
    /// Samples at `fs_hz`; sixteen steps each, the rotation exact.
    #[must_use]
    pub fn play(&self, fs_hz: f64, seconds: f64, seed: u64) -> Vec<f64> {
        const STEPS: usize = 16;
        let dt = 1.0 / (fs_hz * STEPS as f64);
        let w = TAU * self.f_hz;
        let (sin, cos) = (w * dt).sin_cos();
        // s² = c/(2ωk); a force of intensity g² on the velocity in units of ω gives
        // d(x² + v²) the diffusion c·V with c = g².
        let kick = (2.0 * w * self.gained).sqrt() * self.sd * dt.sqrt();
        let mut noise = white(seed);
        let (mut x, mut v) = (self.sd, 0.0);
        let settle = (0.5 * fs_hz) as usize;
        let mut out = Vec::with_capacity((seconds * fs_hz) as usize);
        for n in 0..settle + (seconds * fs_hz) as usize {
            for _ in 0..STEPS {
                (x, v) = (cos * x + sin * v, cos * v - sin * x);
                v -= 2.0 * w * dt * (4.0 * self.gained * x * x - self.lost) * v;
                v += kick * noise.next().unwrap_or(0.0);
            }
            if n >= settle {
                out.push(x);
            }
        }
        out
    }
}
