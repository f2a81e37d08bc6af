//! Recursive ARMA of any order with the roots of its A, of one kind for all orders.
//!
//! The orders that the box has are compiled for themselves, which is several times as fast;
//! all others share one with the order as a value. Both give the same numbers, bit by bit.

use crate::state::{Reader, Writer};
use rarma_core::estimate::{BoundedArma, RarmaConfig, RecursiveArma, StateVisitor, Status};
use rarma_core::spectrum::{FactorTracker, ModalDeviation, Quadratic, Tracking, deviation, modal};
use rarma_fit::{ChannelStatus, RecursiveChannels};

/// Largest p and q.
pub const MAX_ORDER: usize = 30;

/// Sweeps over the roots at a row at most, where they are not followed from the sample before. A
/// search from nothing takes about thirty.
const SWEEPS: u32 = 200;

/// What is read off at a sample: one value a mode, NaN where there is none.
#[derive(Default)]
pub struct Rows {
    pub f_hz: Vec<f64>,
    pub zeta: Vec<f64>,
    pub sd_f_hz: Vec<f64>,
    pub sd_zeta: Vec<f64>,
}

impl Rows {
    /// With room for so many values each.
    pub fn with_room(values: usize) -> Self {
        let room = || Vec::with_capacity(values);
        Self {
            f_hz: room(),
            zeta: room(),
            sd_f_hz: room(),
            sd_zeta: room(),
        }
    }

    fn push(&mut self, f_hz: f64, zeta: f64, sd_f_hz: f64, sd_zeta: f64) {
        self.f_hz.push(f_hz);
        self.zeta.push(zeta);
        self.sd_f_hz.push(sd_f_hz);
        self.sd_zeta.push(sd_zeta);
    }
}

/// A recursive model and its roots.
pub trait Estimator: Send + Sync {
    /// Takes samples, of several channels one channel after the other within each; reads a row off
    /// after every sample at which `due` comes down to 0, which then begins again at `every`.
    fn push(&mut self, x: &[f64], every: u32, due: &mut u32, fs: f64, rows: &mut Rows);
    /// Does what is left of the start-up, and looks for the roots.
    fn finish_start(&mut self);
    fn a(&self) -> &[f64];
    /// Of several channels those of one after the other.
    fn c(&self) -> &[f64];
    /// Element of the covariance of the innovations.
    fn noise(&self, row: usize, column: usize) -> f64;
    fn is_ready(&self) -> bool;
    fn deviation(&self, factor: &Quadratic<f64>, fs: f64) -> Option<ModalDeviation<f64>>;
    /// Element of the covariance of θ = (a, c).
    fn covariance(&self, row: usize, column: usize) -> f64;
    fn write(&mut self, out: &mut Writer);
    /// False where it is the state of another model.
    fn read(&mut self, from: &mut Reader<'_>) -> bool;
}

/// The estimator of an order; none for (0,0) and beyond [`MAX_ORDER`].
pub fn estimator(p: usize, q: usize, config: RarmaConfig<f64>) -> Option<Box<dyn Estimator>> {
    macro_rules! sized {
        ($($p:literal, $q:literal, $n:literal;)*) => {
            match (p, q) {
                $(($p, $q) => {
                    let model = RecursiveArma::<f64, $p, $q, $n>::new(config);
                    Box::new(Followed::<_, $p>::new(model))
                })*
                _ => Box::new(Followed::<_, MAX_ORDER>::new(BoundedArma::new(p, q, config)?)),
            }
        };
    }
    Some(sized! {
        2, 1, 3;
        2, 2, 4;
        4, 3, 7;
        4, 4, 8;
        6, 5, 11;
        6, 6, 12;
        8, 7, 15;
        8, 8, 16;
    })
}

/// What all kinds of models can do.
pub trait Model: Send + Sync {
    /// Channels.
    fn width(&self) -> usize {
        1
    }
    /// Takes one sample of every channel.
    fn take(&mut self, y: &[f64]) -> Status;
    fn finish_start(&mut self);
    fn a(&self) -> &[f64];
    fn c(&self) -> &[f64];
    fn noise(&self, row: usize, column: usize) -> f64;
    fn is_ready(&self) -> bool;
    /// Factor that scales the covariance.
    fn scale(&self) -> f64;
    fn deviation(
        &self,
        factor: &Quadratic<f64>,
        fs: f64,
        scale: f64,
    ) -> Option<ModalDeviation<f64>>;
    fn element(&self, row: usize, column: usize) -> f64;
    fn visit(&mut self, visitor: &mut impl StateVisitor<f64>) -> bool;
}

/// What both of one channel answer under the same name.
macro_rules! passed_on {
    () => {
        #[inline(always)]
        fn take(&mut self, y: &[f64]) -> Status {
            y.first()
                .map_or(Status::Rejected, |y| self.update(*y).status)
        }
        fn finish_start(&mut self) {
            self.finish_start();
        }
        fn a(&self) -> &[f64] {
            self.a()
        }
        fn c(&self) -> &[f64] {
            self.c()
        }
        fn noise(&self, _: usize, _: usize) -> f64 {
            self.sigma2()
        }
        fn is_ready(&self) -> bool {
            self.ready()
        }
        fn visit(&mut self, visitor: &mut impl StateVisitor<f64>) -> bool {
            self.visit_state(visitor)
        }
    };
}

impl<const P: usize, const Q: usize, const N: usize> Model for RecursiveArma<f64, P, Q, N> {
    passed_on!();
    fn scale(&self) -> f64 {
        self.covariance_factor()
    }
    fn deviation(
        &self,
        factor: &Quadratic<f64>,
        fs: f64,
        scale: f64,
    ) -> Option<ModalDeviation<f64>> {
        deviation(self.a(), N, factor, fs, self.covariance(), scale)
    }
    fn element(&self, row: usize, column: usize) -> f64 {
        self.covariance().element(N, row, column)
    }
}

impl Model for BoundedArma<f64> {
    passed_on!();
    fn scale(&self) -> f64 {
        self.covariance().1
    }
    fn deviation(
        &self,
        factor: &Quadratic<f64>,
        fs: f64,
        scale: f64,
    ) -> Option<ModalDeviation<f64>> {
        let n = self.a().len() + self.c().len();
        deviation(self.a(), n, factor, fs, self.covariance().0, scale)
    }
    fn element(&self, row: usize, column: usize) -> f64 {
        let n = self.a().len() + self.c().len();
        self.covariance().0.element(n, row, column)
    }
}

impl Model for RecursiveChannels {
    fn width(&self) -> usize {
        self.channels()
    }
    fn take(&mut self, y: &[f64]) -> Status {
        match self.update(y).status {
            ChannelStatus::Starting => Status::Starting,
            ChannelStatus::Running => Status::Running,
            ChannelStatus::Limiting(limit) => Status::Limiting(limit),
            ChannelStatus::Rejected { .. } => Status::Rejected,
        }
    }
    fn finish_start(&mut self) {
        self.finish_start();
    }
    fn a(&self) -> &[f64] {
        self.a()
    }
    fn c(&self) -> &[f64] {
        self.c()
    }
    fn noise(&self, row: usize, column: usize) -> f64 {
        self.innovation_covariance(row, column)
    }
    fn is_ready(&self) -> bool {
        self.ready()
    }
    fn scale(&self) -> f64 {
        self.covariance_factor()
    }
    /// Its own deviation knows the scale, and what the channels have in common.
    fn deviation(&self, factor: &Quadratic<f64>, fs: f64, _: f64) -> Option<ModalDeviation<f64>> {
        self.deviation(factor, fs)
    }
    fn element(&self, row: usize, column: usize) -> f64 {
        let n = self.a().len() + self.c().len();
        self.covariance().element(n, row, column)
    }
    fn visit(&mut self, visitor: &mut impl StateVisitor<f64>) -> bool {
        self.visit_state(visitor)
    }
}

/// A model, its roots, and the column of each of them.
pub struct Followed<M, const P: usize> {
    pub model: M,
    roots: FactorTracker<f64, P>,
    /// The roots are not those of the model: they are being searched for.
    lost: bool,
    /// Factor that stands in each column: by frequency when they were found, and from then on
    /// the same.
    columns: [u32; P],
}

impl<M: Model, const P: usize> Followed<M, P> {
    pub fn new(model: M) -> Self {
        Self {
            model,
            roots: FactorTracker::new(),
            lost: true,
            columns: [0; P],
        }
    }

    fn factors(&self) -> &[Quadratic<f64>] {
        self.roots.factors(self.model.a().len())
    }

    /// Columns by frequency, pairs of real roots last.
    fn arrange(&mut self) {
        let frequency =
            |factor: &Quadratic<f64>| modal(factor, 1.0).map_or(f64::MAX, |m| m.frequency);
        let key: Vec<f64> = self.factors().iter().map(frequency).collect();
        let columns = &mut self.columns[..key.len()];
        for (k, column) in columns.iter_mut().enumerate() {
            *column = k as u32;
        }
        columns.sort_by(|a, b| key[*a as usize].total_cmp(&key[*b as usize]));
    }

    fn found(&mut self, tracking: Tracking) {
        let was_lost = self.lost;
        self.lost = tracking == Tracking::Searching;
        if was_lost && !self.lost {
            self.arrange();
        }
    }

    /// Follows the roots by so many sweeps at most: fewer where they have settled.
    fn follow(&mut self, sweeps: u32) {
        let mut settled = 0;
        for _ in 0..sweeps {
            let tracking = self.roots.track(self.model.a());
            self.found(tracking);
            settled = match tracking {
                Tracking::Converged => settled + 1,
                _ => 0,
            };
            // What the first of two leaves is squared by the second.
            if settled == 2 {
                break;
            }
        }
    }

    fn row(&self, fs: f64, rows: &mut Rows) {
        let factors = self.factors();
        if self.lost {
            for _ in factors {
                rows.push(f64::NAN, f64::NAN, f64::NAN, f64::NAN);
            }
            return;
        }
        let scale = self.model.scale();
        for column in &self.columns[..factors.len()] {
            let factor = factors.get(*column as usize);
            let mode = factor.and_then(|factor| {
                let sd = self.model.deviation(factor, fs, scale);
                let sd = sd.map_or((f64::NAN, f64::NAN), |sd| (sd.frequency, sd.damping));
                Some((modal(factor, fs)?, sd))
            });
            match mode {
                Some((mode, sd)) => rows.push(mode.frequency, mode.damping, sd.0, sd.1),
                None => rows.push(f64::NAN, f64::NAN, f64::NAN, f64::NAN),
            }
        }
    }
}

impl<M: Model, const P: usize> Estimator for Followed<M, P> {
    fn push(&mut self, x: &[f64], every: u32, due: &mut u32, fs: f64, rows: &mut Rows) {
        for y in x.chunks_exact(self.model.width()) {
            let status = self.model.take(y);
            if status == Status::Starting {
                self.roots.search();
                self.lost = true;
            }
            *due -= 1;
            let is_due = *due == 0;
            let has_model = !matches!(status, Status::Starting | Status::Rejected);
            if is_due && has_model {
                // From sample to sample one sweep follows them; a search is done at once.
                self.follow(if every == 1 && !self.lost { 1 } else { SWEEPS });
            }
            if is_due {
                *due = every;
                self.row(fs, rows);
            }
        }
    }

    fn finish_start(&mut self) {
        self.model.finish_start();
    }

    fn a(&self) -> &[f64] {
        self.model.a()
    }

    fn c(&self) -> &[f64] {
        self.model.c()
    }

    fn noise(&self, row: usize, column: usize) -> f64 {
        self.model.noise(row, column)
    }

    fn is_ready(&self) -> bool {
        self.model.is_ready()
    }

    fn deviation(&self, factor: &Quadratic<f64>, fs: f64) -> Option<ModalDeviation<f64>> {
        self.model.deviation(factor, fs, self.model.scale())
    }

    fn covariance(&self, row: usize, column: usize) -> f64 {
        self.model.scale() * self.model.element(row, column)
    }

    fn write(&mut self, out: &mut Writer) {
        self.model.visit(out);
        self.roots.visit_state(out);
        let mut lost = u32::from(self.lost);
        out.count(&mut lost);
        self.columns.iter_mut().for_each(|column| out.count(column));
    }

    fn read(&mut self, from: &mut Reader<'_>) -> bool {
        let sound = self.model.visit(from);
        self.roots.visit_state(from);
        let mut lost = 0;
        from.count(&mut lost);
        self.lost = lost != 0;
        self.columns
            .iter_mut()
            .for_each(|column| from.count(column));
        sound && self.columns.iter().all(|column| (*column as usize) < P)
    }
}
