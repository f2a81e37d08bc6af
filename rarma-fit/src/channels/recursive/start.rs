//! The first samples: from nothing to a model next to the efficient one.
//!
//! Slow path: once, at the last sample of the start.
//!
//! As rarma-core's start, over all channels together: each channel's long autoregression by
//! Burg's method, whose errors ê_k stand for the innovations (Hannan and Rissanen); then rounds of
//! least squares of C_k0⁻¹(A·y_k − C_k·ê_k) over θ, weighted by Λ of ê, C_k0 being that of the
//! round before.

use super::noise::SMALLEST_VARIANCE;
use super::step::ChannelStatus;
use super::{RecursiveChannels, least_start};
use crate::burg;
use alloc::vec;
use alloc::vec::Vec;
use rarma_core::estimate::schur;

/// Least squares in sequence, as in rarma-core: a fifth moves nothing.
const ROUNDS: u32 = 4;
// Orders of the long autoregression, as there.
const SHORTEST: usize = 16;
const LONGEST: usize = 64;

impl RecursiveChannels {
    pub(super) fn collect(&mut self, y: &[f64]) -> ChannelStatus {
        self.scratch.errors.fill(0.0);
        self.stored.extend_from_slice(y);
        let length = self.stored.len() / self.channels.len();
        if length >= self.config.start_samples as usize {
            self.begin();
        }
        ChannelStatus::Starting
    }

    /// Does the start with the samples there are: for a signal that ends early. Fewer than
    /// 4·(p + q) + 8, or a silent channel, leave no model. Slow path.
    pub fn finish_start(&mut self) {
        let length = self.stored.len() / self.channels.len();
        if !self.ready && length >= least_start(self.p, self.q) as usize {
            self.begin();
        }
    }

    /// The start; where it cannot be done the samples are forgotten and others awaited.
    fn begin(&mut self) {
        let stored = core::mem::take(&mut self.stored);
        let length = stored.len() / self.channels.len();
        if self.work_through(&stored).is_some() {
            self.known = length as u32;
            self.ready = true;
        } else {
            self.reset();
        }
    }

    /// None where a channel is silent, or the numbers leave their range.
    fn work_through(&mut self, stored: &[f64]) -> Option<()> {
        let (channels, n) = (self.channels.len(), self.theta.len());
        let length = stored.len() / channels;
        let count = self.p + self.q;
        let wanted = (count + count / 2)
            .clamp(SHORTEST, LONGEST)
            .min(length.saturating_sub(2) / 4);
        let errors = innovations(stored, channels, wanted)?;
        let mut lambda = vec![0.0; channels * channels];
        for e in errors.chunks_exact(channels).skip(wanted) {
            for (i, x) in e.iter().enumerate() {
                for (j, y) in e.iter().enumerate() {
                    lambda[i * channels + j] += x * y / (length - wanted) as f64;
                }
            }
        }
        for (k, power) in self.noise.power.iter_mut().enumerate() {
            let square = |y: &[f64]| y[k] * y[k];
            *power = stored.chunks_exact(channels).map(square).sum::<f64>() / length as f64;
            if !(*power > SMALLEST_VARIANCE) {
                return None;
            }
        }
        self.noise.begin(lambda, length as u32);
        self.noise.factor(&self.config);
        for _ in 0..if self.q > 0 { ROUNDS } else { 1 } {
            let next = self.round(stored, &errors, wanted);
            if !next.iter().all(|x| x.is_finite()) || !self.covariance.is_definite(n) {
                return None;
            }
            self.theta = next;
            for c in self.theta[self.p..].chunks_exact_mut(self.q.max(1)) {
                schur::shrink::<f64, { super::MOST_ORDER }>(c, self.config.c_radius);
            }
        }
        self.clear_filters();
        for y in stored.chunks_exact(channels) {
            self.predict(y);
            self.decorrelate();
            self.score();
            self.moments.add(y, &self.noise.power, 1.0);
            self.filter(y);
        }
        self.scratch.errors.fill(0.0);
        Some(())
    }

    /// One round of least squares.
    fn round(&mut self, stored: &[f64], errors: &[f64], wanted: usize) -> Vec<f64> {
        let channels = self.channels.len();
        self.clear_filters();
        self.covariance.reset(self.config.start_variance);
        let mut next = self.theta.clone();
        let (mut wild, mut sides) = (vec![0.0; channels], vec![0.0; channels]);
        let samples = stored
            .chunks_exact(channels)
            .zip(errors.chunks_exact(channels));
        for (t, (y, e)) in samples.enumerate() {
            // The innovations apart tell how wild they are, the right sides what they teach.
            self.scratch.errors.copy_from_slice(e);
            self.decorrelate();
            for (k, wild) in wild.iter_mut().enumerate() {
                *wild = self.apart(k);
            }
            for (k, side) in sides.iter_mut().enumerate() {
                let c = self.place(k)..self.place(k) + self.q;
                // Minus the rows of this sample are their own right side.
                let mut channel = self.channels[k].clone();
                let (minus_y_f, e_f) = channel.filter(y[k], e[k], &self.theta[c]);
                self.channels[k] = channel;
                *side = -(minus_y_f + e_f);
            }
            if t < wanted + self.p.max(self.q) {
                continue;
            }
            for k in 0..channels {
                let mut u = sides[k];
                for (l, other) in self.noise.row(k).iter().zip(&sides[..k]) {
                    u -= l * other;
                }
                sides[k] = u;
                let u2 = wild[k] * wild[k];
                let r = self.noise.d(k).max(u2 / self.config.outlier_ratio);
                self.solve_row(k, u, r, &mut next);
            }
        }
        next
    }
}

/// What the long autoregression of each channel cannot predict, 0 before it has its order.
fn innovations(stored: &[f64], channels: usize, order: usize) -> Option<Vec<f64>> {
    let mut errors = vec![0.0; stored.len()];
    for k in 0..channels {
        let y: Vec<f64> = stored.iter().skip(k).step_by(channels).copied().collect();
        let fit = burg::<f64, LONGEST>(&y, order).ok()?;
        for t in order..y.len() {
            let past = fit.a().iter().zip(y[..t].iter().rev());
            errors[t * channels + k] = y[t] + past.map(|(a, y)| a * y).sum::<f64>();
        }
    }
    Some(errors)
}
