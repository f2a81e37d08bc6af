//! Start-up: from the first samples to a model next to the efficient one.
//!
//! Rate: once a sample, with a bounded share of the work (a few updates' worth).
//! Nothing here can find a local minimum, because nothing here searches: every
//! step is linear least squares.
//!
//! 1. *Collect* the first n samples.
//! 2. *Lattice*: a long autoregression by Burg's method; what it cannot predict,
//!    ê, stands for the innovations (Hannan and Rissanen).
//! 3. *Rounds*: least squares of C₀⁻¹(A·y − C·ê) over a and c, C₀ being the C of the
//!    round before (1 at first). Four rounds end next to the efficient estimate,
//!    with its covariance.
//! 4. *Warm up* the filters of φ and ψ over the same samples.
//! 5. *Catch up*: the recursion itself over the samples that came meanwhile, until
//!    it meets the present one. No sample is lost and none counts twice.

mod lattice;

use super::{RecursiveArma, SMALLEST_VARIANCE};
use crate::estimate::config::{Gain, Gradient, MOST};
use crate::estimate::schur;
use crate::estimate::status::{Status, Step};
use crate::real::Real;
use crate::visit::{self, StateVisitor};

/// Least squares in sequence.
const ROUNDS: u32 = 4;
/// Units of work a sample; a unit is one row of least squares or one update.
const PACE: u32 = 4;
/// Samples of a lattice stage a unit: a whole stage a sample at the longest.
const LATTICE_UNIT: usize = MOST / PACE as usize;
/// Samples of filtering a unit.
const WARM_UNIT: usize = 16;
/// Orders of the long autoregression.
const SHORTEST: usize = 16;
const LONGEST: usize = 64;
/// Room for the samples, which are read until the end, and from [`FORWARD`] on for
/// the forward errors ê of the lattice, which are read until the rounds end.
const ROOM: usize = 1280;
const FORWARD: usize = ROOM - MOST;
/// The backward errors lie between the samples, of which there are fewer than this
/// until the lattice ends, and the forward errors.
const BACKWARD: usize = FORWARD - MOST;
// Samples at the end of the lattice, of the rounds and of it all, at the longest.
const LATTICE_END: usize = MOST + LONGEST + 1;
const ROUNDS_END: usize = LATTICE_END + (ROUNDS as usize * MOST).div_ceil(PACE as usize);
const WARM_END: usize = ROUNDS_END + MOST.div_ceil(WARM_UNIT * PACE as usize);
const END: usize = WARM_END + (WARM_END - MOST).div_ceil(PACE as usize - 1);
const _: () = assert!(LATTICE_END < BACKWARD && ROUNDS_END < FORWARD && END < ROOM);

/// What is being done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    Collect,
    Lattice,
    Rounds,
    WarmUp,
    CatchUp,
    /// Over, and the covariance gives the gain.
    Over,
    /// Over, and the normalised gradient has taken the place of the recursion. A stage
    /// of its own keeps the choice of the gain out of the usual path.
    Steepest,
}

const STAGES: [Stage; 7] = [
    Stage::Collect,
    Stage::Lattice,
    Stage::Rounds,
    Stage::WarmUp,
    Stage::CatchUp,
    Stage::Over,
    Stage::Steepest,
];

/// State of the start-up. About 5 kB in `f32`.
#[derive(Debug, Clone)]
pub(in crate::estimate) struct Start<T, const N: usize> {
    stage: Stage,
    /// What follows: [`Stage::Over`] or [`Stage::Steepest`].
    last: Stage,
    store: [T; ROOM],
    /// Samples in store.
    taken: usize,
    /// n: samples of the least squares.
    length: usize,
    /// Place of the stage in its pass over the samples.
    place: usize,
    /// Order of the lattice so far, and the order wanted.
    order: usize,
    wanted: usize,
    /// Reflection coefficient of the stage in work, and the sums for the next.
    reflection: T,
    cross: T,
    square: T,
    /// Backward error that the stage has overwritten last.
    overwritten: T,
    round: u32,
    /// Estimate of the round in work.
    next: [T; N],
}

impl<T: Real, const N: usize> Start<T, N> {
    /// Zeros, until [`Self::begin`].
    pub const BLANK: Self = Self {
        stage: Stage::Collect,
        last: Stage::Collect,
        store: [T::ZERO; ROOM],
        taken: 0,
        length: 0,
        place: 0,
        order: 0,
        wanted: 0,
        reflection: T::ZERO,
        cross: T::ZERO,
        square: T::ZERO,
        overwritten: T::ZERO,
        round: 0,
        next: [T::ZERO; N],
    };

    /// Nothing collected; over at once for 0 samples.
    pub fn begin(&mut self, samples: u32, gain: Gain<T>) {
        let of_gain = match gain {
            Gain::Covariance => Stage::Over,
            Gain::Normalised { .. } => Stage::Steepest,
        };
        // All of them by name, so that none is forgotten.
        let Self {
            stage,
            last,
            store,
            taken,
            length,
            place,
            order,
            wanted,
            reflection,
            cross,
            square,
            overwritten,
            round,
            next,
        } = self;
        *length = (samples as usize).min(MOST);
        *stage = if *length == 0 {
            of_gain
        } else {
            Stage::Collect
        };
        *last = of_gain;
        store.fill(T::ZERO);
        next.fill(T::ZERO);
        (*taken, *place, *order, *wanted, *round) = (0, 0, 0, 0, 0);
        for x in [reflection, cross, square, overwritten] {
            *x = T::ZERO;
        }
    }

    #[inline(always)]
    pub fn is_over(&self) -> bool {
        matches!(self.stage, Stage::Over)
    }

    /// A place of the store; the sums above keep every index inside.
    #[inline(always)]
    fn at(&self, i: usize) -> T {
        self.store.get(i).copied().unwrap_or(T::ZERO)
    }

    #[inline(always)]
    fn put(&mut self, i: usize, x: T) {
        if let Some(place) = self.store.get_mut(i) {
            *place = x;
        }
    }

    /// Every number but what the settings say; false where they are no start-up's.
    pub fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
        let Self {
            stage,
            last: _,
            store,
            taken,
            length,
            place,
            order,
            wanted,
            reflection,
            cross,
            square,
            overwritten,
            round,
            next,
        } = self;
        visit::all(store, visitor);
        visit::all(next, visitor);
        visit::all([reflection, cross, square, overwritten], visitor);
        let mut code = *stage as u32;
        visitor.count(&mut code);
        for n in [taken, length, place, order, wanted] {
            visit::place(n, visitor);
        }
        visitor.count(round);
        let known = STAGES.into_iter().find(|stage| *stage as u32 == code);
        *stage = known.unwrap_or(Stage::Collect);
        // Through the samples of the least squares, and at the end through all of them.
        let pass = match *stage {
            Stage::Collect | Stage::Lattice | Stage::Rounds | Stage::WarmUp => self.length,
            Stage::CatchUp | Stage::Over | Stage::Steepest => ROOM,
        };
        known.is_some()
            && self.taken <= ROOM
            && self.length <= MOST
            && self.place <= pass
            && self.order <= LONGEST + 1
            && self.wanted <= LONGEST
            && self.round <= ROUNDS
    }

    /// The model is ready, whatever gives the gain.
    pub fn is_ready(&self) -> bool {
        matches!(self.stage, Stage::Over | Stage::Steepest)
    }
}

impl<T: Real, const P: usize, const Q: usize, const N: usize> RecursiveArma<T, P, Q, N> {
    /// Stores the sample and does its share of the work. Never inlined: it would take
    /// registers and stack from the recursion.
    #[cold]
    #[inline(never)]
    pub(super) fn start_up(&mut self, y: T, p: usize, q: usize) -> Step<T> {
        if self.start.stage == Stage::Steepest {
            return self.advance_steepest(y, p, q);
        }
        let taken = self.start.taken;
        self.power += (y * y - self.power) / T::from_u32(taken as u32 + 1);
        // There is room by the sums above; a sample without would be a defect here.
        if let Some(place) = self.start.store.get_mut(taken) {
            *place = y;
            self.start.taken += 1;
        }
        if self.start.stage == Stage::Collect && self.start.taken == self.start.length {
            if self.power > T::from_f64(SMALLEST_VARIANCE) {
                self.start.begin_lattice(p + q);
            } else {
                // Silence teaches nothing: wait for a signal.
                self.start.taken = 0;
                self.power = T::ZERO;
            }
        } else {
            for _ in 0..PACE {
                self.start_unit(p, q);
            }
        }
        Step {
            innovation: y,
            status: Status::Starting,
        }
    }

    /// See [`Self::finish_start`].
    pub(in crate::estimate) fn finish(&mut self, p: usize, q: usize) {
        if self.start.stage == Stage::Collect {
            // Too few for the samples wanted; enough for least squares?
            self.start.length = self.start.taken;
            if self.start.taken < 4 * (p + q) + 8 || !(self.power > T::ZERO) {
                return;
            }
            self.start.begin_lattice(p + q);
        }
        // A reset on the way leaves nothing to do.
        while !self.start.is_ready() && self.start.stage != Stage::Collect {
            self.start_unit(p, q);
        }
    }

    fn start_unit(&mut self, p: usize, q: usize) {
        match self.start.stage {
            Stage::Collect | Stage::Over | Stage::Steepest => {}
            Stage::Lattice => self.start.lattice_unit(),
            Stage::Rounds => {
                if self.start.place == 0 {
                    self.begin_round();
                }
                self.row(p, q);
                self.start.place += 1;
                if self.start.place == self.start.length {
                    self.end_round(p, q);
                }
            }
            Stage::WarmUp => {
                let filtered = matches!(self.config.gradient, Gradient::Filtered);
                let end = (self.start.place + WARM_UNIT).min(self.start.length);
                for t in self.start.place..end {
                    let y = self.start.at(t);
                    let e = self.predict(y, p, q);
                    let _ = self.filter(y, e, p, q, filtered);
                }
                self.start.place = end;
                if end == self.start.length {
                    self.start.stage = Stage::CatchUp;
                }
            }
            Stage::CatchUp => {
                if self.start.place < self.start.taken {
                    let y = self.start.at(self.start.place);
                    self.start.place += 1;
                    if self.start.last == Stage::Steepest {
                        let _ = self.advance_steepest(y, p, q);
                    } else {
                        let _ = self.advance(y, p, q);
                    }
                }
                if self.start.place >= self.start.taken {
                    self.start.stage = self.start.last;
                }
            }
        }
    }

    fn begin_round(&mut self) {
        if self.start.round == 0 {
            let floor = self.power * self.config.dynamic_range;
            self.sigma2 = self
                .start
                .innovation_variance()
                .max(floor)
                .max(T::from_f64(SMALLEST_VARIANCE));
        }
        self.clear_filters();
        self.start.next = self.theta;
        self.covariance.reset(self.config.start_variance);
    }

    fn clear_filters(&mut self) {
        self.phi.fill(T::ZERO);
        self.psi.fill(T::ZERO);
        self.older.fill(T::ZERO);
    }

    /// One row of a round: y_f − ê_f = −Σ aᵢ y_f(t−i) + Σ cⱼ ê_f(t−j) + error.
    fn row(&mut self, p: usize, q: usize) {
        let (t, n) = (self.start.place, p + q);
        // Before the lattice has its full order its errors are no innovations.
        let innovation = if t >= self.start.wanted {
            self.start.at(FORWARD + t)
        } else {
            T::ZERO
        };
        let row = self.psi;
        let (minus_y_f, e_f) = self.filter(self.start.at(t), innovation, p, q, true);
        if t < self.start.wanted + p.max(q) {
            return;
        }
        let mut error = -(minus_y_f + e_f);
        for (x, theta) in row[..n].iter().zip(&self.start.next[..n]) {
            error -= *x * *theta;
        }
        // A wild innovation counts with its own size.
        let e2 = innovation * innovation;
        let r = self.sigma2.max(e2 / self.config.outlier_ratio);
        let mut gain = [T::ZERO; N];
        let inverse = self.covariance.measure(n, &row, r, T::ONE, &mut gain);
        error *= inverse;
        for (theta, k) in self.start.next[..n].iter_mut().zip(&gain[..n]) {
            *theta += *k * error;
        }
    }

    fn end_round(&mut self, p: usize, q: usize) {
        let n = p + q;
        let finite = self.start.next[..n].iter().all(|x| x.is_finite());
        if !finite || !self.covariance.is_definite(n) {
            // Samples that span the whole range of numbers: begin again.
            self.reset();
            return;
        }
        self.theta = self.start.next;
        schur::shrink::<T, N>(&mut self.theta[p..n], self.config.c_radius);
        self.start.place = 0;
        self.start.round += 1;
        // Without C every round is the same.
        if self.start.round < ROUNDS && q > 0 {
            return;
        }
        self.clear_filters();
        let rows = T::from_u32(self.start.length as u32);
        self.variance_gain = T::ONE / rows;
        self.recent = self.sigma2;
        self.known = self.start.length as u32;
        self.start.stage = Stage::WarmUp;
    }
}
