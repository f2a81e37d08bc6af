//! Advice as JSON spells it.

use rarma_core::advice::{Advice, Help, KnownCut, Lobes, Proposal, Side, Variation};
use serde::{Deserialize, Serialize};

/// A speed to turn instead.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpeedRecord {
    /// The speed, 1/min.
    pub rpm: f64,
    /// Standard deviation of the middle of its pocket, 1/min.
    pub rpm_sd: f64,
    /// The pocket within reach, from and to, 1/min.
    pub pocket_rpm: [f64; 2],
    /// Waves between two teeth there, about; 0 is above all lobes.
    pub pocket: u32,
    /// Chance that the cut is stable there, before it is tried, 0 to 1.
    pub chance: f64,
    /// How many times deeper the cut may be there by the likeliest lobes, 1 to 8.
    pub margin: f64,
    /// The speed over the present one.
    pub ratio: f64,
    /// The feed over the present one, so that the feed of a tooth stays; 1 with --same-feed.
    pub feed_ratio: f64,
}

/// What helps where no speed does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HelpRecord {
    /// A smaller depth of cut.
    LessDepth,
    /// A speed that swings all the time.
    SpeedVariation,
    /// A cutter with fewer teeth, or with unequal ones.
    OtherTeeth,
}

/// A speed that swings: n(t) = n₀·(1 + RVA·sin(2π·RVF·n₀·t)), n₀ the speed at the alarm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VariationRecord {
    /// RVA, amplitude of the speed over its mean.
    pub rva: f64,
    /// RVF, swings a turn.
    pub rvf: f64,
    /// Lowest and highest speed, 1/min.
    pub rpm: [f64; 2],
    /// Swings a second, Hz.
    pub swing: f64,
    /// Largest acceleration of the spindle, rad/s².
    pub acceleration: f64,
    /// How far the phase of the chatter between two teeth swings to either side, rad.
    pub phase: f64,
    /// Chance that the cut is stable with it, before it is tried, 0 to 1.
    pub chance: f64,
    /// Growth of the chatter with it over that without; below 0 it dies.
    pub growth_ratio: f64,
    /// It is likely to help: a chance of a half or more.
    pub helps: bool,
}

/// The likeliest lobes of the mode that chatters, at the depth of this cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LobesRecord {
    /// Damping ratio of the mode, 1.
    pub zeta: f64,
    /// K·b/(2k_m): half the stiffness of the cut over that of the mode, 1.
    pub load: f64,
    /// Chatter lies above the mode, or below it.
    pub above: bool,
}

/// Another cut with the same tool that was evidence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KnownRecord {
    /// Its speed, 1/min.
    pub rpm: f64,
    /// Its depth over that of this cut.
    pub depth: f64,
    /// It was stable.
    pub stable: bool,
}

/// What a machine that is told says of an alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MachineRecord {
    /// It chatters so, here or where the cut is known to have chattered: the speeds are by all of its modes.
    Explains,
    /// It chatters there, but not so: the speeds are its own, whatever was heard.
    Expects,
    /// It does not, nor do machines like it: the speeds are without it.
    Contradicts,
    /// It was not asked, of one alarm of too many.
    NotAsked,
}

/// What to turn instead, of one alarm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AdviceRecord {
    /// Speed at which the alarm was called, 1/min, as believed.
    pub rpm: f64,
    /// Speeds within reach, 1/min.
    pub reach_rpm: [f64; 2],
    /// Waves between two teeth.
    pub waves: f64,
    /// From so many waves on there is no pocket any more, by the likeliest lobes.
    pub most_waves: f64,
    /// The mode that chatters, Hz.
    pub mode: f64,
    /// It is one of `--structure`; else it was worked out.
    pub of_structure: bool,
    /// Speeds to turn instead, the best first; empty: none within reach.
    pub speeds: Vec<SpeedRecord>,
    /// The next pocket above the reach, 1/min, where one is left there.
    pub beyond_rpm: Option<f64>,
    /// What helps, where `speeds` is empty.
    pub helps: Vec<HelpRecord>,
    /// The swing of the speed that is likeliest to help, where `speeds` is empty; of the first
    /// of such alarms only.
    #[serde(default)]
    pub variation: Option<VariationRecord>,
    /// Lobes of the one mode; none where a machine that is told has given the speeds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lobes: Option<LobesRecord>,
    /// Other cuts that were evidence, if any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub known: Vec<KnownRecord>,
    /// What the machine that is told says; only where one is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine: Option<MachineRecord>,
}

/// So many decimals and no more.
fn rounded(x: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (x * scale).round() / scale
}

/// A speed in 1/min to 0.1.
fn rpm(hz: f64) -> f64 {
    rounded(60.0 * hz, 1)
}

impl AdviceRecord {
    /// Of the core's answer; the reach in turns a second.
    pub(crate) fn new(
        advice: &Advice<f64>,
        swing: Option<&Variation<f64>>,
        at_rpm: f64,
        reach_hz: (f64, f64),
    ) -> Self {
        let speeds: Vec<SpeedRecord> = advice.proposals.iter().flatten().map(speed).collect();
        let helps = if speeds.is_empty() {
            let mut helps = advice.helps.map(help).to_vec();
            // What was played is known better than by the number of waves: second or last.
            if let Some(swing) = swing {
                helps.retain(|h| *h != HelpRecord::SpeedVariation);
                let place = if swing.helps() { 1 } else { helps.len() };
                helps.insert(place, HelpRecord::SpeedVariation);
            }
            helps
        } else {
            Vec::new()
        };
        Self {
            rpm: rounded(at_rpm, 1),
            reach_rpm: [rpm(reach_hz.0), rpm(reach_hz.1)],
            waves: rounded(advice.waves, 3),
            most_waves: rounded(advice.most_waves, 1),
            mode: rounded(advice.natural_hz, 1),
            of_structure: advice.of_structure,
            speeds,
            beyond_rpm: advice.beyond_hz.map(rpm),
            helps,
            variation: swing.map(|v| variation(v, at_rpm)),
            lobes: Some(lobes(&advice.lobes)),
            known: Vec::new(),
            machine: None,
        }
    }
}

fn lobes(of: &Lobes<f64>) -> LobesRecord {
    let (zeta, load, side) = of.of_mode();
    LobesRecord {
        zeta: rounded(zeta, 5),
        load: rounded(load, 5),
        above: side == Side::Above,
    }
}

/// A cut that is known, in the measure of the user.
pub(crate) fn known(cut: &KnownCut<f64>) -> KnownRecord {
    KnownRecord {
        rpm: rpm(cut.spindle_hz),
        depth: rounded(cut.depth, 3),
        stable: cut.is_stable(),
    }
}

fn variation(v: &Variation<f64>, at_rpm: f64) -> VariationRecord {
    let rpm = |sign: f64| rounded(at_rpm * (1.0 + sign * v.amplitude), 1);
    VariationRecord {
        rva: rounded(v.amplitude, 4),
        rvf: rounded(v.frequency_ratio, 5),
        rpm: [rpm(-1.0), rpm(1.0)],
        swing: rounded(v.swing_hz, 3),
        acceleration: rounded(v.acceleration, 1),
        phase: rounded(v.phase_swing, 2),
        chance: rounded(v.chance, 3),
        growth_ratio: rounded(v.growth_ratio, 2),
        helps: v.helps(),
    }
}

fn speed(proposal: &Proposal<f64>) -> SpeedRecord {
    SpeedRecord {
        rpm: rpm(proposal.spindle_hz),
        rpm_sd: rpm(proposal.spindle_sd_hz),
        pocket_rpm: [rpm(proposal.from_hz), rpm(proposal.to_hz)],
        pocket: proposal.pocket,
        chance: rounded(proposal.chance, 3),
        margin: rounded(proposal.margin, 2),
        ratio: rounded(proposal.ratio, 4),
        feed_ratio: rounded(proposal.feed_ratio, 4),
    }
}

fn help(help: Help) -> HelpRecord {
    match help {
        Help::LessDepth => HelpRecord::LessDepth,
        Help::SpeedVariation => HelpRecord::SpeedVariation,
        Help::OtherTeeth => HelpRecord::OtherTeeth,
    }
}
