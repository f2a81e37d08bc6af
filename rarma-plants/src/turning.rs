//! Regenerative orthogonal turning with modes in the direction of the chip
//! thickness: the simplest machine that chatters, and the one with closed-form
//! answers.
//!
//! Rate: [`Turning::step`] runs once per integration step, an integer number of
//! which makes a revolution; no allocation.

use super::error::{PlantError, non_negative, positive};
use super::modal::{Mode, ModeBank, StepTable};
use super::process::{Contact, ForceNoise, ProcessDamping, Schedule, SmoothNoise};
use super::variation::SpeedVariation;

/// Configuration of [`Turning`]. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct TurningConfig {
    /// Spindle frequency, Hz, > 0; the mean one if it swings.
    pub spindle_hz: f64,
    /// Swing of the speed, if any.
    pub variation: Option<SpeedVariation>,
    /// Feed per revolution, m, ≥ 0.
    pub feed_m: f64,
    /// Cutting coefficient Ks in the direction of the chip thickness, N/m², > 0.
    pub ks_n_per_m2: f64,
    /// Edge coefficient, N/m, ≥ 0.
    pub edge_n_per_m: f64,
    /// Nose radius of the tool, m, > 0; only the surface asks for it.
    pub nose_radius_m: f64,
    /// Modes in the direction of the chip thickness.
    pub modes: Vec<Mode>,
    /// Chip width over time.
    pub width: Schedule,
    /// Flank rubbing, if any; its friction has no direction to act in here.
    pub process_damping: Option<ProcessDamping>,
    /// Broadband excitation.
    pub noise: ForceNoise,
    /// Loss of contact, or the linear equation.
    pub contact: Contact,
    /// Least integration rate, Hz, > 0; rounded up to whole steps per revolution.
    pub min_step_rate_hz: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl TurningConfig {
    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` or `WrongLength` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        positive(self.spindle_hz, "spindle_hz")?;
        if let Some(variation) = &self.variation {
            variation.validate()?;
        }
        non_negative(self.feed_m, "feed_m")?;
        positive(self.ks_n_per_m2, "ks_n_per_m2")?;
        non_negative(self.edge_n_per_m, "edge_n_per_m")?;
        positive(self.nose_radius_m, "nose_radius_m")?;
        self.width.validate()?;
        if let Some(p) = &self.process_damping {
            p.validate()?;
        }
        self.noise.validate()?;
        positive(self.min_step_rate_hz, "min_step_rate_hz")
    }

    /// Spindle frequency at time `t` s, Hz.
    #[must_use]
    pub fn spindle_at(&self, t: f64) -> f64 {
        let swing = self.variation.map(|v| v.factor(self.spindle_hz, t));
        self.spindle_hz * swing.unwrap_or(1.0)
    }

    /// Lowest and highest spindle frequency there will be, Hz.
    #[must_use]
    pub fn speeds_hz(&self) -> (f64, f64) {
        let a = self.variation.map_or(0.0, |v| v.amplitude);
        (self.spindle_hz * (1.0 - a), self.spindle_hz * (1.0 + a))
    }
}

/// What the machine does at one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TurnSample {
    /// Time, s.
    pub t: f64,
    /// Displacement into the workpiece, m.
    pub position_m: f64,
    /// Velocity, m/s.
    pub velocity_m_s: f64,
    /// Acceleration, m/s².
    pub acceleration_m_s2: f64,
    /// Force on the tool, N; negative pushes it out of the workpiece.
    pub force_n: f64,
    /// Chip width, m.
    pub width_m: f64,
    /// Chip thickness, m; 0 out of contact.
    pub chip_m: f64,
    /// Spindle frequency, Hz.
    pub spindle_hz: f64,
    /// How far the tool has been fed, m.
    pub feed_m: f64,
}

/// The virtual lathe.
///
/// q > 0 points into the workpiece. With the feed position X = feed·t/T (T one
/// revolution): tip u = q + X, h = max(0, u - S\[angle\]), S ← u where the tool
/// cut, F = -(Ks·h + edge)·b. If it always cuts, h = feed + q(t) - q(t-T).
/// Exact modal step, force predicted and corrected as in milling. A speed that swings
/// makes the steps longer and shorter, one cell of angle each, as in milling; the feed
/// follows the spindle.
#[derive(Clone, Debug)]
pub struct Turning {
    config: TurningConfig,
    dt: f64,
    surface: Vec<f64>,
    bank: ModeBank,
    force: f64,
    damping: f64,
    noise: Option<SmoothNoise<2>>,
    index: u64,
    /// Where the speed swings: the time, s, and the steps of each mode by their length.
    swinging: Option<(f64, Vec<StepTable>)>,
    spindle_hz: f64,
}

impl Turning {
    /// Builds the machine at rest with a smooth surface one feed behind.
    ///
    /// # Errors
    /// As [`TurningConfig::validate`] and [`Mode::validate`].
    pub fn new(config: TurningConfig) -> Result<Self, PlantError> {
        config.validate()?;
        let (slowest, fastest) = config.speeds_hz();
        let count = (config.min_step_rate_hz / slowest - 1e-9).ceil().max(4.0) as usize;
        let dt = 1.0 / (config.spindle_hz * count as f64);
        let swinging = config.variation.map(|_| {
            let step_s = |hz: f64| 1.0 / (hz * count as f64);
            let table = |m: &Mode| StepTable::new(m, step_s(fastest), step_s(slowest));
            (0.0, config.modes.iter().map(table).collect())
        });
        let feed_speed = config.feed_m * config.spindle_hz;
        // Cell i was last cut at step i - count; cell 0 at time 0 itself.
        let surface = (0..count)
            .map(|i| feed_speed * dt * (i as f64 - if i == 0 { 0.0 } else { count as f64 }))
            .collect();
        let noisy = config.noise.relative > 0.0 || config.noise.background_n > 0.0;
        Ok(Self {
            dt,
            surface,
            bank: ModeBank::new(&config.modes, dt)?,
            force: 0.0,
            damping: config
                .process_damping
                .map_or(0.0, |p| p.per_speed(config.spindle_hz)),
            noise: noisy.then(|| SmoothNoise::new(config.noise.bandwidth_hz, dt, config.seed)),
            index: 0,
            swinging,
            spindle_hz: config.spindle_hz,
            config,
        })
    }

    /// Steps in a revolution.
    #[must_use]
    pub fn steps_per_turn(&self) -> usize {
        self.surface.len()
    }

    /// Step length now, s.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// The configuration it was built from.
    #[must_use]
    pub fn config(&self) -> &TurningConfig {
        &self.config
    }

    /// Sets mode `index` to displacement m and velocity m/s.
    pub fn disturb(&mut self, index: usize, q: f64, v: f64) {
        self.bank.set_state(index, q, v);
    }

    /// Advances by one step and returns the state after it.
    pub fn step(&mut self) -> TurnSample {
        self.index += 1;
        let t = self.advance_time();
        let width = self.config.width.at(t);
        let noise = self.noise.as_mut().map_or([0.0; 2], SmoothNoise::advance);
        let cell = (self.index % self.surface.len() as u64) as usize;
        let feed = match &self.swinging {
            Some(_) => self.config.feed_m * self.index as f64 / self.surface.len() as f64,
            None => self.config.feed_m * self.config.spindle_hz * t,
        };
        // A rigid tool is where the feed has brought it, whatever the machine does.
        let moves = match self.config.contact {
            Contact::Rigid => 0.0,
            Contact::Real | Contact::Linear => 1.0,
        };
        let (q, v) = self.bank.peek(self.force, self.force);
        let (force, _) = self.cut(moves * q + feed, moves * v, cell, width, &noise);
        let (q, v) = self.bank.step(self.force, force);
        let tip = moves * q + feed;
        let (force, chip) = self.cut(tip, moves * v, cell, width, &noise);
        self.force = force;
        match self.config.contact {
            Contact::Linear => self.surface[cell] = tip,
            Contact::Real | Contact::Rigid => self.surface[cell] = self.surface[cell].max(tip),
        }
        TurnSample {
            t,
            position_m: q,
            velocity_m_s: v,
            acceleration_m_s2: self.bank.acceleration_m_s2(force),
            force_n: force,
            width_m: width,
            chip_m: chip,
            spindle_hz: self.spindle_hz,
            feed_m: feed,
        }
    }

    /// Steps per second at the highest speed there will be, Hz.
    #[must_use]
    pub fn fastest_step_rate_hz(&self) -> f64 {
        match &self.swinging {
            Some(_) => self.config.speeds_hz().1 * self.surface.len() as f64,
            None => 1.0 / self.dt,
        }
    }

    /// The time after one more step, s, whose length follows the speed where that swings.
    fn advance_time(&mut self) -> f64 {
        let (Some(variation), Some((now_s, tables))) = (&self.config.variation, &mut self.swinging)
        else {
            return self.index as f64 * self.dt;
        };
        let c = &self.config;
        let turns = 1.0 / self.surface.len() as f64;
        let swing_hz = variation.frequency_hz(c.spindle_hz);
        self.dt = variation.time_for_s(c.spindle_hz, swing_hz, *now_s, turns);
        *now_s += self.dt;
        self.spindle_hz = turns / self.dt;
        self.bank.retime(tables, self.dt);
        if let Some(noise) = &mut self.noise {
            noise.retime(c.noise.bandwidth_hz, self.dt);
        }
        if let Some(rub) = c.process_damping {
            self.damping = rub.per_speed(self.spindle_hz);
        }
        *now_s
    }

    fn cut(&self, tip: f64, v: f64, cell: usize, b: f64, noise: &[f64; 2]) -> (f64, f64) {
        let c = &self.config;
        let background = c.noise.background_n * noise[1];
        let h = tip - self.surface[cell];
        let linear = c.contact == Contact::Linear;
        if b <= 0.0 || (h <= 0.0 && !linear) {
            return (background, 0.0);
        }
        let edge = if linear { 0.0 } else { c.edge_n_per_m };
        let cutting = (c.ks_n_per_m2 * h + edge + self.damping * v) * b;
        (
            background - cutting * (1.0 + c.noise.relative * noise[0]),
            h.max(0.0),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::stability::turning_limit;
    use super::*;

    const MODE: Mode = Mode::from_stiffness(980.0, 0.02, 11.8e6);

    fn lathe(width_m: f64) -> TurningConfig {
        TurningConfig {
            spindle_hz: 10_422.9 / 60.0,
            variation: None,
            feed_m: 1e-4,
            ks_n_per_m2: 2e9,
            edge_n_per_m: 0.0,
            nose_radius_m: 0.8e-3,
            modes: vec![MODE],
            width: Schedule::constant(width_m),
            process_damping: None,
            noise: ForceNoise::default(),
            contact: Contact::Linear,
            min_step_rate_hz: 100_000.0,
            seed: 0,
        }
    }

    fn rms(y: &[f64]) -> f64 {
        let mean = y.iter().sum::<f64>() / y.len() as f64;
        (y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / y.len() as f64).sqrt()
    }

    #[test]
    fn growth_around_the_limit() {
        let limit = turning_limit(&MODE, 2e9).depth_m;
        for (part, want) in [(0.90, 0.05), (0.97, 0.42), (1.03, 2.3), (1.10, 15.0)] {
            let mut config = lathe(part * limit);
            config.feed_m = 0.0;
            let mut lathe = Turning::new(config).expect("valid");
            lathe.disturb(0, 1e-7, 0.0);
            let n = (0.8 / lathe.dt()) as usize;
            let q: Vec<f64> = (0..n).map(|_| lathe.step().position_m).collect();
            let got = rms(&q[3 * n / 4..]) / rms(&q[n / 4..n / 2]);
            assert!(
                (got / want - 1.0).abs() < 0.15,
                "{part}: {got} against {want}"
            );
        }
    }

    #[test]
    fn steady_cut_is_the_static_deflection_and_contact_limits_chatter() {
        let limit = turning_limit(&MODE, 2e9).depth_m;
        let mut config = lathe(0.5 * limit);
        config.contact = Contact::Real;
        let mut stable = Turning::new(config.clone()).expect("valid");
        let mut last = TurnSample::default();
        for _ in 0..80_000 {
            last = stable.step();
        }
        let want = -2e9 * 0.5 * limit * 1e-4 / 11.8e6;
        assert!((last.position_m / want - 1.0).abs() < 1e-3);
        assert!((last.chip_m / 1e-4 - 1.0).abs() < 1e-3);

        config.width = Schedule::constant(1.5 * limit);
        let mut wild = Turning::new(config).expect("valid");
        let q: Vec<TurnSample> = (0..200_000).map(|_| wild.step()).collect();
        let early = rms(&q[100_000..150_000]
            .iter()
            .map(|s| s.position_m)
            .collect::<Vec<_>>());
        let late = rms(&q[150_000..]
            .iter()
            .map(|s| s.position_m)
            .collect::<Vec<_>>());
        assert!(
            (late / early - 1.0).abs() < 0.02,
            "no limit cycle: {early} {late}"
        );
        assert!(late > 1e-5 && late < 1e-3, "{late}");
        assert!(q[150_000..].iter().any(|s| s.chip_m == 0.0));
    }

    #[test]
    fn no_width_leaves_the_bare_mode() {
        let mut air = Turning::new(lathe(0.0)).expect("valid");
        air.disturb(0, 1e-5, 0.0);
        let w = MODE.omega();
        let energy = |s: &TurnSample| s.position_m.hypot(s.velocity_m_s / w);
        let n = 3000;
        let first = energy(&air.step());
        let last = (0..n).map(|_| energy(&air.step())).last().expect("some");
        let want = (-0.02 * w * f64::from(n) * air.dt()).exp();
        assert!((last / first / want - 1.0).abs() < 0.03);
    }
}
