//! What the population is drawn from: every range, with its unit and what it stands for.
//!
//! The ranges cover workshops, not one machine. What is left out is said where it is
//! left out: a range narrowed for the sake of time is a limit of the population.

use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// A range of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Lowest value.
    pub low: f64,
    /// Highest value.
    pub high: f64,
    /// Drawn evenly in the logarithm, for quantities that spread over decades.
    pub log: bool,
}

impl Span {
    /// Drawn evenly.
    #[must_use]
    pub const fn even(low: f64, high: f64) -> Self {
        Self {
            low,
            high,
            log: false,
        }
    }

    /// Drawn evenly in the logarithm; both ends above 0.
    #[must_use]
    pub const fn ratio(low: f64, high: f64) -> Self {
        Self {
            low,
            high,
            log: true,
        }
    }

    /// One value.
    pub fn draw(&self, rng: &mut ChaCha8Rng) -> f64 {
        let u: f64 = rng.random();
        if self.log {
            self.low * (self.high / self.low).powf(u)
        } else {
            self.low + u * (self.high - self.low)
        }
    }
}

/// True with this probability.
pub(super) fn chance(rng: &mut ChaCha8Rng, probability: f64) -> bool {
    rng.random::<f64>() < probability
}

/// One of several.
pub(super) fn one_of<T: Copy>(rng: &mut ChaCha8Rng, choices: &[T]) -> T {
    choices[rng.random_range(0..choices.len())]
}

// The machine.

/// Part of the cuts that are turned; the others are milled.
pub const TURNED: f64 = 0.2;
/// Modes of a structure that matter, most.
pub const MOST_MODES: usize = 4;
/// Natural frequency, Hz.
pub const MODE_HZ: Span = Span::ratio(90.0, 3000.0);
/// Damping ratio of the structure, 1.
pub const ZETA: Span = Span::ratio(0.005, 0.06);
/// Modal stiffness, N/m.
pub const STIFFNESS_N_PER_M: Span = Span::ratio(5e6, 80e6);
/// Teeth of a cutter, from and to.
pub const TEETH: (usize, usize) = (1, 8);
/// Spindle speed of a mill, 1/min.
pub const SPEED_RPM: Span = Span::ratio(300.0, 24_000.0);
/// That of a lathe.
pub const TURNED_RPM: Span = Span::ratio(300.0, 6000.0);
/// Waves of the fastest mode between two teeth of a mill, most: beyond it the delay
/// equation takes seconds to minutes. So fast modes do not meet slow teeth: a limit of the
/// population. (With unequal pitch it is the waves of a whole turn.)
pub const MOST_WAVES: f64 = 45.0;
/// Tangential cutting coefficient, N/m²: aluminium to hard steel.
pub const CUTTING_N_PER_M2: Span = Span::ratio(5e8, 3e9);
/// Radial over tangential coefficient, 1.
pub const RADIAL_PART: Span = Span::even(0.1, 0.6);
/// Edge coefficient, N/m.
pub const EDGE_N_PER_M: Span = Span::ratio(5e3, 5e4);
/// Feed a tooth (milling) or a turn (turning), m.
pub const FEED_M: Span = Span::ratio(0.03e-3, 0.25e-3);
/// Radial immersion over the diameter, 1.
pub const IMMERSION: Span = Span::ratio(0.05, 1.0);
/// Runout of a tooth over the feed, 1.
pub const RUNOUT: Span = Span::even(0.0, 0.3);
/// Part of the cutters with unequal pitch, and how far a pitch is off, 1.
pub const UNEQUAL_PITCH: (f64, Span) = (0.15, Span::even(0.02, 0.12));
/// Noise of the cutting force over its value, 1 (grain, built-up edge).
pub const FORCE_NOISE: Span = Span::ratio(0.02, 0.3);
/// Noise of bearings and drives on the tool, N.
pub const BACKGROUND_N: Span = Span::ratio(0.1, 3.0);

// What is done with it.

/// Depth over the limit of cuts that are meant to chatter.
pub const DEEP: Span = Span::even(1.15, 2.0);
/// Depth over the limit of cuts that are meant to be quiet.
pub const SHALLOW: Span = Span::even(0.1, 0.8);
/// Depth over the limit of cuts between the two.
pub const BETWEEN: Span = Span::even(0.8, 1.15);
/// Parts of the population that are deep, and between; the others are shallow.
pub const DEEP_BETWEEN: (f64, f64) = (0.4, 0.1);
/// Length of a recording, s.
pub const LENGTH_S: Span = Span::even(4.0, 8.0);
/// Air before the cut, s.
pub const AIR_S: Span = Span::even(0.4, 1.5);
/// Time a tool takes into the cut or out of it, s.
pub const ENTRY_S: Span = Span::ratio(0.005, 0.3);
/// Time over which a growing cut reaches its depth, s.
pub const GROWING_S: Span = Span::even(1.0, 3.0);
/// Part of the milled cuts in which someone turns the override, and by how much, 1. A
/// lathe keeps its speed: a limit of the population.
pub const OVERRIDE: (f64, Span) = (0.2, Span::even(0.05, 0.2));
/// Time an override takes in a step and in a ramp, s; the two come equally often.
pub const OVERRIDE_S: [Span; 2] = [Span::even(0.05, 0.3), Span::even(0.5, 2.5)];
/// Part of the milled cuts that begin in air whose spindle is still running up to its
/// speed in the first sample, and part of its speed that it has there, 1.
pub const RUN_UP: (f64, Span) = (0.15, Span::even(0.55, 0.9));
/// Simulated before a recording that begins within the cut, s.
pub const LEAD_S: f64 = 1.0;

/// How late a control tells the spindle's speed, s.
pub const CONTROL_DELAY_S: Span = Span::even(0.02, 0.25);

// What listens.

/// Sampling rates, Hz; the first is a logger of the kind whose recordings are published.
pub const RATES_HZ: [f64; 7] = [
    1650.0, 8000.0, 16_000.0, 25_600.0, 44_100.0, 48_000.0, 96_000.0,
];
/// Part of the samplers without an anti-alias filter.
pub const UNFILTERED: f64 = 0.15;
/// Bits of the converter.
pub const BITS: [u32; 4] = [12, 14, 16, 16];
/// Full scale over the loudest sample: the gain.
pub const HEADROOM: Span = Span::ratio(1.2, 30.0);
/// Part of the recordings that clip, and part of their samples that do: few enough for
/// `rarma` not to refuse the file (one in a thousand).
pub const CLIPPED: (f64, Span) = (0.07, Span::ratio(1e-5, 8e-4));
/// Resonance of the enclosure: how often, Hz, damping, gain over the direct sound.
pub const ENCLOSURE: (f64, Span, Span, Span) = (
    0.5,
    Span::ratio(150.0, 1500.0),
    Span::even(0.02, 0.1),
    Span::even(0.3, 3.0),
);
/// Distance of the sensor, m; 0 is an accelerometer.
pub const DISTANCE_M: Span = Span::even(0.1, 1.5);

// What else is to be heard. Levels in dB over the forced vibration of the cut.

/// White noise, dB.
pub const NOISE_DB: Span = Span::even(-50.0, -10.0);
/// Fans and pumps: how often, how many at most, Hz, dB, and how far they wander (part of
/// their frequency in a second).
pub const TONES: (f64, usize, Span, Span, Span) = (
    0.4,
    3,
    Span::ratio(80.0, 2500.0),
    Span::even(-30.0, 0.0),
    Span::ratio(1e-5, 2e-3),
);
/// Hum of the mains: how often, dB of its strongest multiple.
pub const MAINS: (f64, Span) = (0.25, Span::even(-30.0, -5.0));
/// Knocks: how often, most, Hz of what rings, its damping, dB of its peak.
pub const KNOCKS: (f64, usize, Span, Span, Span) = (
    0.25,
    6,
    Span::ratio(150.0, 3000.0),
    Span::ratio(0.01, 0.1),
    Span::even(-5.0, 20.0),
);
/// Compressed air: how often, s, dB.
pub const AIR_JET: (f64, Span, Span) = (0.15, Span::even(0.3, 2.0), Span::even(-15.0, 8.0));
/// Speech: how often, Hz of the voice, dB.
pub const SPEECH: (f64, Span, Span) = (0.1, Span::even(90.0, 250.0), Span::even(-20.0, 0.0));
/// The chatter of a machine next to it, through floor and air: how often, Hz, dB, wander.
pub const NEIGHBOUR: (f64, Span, Span, Span) = (
    0.1,
    Span::ratio(150.0, 2500.0),
    Span::even(-25.0, -3.0),
    Span::ratio(1e-4, 3e-3),
);
/// What a box may have heard before a cut, dB: something that is hit (110 to 120 dB of peak beside 80 to 90 dB of cutting), at
/// its peak; compressed air; and what is left of the room at night.
pub const LOUD_KNOCK_DB: f64 = 30.0;
/// See [`LOUD_KNOCK_DB`].
pub const LOUD_JET_DB: f64 = 15.0;
/// See [`LOUD_KNOCK_DB`].
pub const NIGHT_DB: f64 = -40.0;
/// A tone of unknown origin this loud, dB, is as loud as the quietest chatter that counts
/// ([`super::heard::AUDIBLE`] of the power), and where it is first heard in the cut nobody
/// can tell which it is.
pub const UNDECIDABLE_DB: f64 = -6.0;
/// Time that a tone must have been heard alone to be known, s.
pub const KNOWN_S: f64 = 0.3;
