//! One sample of all channels.

use super::{MOST_PARAMETERS, RecursiveChannels};
use alloc::vec;
use alloc::vec::Vec;
use rarma_core::estimate::{Limit, schur};

/// Samples from here on are rejected, as in rarma-core's recursion.
pub(super) const LARGEST_SAMPLE: f64 = 1e15;
/// Growth of the covariance at an outlier, as there.
const OUTLIER_INFLATION: f64 = 1.03;

/// What the model is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelStatus {
    /// The first samples are collected: there is no model yet.
    Starting,
    /// Running freely.
    Running,
    /// Running, but something is held back.
    Limiting(Limit),
    /// The sample of a channel is not finite, 1e15 or more, or missing: nothing has changed.
    Rejected {
        /// Which, from 0; the first of them.
        channel: usize,
    },
}

/// Result of one update.
#[derive(Debug, Clone, Copy)]
pub struct ChannelStep<'a> {
    /// Innovations e_k, input units; 0 while the model starts and where a sample was rejected.
    pub innovations: &'a [f64],
    /// What the model is doing.
    pub status: ChannelStatus,
}

/// Room for the work of one sample.
#[derive(Debug, Clone)]
pub(super) struct Scratch {
    pub errors: Vec<f64>,
    apart: Vec<f64>,
    /// η of all channels, each of the length of the covariance's storage.
    gradients: Vec<[f64; MOST_PARAMETERS]>,
    moved: Vec<f64>,
    before: Vec<f64>,
    wild: Vec<bool>,
}

impl Scratch {
    pub fn new(n: usize, channels: usize) -> Self {
        Self {
            errors: vec![0.0; channels],
            apart: vec![0.0; channels],
            gradients: vec![[0.0; MOST_PARAMETERS]; channels],
            moved: vec![0.0; n],
            before: vec![0.0; n],
            wild: vec![false; channels],
        }
    }
}

impl RecursiveChannels {
    /// Takes one sample of every channel; see the type for the recurrence. Samples that hold one
    /// that is not finite, or 1e15 and more, or not as many as there are channels, are rejected
    /// as a whole and change nothing.
    pub fn update(&mut self, y: &[f64]) -> ChannelStep<'_> {
        let channels = self.channels.len();
        // False for NaN as well.
        let bad = y.iter().position(|y| !(y.abs() < LARGEST_SAMPLE));
        let uneven = (y.len() != channels).then_some(y.len().min(channels));
        let status = match bad.or(uneven) {
            Some(channel) => {
                self.scratch.errors.fill(0.0);
                ChannelStatus::Rejected { channel }
            }
            None => {
                self.count = self.count.saturating_add(1);
                if self.ready {
                    self.advance(y)
                } else {
                    self.collect(y)
                }
            }
        };
        ChannelStep {
            innovations: &self.scratch.errors,
            status,
        }
    }

    fn advance(&mut self, y: &[f64]) -> ChannelStatus {
        let n = self.theta.len();
        self.predict(y);
        if !self.scratch.errors.iter().all(|e| e.is_finite()) {
            // Only where the input spans the whole range of numbers.
            return self.begin_anew();
        }
        self.noise.hear(y, &self.config);
        self.moments
            .add(y, &self.noise.power, self.config.forgetting);
        self.noise.factor(&self.config);
        self.decorrelate();
        let outlier = self.measure();
        let full_step = self.correct();

        if self.turn >= n {
            self.turn = 0;
            if self.at_ceiling >= n {
                // Every factor has wound up: nothing is remembered.
                return self.begin_anew();
            }
            self.at_ceiling = 0;
        }
        let turn = self.turn;
        self.turn += 1;
        let (floor, ceiling) = (self.config.d_floor, self.config.d_ceiling);
        let at_ceiling = self.covariance.hold(turn, floor, ceiling);
        self.at_ceiling += usize::from(at_ceiling);
        if self.config.random_walk > 0.0 {
            self.covariance
                .spread(turn, self.config.random_walk * n as f64);
        }
        self.filter(y);
        self.noise.track(&mut self.scratch.apart, &self.config);
        for (k, wild) in self.scratch.wild.iter().enumerate() {
            self.noise.judge(k, self.scratch.errors[k], *wild);
        }
        self.scores.end_sample(self.config.forgetting);
        if !full_step {
            ChannelStatus::Limiting(Limit::NoiseModel)
        } else if outlier {
            ChannelStatus::Limiting(Limit::Outlier)
        } else if at_ceiling {
            ChannelStatus::Limiting(Limit::Covariance)
        } else {
            ChannelStatus::Running
        }
    }

    fn begin_anew(&mut self) -> ChannelStatus {
        self.reset();
        self.scratch.errors.fill(0.0);
        ChannelStatus::Starting
    }

    /// e of every channel.
    pub(super) fn predict(&mut self, y: &[f64]) {
        let (a, c) = self.theta.split_at(self.p);
        let q = self.q;
        for (k, (channel, y)) in self.channels.iter_mut().zip(y).enumerate() {
            self.scratch.errors[k] = channel.predict(*y, a, &c[k * q..(k + 1) * q]);
        }
    }

    /// Every channel's filters by 1/C.
    pub(super) fn filter(&mut self, y: &[f64]) {
        let (_, c) = self.theta.split_at(self.p);
        let q = self.q;
        for (k, (channel, y)) in self.channels.iter_mut().zip(y).enumerate() {
            channel.filter(*y, self.scratch.errors[k], &c[k * q..(k + 1) * q]);
        }
    }

    /// (u, η) = L⁻¹·(e, ψ).
    pub(super) fn decorrelate(&mut self) {
        let n = self.theta.len();
        for k in 0..self.channels.len() {
            let from = self.place(k);
            let (of_a, of_c) = self.channels[k].gradient(self.p);
            let (before, rest) = self.scratch.gradients.split_at_mut(k);
            let eta = &mut rest[0];
            eta[self.p..n].fill(0.0);
            eta[..self.p].copy_from_slice(of_a);
            eta[from..from + self.q].copy_from_slice(of_c);
            let mut u = self.scratch.errors[k];
            for ((l, other), other_u) in self
                .noise
                .row(k)
                .iter()
                .zip(before.iter())
                .zip(&self.scratch.apart)
            {
                u -= l * other_u;
                for (x, y) in eta[..n].iter_mut().zip(other) {
                    *x -= l * y;
                }
            }
            self.scratch.apart[k] = u;
        }
    }

    /// The scalar equations, one after the other: leaves what θ is to move, and the innovations
    /// apart, each shortened to what is left of it after the step. True where one was wild.
    fn measure(&mut self) -> bool {
        let n = self.theta.len();
        let config = &self.config;
        let mut any = false;
        self.scratch.moved.fill(0.0);
        for k in 0..self.channels.len() {
            let eta = &self.scratch.gradients[k];
            let mut u = self.scratch.apart[k];
            if k > 0 {
                for (x, moved) in eta[..n].iter().zip(&self.scratch.moved) {
                    u -= x * moved;
                }
            }
            let (u2, d) = (u * u, self.noise.d(k));
            let bound = config.outlier_ratio * d;
            let outlier = u2 > bound;
            any |= outlier;
            self.scratch.wild[k] = outlier;
            // A wild one counts with its own size, and takes some confidence back.
            let mut r = if outlier {
                u2 / config.outlier_ratio
            } else {
                d
            };
            let mut growth = 1.0;
            if k == 0 {
                r *= config.forgetting;
                growth = 1.0 / config.forgetting;
            }
            if outlier {
                growth *= OUTLIER_INFLATION;
            }
            let mut gain = [0.0; MOST_PARAMETERS];
            let inverse = self.covariance.measure(n, eta, r, growth, &mut gain);
            let step = u * inverse;
            for (moved, gain) in self.scratch.moved.iter_mut().zip(&gain) {
                *moved += gain * step;
            }
            let counted = if outlier { bound } else { u2 };
            let left = libm::copysign(libm::sqrt(counted * (r * inverse)), u);
            self.scratch.apart[k] = left;
            self.scores.add(&eta[..n], left / d);
        }
        any
    }

    /// θ ← θ + Δθ with every C inside the radius: the full step (true), else a quarter of it,
    /// else a C that would still leave it stays as it was.
    fn correct(&mut self) -> bool {
        self.scratch.before.copy_from_slice(&self.theta);
        self.take(1.0);
        let full = (0..self.channels.len()).all(|k| self.is_stable(k));
        if !full {
            self.theta.copy_from_slice(&self.scratch.before);
            self.take(0.25);
            for k in 0..self.channels.len() {
                if !self.is_stable(k) {
                    let c = self.place(k)..self.place(k) + self.q;
                    self.theta[c.clone()].copy_from_slice(&self.scratch.before[c]);
                }
            }
        }
        full
    }

    fn take(&mut self, part: f64) {
        for (theta, moved) in self.theta.iter_mut().zip(&self.scratch.moved) {
            *theta += moved * part;
        }
    }

    fn is_stable(&self, channel: usize) -> bool {
        let from = self.place(channel);
        let c = &self.theta[from..from + self.q];
        schur::inside::<f64, { super::MOST_ORDER }>(c, self.config.c_radius)
    }

    /// One equation of the start's least squares: row η of channel k with the right side `u`,
    /// noise variance `r`, on the estimate `next`.
    pub(super) fn solve_row(&mut self, k: usize, u: f64, r: f64, next: &mut [f64]) {
        let n = next.len();
        let eta = &self.scratch.gradients[k];
        let mut error = u;
        for (x, theta) in eta[..n].iter().zip(next.iter()) {
            error -= x * theta;
        }
        let mut gain = [0.0; MOST_PARAMETERS];
        error *= self.covariance.measure(n, eta, r, 1.0, &mut gain);
        for (theta, gain) in next.iter_mut().zip(&gain) {
            *theta += gain * error;
        }
    }

    /// The scores of a sample of the start, which weighs as much as any other.
    pub(super) fn score(&mut self) {
        let n = self.theta.len();
        for k in 0..self.channels.len() {
            let (u, d) = (self.scratch.apart[k], self.noise.d(k));
            let most = libm::sqrt(self.config.outlier_ratio * d);
            let eta = &self.scratch.gradients[k][..n];
            self.scores.add(eta, u.clamp(-most, most) / d);
        }
        self.scores.end_sample(1.0);
    }

    /// Innovation of channel k without what the channels before tell of it.
    pub(super) fn apart(&self, k: usize) -> f64 {
        self.scratch.apart[k]
    }
}
