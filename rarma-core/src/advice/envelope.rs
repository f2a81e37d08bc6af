//! Whether chatter of one mode grows while the speed swings: its envelope, played.
//!
//! Near its frequency a mode is a pole of first order (see the phase module), and the
//! envelope b of its vibration, q = Re(b·e^(jω_m·t)), follows
//!
//! ```text
//! b' = ω_m·(−ζ + j·h)·b(t) − j·ω_m·h·e^(−jω_m·τ(t))·b(t − τ(t))       h < 0 below the mode
//! ```
//!
//! with τ(t) the time between two teeth. On a grid of angles that is a whole number of steps,
//! whatever the speed does. The envelope is slow: some steps for each radian of ω_m·τ·h are
//! enough where the vibration itself would need sixty a wave. A step is the trapezoidal rule.
//!
//! Slow path, bounded: [`MOST_PASSES`] teeth a swing, [`SWINGS`] swings, at most [`CELLS`] steps
//! a tooth; no allocation.

use super::lobes::Side;
use crate::real::{Real, times};

/// Steps between two teeth at most, and at least. Where 2π·w·h wants more than the most, w and h
/// are so large that every wave turns many times: the phase is coarse there, the growth is not.
const CELLS: usize = 160;
const LEAST_CELLS: usize = 12;
/// Steps a radian of the envelope between two teeth: the trapezoidal rule is then off by a part
/// in 300 of its turning. Half of them: a part in 75.
const PER_RADIAN: f64 = 5.0;
/// Swings that are played; growth counts from the first one's end on.
const SWINGS: usize = 3;
/// Teeth a swing at most. A swing that is slower is slow beside the envelope anyhow, and is
/// played as if it were so quick. Half or double: growth alters by less than a tenth.
const MOST_PASSES: f64 = 300.0;
/// Teeth that are played at least after the first swing: quick swings are played longer.
const LEAST_PASSES: f64 = 24.0;

/// One mode in a cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cutting<T> {
    pub natural_hz: T,
    pub zeta: T,
    /// K·b/(2k_m) > 0.
    pub load: T,
    pub side: Side,
    /// Teeth a second at the mean speed.
    pub tooth_hz: T,
}

/// A swing of the speed: RVA, and swings for each tooth, RVF/N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Swing<T> {
    pub amplitude: T,
    pub per_tooth: T,
}

/// The envelope at one cell of angle, and when it was there, in waves.
#[derive(Clone, Copy)]
struct Left<T> {
    b: (T, T),
    waves: T,
}

/// Growth of the vibration, as a part of ω_m (−ζ without a cut; above 0: it grows).
pub(super) fn growth<T: Real>(cut: &Cutting<T>, swing: &Swing<T>) -> T {
    let two_pi = T::PI * T::from_f64(2.0);
    let half = T::from_f64(0.5);
    // All times in waves of the mode: ω_m·t = 2π·waves.
    let mean = cut.natural_hz / cut.tooth_hz;
    let turned = two_pi * mean * (cut.load + cut.zeta) * T::from_f64(PER_RADIAN);
    let wanted = turned.to_f64() as usize + 1;
    let cells = wanted.clamp(LEAST_CELLS, CELLS);
    let cell = mean / T::from_u32(cells as u32);
    let passes = (T::ONE / swing.per_tooth).min(T::from_f64(MOST_PASSES));
    // Waves of one swing.
    let period = passes * mean;
    let speed = |waves: T| {
        let (sin, _) = (waves / period * two_pi).sin_cos();
        T::ONE + swing.amplitude * sin
    };
    let load = cut.load * cut.side.sign();
    let mut past = [Left {
        b: (T::ONE, T::ZERO),
        waves: T::ZERO,
    }; CELLS];
    let Some(past) = past.get_mut(..cells) else {
        return T::ZERO;
    };
    // Whatever the first tooth meets matters no longer after a swing.
    for (i, left) in past.iter_mut().enumerate() {
        left.waves = cell * (T::from_u32(i as u32) - T::from_u32(cells as u32));
    }
    let per_swing = (passes * T::from_u32(cells as u32)).round().to_f64() as usize;
    let extra = (T::from_f64(LEAST_PASSES) / passes).to_f64() as usize;
    let mut now = T::ZERO;
    let mut b = (T::ONE, T::ZERO);
    let mut kept = T::ZERO;
    let mut began = T::ZERO;
    let mut place = 0;
    // What a tooth does at a time that meets what was left.
    let drive = |left: &Left<T>, at: T| {
        // −j·h·e^(−j·2π·(at − left)): the whole waves fall out.
        let between = at - left.waves;
        let angle = (between - between.round()) * two_pi;
        let (sin, cos) = angle.sin_cos();
        times((-load * sin, -load * cos), left.b)
    };
    let mut step = cell;
    let mut d0 = past
        .first()
        .map_or((T::ZERO, T::ZERO), |met| drive(met, now));
    for turn in 0..SWINGS + extra {
        for _ in 0..per_swing {
            // A cell of angle takes so many waves at the speed of its middle.
            step = cell / speed(now + half * step);
            let next = now + step;
            let after = if place + 1 < cells { place + 1 } else { 0 };
            let Some(met) = past.get(after) else {
                return T::ZERO;
            };
            let d1 = drive(met, next);
            // Half a step in radians.
            let h = half * step * two_pi;
            let own = (-cut.zeta * h, load * h);
            let ahead = times((T::ONE + own.0, own.1), b);
            let sum = (ahead.0 + h * (d0.0 + d1.0), ahead.1 + h * (d0.1 + d1.1));
            let (re, im) = (T::ONE - own.0, -own.1);
            let size = T::ONE / (re * re + im * im);
            if let Some(left) = past.get_mut(place) {
                *left = Left { b, waves: now };
            }
            b = times(sum, (re * size, -im * size));
            (now, place, d0) = (next, after, d1);
        }
        // The clock starts anew and the size is taken out, so that single precision does.
        let level = past
            .iter()
            .map(|left| left.b.0 * left.b.0 + left.b.1 * left.b.1)
            .sum::<T>();
        if !(level > T::ZERO && level.is_finite()) {
            return if level > T::ZERO { T::ONE } else { -cut.zeta };
        }
        let scale = T::ONE / level.sqrt();
        kept += half * level.ln();
        for left in past.iter_mut() {
            left.b = (left.b.0 * scale, left.b.1 * scale);
            left.waves -= period;
        }
        b = (b.0 * scale, b.1 * scale);
        d0 = (d0.0 * scale, d0.1 * scale);
        now -= period;
        if turn == 0 {
            began = kept;
        }
    }
    let swings = T::from_u32((SWINGS + extra - 1) as u32);
    (kept - began) / (swings * period * two_pi)
}
