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

/// See the module.
#[derive(Debug)]
pub struct BarDuty {
    valve: ValveLoop,
    settled: bool,
    procedure: Option<Procedure>,
    standing: Option<StandDuty>,
    bar: Option<BarSet>,
    /// The other direction at this pressure and its force, N, until both are there.
    half: Option<(Trace<f32, BINS>, f32)>,
    both: bool,
    map: StiffnessMap<f32, BINS>,
    points: CirclePoints,
    sums: (f32, f32),
    in_point: u16,
    news: Deque<CircleMessage, WAITING>,
}

impl Default for BarDuty {
    fn default() -> Self {
        Self {
            valve: ValveLoop::default(),
            settled: false,
            procedure: None,
            standing: None,
            bar: None,
            half: None,
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
        self.procedure = None;
        self.standing = None;
    }

    /// A test of circles is wanted.
    ///
    /// # Errors
    /// [`Denial::Limit`]: a pressure is out of reach or does not hold the bar, or the job's
    /// numbers do not fit together.
    pub fn want(&mut self, job: &CircleJob, bar: &BarSet) -> Result<(), Denial> {
        let job = job.for_bar(bar).map_err(|_| Denial::Limit)?;
        let (config, schedule) = job.procedure().ok_or(Denial::Limit)?;
        self.procedure = Some(Procedure::new(config, schedule).ok_or(Denial::Limit)?);
        self.standing = None;
        self.bar = Some(*bar);
        self.map.reset();
        self.half = None;
        self.both = job.both;
        self.news.clear();
        Ok(())
    }

    /// A static test is wanted.
    ///
    /// # Errors
    /// As [`Self::want`].
    pub fn want_stand(
        &mut self,
        job: &StandJob,
        bar: &BarSet,
        gauge_limit_m: f32,
    ) -> Result<(), Denial> {
        let stand = StandDuty::new(job, bar, gauge_limit_m).ok_or(Denial::Limit)?;
        self.standing = Some(stand);
        self.procedure = None;
        self.news.clear();
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
        self.procedure.is_some() || self.standing.is_some()
    }

    /// Where the test is; none without one.
    pub fn stage(&self) -> Option<Stage> {
        self.procedure.as_ref().map(Procedure::stage)
    }

    /// What there is to say, the oldest first.
    pub fn news(&mut self) -> Option<CircleMessage> {
        self.news.pop_front()
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
        if let Some(mut standing) = self.standing.take() {
            let seen = self.seen(state);
            for message in standing.step(&seen).into_iter().flatten() {
                self.say(message);
            }
            let asked = standing.asked();
            (set_pa, dither) = (asked.pressure_pa.min(c.most_pa), asked.dither);
            self.standing = Some(standing);
        }
        if let Some(mut procedure) = self.procedure.take() {
            self.test(&mut procedure, state);
            let asked = procedure.asked();
            (set_pa, dither) = (asked.pressure_pa.min(c.most_pa), asked.dither);
            self.procedure = Some(procedure);
        }
        let out = self.valve.step(c, 1e-3, set_pa, state.pressure_pa, dither);
        self.settled = out.settled;
        (out.reference_pa, out.command_pa)
    }

    fn seen(&self, state: &RigState) -> Seen {
        Seen {
            gauge_m: state.gauge_m,
            pressure_pa: state.pressure_pa,
            settled: self.settled,
        }
    }

    fn test(&mut self, procedure: &mut Procedure, state: &RigState) {
        let seen = self.seen(state);
        let run = procedure.run().map_or(0, |r| r.number);
        let event = procedure.step(&seen);
        if let Some(run_s) = procedure.run_s() {
            self.point(run, run_s - procedure.config().lead_s, &seen);
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
            let trace: Trace<f32, BINS> = procedure.trace(done);
            // The gauge sees ΔL = Δr·cos φ: c = (ΔL/cos φ)/F_plane, so the readings stay and the
            // force takes cos φ.
            let force_n = bar.in_plane_n(done.pressure_pa) * bar.cos();
            match (self.both, self.half.take()) {
                (true, None) => self.half = Some((trace, force_n)),
                (_, other) => {
                    let (mean, force_n) = other.map_or((trace, force_n), |(o, f)| {
                        (o.averaged(&trace), 0.5 * (f + force_n))
                    });
                    // A force that is not finite would be a pressure that is not: checked.
                    let _ = self.map.add(&mean, force_n);
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
