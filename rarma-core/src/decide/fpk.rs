//! Forced or self-excited, by the distribution of the squared amplitude (the thesis'
//! criterion from the Fokker-Planck-Kolmogorov equation, eqs. 23 to 33).
//!
//! Rate: decision rate. **Confirmation and label, never the alarm**: it needs as many
//! independent amplitudes as it can get, and there are ζω of them a second: 64 take
//! 0.2 s at 980 Hz and 5 %, 0.5 s at 2 %, 2 s at 0.5 %, 10 s at 0.1 %. It slows down
//! just when stability is lost.
//!
//! Words: *V*, squared amplitude A² of a mode; *scintillation* S = Var V/E²V; *N*,
//! number of independent values of V that a stretch of time is worth.

use super::fpk_histogram::Histogram;
use super::fpk_verdict::{AmplitudeReading, verdict};
use crate::real::Real;
use crate::spectrum::envelope_corner;
use crate::visit::state;

/// Damping ratio below which a reading counts as this: a line without damping reads
/// 0.000, and by its word no time would be long enough.
pub const LEAST_DAMPING: f64 = 0.001;
/// Memory, s.
pub const MEMORY_S: f64 = 2.0;

/// The memory goes in blocks, so that it can be halved and forgets for good.
const BLOCKS: usize = 8;
/// Squared amplitudes are limited to this range; a mean at its lower end is silence.
const RANGE: (f64, f64) = (1e-24, 1e24);
/// A V above this multiple of its block's scale becomes the scale.
const MOST: f64 = 1e6;
/// One V in so many goes to the histogram.
const DECIMATION: u32 = 4;
/// What two low-pass stages of corner β add to the correlation time of V, and of the
/// part of V² that V does not explain, in 1/β: fitted for β = 3ζω to 30ζω, within 4 %.
const FILTER: (f64, f64) = (2.8, 4.8);

/// Sums over a stretch of time, of d = V/scale − 1.
#[derive(Debug, Clone, Copy, Default)]
struct Block<T> {
    scale: T,
    count: u32,
    d: T,
    d2: T,
    effective: T,
    effective2: T,
}

state! { Block<T> { scale, count, d, d2, effective, effective2 } }

impl<T: Real> Block<T> {
    /// The same sums of V/scale − 1 with another scale: V/new − 1 = (r − 1) + r·d, so
    /// that nothing large is subtracted where V hardly varies.
    fn rescaled(&self, scale: T) -> Self {
        let r = self.scale / scale;
        let (n, off) = (T::from_u32(self.count), r - T::ONE);
        Self {
            scale,
            d: n * off + r * self.d,
            d2: n * off * off + T::from_f64(2.0) * off * r * self.d + r * r * self.d2,
            ..*self
        }
    }
}

/// Judges one mode by the squared envelope of its band.
///
/// ```text
/// w(V) ∝ exp(−∫ h(√V)/(2√V·Ω·(D_ζ + D_n V)) dV)    (eq. 33, with the minus sign)
/// ```
///
/// h is the damping averaged over a period. Where h > 0 everywhere, w falls
/// everywhere: noise drives the mode. Where w rises, h < 0: the mode drives itself.
/// For a linear mode in noise w is exponential and S = 1; for a limit cycle in noise w
/// is a hump and S goes to 0. S decides: a test for a bin that rises over its neighbour
/// finds a fraction of what S finds; the histogram is there to be looked at.
///
/// Scatter: for a linear mode V is an Ornstein-Uhlenbeck square, whose Laguerre
/// polynomials decay at 2nζω. The mean of V goes with the first, S with the second:
///
/// ```text
/// E S = 1 − 2/N,  N  = Σ tanh(ζω·dt)  → T·ζω    (slow modes; at most one per V)
/// Var S = 4/N₂,   N₂ = Σ tanh(2ζω·dt) → 2T·ζω,  z = ln S·√N₂/2
/// ```
///
/// both less what the envelope's filter ([`crate::spectrum::Envelope`]) adds to the
/// correlation. ln S, not S, is nearly normal: z < −2.33 has 0.2 to 1.1 % from N = 2
/// to 256.
///
/// **Limits.** Lines at multiples of the rotation must have been removed: a forced
/// tone of amplitude a in noise σ² of the same band is Rician, w rises as soon as
/// a²/2 > σ² (S = 0.75), and it is called self-excited below S = 0.571
/// (a²/2 > 1.9σ²). ζ is taken at its word: read too high, slow noise looks like a limit
/// cycle; below [`LEAST_DAMPING`], it counts as that, so a linear mode with less looks
/// like a limit cycle, too. The envelope's filter takes the fast fluctuations of a limit
/// cycle, so S reads low there, never high.
///
/// ```
/// use rarma_core::decide::{Amplitude, Fpk};
/// let mut fpk = Fpk::<f32>::new(0.002);
/// for n in 0..1000 {
///     // An amplitude that hardly varies.
///     fpk.push(1.0 + 0.1 * (n as f32).sin(), 980.0, 0.005);
/// }
/// let reading = fpk.reading();
/// assert_eq!(reading.verdict, Amplitude::SelfExcited);
/// assert!((reading.scintillation - 0.005).abs() < 1e-4);
/// ```
#[derive(Debug, Clone)]
pub struct Fpk<T> {
    period_s: T,
    block_length: u32,
    blocks: [Block<T>; BLOCKS],
    /// Index of the block being filled, and closed blocks in the memory.
    open: usize,
    closed: usize,
    running: Histogram<T>,
    complete: Histogram<T>,
    blocks_until_complete: usize,
    pushes: u32,
}

state! { Fpk<T> {
    blocks, open, closed, running, complete, blocks_until_complete, pushes;
    settings period_s, block_length;
    where *open < BLOCKS
        && *closed < BLOCKS
        && (1..=BLOCKS).contains(blocks_until_complete)
        && blocks.iter().all(|block| block.count <= *block_length)
} }

impl<T: Real> Fpk<T> {
    /// For one V every `period_s` seconds (> 0), with a memory of [`MEMORY_S`].
    pub fn new(period_s: f64) -> Self {
        Self::with_memory(period_s, MEMORY_S)
    }

    /// With another memory, s: from 64 periods to 60 s, default [`MEMORY_S`]. It is
    /// forgotten in eighths, so that between 7/8 of it and all of it counts. Longer
    /// sees less damped modes, shorter sees the cut change.
    pub fn with_memory(period_s: f64, memory_s: f64) -> Self {
        let samples = (memory_s.min(60.0) / period_s).max(64.0);
        Self {
            period_s: T::from_f64(period_s),
            block_length: (samples / BLOCKS as f64) as u32,
            blocks: [Block::default(); BLOCKS],
            open: 0,
            closed: 0,
            running: Histogram::default(),
            complete: Histogram::default(),
            blocks_until_complete: BLOCKS,
            pushes: 0,
        }
    }

    /// Takes the squared amplitude V of the mode's band, squared input units, and the
    /// mode's frequency, Hz, and damping ratio as they read now. V from an
    /// [`crate::spectrum::Envelope`] steered by the same readings; its width is
    /// allowed for. A V that is negative or not finite is left out.
    pub fn push(&mut self, v: T, f_hz: T, zeta: T) {
        if !(v >= T::ZERO && v.is_finite()) {
            return;
        }
        let v = v.clamp(T::from_f64(RANGE.0), T::from_f64(RANGE.1));
        let (effective, effective2) = self.worth(f_hz, zeta);
        let mut full = false;
        if let Some(block) = self.blocks.get_mut(self.open) {
            // The first V is the scale: r in `rescaled` is then at most the number of V.
            if block.count == 0 {
                block.scale = v;
            }
            if v > block.scale * T::from_f64(MOST) {
                *block = block.rescaled(v);
            }
            let d = v / block.scale - T::ONE;
            block.count += 1;
            block.d += d;
            block.d2 += d * d;
            block.effective += effective;
            block.effective2 += effective2;
            full = block.count >= self.block_length;
        }
        if full {
            self.close();
        }
        self.pushes = self.pushes.wrapping_add(1);
        if self.pushes.is_multiple_of(DECIMATION) {
            self.running.count(v);
        }
    }

    /// Independent values that one V is worth: for its mean, and for S.
    fn worth(&self, f_hz: T, zeta: T) -> (T, T) {
        let heard = f_hz > T::from_f64(1e-3) && f_hz < T::from_f64(1e9);
        if !(heard && zeta.is_finite()) {
            return (T::ZERO, T::ZERO);
        }
        let zeta = zeta.clamp(T::from_f64(LEAST_DAMPING), T::ONE);
        let rate = T::from_f64(2.0) * T::PI * f_hz * zeta;
        let filter = rate / envelope_corner(f_hz, zeta);
        let part = |times: T, filtered: f64| {
            let x = times * rate * self.period_s / (T::ONE + T::from_f64(filtered) * filter);
            // tanh x
            let e = (-(x + x)).exp();
            (T::ONE - e) / (T::ONE + e)
        };
        (part(T::ONE, FILTER.0), part(T::from_f64(2.0), FILTER.1))
    }

    /// A block is full: the next one begins, in the place of the oldest.
    fn close(&mut self) {
        self.open = (self.open + 1) % BLOCKS;
        self.closed = (self.closed + 1).min(BLOCKS - 1);
        if let Some(next) = self.blocks.get_mut(self.open) {
            *next = Block::default();
        }
        self.blocks_until_complete -= 1;
        if !(self.running.bin_width > T::ZERO) || self.blocks_until_complete == 0 {
            if self.blocks_until_complete == 0 {
                self.complete = self.running;
            }
            self.running = Histogram::of_mean(self.sums(0..=self.closed).mean);
            self.blocks_until_complete = BLOCKS;
        }
    }

    /// Closed blocks, oldest first, then the open one.
    fn block(&self, age_order: usize) -> Block<T> {
        let at = (self.open + BLOCKS - self.closed + age_order) % BLOCKS;
        self.blocks.get(at).copied().unwrap_or_default()
    }

    fn sums(&self, which: core::ops::RangeInclusive<usize>) -> Sums<T> {
        let mut sums = Sums::default();
        for k in which.clone() {
            let block = self.block(k);
            let n = T::from_u32(block.count);
            sums.count += n;
            // Σ V here, the mean below.
            sums.mean += block.scale * (n + block.d);
            sums.effective += block.effective;
            sums.effective2 += block.effective2;
        }
        if !(sums.count > T::ZERO && sums.mean > T::ZERO) {
            return Sums::default();
        }
        sums.mean /= sums.count;
        for k in which {
            let block = self.block(k);
            if block.count > 0 {
                sums.scintillation += block.rescaled(sums.mean).d2;
            }
        }
        sums.scintillation = (sums.scintillation / sums.count).max(T::ZERO);
        sums
    }

    /// What is known now.
    pub fn reading(&self) -> AmplitudeReading<T> {
        let all = self.sums(0..=self.closed);
        let silence = T::from_f64(2.0 * RANGE.0);
        if self.closed == 0 || !(all.mean > silence) {
            return AmplitudeReading {
                scintillation: T::ONE,
                ..AmplitudeReading::default()
            };
        }
        let half = self.closed.div_ceil(2);
        let drift_z = drift(&self.sums(0..=half - 1), &self.sums(half..=self.closed));
        let s = all.scintillation;
        // A constant V has no logarithm.
        let least = T::EPSILON;
        let spread = T::from_f64(2.0) / all.effective2.max(T::EPSILON).sqrt();
        let z = s.max(least).ln() / spread;
        AmplitudeReading {
            scintillation: s,
            scintillation_sd: s * spread,
            effective: all.effective,
            mean: all.mean,
            verdict: verdict(s, all.effective, z, drift_z),
            z,
            drift_z,
        }
    }

    /// The histogram of the last memory that was complete; of the present one before
    /// that. For display.
    pub fn histogram(&self) -> Histogram<T> {
        if self.complete.bin_width > T::ZERO {
            self.complete
        } else {
            self.running
        }
    }

    /// Forgets everything: the mode has been replaced by another.
    pub fn reset(&mut self) {
        self.blocks = [Block::default(); BLOCKS];
        self.open = 0;
        self.closed = 0;
        self.running = Histogram::default();
        self.complete = Histogram::default();
        self.blocks_until_complete = BLOCKS;
        self.pushes = 0;
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums<T> {
    count: T,
    mean: T,
    scintillation: T,
    effective: T,
    effective2: T,
}

/// z of ln(mean₂/mean₁) between two stretches of a linear mode: a mean of N exponential
/// values has Var ln = 1/N + 1/(2N²), nearly.
fn drift<T: Real>(old: &Sums<T>, new: &Sums<T>) -> T {
    if !(old.mean > T::ZERO && new.mean > T::ZERO) {
        return T::ZERO;
    }
    let variance = |n: T| {
        let one = T::ONE / n.max(T::ONE);
        one + T::from_f64(0.5) * one * one
    };
    let sd = (variance(old.effective) + variance(new.effective)).sqrt();
    (new.mean.ln() - old.mean.ln()) / sd
}

#[cfg(test)]
#[path = "fpk_tests.rs"]
mod tests;
