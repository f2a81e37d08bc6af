//! The ball bar duty: pressure loop, sequence of a circle, readings, stiffness on the box.
//!
//! Rate: once a millisecond, from the output duty ([`crate::rig`]). What it has to say
//! waits until the slow duty fetches it ([`BarDuty::news`]).

use crate::stand::StandDuty;
use heapless::Deque;
use rarma_box::guard::{Denial, RigState};
use rarma_box::wire::{CIRCLE_POINTS, CircleJob, CircleMessage, CirclePoints, StandJob};
use rarma_rigs::ldbb::{
    BarSet, Event, Procedure, RunDone, Seen, Sense, Stage, StiffnessMap, Trace, ValveConfig,
    ValveLoop,
};

/// Directions the box keeps: 2° each.
pub const BINS: usize = 180;
/// Milliseconds in a reading that is sent.
const POINT_MS: u16 = 10;
/// Messages that wait: more than come in one millisecond.
const WAITING: usize = 4;

/// The duty of the ball bar.
#[derive(Debug, Default)]
pub struct BarDuty {
    valve: ValveLoop,
    settled: bool,
    /// Idle without a test of circles. In place, because it is large.
    procedure: Procedure,
    standing: Option<StandDuty>,
    circles: Circles,
}

/// What circles bring, and what is to be said of them.
#[derive(Debug)]
struct Circles {
    bar: Option<BarSet>,
    /// The other direction at this pressure; its force, N, until both are there.
    other: Trace<f32, BINS>,
    other_n: Option<f32>,
    both: bool,
    map: StiffnessMap<f32, BINS>,
    points: CirclePoints,
    sums: (f32, f32),
    in_point: u16,
    news: Deque<CircleMessage, WAITING>,
}

impl Default for Circles {
    fn default() -> Self {
        Self {
            bar: None,
            other: Trace::default(),
            other_n: None,
            both: false,
            map: StiffnessMap::BLANK,
            points: CirclePoints::default(),
            sums: (0.0, 0.0),
            in_point: 0,
            news: Deque::new(),
        }
    }
}

impl BarDuty {
    /// The valve is vented; a test that was under way is over.
    pub fn fall(&mut self) {
        self.valve.reset();
        self.settled = false;
        self.end_test();
    }

    /// A set point by hand, or a stop, ends a test.
    pub fn end_test(&mut self) {
        self.procedure.stop();
        self.standing = None;
    }

    /// A test of circles is wanted.
    ///
    /// # Errors
    /// [`Denial::Limit`]: a pressure is out of reach or does not hold the bar, or the job's
    /// numbers do not fit together.
    #[inline(never)]
    pub fn want(&mut self, job: &CircleJob, bar: &BarSet) -> Result<(), Denial> {
        let job = job.for_bar(bar).map_err(|_| Denial::Limit)?;
        let (config, schedule) = job.procedure().ok_or(Denial::Limit)?;
        if !self.procedure.begin(config, schedule) {
            return Err(Denial::Limit);
        }
        self.standing = None;
        self.circles.begin(*bar, job.both);
        Ok(())
    }

    /// A static test is wanted.
    ///
    /// # Errors
    /// As [`Self::want`].
    #[inline(never)]
    pub fn want_stand(
        &mut self,
        job: &StandJob,
        bar: &BarSet,
        gauge_limit_m: f32,
    ) -> Result<(), Denial> {
        let stand = StandDuty::new(job, bar, gauge_limit_m).ok_or(Denial::Limit)?;
        self.standing = Some(stand);
        self.procedure.stop();
        self.circles.news.clear();
        Ok(())
    }

    /// The machine stands where the static test wants it.
    ///
    /// # Errors
    /// [`Denial::NotReady`]: no static test waits for it.
    pub fn go(&mut self) -> Result<(), Denial> {
        let standing = self.standing.as_mut().filter(|s| !s.is_over());
        standing.ok_or(Denial::NotReady)?.go();
        Ok(())
    }

    /// Whether a test moves the set point.
    pub fn busy(&self) -> bool {
        !self.procedure.is_idle() || self.standing.is_some()
    }

    /// Where the test is; none without one.
    pub fn stage(&self) -> Option<Stage> {
        (!self.procedure.is_idle()).then(|| self.procedure.stage())
    }

    /// What there is to say, the oldest first.
    pub fn news(&mut self) -> Option<CircleMessage> {
        self.circles.news.pop_front()
    }

    /// One millisecond while outputs are on: `set_pa` is what the working point by hand asks
    /// for, `at_work` whether set points may be other than that. Gives reference and command,
    /// Pa.
    pub fn step(
        &mut self,
        c: &ValveConfig,
        set_pa: f32,
        at_work: bool,
        state: &RigState,
    ) -> (f32, f32) {
        let (mut set_pa, mut dither) = (set_pa, false);
        if !at_work {
            self.end_test();
        }
        let seen = Seen {
            gauge_m: state.gauge_m,
            pressure_pa: state.pressure_pa,
            settled: self.settled,
        };
        let mut asked = None;
        if let Some(standing) = &mut self.standing {
            for message in standing.step(&seen).into_iter().flatten() {
                self.circles.say(message);
            }
            asked = Some(standing.asked());
        }
        if !self.procedure.is_idle() {
            self.circles.step(&mut self.procedure, &seen);
            asked = Some(self.procedure.asked());
        }
        if let Some(asked) = asked {
            (set_pa, dither) = (asked.pressure_pa.min(c.most_pa), asked.dither);
        }
        let out = self.valve.step(c, 1e-3, set_pa, state.pressure_pa, dither);
        self.settled = out.settled;
        (out.reference_pa, out.command_pa)
    }
}

impl Circles {
    fn begin(&mut self, bar: BarSet, both: bool) {
        self.bar = Some(bar);
        self.map.reset();
        self.other_n = None;
        self.both = both;
        self.news.clear();
    }

    fn step(&mut self, procedure: &mut Procedure, seen: &Seen) {
        let run = procedure.run().map_or(0, |r| r.number);
        let event = procedure.step(seen);
        if let Some(run_s) = procedure.run_s() {
            self.point(run, run_s - procedure.config().lead_s, seen);
        }
        match event {
            None => {}
            Some(Event::Ready(next)) => {
                self.in_point = 0;
                self.points.gauge_m.clear();
                self.say(CircleMessage::Ready {
                    run: next.number,
                    cw: next.sense == Sense::Cw,
                    rising: next.rising,
                    pressure_pa: next.pressure_pa,
                });
            }
            Some(Event::Done(done)) => {
                self.flush();
                self.done(procedure, &done);
            }
            Some(Event::Failed(why)) => {
                self.flush();
                self.say(CircleMessage::Failed { run, why });
            }
        }
    }

    /// A reading of a millisecond.
    fn point(&mut self, run: u16, arc_s: f32, seen: &Seen) {
        if self.in_point == 0 {
            self.sums = (0.0, 0.0);
            if self.points.gauge_m.is_empty() {
                self.points.run = run;
                // Middle of ten milliseconds.
                self.points.first_ms = (1e3 * arc_s) as i32 + i32::from(POINT_MS) / 2;
                self.points.pressure_pa = 0.0;
            }
        }
        self.sums.0 += seen.gauge_m;
        self.sums.1 += seen.pressure_pa;
        self.in_point += 1;
        if self.in_point < POINT_MS {
            return;
        }
        self.in_point = 0;
        let per = 1.0 / f32::from(POINT_MS);
        // There is room: a full message has been sent.
        let _ = self.points.gauge_m.push(self.sums.0 * per);
        let n = self.points.gauge_m.len() as f32;
        self.points.pressure_pa += (self.sums.1 * per - self.points.pressure_pa) / n;
        if self.points.gauge_m.len() == CIRCLE_POINTS {
            self.flush();
        }
    }

    fn flush(&mut self) {
        if !self.points.gauge_m.is_empty() {
            let points = core::mem::take(&mut self.points);
            self.say(CircleMessage::Points(points));
        }
        self.in_point = 0;
    }

    #[inline(never)]
    fn done(&mut self, procedure: &Procedure, done: &RunDone) {
        self.say(CircleMessage::Done {
            run: done.run.number,
            arc_s: done.map.to_s - done.map.from_s,
            pressure_pa: done.pressure_pa,
            feed_m_s: done.feed_m_s,
            proof: done.proof,
            reversals: (done.reversals.seen, done.reversals.off_rad),
        });
        if let Some(bar) = self.bar
            && done.run.rising
        {
            let mut trace: Trace<f32, BINS> = procedure.trace(done);
            // The gauge sees ΔL = Δr·cos φ: c = (ΔL/cos φ)/F_plane, so the readings stay and the
            // force takes cos φ.
            let force_n = bar.in_plane_n(done.pressure_pa) * bar.cos();
            match self.other_n.take() {
                None if self.both => (self.other, self.other_n) = (trace, Some(force_n)),
                other => {
                    let force_n = other.map_or(force_n, |other_n| {
                        trace.average_with(&self.other);
                        0.5 * (other_n + force_n)
                    });
                    // A force that is not finite would be a pressure that is not: checked.
                    let _ = self.map.add(&trace, force_n);
                }
            }
        }
        if procedure.stage() == Stage::Finished
            && let Some(found) = self.stiffness()
        {
            self.say(found);
        }
    }

    fn stiffness(&self) -> Option<CircleMessage> {
        let scatter_m = self.map.scatter_m(false).ok()?;
        let mut all = self.map.directions(0.0).ok()?;
        let first = all.next()?;
        let (mut most, mut least, mut sum, mut n) = (first, first, 0.0, 0.0);
        for d in core::iter::once(first).chain(all) {
            let k = d.stiffness_n_per_m.value;
            if k > most.stiffness_n_per_m.value {
                most = d;
            }
            if k < least.stiffness_n_per_m.value {
                least = d;
            }
            sum += k;
            n += 1.0;
        }
        Some(CircleMessage::Stiffness {
            mean_n_per_m: sum / n,
            most: (most.stiffness_n_per_m.value, most.angle_rad),
            least: (least.stiffness_n_per_m.value, least.angle_rad),
            sd_n_per_m: most.stiffness_n_per_m.sd,
            scatter_m,
        })
    }

    /// What finds no room is lost: the host sees it in the numbers of the readings.
    fn say(&mut self, message: CircleMessage) {
        let _ = self.news.push_back(message);
    }
}
