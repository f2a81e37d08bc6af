//! What happens to a machine: wear, crashes, repairs, seasons.

use super::machine::{Drawn, MachineNow};
use super::{Fate, PlantConfig};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// Something that changed a machine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Event {
    /// Day on which it began, from 0.
    pub day: f64,
    /// What.
    #[serde(flatten)]
    pub what: What,
}

/// See [`Event`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "what", rename_all = "kebab-case")]
pub enum What {
    /// A crash: stiffness is lost in one direction, at once, and the axes are out of square.
    Crash {
        /// Direction, degrees, 0 to 180.
        direction_deg: f64,
        /// Part of the stiffness in that direction that is lost, 1.
        part: f64,
        /// What the squareness is off by since, µrad.
        squareness_urad: f64,
    },
    /// A mode loses damping, evenly over some days.
    Wear {
        /// Which mode, from 0.
        mode: usize,
        /// Its frequency, Hz.
        f_hz: f64,
        /// Part of the damping that is lost in the end, 1.
        part: f64,
        /// Days that it takes.
        over_days: f64,
    },
    /// A joint wears, evenly over some days: wider loops, more backlash.
    Joint {
        /// Axis, 0 or 1.
        axis: usize,
        /// Part by which loops are wider in the end, 1.
        part: f64,
        /// Backlash that the axis has more in the end, µm.
        backlash_um: f64,
        /// Days that it takes.
        over_days: f64,
    },
    /// Everything that was before is put right.
    Repair,
}

/// The life of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Life {
    /// What happens, by time.
    pub events: Vec<Event>,
    /// Warmest day of the year, from 0.
    warmest_day: f64,
}

/// Crashes in a machine's year.
const CRASHES: f64 = 0.35;
/// Modes that begin to lose damping in a machine's year.
const WEARS: f64 = 0.35;
/// Joints that begin to wear in a machine's year.
const JOINTS: f64 = 0.25;
/// What a crash does to the squareness, µrad: a loss of a tenth of the stiffness goes with 40.
const CRASH_URAD: f64 = 400.0;
/// With a fate other than [`Fate::Usual`] and [`Fate::Nothing`] it happens to one machine in so many.
pub const ONE_IN: usize = 3;
/// Part of those that are repaired.
const REPAIRED: f64 = 0.6;
/// How far the hall is from its mean in the warmest week, K.
const SEASON_K: f64 = 5.0;

impl Life {
    /// Draws a life.
    pub(super) fn draw(
        n: usize,
        drawn: &Drawn,
        config: &PlantConfig,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        // The first of January is a day of winter: the warmest is the end of July.
        let start = f64::from(u32::try_from(config.start.day()).unwrap_or(0));
        let warmest_day = (208.0 - start).rem_euclid(365.25);
        let crash = |rng: &mut ChaCha8Rng, part, squareness_urad: f64| What::Crash {
            direction_deg: rng.random_range(0.0..180.0),
            part,
            squareness_urad: if rng.random() {
                squareness_urad
            } else {
                -squareness_urad
            },
        };
        let joint = |rng: &mut ChaCha8Rng, part, backlash_um, over_days| What::Joint {
            axis: rng.random_range(0..2),
            part,
            backlash_um,
            over_days,
        };
        let wear = |rng: &mut ChaCha8Rng, part, over_days| {
            let mode = rng.random_range(0..drawn.new.modes.len());
            What::Wear {
                mode,
                f_hz: drawn.new.modes[mode].f_hz,
                part,
                over_days,
            }
        };
        let mut events = Vec::new();
        match config.fate {
            Fate::Nothing => {}
            // A plant in which every machine breaks on the same day is none.
            Fate::Loss { .. } | Fate::Wear { .. } | Fate::Joint { .. } | Fate::Knock { .. }
                if !n.is_multiple_of(ONE_IN) => {}
            Fate::Loss { day, part } => events.push(Event {
                day,
                what: crash(rng, part, 0.0),
            }),
            Fate::Knock {
                day,
                squareness_urad,
            } => events.push(Event {
                day,
                what: crash(rng, 0.0, squareness_urad),
            }),
            Fate::Joint {
                day,
                over,
                part,
                backlash_um,
            } => events.push(Event {
                day,
                what: joint(rng, part, backlash_um, over),
            }),
            Fate::Wear { day, over, part } => events.push(Event {
                day,
                what: wear(rng, part, over),
            }),
            Fate::Usual => {
                let days = f64::from(config.days);
                let mut day = 0.0;
                while day < days {
                    let draw: f64 = rng.random();
                    let what = if draw < CRASHES / 365.0 {
                        let part = rng.random_range(0.05..0.15);
                        crash(rng, part, CRASH_URAD * part)
                    } else if draw < (CRASHES + WEARS) / 365.0 {
                        let (part, over) =
                            (rng.random_range(0.15..0.35), rng.random_range(60.0..150.0));
                        wear(rng, part, over)
                    } else if draw < (CRASHES + WEARS + JOINTS) / 365.0 {
                        let (part, backlash_um) =
                            (rng.random_range(0.2..0.6), rng.random_range(0.3..1.5));
                        let over = rng.random_range(60.0..150.0);
                        joint(rng, part, backlash_um, over)
                    } else {
                        day += 1.0;
                        continue;
                    };
                    events.push(Event { day, what });
                    // Nothing else until it is clear whether it is repaired: two things at once cannot be
                    // judged one by one.
                    day += rng.random_range(120.0..200.0);
                    if rng.random::<f64>() < REPAIRED {
                        events.push(Event {
                            day,
                            what: What::Repair,
                        });
                        day += 60.0;
                    }
                }
            }
        }
        Self {
            events,
            warmest_day,
        }
    }

    /// How far the hall is from its mean on a day, K.
    #[must_use]
    pub fn warmer_k(&self, day: f64) -> f64 {
        SEASON_K * ((day - self.warmest_day) / 365.25 * std::f64::consts::TAU).cos()
    }

    /// The machine on a day.
    #[must_use]
    pub fn at(&self, drawn: &Drawn, day: f64) -> MachineNow {
        let mut now = drawn.new.clone();
        for event in self.events.iter().filter(|e| e.day <= day) {
            match event.what {
                What::Crash {
                    direction_deg,
                    part,
                    squareness_urad,
                } => {
                    now.geometry.squareness_urad += squareness_urad;
                    let angle = direction_deg.to_radians();
                    let c = now.plane.along(angle);
                    now.plane = now.plane.softened(angle, c * part / (1.0 - part));
                    for mode in &mut now.modes {
                        let axis = if mode.axis == 'X' {
                            0.0
                        } else {
                            std::f64::consts::FRAC_PI_2
                        };
                        mode.n_per_um *= 1.0 - part * (angle - axis).cos().powi(2);
                        // A mode softer by a part is slower by half of it.
                        mode.f_hz *= (1.0 - part * (angle - axis).cos().powi(2)).sqrt();
                    }
                }
                What::Wear {
                    mode,
                    part,
                    over_days,
                    ..
                } => {
                    let done = ((day - event.day) / over_days).min(1.0);
                    now.modes[mode].zeta *= 1.0 - part * done;
                }
                What::Joint {
                    axis,
                    part,
                    backlash_um,
                    over_days,
                } => {
                    let done = ((day - event.day) / over_days).min(1.0);
                    now.geometry.worn(axis, part * done, backlash_um * done);
                }
                What::Repair => now = drawn.new.clone(),
            }
        }
        let warmer = self.warmer_k(day);
        now.geometry.warmer(warmer);
        now.plane = now.plane.times(1.0 + drawn.compliance_per_k * warmer);
        for mode in &mut now.modes {
            mode.zeta *= 1.0 + drawn.damping_per_k * warmer;
            mode.f_hz *= 1.0 - 0.5 * drawn.compliance_per_k * warmer;
        }
        now
    }
}
