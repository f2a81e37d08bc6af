//! The machine's program: in along the radius, the arc, out again.

use rarma_rigs::ldbb::Sense;

/// One circle as it is programmed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Program {
    /// Radius, m.
    pub radius_m: f64,
    /// Feed along the arc and along the radius, m/s.
    pub feed_m_s: f64,
    /// Acceleration along the arc, m/s².
    pub acceleration_m_s2: f64,
    /// Where the arc begins, rad.
    pub start_rad: f64,
    /// How far it goes, rad.
    pub sweep_rad: f64,
    /// Direction.
    pub sense: Sense,
    /// The machine waits this far outside the circle, m.
    pub outside_m: f64,
    /// Pause between radius and arc, s.
    pub pause_s: f64,
}

/// What is done otherwise than programmed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionFault {
    /// The machine never moves in.
    NoStart,
    /// It never moves out.
    NoEnd,
    /// It runs the other way round.
    Reversed,
    /// The feed is this many times the programmed one all along.
    Feed(f64),
    /// Beyond this part of the sweep the feed is this many times the programmed one.
    FeedFrom(f64, f64),
    /// This part faster over the first half of the arc, and slower over the second so that the
    /// arc takes its time all the same.
    FeedSwings(f64),
    /// It stops and moves out after this part of the sweep.
    StopsAt(f64),
}

/// Where the spindle is told to be.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Place {
    /// Angle, rad.
    pub theta: f64,
    /// Distance from the centre beyond the radius, m.
    pub outside_m: f64,
    /// Speed along the arc, m/s; positive counter-clockwise.
    pub speed_m_s: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Leg {
    Standing,
    In,
    PauseIn(f64),
    Arc,
    PauseOut(f64),
    Out,
}

/// The axes on their way.
#[derive(Debug, Clone)]
pub struct Motion {
    leg: Leg,
    place: Place,
    run_rad: f64,
    program: Option<(Program, Option<MotionFault>)>,
}

impl Motion {
    /// Standing on the circle at an angle, rad.
    pub fn standing(theta: f64) -> Self {
        Self {
            leg: Leg::Standing,
            place: Place {
                theta,
                ..Place::default()
            },
            run_rad: 0.0,
            program: None,
        }
    }

    /// Moves to an angle on the circle at once, and stands there.
    pub fn stand(&mut self, theta: f64) {
        *self = Self::standing(theta);
    }

    /// Goes to the start of a program and waits there, outside the circle.
    pub fn prepare(&mut self, program: &Program) {
        self.leg = Leg::Standing;
        self.program = None;
        self.place = Place {
            theta: program.start_rad,
            outside_m: program.outside_m,
            speed_m_s: 0.0,
        };
    }

    /// Starts a program.
    pub fn start(&mut self, program: Program, fault: Option<MotionFault>) {
        self.prepare(&program);
        self.run_rad = 0.0;
        self.program = Some((program, fault));
        if fault != Some(MotionFault::NoStart) {
            self.leg = Leg::In;
        }
    }

    /// Whether a program is running.
    pub fn busy(&self) -> bool {
        self.leg != Leg::Standing
    }

    /// Where the spindle is told to be.
    pub fn place(&self) -> Place {
        self.place
    }

    /// `dt_s` on.
    pub fn step(&mut self, dt_s: f64) {
        let Some((p, fault)) = self.program else {
            return;
        };
        self.leg = match self.leg {
            Leg::Standing => Leg::Standing,
            Leg::In => {
                self.place.outside_m = (self.place.outside_m - p.feed_m_s * dt_s).max(0.0);
                if self.place.outside_m > 0.0 {
                    Leg::In
                } else {
                    Leg::PauseIn(p.pause_s)
                }
            }
            Leg::PauseIn(left) if left > dt_s => Leg::PauseIn(left - dt_s),
            Leg::PauseIn(_) => Leg::Arc,
            Leg::Arc => self.arc(dt_s, &p, fault),
            Leg::PauseOut(left) if left > dt_s => Leg::PauseOut(left - dt_s),
            Leg::PauseOut(_) if fault == Some(MotionFault::NoEnd) => Leg::Standing,
            Leg::PauseOut(_) => Leg::Out,
            Leg::Out => {
                self.place.outside_m = (self.place.outside_m + p.feed_m_s * dt_s).min(p.outside_m);
                if self.place.outside_m < p.outside_m {
                    Leg::Out
                } else {
                    Leg::Standing
                }
            }
        };
    }

    fn arc(&mut self, dt_s: f64, p: &Program, fault: Option<MotionFault>) -> Leg {
        let part = self.run_rad / p.sweep_rad;
        let (mut feed, mut end, mut sign) = (p.feed_m_s, p.sweep_rad, p.sense.sign::<f64>());
        match fault {
            Some(MotionFault::Reversed) => sign = -sign,
            Some(MotionFault::Feed(factor)) => feed *= factor,
            Some(MotionFault::FeedFrom(from, factor)) if part >= from => feed *= factor,
            Some(MotionFault::FeedSwings(by)) if part < 0.5 => feed *= 1.0 + by,
            Some(MotionFault::FeedSwings(by)) => feed /= 2.0 - 1.0 / (1.0 + by),
            Some(MotionFault::StopsAt(at)) => end *= at,
            _ => {}
        }
        // As fast as lets it stop at the end.
        let left_m = (end - self.run_rad).max(0.0) * p.radius_m;
        let stopping = (2.0 * p.acceleration_m_s2 * left_m).sqrt();
        let speed = self.place.speed_m_s.abs() + p.acceleration_m_s2 * dt_s;
        let speed = speed.min(feed).min(stopping.max(1e-4));
        let step = (speed * dt_s / p.radius_m).min(end - self.run_rad);
        self.run_rad += step;
        self.place.theta = p.start_rad + sign * self.run_rad;
        self.place.speed_m_s = sign * speed;
        if self.run_rad < end {
            return Leg::Arc;
        }
        self.place.speed_m_s = 0.0;
        Leg::PauseOut(p.pause_s)
    }
}
