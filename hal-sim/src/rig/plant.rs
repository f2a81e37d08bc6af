//! The world behind the outputs: four coils, two gaps, a regulator with its cylinder, a
//! gauge, a supply. Simple on purpose: enough for every protection to have something to
//! protect.

use rand::Rng;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rarma_plants::cers::{ExciterConfig, ExciterPlant, Reading, SensorConfig};
use rarma_plants::error::PlantError;
use rarma_plants::ldbb::Bench;
use rarma_rigs::ldbb::ForceLaw;

/// Coils and gaps.
pub const COILS: usize = 4;
/// Displacement sensors.
pub const GAPS: usize = 2;

/// What is connected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigConfig {
    /// Coil inductance, H; resistance, Ω.
    pub inductance_h: f64,
    /// See [`Self::inductance_h`].
    pub resistance_ohm: f64,
    /// Supply, V.
    pub supply_v: f64,
    /// Current from end to end of a sensor's range, A.
    pub span_a: f64,
    /// Comparators trip at this current, A.
    pub comparator_a: f64,
    /// Gap at rest, m, and at a sensor's upper end.
    pub gap_m: f64,
    /// See [`Self::gap_m`].
    pub gap_span_m: f64,
    /// Dead time and lag of the regulator, s.
    pub valve_dead_s: f64,
    /// See [`Self::valve_dead_s`].
    pub valve_lag_s: f64,
    /// Pressure at the valve's upper end, Pa.
    pub valve_span_pa: f64,
    /// Lag of venting, s.
    pub vent_lag_s: f64,
    /// Noise of every converter, codes of 12 bits, standard deviation.
    pub noise_codes: f64,
    /// Zero error of the current sensors, A.
    pub offset_a: [f64; COILS],
    /// Temperature of the hottest winding, K, and B of its thermistor, K, on the gauge's input;
    /// none: the gauge is there.
    pub thermistor: Option<(f64, f64)>,
}

impl Default for RigConfig {
    fn default() -> Self {
        Self {
            inductance_h: 4.19e-3,
            resistance_ohm: 4.0,
            supply_v: 48.0,
            span_a: 8.0,
            comparator_a: 3.4,
            gap_m: 150e-6,
            gap_span_m: 400e-6,
            valve_dead_s: 0.02,
            valve_lag_s: 0.1,
            valve_span_pa: 9e5,
            vent_lag_s: 0.05,
            noise_codes: 1.2,
            offset_a: [0.03, -0.02, 0.01, -0.04],
            thermistor: None,
        }
    }
}

/// What faults do to the plant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spoilt {
    /// Coil that is open.
    pub open: Option<usize>,
    /// Coil with shorted turns, and the part of inductance and resistance that is left.
    pub short: Option<(usize, f64)>,
    /// Coil with a voltage from elsewhere, V.
    pub surge: Option<(usize, f64)>,
    /// Gap that closes: axis, m/s.
    pub closing: Option<(usize, f64)>,
    /// Supply, V.
    pub supply_v: Option<f64>,
    /// The regulator stays where it is.
    pub valve_stuck: bool,
    /// The regulator goes up by itself, Pa.
    pub valve_adds_pa: f64,
    /// Part of the pressure that leaks away.
    pub leak: f64,
    /// Windings are hotter by this, K.
    pub hotter_k: f64,
    /// The gauge moves out by this, m.
    pub gauge_m: f64,
}

/// The plant.
#[derive(Debug, Clone)]
pub struct Plant {
    /// What it is made of.
    pub config: RigConfig,
    rng: ChaCha8Rng,
    /// Coil currents, A; never below zero.
    pub current_a: [f64; COILS],
    closed_m: [f64; GAPS],
    /// Pressure in the cylinder, Pa.
    pub pressure_pa: f64,
    regulator_pa: f64,
    line: std::collections::VecDeque<f64>,
    time_s: f64,
    /// The machine under the bar; none: its circle is some µm, whatever the pressure.
    pub bar: Option<Bench>,
    bar_gauge_m: f64,
    /// Magnets and spindle behind the coils; none: four chokes and gaps that run out by 3 µm.
    /// Faults of coils are the chokes'.
    exciter: Option<ExciterPlant>,
    seen: Reading,
}

impl Plant {
    /// Puts magnets and a spindle behind the coils. The rig's own converters stand for those of
    /// the plant's sensors.
    ///
    /// # Errors
    /// `OutOfRange`, a field of the plant.
    pub fn attach(&mut self, config: ExciterConfig, seed: u64) -> Result<(), PlantError> {
        let config = ExciterConfig {
            sensors: SensorConfig {
                displacement_hz: config.sensors.displacement_hz,
                acceleration_hz: config.sensors.acceleration_hz,
                current_gain_error: config.sensors.current_gain_error,
                acceleration_noise_m_per_s2: config.sensors.acceleration_noise_m_per_s2,
                ..config.sensors.quiet()
            },
            supply_v: self.config.supply_v,
            ..config
        };
        self.exciter = Some(ExciterPlant::new(config, seed)?);
        Ok(())
    }

    /// Magnets and spindle, where there are some.
    pub fn exciter(&self) -> Option<&ExciterPlant> {
        self.exciter.as_ref()
    }

    /// Acceleration at the front bearing, m/s²; none without a spindle.
    pub fn acceleration_m_per_s2(&self) -> Option<[f64; 2]> {
        self.exciter
            .as_ref()
            .map(|_| self.seen.acceleration_m_per_s2)
    }

    /// A plant at rest.
    pub fn new(config: RigConfig, seed: u64) -> Self {
        Self {
            config,
            rng: ChaCha8Rng::seed_from_u64(seed),
            current_a: [0.0; COILS],
            closed_m: [0.0; GAPS],
            pressure_pa: 0.0,
            regulator_pa: 0.0,
            line: std::collections::VecDeque::new(),
            time_s: 0.0,
            bar: None,
            bar_gauge_m: 0.0,
            exciter: None,
            seen: Reading::default(),
        }
    }

    /// One period of the current loop. `duty` is the mean voltage over the supply's, none
    /// where switches are open. Gives the first coil whose comparator trips.
    pub fn coils(
        &mut self,
        dt_s: f64,
        duty: Option<[f64; COILS]>,
        spindle_hz: f64,
        spoilt: &Spoilt,
    ) -> Option<usize> {
        self.time_s += dt_s;
        if let Some(exciter) = &mut self.exciter {
            exciter.turn(spindle_hz);
            exciter.drive(duty);
            self.seen = exciter.read();
            self.current_a = exciter.truth().current_a;
            let beyond = |i: &f64| *i > self.config.comparator_a;
            return self.current_a.iter().position(beyond);
        }
        let supply = spoilt.supply_v.unwrap_or(self.config.supply_v);
        let mut tripped = None;
        for (k, current) in self.current_a.iter_mut().enumerate() {
            let left = match spoilt.short {
                Some((coil, left)) if coil == k => left,
                _ => 1.0,
            };
            let (l, r) = (
                self.config.inductance_h * left,
                self.config.resistance_ohm * left,
            );
            let driven = duty.map_or(-supply, |d| d[k] * supply);
            let volts = driven
                + match spoilt.surge {
                    Some((coil, v)) if coil == k => v,
                    _ => 0.0,
                };
            let decay = (-dt_s * r / l).exp();
            *current = (*current * decay + volts / r * (1.0 - decay)).max(0.0);
            if spoilt.open == Some(k) {
                *current = 0.0;
            }
            if *current > self.config.comparator_a {
                tripped = tripped.or(Some(k));
            }
        }
        tripped
    }

    /// One millisecond of everything slow; `valve` is the part of its range that the
    /// regulator is asked for, none where it has no supply and vents.
    pub fn slow(&mut self, valve: Option<f64>, spoilt: &Spoilt) {
        const DT_S: f64 = 1e-3;
        let dead = (self.config.valve_dead_s / DT_S) as usize;
        self.line
            .push_back(valve.unwrap_or(0.0) * self.config.valve_span_pa);
        let asked = if self.line.len() > dead {
            self.line.pop_front()
        } else {
            None
        };
        if let Some(asked) = asked
            && !spoilt.valve_stuck
        {
            self.regulator_pa = asked;
        }
        let (goal, lag) = match valve {
            Some(_) => (
                (self.regulator_pa + spoilt.valve_adds_pa) * (1.0 - spoilt.leak),
                self.config.valve_lag_s,
            ),
            None => {
                self.line.clear();
                self.regulator_pa = 0.0;
                (0.0, self.config.vent_lag_s)
            }
        };
        self.pressure_pa += DT_S / (lag + DT_S) * (goal - self.pressure_pa);
        if let Some(bar) = &mut self.bar {
            let force_n = ForceLaw::standard().force_n(self.pressure_pa).max(0.0);
            self.bar_gauge_m = bar.step_at_force(DT_S, force_n);
        }
        if let Some((axis, speed)) = spoilt.closing
            && let Some(closed) = self.closed_m.get_mut(axis)
        {
            *closed += speed * DT_S;
        }
    }

    /// A left-aligned 12-bit code of a part of the range, with noise.
    pub fn code(&mut self, part: f64) -> u16 {
        let noise: f64 = StandardNormal.sample(&mut self.rng);
        let code = (part * 4095.0 + self.config.noise_codes * noise).round();
        (code.clamp(0.0, 4095.0) as u16) << 4
    }

    /// Code of a coil's current sensor.
    pub fn current_code(&mut self, coil: usize) -> u16 {
        let i = match &self.exciter {
            Some(_) => self.seen.current_a[coil],
            None => self.current_a[coil],
        };
        let i = i + self.config.offset_a[coil];
        self.code(0.5 + i / self.config.span_a)
    }

    /// Code of a displacement sensor: the gap of the + magnet.
    pub fn gap_code(&mut self, axis: usize) -> u16 {
        let swing = match &self.exciter {
            Some(_) => -self.seen.displacement_m[axis],
            None => 3e-6 * (core::f64::consts::TAU * 50.0 * self.time_s + axis as f64).sin(),
        };
        let gap = self.config.gap_m - self.closed_m[axis] + swing;
        self.code(gap / self.config.gap_span_m)
    }

    /// Code of the pressure transducer: 10 % to 90 % is 0 to 10 bar.
    pub fn pressure_code(&mut self) -> u16 {
        self.code(0.1 + 0.8 * self.pressure_pa / 1e6)
    }

    /// Code of the gauge: the machine's circle is off by some µm.
    pub fn gauge_code(&mut self, spoilt: &Spoilt) -> u16 {
        if let Some((kelvin, b_k)) = self.config.thermistor {
            let kelvin = kelvin + spoilt.hotter_k;
            let ratio = (b_k * (1.0 / kelvin - 1.0 / 298.15)).exp();
            return self.code(1.0 / (1.0 + ratio));
        }
        let circle = match self.bar {
            Some(_) => self.bar_gauge_m,
            None => 8e-6 * (core::f64::consts::TAU * 0.03 * self.time_s).sin(),
        };
        self.code(0.5 + (circle + spoilt.gauge_m) / 2.4e-3)
    }

    /// Code of the supply.
    pub fn supply_code(&mut self, spoilt: &Spoilt) -> u16 {
        let v = spoilt.supply_v.unwrap_or(self.config.supply_v);
        self.code(v / 80.0)
    }

    /// A number that is anything from 0 to 1.
    pub fn any(&mut self) -> f64 {
        self.rng.random()
    }
}
