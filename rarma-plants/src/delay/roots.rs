//! From Floquet multipliers to operational frequency and damping.

use super::{DelaySystem, RESPONSES, krylov};
use core::f64::consts::{PI, TAU};
use nalgebra::Complex;

/// How a cut loses its stability.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossing {
    /// A complex pair: quasi-periodic chatter.
    Hopf,
    /// μ = -1: the motion repeats every second period.
    Flip,
    /// μ = +1.
    Fold,
}

impl Crossing {
    /// What a multiplier on the unit circle means.
    pub(super) fn of(re: f64, im: f64) -> Self {
        let angle = im.abs().atan2(re);
        if angle > PI - 1e-3 {
            Self::Flip
        } else if angle < 1e-3 {
            Self::Fold
        } else {
            Self::Hopf
        }
    }

    /// One letter: H, F or P.
    #[must_use]
    pub fn letter(self) -> char {
        match self {
            Self::Hopf => 'H',
            Self::Flip => 'F',
            Self::Fold => 'P',
        }
    }
}

/// A root of the delay equation: what an ideal estimator would find in the cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// Undamped natural frequency |s|/2π of its strongest component, Hz.
    pub f_hz: f64,
    /// Damping ratio -Re s/|s|, 1; negative: the motion grows.
    pub zeta: f64,
    /// Growth rate Re s, 1/s.
    pub growth_per_s: f64,
    /// The Floquet multiplier (real, imaginary ≥ 0).
    pub multiplier: (f64, f64),
    /// Share of the motion's power in the strongest component, 0 to 1; the rest
    /// lies at that frequency plus or minus multiples of 1/T. Where the speed swings
    /// that is little: the frequency swings a little with it.
    pub purity: f64,
}

pub(super) fn of(system: &DelaySystem, wanted: usize) -> Vec<Root> {
    let found = krylov::dominant(system.dimension(), wanted, |x| system.advance(x, |_, _| {}));
    (0..found.values.len())
        .filter_map(|i| {
            let value = found.values[i];
            let (re, im) = found.vector(i)?;
            (value.norm() > 0.0).then(|| match &system.swinging {
                None => root(system, value, &re, &im),
                Some(swinging) => swinging_root(system, &swinging.times_s, value, &re),
            })
        })
        .collect()
}

/// The root where steps are not alike in length, its frequency from the spectrum of the
/// motion over time. A period is long there: its growth need not be known from the phase.
fn swinging_root(
    system: &DelaySystem,
    times_s: &[f64],
    value: Complex<f64>,
    vector: &[f64],
) -> Root {
    let growth = value.norm().ln() / system.period_s;
    let mut motion = Vec::with_capacity(times_s.len());
    system.advance(vector, |k, r| {
        let back = (-growth * times_s[k]).exp();
        motion.push(r.map(|x| x * back));
    });
    // Evenly in time: twice as many points as steps, and straight lines between.
    let n = (2 * motion.len()).next_power_of_two();
    let mut powers = vec![0.0; n / 2 + 1];
    let transform = rarma_fourier::forward(n);
    for axis in 0..RESPONSES {
        let mut even = transform.make_input_vec();
        let mut step = 0;
        for (i, x) in even.iter_mut().enumerate() {
            let t = system.period_s * i as f64 / n as f64;
            while step + 2 < times_s.len() && times_s[step + 1] <= t {
                step += 1;
            }
            let (t0, t1) = (times_s[step], times_s[step + 1]);
            let part = ((t - t0) / (t1 - t0)).min(1.0);
            let (a, b) = (motion[step][axis], motion[step + 1][axis]);
            let window = 0.5 * (1.0 - (TAU * i as f64 / n as f64).cos());
            *x = window * (a + part * (b - a));
        }
        let mut lines = transform.make_output_vec();
        if transform.process(&mut even, &mut lines).is_ok() {
            for (p, line) in powers.iter_mut().zip(&lines) {
                *p += line.norm_sqr();
            }
        }
    }
    let total: f64 = powers.iter().sum();
    let best = (0..powers.len())
        .max_by(|a, b| powers[*a].total_cmp(&powers[*b]))
        .unwrap_or(0);
    let near = powers[best.saturating_sub(1)..powers.len().min(best + 2)].iter();
    let w = TAU * best as f64 / system.period_s;
    let size = growth.hypot(w).max(f64::MIN_POSITIVE);
    Root {
        f_hz: size / TAU,
        zeta: -growth / size,
        growth_per_s: growth,
        multiplier: (value.re, value.im.abs()),
        purity: (near.sum::<f64>() / total.max(f64::MIN_POSITIVE)).min(1.0),
    }
}

fn root(system: &DelaySystem, value: Complex<f64>, re: &[f64], im: &[f64]) -> Root {
    let period = system.period_s;
    let growth = value.norm().ln() / period;
    let turn = value.im.atan2(value.re) / period;
    let n = system.steps();
    // The periodic part of the motion: r(t)·e^(-st).
    let mut motion = vec![[Complex::new(0.0, 0.0); RESPONSES]; n];
    let mut add = |part: &[f64], unit: Complex<f64>| {
        system.advance(part, |k, r| {
            for (m, x) in motion[k].iter_mut().zip(r) {
                *m += unit * x;
            }
        });
    };
    add(re, Complex::new(1.0, 0.0));
    add(im, Complex::new(0.0, 1.0));
    let dt = period / n as f64;
    for (k, m) in motion.iter_mut().enumerate() {
        let t = k as f64 * dt;
        let back = Complex::from_polar((-growth * t).exp(), -turn * t);
        for x in m {
            *x *= back;
        }
    }
    let highest = system.seen.iter().map(|s| s.mode.f_hz).fold(0.0, f64::max);
    let most = ((3.0 * highest * period).ceil() as i64 + 2).min(n as i64 / 2);
    let mut total = 0.0;
    let mut best = (0.0, 0);
    for h in -most..=most {
        let mut sum = [Complex::new(0.0, 0.0); RESPONSES];
        let step = Complex::from_polar(1.0, -TAU * h as f64 / n as f64);
        let mut wave = Complex::new(1.0, 0.0);
        for m in &motion {
            for (s, x) in sum.iter_mut().zip(m) {
                *s += x * wave;
            }
            wave *= step;
        }
        let power: f64 = sum.iter().map(Complex::norm_sqr).sum();
        total += power;
        if power > best.0 {
            best = (power, h);
        }
    }
    let w = turn + TAU * best.1 as f64 / period;
    // A real motion (flip) shows each of its tones at +w and at -w.
    let sides = if value.im == 0.0 && w != 0.0 {
        2.0
    } else {
        1.0
    };
    let size = growth.hypot(w);
    Root {
        f_hz: size / TAU,
        zeta: -growth / size,
        growth_per_s: growth,
        multiplier: (value.re, value.im),
        purity: (sides * best.0 / total).min(1.0),
    }
}
