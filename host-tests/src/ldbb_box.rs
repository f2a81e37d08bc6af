//! The box with a ball bar and a machine under it, as the ball bar's tests use it: whole
//! circle tests, and what the box told of them.

use crate::rig::{answer, quiet};
use hal_sim::rig::{FaultEvent, RigSetUp, SimBox, SimRig};
use rarma_box::guard::{FaultCode, Mode, Severity, Stage};
use rarma_box::wire::{Answer, CIRCLE_RATE_HZ, CircleJob, CircleMessage, Command, Telemetry};
use rarma_plants::ldbb::drive::program;
use rarma_plants::ldbb::{BenchConfig, MotionFault};
use rarma_recordings::input::RunData;
use rarma_rigs::ldbb::{AngleMap, ForceLaw, ProcedureConfig, RunFault, Sense};
use rarma_scenarios::ldbb::{Findings, Options, evaluate};

/// Feed of the circles: 2000 mm/min.
const FEED_M_S: f32 = 2000.0 / 6e4;

/// A circle test of 150 mm at these pressures, bar; in both directions or one, and down again
/// or not.
pub fn job(bars: &[f32], both: bool, down: bool) -> CircleJob {
    let mut pressures_pa = [0.0; 8];
    for (p, bar) in pressures_pa.iter_mut().zip(bars) {
        *p = 1e5 * bar;
    }
    CircleJob {
        pressures_pa,
        feed_m_s: FEED_M_S,
        radius_m: 0.15,
        both,
        down,
    }
}

/// What the box told of a test.
#[derive(Debug, Default)]
pub struct Told {
    /// Runs cut to their captures, forces by the standard law.
    pub runs: Vec<RunData>,
    /// The run that failed, and why.
    pub failed: Option<(u16, RunFault)>,
    /// The box's own evaluation at the end.
    pub stiffness: Option<CircleMessage>,
    /// Faults, in the order they were told.
    pub faults: Vec<(FaultCode, Severity)>,
    /// How long it took, s of the world.
    pub world_s: f64,
}

impl Told {
    /// What the host finds in the runs.
    ///
    /// # Panics
    /// They are not a whole test.
    pub fn findings(&self) -> Findings {
        let options = Options {
            feed_m_s: f64::from(FEED_M_S),
            ..Options::default()
        };
        evaluate(&self.runs, &[], &options).expect("a whole test")
    }
}

/// A gauge with little noise and no steps: the box's converter has both of its own.
pub fn quieter(mut bench: BenchConfig) -> BenchConfig {
    bench.gauge.noise_m = 0.2e-6;
    bench.gauge.step_m = 0.0;
    bench
}

/// A box, not started, with a machine under its bar.
pub fn rig(bench: BenchConfig, faults: Vec<FaultEvent>) -> SimRig {
    let set_up = RigSetUp {
        faults,
        ..RigSetUp::default()
    };
    let mut rig = SimRig::new(set_up, quiet(1));
    rig.set_bar(quieter(bench));
    rig
}

/// From start-up, at 0.1 s, to the working point.
///
/// # Panics
/// It does not come to that.
pub fn arm(all: &mut SimBox) {
    all.send(&Command::Start(Mode::Ldbb));
    all.run_to(200_000);
    all.send(&Command::Arm);
    all.run_to(1_500_000);
    assert_eq!(all.app.supervisor().stage(), Stage::Ready);
}

/// A box with a machine under its bar, at its working point.
///
/// # Panics
/// It does not come to that.
pub fn ready(bench: BenchConfig, faults: Vec<FaultEvent>) -> SimBox {
    let mut all = SimBox::new(rig(bench, faults));
    all.run_to(100_000);
    arm(&mut all);
    all
}

/// Runs a test to its end; the operator starts the machine 0.3 s after the box is ready.
///
/// # Panics
/// The box refuses it, or comes to no end.
pub fn run(all: &mut SimBox, job: &CircleJob, motion: Option<(u16, MotionFault)>) -> Told {
    run_as(all, job, job, motion)
}

/// The same where the machine runs another circle than that of the job: an inclined bar's.
///
/// # Panics
/// As [`run`].
pub fn run_as(
    all: &mut SimBox,
    job: &CircleJob,
    machine: &CircleJob,
    motion: Option<(u16, MotionFault)>,
) -> Told {
    let (config, _) = machine.procedure().expect("a sound job");
    let bar = all.rig.bar_mut().expect("a machine");
    bar.prepare(&program(&config, Sense::Ccw));
    let to = all.send(&Command::Circle(*job));
    all.run_for(0.1);
    assert_eq!(answer(all, to), Some(Answer::Done));
    let mut told = Told::default();
    let (mut start, mut ready, mut readings) = (None, None, Vec::new());
    let begun_us = all.rig.world_us();
    let mut over_us = None;
    while over_us.is_none_or(|us| all.rig.world_us() < us) {
        all.step();
        for heard in std::mem::take(&mut all.host.heard) {
            match heard.message {
                Telemetry::Circle(CircleMessage::Ready {
                    run,
                    cw,
                    rising,
                    pressure_pa,
                }) => {
                    start = Some(heard.at_us + 300_000);
                    ready = Some((run, cw, rising, pressure_pa));
                }
                Telemetry::Circle(CircleMessage::Points(p)) => {
                    for (k, gauge_m) in p.gauge_m.iter().enumerate() {
                        let ms = f64::from(p.first_ms) + 1e3 / f64::from(CIRCLE_RATE_HZ) * k as f64;
                        let pa = f64::from(p.pressure_pa);
                        readings.push((1e-3 * ms, f64::from(*gauge_m), pa));
                    }
                }
                Telemetry::Circle(CircleMessage::Done {
                    run,
                    arc_s,
                    pressure_pa,
                    ..
                }) => {
                    let run_of = ready.expect("it was ready");
                    assert_eq!(run_of.0, run);
                    let readings = std::mem::take(&mut readings);
                    told.runs
                        .push(captured(&config, run_of, arc_s, pressure_pa, &readings));
                }
                Telemetry::Circle(CircleMessage::Failed { run, why }) => {
                    told.failed = Some((run, why));
                    over_us = over_us.or(Some(all.rig.world_us() + 2_000_000));
                }
                Telemetry::Circle(found @ CircleMessage::Stiffness { .. }) => {
                    told.stiffness = Some(found);
                    over_us = over_us.or(Some(all.rig.world_us() + 2_000_000));
                }
                Telemetry::Fault(f) => {
                    told.faults.push((f.record.code, f.severity));
                    if f.severity == Severity::Trip {
                        over_us = over_us.or(Some(all.rig.world_us() + 2_000_000));
                    }
                }
                _ => {}
            }
        }
        if start.is_some_and(|us| all.rig.world_us() >= us) {
            start = None;
            let (number, cw, ..) = ready.expect("it was ready");
            let sense = if cw { Sense::Cw } else { Sense::Ccw };
            let fault = motion.filter(|(run, _)| *run == number).map(|(_, f)| f);
            let bar = all.rig.bar_mut().expect("a machine");
            bar.start(program(&config, sense), fault);
        }
        assert!(all.rig.world_us() - begun_us < 2_000_000_000, "no end");
    }
    told.world_s = 1e-6 * (all.rig.world_us() - begun_us) as f64;
    told
}

fn captured(
    config: &ProcedureConfig,
    (run, cw, rising, set_pa): (u16, bool, bool, f32),
    arc_s: f32,
    pressure_pa: f32,
    readings: &[(f64, f64, f64)],
) -> RunData {
    let (from, sweep) = (f64::from(config.start_rad), f64::from(config.sweep_rad));
    let map = AngleMap {
        start_rad: if cw { from + sweep } else { from },
        sweep_rad: sweep,
        sense: if cw { Sense::Cw } else { Sense::Ccw },
        from_s: 0.0,
        to_s: f64::from(arc_s),
    };
    let overshoot = f64::from(config.overshoot_rad);
    let inside = || {
        readings
            .iter()
            .filter_map(|(t, r, pa)| Some((map.captured(*t, overshoot)?, *r, *pa)))
    };
    RunData {
        number: u32::from(run),
        sense: map.sense,
        rising,
        set_pa: Some(f64::from(set_pa)),
        pressure_pa: f64::from(pressure_pa),
        force_n: ForceLaw::standard().force_n(f64::from(pressure_pa)),
        points: inside().map(|(theta, r, _)| (theta, r)).collect(),
        forces_n: inside()
            .map(|(_, _, pa)| ForceLaw::standard().force_n(pa))
            .collect(),
    }
}
