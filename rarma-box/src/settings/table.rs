//! The settings, each in one place: number, name, unit, range, default, effect.
//!
//! This table makes the typed keys, the checks, the page for people and the schema for
//! programs. A number is never used again for something else. `version` counts the
//! meanings a setting has had: a stored record of another one is not read.

use super::value::{Key, Kind, Real, Secret, Setting, Takes, Whole};
use rarma_core::verdict::{Number, number};

const fn low(of: Number) -> f32 {
    of.least as f32
}

const fn high(of: Number) -> f32 {
    of.most as f32
}

const fn usual(of: Number) -> f32 {
    of.usual as f32
}

/// A recording may begin in a cut (15 dB); a box is switched on beside a machine that idles. With 15 dB 50 of 237 random machines
/// have an alarm of a fan or a pump before anything is cut, with 10 none, and 0.72 of the chatters are called for 0.74
/// (`rarma population --heard-before air`).
const UNHEARD_IDLE_DB: f32 = 10.0;

macro_rules! kind {
    (Real, $low:expr, $high:expr, $default:expr) => {
        Kind::Real {
            low: $low,
            high: $high,
            default: $default,
        }
    };
    (Whole, $low:expr, $high:expr, $default:expr) => {
        Kind::Whole {
            low: $low,
            high: $high,
            default: $default,
        }
    };
    (Secret, $low:expr, $high:expr, $default:expr) => {
        Kind::Key
    };
}

macro_rules! table {
    ($($number:literal $key:ident: $kind:ident $name:literal, $unit:literal, $low:expr, $high:expr, $default:expr, $takes:ident, $effect:literal;)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        #[derive(Clone, Copy)]
        enum Place { $($key,)* }

        $(
            #[doc = concat!("`", $name, "`: ", $effect)]
            pub const $key: Key<$kind> = Key::at(Place::$key as usize);
        )*

        /// Their numbers, which ascend.
        pub(super) const NUMBERS: [u16; [$($number,)*].len()] = [$($number,)*];

        /// All settings, in the order of the page.
        pub static SETTINGS: [Setting; [$($number,)*].len()] = [
            $(Setting {
                number: $number,
                version: 1,
                name: $name,
                unit: $unit,
                kind: kind!($kind, $low, $high, $default),
                takes: Takes::$takes,
                effect: $effect,
            },)*
        ];
    };
}

const _: () = {
    let mut place = 1;
    while place < NUMBERS.len() {
        assert!(NUMBERS[place - 1] < NUMBERS[place], "numbers ascend");
        place += 1;
    }
};

table! {
    1 BOX_START: Whole "box.start", "1", 0, 1, 1, AtStart,
        "mode after a reset: 0 safe, 1 monitor";
    2 LINK_HEARTBEAT: Real "link.heartbeat", "s", 0.05, 5.0, 0.5, AtOnce,
        "outputs go off after this long without a heartbeat of the host";
    3 TELL_VERDICT: Real "tell.verdict", "s", 0.002, 60.0, 0.05, NextMode,
        "time between two verdicts; alarms come at once";
    4 TELL_STATUS: Real "tell.status", "s", 0.01, 60.0, 0.2, AtOnce,
        "time between two status messages";
    5 TELL_HEALTH: Real "tell.health", "s", 0.1, 600.0, 1.0, AtOnce,
        "time between two health messages (deadlines, drops, counts)";

    10 MONITOR_ORDER: Whole "monitor.order", "1", 0, 7, 2, NextMode,
        "model order: 0 (2,1), 1 (2,2), 2 (4,3), 3 (4,4), 4 (6,5), 5 (6,6), 6 (8,7), 7 (8,8)";
    11 MONITOR_BAND_LOW: Real "monitor.band-low", "Hz", 10.0, 10000.0, 300.0, NextMode,
        "lower edge of the band that is analysed";
    12 MONITOR_BAND_HIGH: Real "monitor.band-high", "Hz", 20.0, 20000.0, 2500.0, NextMode,
        "upper edge of the band that is analysed";
    13 MONITOR_THRESHOLD: Real "monitor.threshold", "1", 0.0005, 0.2, 0.01, NextMode,
        "damping ratio below which a mode counts as undamped";
    14 MONITOR_MEMORY: Real "monitor.memory", "s", 0.001, 100.0, 0.1, NextMode,
        "memory of the estimator";
    15 MONITOR_SPINDLE: Real "monitor.spindle", "Hz", 0.0, 5000.0, 0.0, AtOnce,
        "spindle frequency where it is known; 0: unknown, from the next start of a mode on";
    16 MONITOR_TEETH: Whole "monitor.teeth", "1", 0, 1000, 0, NextMode,
        "teeth on the cutter where they are known; 0: unknown";
    17 TACHO_PULSES: Whole "tacho.pulses", "1", 0, 100, 0, NextMode,
        "pulses of the tacho a turn; 0: there is no tacho";
    18 TACHO_SILENCE: Real "tacho.silence", "s", 0.05, 60.0, 1.0, AtOnce,
        "a tacho without a pulse for this long is told as silent";

    19 MONITOR_MICROPHONES: Whole "monitor.microphones", "1", 1, 2, 1, NextMode,
        "2: a second microphone takes over when the first is stuck, silent, noisy or not a number";

    30 SUPPLY_LOW: Real "supply.low", "V", 5.0, 100.0, 40.0, AtOnce,
        "least supply of the power stage";
    31 SUPPLY_HIGH: Real "supply.high", "V", 10.0, 100.0, 56.0, AtOnce,
        "greatest supply of the power stage";
    32 SUPPLY_SPAN: Real "supply.span", "V", 10.0, 200.0, 80.0, AtStart,
        "supply at the converter's upper end";

    40 CERS_BIAS: Real "cers.bias", "A", 0.05, 2.5, 0.8, NextArm,
        "bias current of every coil";
    41 CERS_MOST: Real "cers.most", "A", 0.1, 3.0, 2.5, NextArm,
        "no target of a coil exceeds this";
    42 CERS_TRIP: Real "cers.trip", "A", 0.2, 3.7, 3.0, NextArm,
        "a coil current beyond this is a fault";
    43 CERS_NOMINAL: Real "cers.nominal", "A", 0.1, 3.0, 1.2, NextArm,
        "current a winding carries for ever";
    44 CERS_THERMAL: Real "cers.thermal", "s", 1.0, 1000.0, 100.0, NextArm,
        "time constant of a winding's heat";
    45 CERS_SPAN: Real "cers.span", "A", 0.5, 100.0, 8.0, AtStart,
        "current from one end of a sensor's range to the other";
    46 CERS_RESISTANCE: Real "cers.resistance", "ohm", 0.05, 50.0, 4.0, NextArm,
        "resistance of a coil";
    47 CERS_INDUCTANCE: Real "cers.inductance", "H", 1e-4, 0.1, 4.19e-3, NextArm,
        "inductance of a coil at the nominal gap";
    48 CERS_RAMP: Real "cers.ramp", "s", 0.1, 10.0, 0.1, NextArm,
        "time to the bias current, and back";
    49 CERS_GAP: Real "cers.gap", "m", 2e-5, 2e-3, 1.5e-4, NextArm,
        "nominal gap: warned of below 0.5, switched off below 0.35 of it";
    50 CERS_GAP_SPAN: Real "cers.gap-span", "m", 5e-5, 5e-3, 4e-4, AtStart,
        "gap at the converter's upper end; 0 at the lower";
    51 CERS_OVERSPEED: Real "cers.overspeed", "Hz", 1.0, 2000.0, 310.0, AtOnce,
        "a spindle faster than this is a fault";

    52 CERS_POLE_ANGLE: Real "cers.pole-angle", "rad", 0.0, 1.2, core::f32::consts::FRAC_PI_8, NextArm,
        "half the angle between the poles of a magnet: 22.5° with eight poles";
    53 CERS_LAMINATION: Real "cers.lamination", "m", 0.0, 2e-3, 3.5e-4, NextArm,
        "thickness of a lamination: the lag of the flux is taken out of responses; 0: it is not";
    54 CERS_IRON_PATH: Real "cers.iron-path", "m", 0.0, 2.0, 0.12, NextArm,
        "path of the flux in iron";
    55 CERS_LEAKAGE: Real "cers.leakage", "1", 0.0, 1.0, 0.15, NextArm,
        "part of the inductance that does not change with the gap, over that which does";
    56 CERS_GAP_CORNER: Real "cers.gap-corner", "Hz", 0.0, 1e5, 1e4, NextArm,
        "corner of the displacement sensors (second order), taken out of responses; 0: none";
    57 CERS_ORDER: Whole "cers.order", "1", 0, 8, 0, NextMode,
        "listens while exciting: 0 no, n: the model order that monitor.order calls n − 1";
    58 CERS_WINDING_LIMIT: Real "cers.winding-limit", "K", 300.0, 500.0, 393.15, AtOnce,
        "a winding hotter than this is a fault";
    59 CERS_THERMISTOR: Real "cers.thermistor", "K", 0.0, 6000.0, 0.0, AtOnce,
        "B of a 10 kΩ thermistor on the gauge's input while the mode is cers; 0: there is none";

    60 LDBB_MOST: Real "ldbb.most", "Pa", 4e4, 9e5, 7.2e5, NextArm,
        "no pressure set point exceeds this; 1.1 times it is a fault";
    61 LDBB_REST: Real "ldbb.rest", "Pa", 0.0, 1e5, 4e4, NextArm,
        "pressure after arming: holds the bar between the balls";
    62 LDBB_RATE: Real "ldbb.rate", "Pa/s", 1e4, 1e7, 1e6, NextArm,
        "the set point moves no faster";
    63 LDBB_TOLERANCE: Real "ldbb.tolerance", "Pa", 5e3, 2e5, 3e4, NextArm,
        "a pressure this far off the expected one for ldbb.settle is a fault";
    64 LDBB_SETTLE: Real "ldbb.settle", "s", 0.05, 10.0, 0.5, NextArm,
        "see ldbb.tolerance";
    65 LDBB_VALVE_SPAN: Real "ldbb.valve-span", "Pa", 1e5, 2e6, 9e5, AtStart,
        "pressure the regulator gives at the converter's upper end";
    66 LDBB_PRESSURE_SPAN: Real "ldbb.pressure-span", "Pa", 1e5, 2e6, 1e6, AtStart,
        "pressure from 10 % to 90 % of the transducer's range";
    67 LDBB_GAUGE_SPAN: Real "ldbb.gauge-span", "m", 1e-4, 0.1, 2.4e-3, AtStart,
        "length from one end of the gauge's range to the other; zero is in its middle";
    68 LDBB_GAUGE_LIMIT: Real "ldbb.gauge-limit", "m", 1e-5, 0.05, 9e-4, NextArm,
        "a gauge beyond ± this is a fault";
    69 LDBB_LAG: Real "ldbb.lag", "s", 0.005, 2.0, 0.1, NextArm,
        "time constant of regulator and cylinder";
    70 LDBB_CROSSOVER: Real "ldbb.crossover", "Hz", 0.0, 2.0, 0.5, NextArm,
        "crossover of the outer pressure loop; 0 switches it off";
    71 LDBB_TRIM: Real "ldbb.trim", "Pa", 0.0, 1e5, 2.5e4, NextArm,
        "the outer pressure loop adds or takes no more than this";
    72 LDBB_WINDOW: Real "ldbb.window", "Pa", 200.0, 5e4, 2e3, NextArm,
        "a pressure is settled this near its set point, moving by less than this a second";
    73 LDBB_WINDOW_TIME: Real "ldbb.window-time", "s", 0.1, 30.0, 1.0, NextArm,
        "for so long";
    74 LDBB_DITHER: Real "ldbb.dither", "Pa", 0.0, 5e4, 5e3, NextArm,
        "amplitude of the triangle that works the seal loose before a run";
    75 LDBB_DITHER_RATE: Real "ldbb.dither-rate", "Hz", 0.5, 50.0, 7.0, NextArm,
        "its frequency";
    76 LDBB_GAIN: Real "ldbb.gain", "N/Pa", 1e-4, 1e-2, 1.26e-3, NextArm,
        "calibrated force of the cylinder: gain";
    77 LDBB_OFFSET: Real "ldbb.offset", "N", -500.0, 500.0, -14.0, NextArm,
        "and offset";
    78 LDBB_INCLINATION: Real "ldbb.inclination", "rad", -1.396, 1.396, 0.0, NextArm,
        "angle of the bar above the plane; pressures and feed of a job are those of the level bar";
    79 LDBB_WEIGHT: Real "ldbb.weight", "N", 0.0, 100.0, 0.0, NextArm,
        "weight of the bar that its lower ball does not carry; 0 where the plane is not level";

    100 CERS_GAIN_XP: Real "cers.gain-xp", "N·m²/A²", 0.0, 1e-3, 0.0, NextArm,
        "K of the magnet +X from its calibration; 0: not calibrated, nothing is excited";
    101 CERS_OFFSET_XP: Real "cers.offset-xp", "m", -1e-4, 1e-3, 2e-5, NextArm,
        "δ of the magnet +X: what iron adds to its gap";
    102 CERS_KNEE_XP: Real "cers.knee-xp", "A/m", 1.0, 1e7, 1.91e4, NextArm,
        "h of the magnet +X: field at the knee of its iron";
    103 CERS_GAIN_XM: Real "cers.gain-xm", "N·m²/A²", 0.0, 1e-3, 0.0, NextArm,
        "K of the magnet −X";
    104 CERS_OFFSET_XM: Real "cers.offset-xm", "m", -1e-4, 1e-3, 2e-5, NextArm,
        "δ of the magnet −X";
    105 CERS_KNEE_XM: Real "cers.knee-xm", "A/m", 1.0, 1e7, 1.91e4, NextArm,
        "h of the magnet −X";
    106 CERS_GAIN_YP: Real "cers.gain-yp", "N·m²/A²", 0.0, 1e-3, 0.0, NextArm,
        "K of the magnet +Y";
    107 CERS_OFFSET_YP: Real "cers.offset-yp", "m", -1e-4, 1e-3, 2e-5, NextArm,
        "δ of the magnet +Y";
    108 CERS_KNEE_YP: Real "cers.knee-yp", "A/m", 1.0, 1e7, 1.91e4, NextArm,
        "h of the magnet +Y";
    109 CERS_GAIN_YM: Real "cers.gain-ym", "N·m²/A²", 0.0, 1e-3, 0.0, NextArm,
        "K of the magnet −Y";
    110 CERS_OFFSET_YM: Real "cers.offset-ym", "m", -1e-4, 1e-3, 2e-5, NextArm,
        "δ of the magnet −Y";
    111 CERS_KNEE_YM: Real "cers.knee-ym", "A/m", 1.0, 1e7, 1.91e4, NextArm,
        "h of the magnet −Y";

    120 LINK_KEY: Secret "link.key", "1", 0, 0, 0, AtOnce,
        "key that seals every command which changes anything; set at the box's own port, never shown";

    130 VERDICT_CALL: Real "verdict.call", "1", low(number::call), high(number::call), usual(number::call), NextMode,
        "evidence from which on chatter is called; a greater one calls less often";
    131 VERDICT_HYSTERESIS: Real "verdict.hysteresis", "1", low(number::hysteresis), high(number::hysteresis), usual(number::hysteresis), NextMode,
        "an alarm ends so far below verdict.call";
    132 VERDICT_MEMORY_S: Real "verdict.memory-s", "s", low(number::memory_s), high(number::memory_s), usual(number::memory_s), NextMode,
        "time in which evidence of 1 moves the sum by 1";
    133 VERDICT_DOUBT: Real "verdict.doubt", "1", low(number::doubt), high(number::doubt), usual(number::doubt), NextMode,
        "the sum of evidence starts here and never falls below";
    134 VERDICT_BELIEF: Real "verdict.belief", "1", low(number::belief), high(number::belief), usual(number::belief), NextMode,
        "evidence of a line that nothing speaks against";
    135 VERDICT_FREE_WEIGHT: Real "verdict.free-weight", "1", low(number::free_weight), high(number::free_weight), usual(number::free_weight), NextMode,
        "weight of the log-odds that the rotation does not make the line";
    136 VERDICT_FREE_MOST: Real "verdict.free-most", "1", low(number::free_most), high(number::free_most), usual(number::free_most), NextMode,
        "largest log-odds that count for the line";
    137 VERDICT_PART_OF_REST: Real "verdict.part-of-rest", "1", low(number::part_of_rest), high(number::part_of_rest), usual(number::part_of_rest), NextMode,
        "log-odds of the part of what the rotation leaves, below which it speaks against";
    138 VERDICT_PART_OF_ALL: Real "verdict.part-of-all", "1", low(number::part_of_all), high(number::part_of_all), usual(number::part_of_all), NextMode,
        "the same for the part of all power";
    139 VERDICT_OVER_IDLE_DB: Real "verdict.over-idle-db", "dB", low(number::over_idle_db), high(number::over_idle_db), usual(number::over_idle_db), NextMode,
        "level over idle below which it speaks against";
    140 VERDICT_UNHEARD_IDLE_DB: Real "verdict.unheard-idle-db", "dB", low(number::unheard_idle_db), high(number::unheard_idle_db), UNHEARD_IDLE_DB, NextMode,
        "level over an idle that was never heard; up to 11 no line is called before both idle and a cut were heard";
    141 VERDICT_FLUCTUATION: Real "verdict.fluctuation", "1", low(number::fluctuation), high(number::fluctuation), usual(number::fluctuation), NextMode,
        "ln of the power's fluctuation above which it speaks against";
    142 VERDICT_LEVEL: Real "verdict.level", "1", low(number::level), high(number::level), usual(number::level), NextMode,
        "lg of the level over the loudest heard, below which it speaks against";
    143 VERDICT_TOLD_SD: Real "verdict.told-sd", "1", low(number::told_sd), high(number::told_sd), usual(number::told_sd), NextMode,
        "standard deviation of a told speed, as a part of it";
    144 VERDICT_ON_TEETH: Real "verdict.on-teeth", "1", low(number::on_teeth), high(number::on_teeth), usual(number::on_teeth), NextMode,
        "part of the forced lines that lie on multiples of the teeth";
    145 VERDICT_RARE_MULTIPLE: Real "verdict.rare-multiple", "1", low(number::rare_multiple), high(number::rare_multiple), usual(number::rare_multiple), NextMode,
        "multiple of the tooth frequency from which on forced lines become rare";
    146 VERDICT_ALONE: Real "verdict.alone", "1", low(number::alone), high(number::alone), usual(number::alone), NextMode,
        "part of the prior chance to be forced that is left to a line alone";
    147 VERDICT_BREADTH: Real "verdict.breadth", "1", low(number::breadth), high(number::breadth), usual(number::breadth), NextMode,
        "lines this near, as a part of the frequency, are one vibration";
    148 VERDICT_GLIDE: Real "verdict.glide", "1/s", low(number::glide), high(number::glide), usual(number::glide), NextMode,
        "a line that moves faster, as a part of its frequency, is bound to no structure";
}
