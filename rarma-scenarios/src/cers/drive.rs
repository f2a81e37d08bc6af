//! What is superposed on the bias: the commanded sequence of each direction.

use rarma_rigs::cers::{
    BandNoise, BandNoiseConfig, Dodge, LineSet, Lines, Phases, Prbs, RealFft, Regulator,
    RegulatorConfig, Tuning, lower_crest, multisine,
};

/// Periods of the current loop a second.
pub const LOOP_HZ: f64 = 40e3;
/// Rate of a record, Hz: every second period.
pub const RATE_HZ: f64 = 20e3;
/// Samples of a block of the record: 4.88 Hz.
pub const BLOCK: usize = 4096;
/// A period of the multisine in periods of the loop.
const TABLE: usize = 2 * BLOCK;
/// Lines nearer than this to a multiple of the speed are left out, Hz.
const CLEARANCE_HZ: f64 = 3.0;
/// Register and hold of the binary sequence: 65 535 steps at 13.3 kHz, 4.9 s.
const PRBS: (u32, u32) = (16, 3);

/// Kinds of excitation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// Lines on the blocks' grid, Schroeder's phases.
    Multisine,
    /// Gaussian in a band, clipped at three deviations.
    Noise,
    /// A shift register.
    Prbs,
}

impl Signal {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Multisine => "multisine",
            Self::Noise => "noise",
            Self::Prbs => "prbs",
        }
    }
}

/// An excitation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// What kind.
    pub signal: Signal,
    /// Whether x and y are driven.
    pub axes: [bool; 2],
    /// From where to where, Hz; a binary sequence ignores it.
    pub band_hz: (f64, f64),
    /// Current, A rms.
    pub rms_a: f64,
    /// Speed whose multiples the lines dodge, revolutions/s; 0: none.
    pub dodge_hz: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            signal: Signal::Multisine,
            axes: [true; 2],
            band_hz: (150.0, 5000.0),
            rms_a: 0.18,
            dodge_hz: 0.0,
        }
    }
}

impl Drive {
    /// Lines of a direction; `None` if the signal is no multisine or the direction rests.
    pub fn lines(&self, axis: usize) -> Option<Lines<f64>> {
        if self.signal != Signal::Multisine || !self.axes[axis] {
            return None;
        }
        let set = match self.axes {
            [true, true] => [LineSet::Odd, LineSet::Even][axis],
            _ => LineSet::All,
        };
        let dodge = (self.dodge_hz > 0.0).then_some(Dodge {
            spindle_hz: self.dodge_hz,
            clearance_hz: CLEARANCE_HZ,
        });
        Lines::new(RATE_HZ / BLOCK as f64, self.band_hz, set, dodge).ok()
    }
}

/// One direction's source.
#[derive(Debug, Clone)]
enum Source {
    Rest,
    Table(Vec<f64>),
    Noise(Box<BandNoise<f64>>),
    Prbs(Prbs),
}

/// The commanded sequences, period by period.
#[derive(Debug, Clone)]
pub struct Commands {
    axes: [Source; 2],
    rms_a: f64,
}

impl Commands {
    /// From the first period on; a direction that no line fits rests.
    pub fn new(drive: &Drive, seed: u64) -> Self {
        let source = |axis: usize| {
            if !drive.axes[axis] {
                return Source::Rest;
            }
            match drive.signal {
                Signal::Multisine => drive
                    .lines(axis)
                    .and_then(|lines| period(&lines, drive.dodge_hz > 0.0))
                    .map_or(Source::Rest, Source::Table),
                Signal::Noise => BandNoise::new(&BandNoiseConfig {
                    rate_hz: LOOP_HZ,
                    low_hz: drive.band_hz.0,
                    high_hz: drive.band_hz.1,
                    seed: (2 * seed + 1) as u32 * 7919 + axis as u32,
                })
                .map_or(Source::Rest, |n| Source::Noise(Box::new(n))),
                Signal::Prbs => Prbs::new(PRBS.0, PRBS.1).map_or(Source::Rest, |p| {
                    // Half a period apart the two directions are orthogonal.
                    Source::Prbs(p.advanced(axis as u32 * (1 << (PRBS.0 - 1))))
                }),
            }
        };
        Self {
            axes: [source(0), source(1)],
            rms_a: drive.rms_a,
        }
    }

    /// Largest current of either direction from the first period on, A.
    pub fn peak_a(&self) -> f64 {
        let mut commands = self.clone();
        (0..2 * TABLE).fold(0.0, |m: f64, n| {
            let [x, y] = commands.at(n);
            m.max(f64::from(x.abs())).max(f64::from(y.abs()))
        })
    }

    /// Changes of the current at period `n`, A; periods one after the other.
    pub fn at(&mut self, n: usize) -> [f32; 2] {
        let rms = self.rms_a;
        let mut one = |axis: usize| {
            let unit = match &mut self.axes[axis] {
                Source::Rest => 0.0,
                Source::Table(table) => table[n % table.len()],
                Source::Noise(noise) => noise.next_sample(),
                Source::Prbs(prbs) => f64::from(prbs.next_sample()),
            };
            (rms * unit) as f32
        };
        [one(0), one(1)]
    }
}

fn period(lines: &Lines<f64>, gaps: bool) -> Option<Vec<f64>> {
    let mut fft = RealFft::<f64, BLOCK>::default();
    let mut out = vec![0.0; TABLE];
    multisine(lines, Phases::Schroeder, |_| 1.0, &mut fft, &mut out).ok()?;
    if gaps {
        // Schroeder's phases are for lines that follow each other; gaps raise the peaks.
        let mut work = vec![0.0; TABLE];
        lower_crest(lines, 150, &mut fft, &mut out, &mut work).ok()?;
    }
    Some(out)
}

/// The regulators' coefficients for a coil.
///
/// # Errors
/// The field out of range.
pub fn tuning(inductance_h: f64, resistance_ohm: f64, most_duty: f64) -> Result<Tuning, String> {
    RegulatorConfig {
        inductance_h: inductance_h as f32,
        resistance_ohm: resistance_ohm as f32,
        rate_hz: LOOP_HZ as f32,
        crossover: 1.0 / 18.0,
        most_duty: most_duty as f32,
    }
    .tuning()
    .map_err(|why| why.to_string())
}

/// Largest voltage that the regulators would ask for: bias and excitation through the loop
/// on a coil of constant inductance, with no limit; two periods of the multisine, or as
/// much of another signal. The commands are those from the first period on.
pub fn needed_volts(
    from_start: &Commands,
    bias_a: f64,
    inductance_h: f64,
    resistance_ohm: f64,
) -> f64 {
    let Ok(mut tuning) = tuning(inductance_h, resistance_ohm, 1.0) else {
        return f64::INFINITY;
    };
    tuning.most_duty = f32::MAX;
    let mut most = 0.0f64;
    let keep = (-resistance_ohm / (inductance_h * LOOP_HZ)).exp();
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
        let mut commands = from_start.clone();
        let (mut regulator, mut current) = (Regulator::default(), bias_a);
        // The sum starts where the bias holds itself.
        let (mut volts, mut next) = (bias_a * resistance_ohm, bias_a * resistance_ohm);
        for n in 0..3 * TABLE {
            let target = bias_a + sign * f64::from(commands.at(n)[axis]);
            let asked = regulator.update(&tuning, target as f32, current as f32, 1.0);
            current = keep * current + (1.0 - keep) * volts / resistance_ohm;
            volts = next;
            next = f64::from(asked.duty);
            if n >= TABLE {
                most = most.max(next.abs());
            }
        }
    }
    most
}
