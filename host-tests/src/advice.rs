//! Random cuts beyond their limit, and what is true of them at every speed within reach: what
//! advice is judged on.

use core::ops::Range;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rarma_cli::advice::machine::{Belief, Machine, Spread};
use rarma_cli::controller::{Charts, Chatter};
use rarma_core::act::ActConfig;
use rarma_core::advice::{AdviceConfig, HeardChatter, KnownCut, Proposal, advise};
use rarma_core::decide::{StructuralMode, Structure};
use rarma_plants::cut::Process;
use rarma_plants::population::Cut;
use rarma_plants::truth::roots;

/// The reach: an override of 50 to 150 %.
pub const REACH: (f64, f64) = (0.5, 1.5);
/// Speeds that are looked at, half a percent of the present one apart.
const SPEEDS: usize = 201;
/// From one to the next that is looked at where any will do; it meets them all.
const STRIDE: usize = 40;
/// A pocket is so many of them in a row: 1 % of the present speed.
const POCKET: usize = 3;
/// Cuts at least so deep over their limit.
const DEEP: f64 = 1.15;
/// Deviation of the noise on a true frequency, a part of it.
pub const F_NOISE: f64 = 0.002;
/// How well a structure's frequencies are known, a part of them.
const MODE_SD: f64 = 0.001;

/// What there is within reach.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Within {
    /// A stretch of stable speeds, 1 % or wider.
    Pocket,
    /// Some stable speed, no such stretch: in no figure.
    Thin,
    /// No speed is stable.
    None,
}

/// A cut that chatters by its delay equation.
#[derive(Debug)]
pub struct Case {
    /// As it was drawn.
    pub cut: Cut,
    /// At full depth.
    pub process: Process,
    /// Full depth, m.
    pub depth_m: f64,
    /// What there is within reach.
    pub within: Within,
    /// The modes of its structure.
    pub structure: Structure<f64>,
}

/// The monitor's usual band, without its rims, Hz.
pub const HEARD_HZ: Range<f64> = 320.0..2400.0;

/// Whether the whole loop can be played with it: milled, with equal teeth, and chatter that can
/// be heard.
#[must_use]
pub fn plays(cut: &Cut) -> bool {
    let Process::Milling(config) = cut.process() else {
        return false;
    };
    config.pitch_rad.is_empty() && HEARD_HZ.contains(&cut.operational().0)
}

/// What is told of a chatter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Told {
    /// Frequency, Hz.
    pub f_hz: f64,
    /// Its standard deviation, Hz.
    pub f_sd_hz: f64,
}

impl Case {
    /// The cut of this seed, where it is deep and chatters; what is within its reach is not looked at.
    ///
    /// # Panics
    /// The population has a defect.
    #[must_use]
    pub fn deep(seed: u64) -> Option<Self> {
        let cut = Cut::draw(seed).unwrap_or_else(|why| panic!("seed {seed}: {why:?}"));
        (cut.limit_part() >= DEEP && cut.operational().1 < 0.0).then(|| Self::of(cut))
    }

    /// The same, with what is within its reach.
    ///
    /// # Panics
    /// As [`deep`](Self::deep).
    #[must_use]
    pub fn draw(seed: u64) -> Option<Self> {
        let mut case = Self::deep(seed)?;
        let (mut row, mut longest) = (0, 0);
        for i in 0..SPEEDS {
            let part = i as f64 / (SPEEDS - 1) as f64;
            let stable = case.root(REACH.0 + (REACH.1 - REACH.0) * part).is_none();
            row = if stable { row + 1 } else { 0 };
            longest = longest.max(row);
        }
        case.within = match longest {
            0 => Within::None,
            POCKET.. => Within::Pocket,
            _ => Within::Thin,
        };
        Some(case)
    }

    /// The cut of this seed, where it is deep and chatters, and no speed within reach is stable.
    ///
    /// # Panics
    /// As [`deep`](Self::deep).
    #[must_use]
    pub fn draw_without(seed: u64) -> Option<Self> {
        let case = Self::deep(seed)?;
        // All of them, but far apart first: a pocket is soon met.
        let stable = |i: usize| {
            let part = (i * STRIDE % SPEEDS) as f64 / (SPEEDS - 1) as f64;
            case.root(REACH.0 + (REACH.1 - REACH.0) * part).is_none()
        };
        (!(0..SPEEDS).any(stable)).then_some(case)
    }

    /// Any cut; what is within its reach is not looked at.
    ///
    /// # Panics
    /// As [`draw`](Self::draw).
    #[must_use]
    pub fn of(cut: Cut) -> Self {
        let process = cut.process().clone();
        let modes: Vec<StructuralMode<f64>> = process
            .modes()
            .iter()
            .map(|m| StructuralMode {
                f_hz: m.mode.f_hz,
                f_sd: MODE_SD * m.mode.f_hz,
                zeta: m.mode.zeta,
                zeta_sd: 0.0,
            })
            .collect();
        Self {
            depth_m: process.depth().largest(),
            structure: Structure::new(&modes).expect("a structure"),
            within: Within::None,
            cut,
            process,
        }
    }

    /// The frequency at which it chatters at so many times its speed, Hz; `None`: stable. What
    /// cannot be told is not stable.
    #[must_use]
    pub fn root(&self, ratio: f64) -> Option<f64> {
        self.root_of(ratio, 1.0)
    }

    /// The same at a part of its depth.
    #[must_use]
    pub fn root_of(&self, ratio: f64, depth: f64) -> Option<f64> {
        let there = self.process.at_spindle_hz(ratio * self.cut.spindle_hz());
        let root = roots(&there, 0.0, depth * self.depth_m, 1).ok();
        match root.as_ref().and_then(|r| r.first()) {
            Some(root) if root.growth_per_s < 0.0 => None,
            Some(root) => Some(root.f_hz),
            None => Some(f64::NAN),
        }
    }

    /// What is proposed when chatter was told at so many times the cut's speed, and these
    /// other speeds, likewise, are known to chatter.
    #[must_use]
    pub fn proposed(
        &self,
        told: Told,
        ratio: f64,
        tried: &[f64],
        with_structure: bool,
    ) -> Option<Proposal<f64>> {
        let hz = self.cut.spindle_hz();
        let known = tried
            .iter()
            .map(|ratio| KnownCut::chattered(ratio * hz, None));
        self.proposed_knowing(told, ratio, &known.collect::<Vec<_>>(), with_structure)
    }

    /// The same where these cuts are known.
    #[must_use]
    pub fn proposed_knowing(
        &self,
        told: Told,
        ratio: f64,
        known: &[KnownCut<f64>],
        with_structure: bool,
    ) -> Option<Proposal<f64>> {
        let (reach, heard) = self.asked(told, ratio);
        let structure = with_structure.then_some(&self.structure);
        let advice = advise(&reach, &heard, structure, known).expect("sound");
        advice.first().copied()
    }

    /// What is believed where its machine is told, with errors of so many times the usual deviations: so
    /// wrong by a draw of its own. The belief takes them for usual.
    #[must_use]
    pub fn told(&self, errors: f64) -> Belief {
        let mut rng = ChaCha8Rng::seed_from_u64(self.cut.seed);
        let truth = Machine::of(self.process.clone());
        let told = truth.like(&Spread::USUAL.times(errors), &mut rng);
        Belief::new(told, Spread::USUAL, 1)
    }

    /// What an actor is told of it: teeth and modes.
    #[must_use]
    pub fn about(&self) -> Chatter {
        Chatter {
            teeth: self.cut.teeth() as u32,
            structure: Some(self.structure),
            ..Chatter::default()
        }
    }

    /// The same, and its machine, usually wrong, worked out for its speed. This takes seconds.
    #[must_use]
    pub fn about_with_machine(&self) -> Chatter {
        self.about_with_machine_off(1.0)
    }

    /// The same, the machine so many times as wrong as it is believed to be.
    #[must_use]
    pub fn about_with_machine_off(&self, errors: f64) -> Chatter {
        let mut charts = Charts::new(self.told(errors));
        let config = ActConfig::limits(false, REACH.0, REACH.1);
        charts.make(self.cut.spindle_hz(), &config, || ());
        Chatter {
            machine: Some(charts),
            ..self.about()
        }
    }

    /// [`Self::proposed_knowing`], where this is believed of the machine; where nothing of it agrees, as if
    /// nobody had told it.
    #[must_use]
    pub fn proposed_by(
        &self,
        belief: &Belief,
        told: Told,
        ratio: f64,
        known: &[KnownCut<f64>],
    ) -> Option<Proposal<f64>> {
        let (reach, heard) = self.asked(told, ratio);
        match belief.advise(&reach, &heard, known, || ()).expect("sound") {
            Some(answer) => answer.advice.first().copied(),
            None => self.proposed_knowing(told, ratio, known, false),
        }
    }

    /// What may be turned, and what was heard at so many times the cut's speed.
    fn asked(&self, told: Told, ratio: f64) -> (AdviceConfig<f64>, HeardChatter<f64>) {
        let hz = self.cut.spindle_hz();
        let heard = HeardChatter {
            f_hz: told.f_hz,
            f_sd_hz: told.f_sd_hz,
            spindle_hz: ratio * hz,
            spindle_sd_hz: 0.001 * hz,
            teeth: self.cut.teeth() as u32,
        };
        (AdviceConfig::reach(REACH.0 * hz, REACH.1 * hz), heard)
    }

    /// The plain rule: of the speeds f/(k·N) within reach the nearest, over the cut's.
    #[must_use]
    pub fn plain(&self, f_hz: f64) -> Option<f64> {
        let waves = f_hz / (self.cut.spindle_hz() * self.cut.teeth() as f64);
        let below = waves.floor().max(1.0);
        let ratios = [waves / below, waves / (below + 1.0)];
        ratios
            .into_iter()
            .filter(|r| (REACH.0..=REACH.1).contains(r))
            .min_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()))
    }
}
