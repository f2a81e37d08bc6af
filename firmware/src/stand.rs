//! The static test of the ball bar: directions one after the other, up and down in each.
//!
//! Rate: once a millisecond, from the ball bar's duty ([`crate::bar`]).

use heapless::Vec;
use rarma_box::wire::{CircleMessage, JOB_PRESSURES, StandJob};
use rarma_rigs::ldbb::{
    Asked, BarSet, Held, LoadCycle, Seen, Standing, StandingConfig, StandingEvent, StiffnessMap,
    Trace,
};

/// Force, N, and length change, m, in the plane.
type Way = Vec<(f32, f32), JOB_PRESSURES>;

/// The duty of the static test.
#[derive(Debug)]
pub struct StandDuty {
    test: Standing,
    bar: BarSet,
    last_step: u16,
    up: Way,
    down: Way,
}

impl StandDuty {
    /// None where the job's numbers do not fit together, or a pressure is out of reach.
    pub fn new(job: &StandJob, bar: &BarSet, gauge_limit_m: f32) -> Option<Self> {
        let job = job.for_bar(bar).ok()?;
        let schedule = job.schedule()?;
        let first = schedule.run(0)?;
        let config = StandingConfig {
            directions: job.directions,
            gauge_limit_m,
            ..StandingConfig::default()
        };
        if first.pressure_pa < 0.99 * config.holding_pa {
            return None;
        }
        Some(Self {
            last_step: schedule.runs().saturating_sub(1),
            test: Standing::new(config, schedule)?,
            bar: *bar,
            up: Way::new(),
            down: Way::new(),
        })
    }

    /// The machine stands.
    pub fn go(&mut self) {
        self.test.go();
    }

    /// Whether everything is over.
    pub fn is_over(&self) -> bool {
        self.test.is_over()
    }

    /// What the valve loop should do.
    pub fn asked(&self) -> Asked {
        self.test.asked()
    }

    /// One millisecond: what there is to say.
    pub fn step(&mut self, seen: &Seen) -> [Option<CircleMessage>; 2] {
        match self.test.step(seen) {
            None => [None, None],
            Some(StandingEvent::Go(direction)) => [Some(CircleMessage::Go { direction }), None],
            Some(StandingEvent::Held(held)) => self.held(&held),
            Some(StandingEvent::Failed(why)) => [Some(CircleMessage::Failed { run: 0, why }), None],
        }
    }

    fn held(&mut self, held: &Held) -> [Option<CircleMessage>; 2] {
        let force_n = self.bar.in_plane_n(held.pressure_pa);
        let dr_m = self.bar.in_plane_m(held.gauge_m);
        let run = held.run;
        // There is room: no way has more steps than a job has pressures.
        let _ = if run.rising {
            &mut self.up
        } else {
            &mut self.down
        }
        .push((force_n, dr_m));
        let told = CircleMessage::Held {
            direction: held.direction,
            step: run.number,
            rising: run.rising,
            pressure_pa: held.pressure_pa,
            force_n,
            dr_m,
        };
        let cycle = (run.number == self.last_step).then(|| self.cycle(held.direction));
        [Some(told), cycle.flatten()]
    }

    fn cycle(&mut self, direction: u8) -> Option<CircleMessage> {
        let (up, down) = (
            core::mem::take(&mut self.up),
            core::mem::take(&mut self.down),
        );
        let found = LoadCycle::new(&up, &down).ok()?;
        let mut map = StiffnessMap::<f32, 1>::default();
        for (force_n, dr_m) in &up {
            let mut trace = Trace::<f32, 1>::default();
            let _ = trace.add(0.0, *dr_m);
            map.add(&trace, *force_n).ok()?;
        }
        let k = map.directions(0.0).ok().and_then(|mut d| d.next());
        Some(CircleMessage::Cycle {
            direction,
            most_m: found.most_m,
            left_m: found.left_m,
            stiffness_n_per_m: k.map_or((0.0, 0.0), |d| {
                (d.stiffness_n_per_m.value, d.stiffness_n_per_m.sd)
            }),
        })
    }
}
