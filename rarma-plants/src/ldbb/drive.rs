//! The bench with the box's sequence and valve loop around it, without the box: for
//! evaluating many machines in little time.

use super::bench::{Bench, BenchConfig, Reading};
use super::motion::{MotionFault, Program};
use rarma_rigs::ldbb::{
    Event, Held, Procedure, ProcedureConfig, RunDone, RunFault, Schedule, Seen, Sense, Stage,
    Standing, StandingConfig, StandingEvent, ValveConfig, ValveLoop,
};

/// Milliseconds in a recorded point: 100 points a second.
const POINT_MS: u32 = 10;
/// The operator takes this long to start, ms.
const START_MS: u32 = 300;

/// A recorded point: means of 10 ms.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Point {
    /// Since the programmed beginning of the arc, s.
    pub t_s: f64,
    /// Gauge, m.
    pub gauge_m: f64,
    /// Transducer, Pa.
    pub pressure_pa: f64,
}

/// A run.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// What the sequence says of it.
    pub done: RunDone,
    /// Its points, overshoots included.
    pub points: Vec<Point>,
}

/// Something that goes wrong with the air, and in which run, how long after its on-trigger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AirFault {
    /// This part of the pressure leaks away.
    Leak(f64),
    /// The regulator's gain is off by this part.
    Gain(f64),
}

/// What goes wrong in a test.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trouble {
    /// With the motion of a run.
    pub motion: Option<(u16, MotionFault)>,
    /// With the air: run, s after its on-trigger.
    pub air: Option<(u16, f32, AirFault)>,
}

/// A whole test.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    /// Runs that were finished.
    pub runs: Vec<Recorded>,
    /// Why it ended early.
    pub fault: Option<RunFault>,
    /// Run in which it did.
    pub fault_run: Option<u16>,
    /// Pressure 3 s after the fault, or at the end, Pa.
    pub pressure_after_pa: f64,
    /// Least pressure while the machine moved, Pa.
    pub least_moving_pa: f64,
    /// Simulated time, s.
    pub time_s: f64,
}

/// The program of a run.
pub fn program(c: &ProcedureConfig, sense: Sense) -> Program {
    let (from, sweep) = (f64::from(c.start_rad), f64::from(c.sweep_rad));
    let feed_m_s = f64::from(c.feed_m_s);
    Program {
        radius_m: f64::from(c.radius_m),
        feed_m_s,
        acceleration_m_s2: 0.5,
        start_rad: match sense {
            Sense::Ccw => from,
            Sense::Cw => from + sweep,
        },
        sweep_rad: sweep,
        sense,
        outside_m: 2.0 * f64::from(c.trigger_m),
        pause_s: (f64::from(c.lead_s) - f64::from(c.trigger_m) / feed_m_s).max(0.0),
    }
}

/// Runs a test to its end.
pub fn circles(
    bench: BenchConfig,
    config: ProcedureConfig,
    valve: ValveConfig,
    schedule: Schedule,
    trouble: &Trouble,
) -> Option<Test> {
    let mut bench = Bench::new(bench);
    let mut procedure = Procedure::new(config, schedule)?;
    let mut valve_loop = ValveLoop::default();
    bench.prepare(&program(&config, Sense::Ccw));
    let mut out = Test {
        runs: Vec::new(),
        fault: None,
        fault_run: None,
        pressure_after_pa: 0.0,
        least_moving_pa: f64::INFINITY,
        time_s: 0.0,
    };
    let (mut points, mut part, mut parts) = (Vec::new(), Point::default(), 0u32);
    let mut start: Option<(u32, Sense)> = None;
    let (mut command_pa, mut settled) = (0.0, false);
    let mut over_ms = 0;
    while over_ms < 3000 {
        let reading = bench.step(1e-3, Some(command_pa));
        out.time_s += 1e-3;
        let event = procedure.step(&seen(&reading, settled));
        match event {
            Some(Event::Ready(run)) => start = Some((START_MS, run.sense)),
            Some(Event::Done(done)) => {
                out.runs.push(Recorded {
                    done,
                    points: std::mem::take(&mut points),
                });
            }
            Some(Event::Failed(why)) => {
                out.fault = Some(why);
                out.fault_run = procedure.run().map(|r| r.number);
            }
            None => {}
        }
        if matches!(procedure.stage(), Stage::Finished | Stage::Failed) {
            over_ms += 1;
        }
        if let Some((left, sense)) = start {
            start = (left > 0).then(|| (left.saturating_sub(1), sense));
            if start.is_none() {
                let number = procedure.run().map_or(0, |r| r.number);
                let fault = trouble.motion.filter(|(run, _)| *run == number);
                bench.start(program(&config, sense), fault.map(|(_, f)| f));
                points.clear();
                (part, parts) = (Point::default(), 0);
            }
        }
        if let Some(run_s) = procedure.run_s() {
            out.least_moving_pa = out.least_moving_pa.min(reading.pressure_pa);
            part.t_s += f64::from(run_s - config.lead_s);
            part.gauge_m += reading.gauge_m;
            part.pressure_pa += reading.pressure_pa;
            parts += 1;
            if parts == POINT_MS {
                let n = f64::from(parts);
                points.push(Point {
                    t_s: part.t_s / n,
                    gauge_m: part.gauge_m / n,
                    pressure_pa: part.pressure_pa / n,
                });
                (part, parts) = (Point::default(), 0);
            }
            if let Some((run, at_s, fault)) = trouble.air
                && procedure.run().is_some_and(|r| r.number == run)
                && run_s >= at_s
            {
                match fault {
                    AirFault::Leak(leak) => bench.air_mut().config.leak = leak,
                    AirFault::Gain(error) => bench.air_mut().config.gain_error = error,
                }
            }
        }
        let asked = procedure.asked();
        let p = reading.pressure_pa as f32;
        let ordered = valve_loop.step(&valve, 1e-3, asked.pressure_pa, p, asked.dither);
        command_pa = f64::from(ordered.command_pa);
        settled = ordered.settled;
        out.pressure_after_pa = reading.pressure_pa;
    }
    Some(out)
}

/// Runs a static test in these directions, rad. None where it fails.
pub fn standing(
    bench: BenchConfig,
    config: StandingConfig,
    valve: ValveConfig,
    schedule: Schedule,
    directions_rad: &[f64],
) -> Option<Vec<Held>> {
    let mut bench = Bench::new(bench);
    let mut test = Standing::new(config, schedule)?;
    let mut valve_loop = ValveLoop::default();
    let (mut command_pa, mut settled) = (0.0, false);
    let mut out = Vec::new();
    while !test.is_over() {
        let reading = bench.step(1e-3, Some(command_pa));
        match test.step(&seen(&reading, settled)) {
            Some(StandingEvent::Go(k)) => {
                bench.stand(*directions_rad.get(usize::from(k))?);
                test.go();
            }
            Some(StandingEvent::Held(held)) => out.push(held),
            Some(StandingEvent::Failed(_)) => return None,
            None => {}
        }
        let asked = test.asked();
        let p = reading.pressure_pa as f32;
        let ordered = valve_loop.step(&valve, 1e-3, asked.pressure_pa, p, asked.dither);
        command_pa = f64::from(ordered.command_pa);
        settled = ordered.settled;
    }
    Some(out)
}

fn seen(reading: &Reading, settled: bool) -> Seen {
    Seen {
        gauge_m: reading.gauge_m as f32,
        pressure_pa: reading.pressure_pa as f32,
        settled,
    }
}
