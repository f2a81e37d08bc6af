//! The limiting width of cut in one direction.

use super::complex::Complex;
use super::error::ElsError;
use rarma_core::real::Real;

/// What the cut adds to the receptance. Taken at construction of [`LimitSearch`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutConfig<T> {
    /// Specific cutting stiffness Ks: force per chip area, N/m², > 0. Steel about 2e9.
    pub ks_n_per_m2: T,
    /// Teeth in the cut on average, > 0: teeth·(exit − entry angle)/2π in milling, 1 in
    /// turning. Default 1.
    pub teeth_in_cut: T,
    /// Overlap factor μ, 0 to 1: share of the wave of the pass before that is cut again.
    /// 1 in slots and plunging, 0 in threading, below 1 where the feed is about as large
    /// as the cut is wide. Default 1.
    pub overlap: T,
}

impl<T: Real> CutConfig<T> {
    /// One tooth that cuts the whole of the last wave again.
    pub fn orthogonal(ks_n_per_m2: T) -> Self {
        Self {
            ks_n_per_m2,
            teeth_in_cut: T::ONE,
            overlap: T::ONE,
        }
    }

    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn validate(&self) -> Result<(), ElsError> {
        let positive = |x: T| x.is_finite() && x > T::ZERO;
        let check = |ok, name| {
            if ok {
                Ok(())
            } else {
                Err(ElsError::OutOfRange { name })
            }
        };
        check(positive(self.ks_n_per_m2), "ks_n_per_m2")?;
        check(positive(self.teeth_in_cut), "teeth_in_cut")?;
        check(self.overlap >= T::ZERO && self.overlap <= T::ONE, "overlap")
    }

    /// What limits the width at one frequency: z = 1/(Ks·teeth·b), m/N, 0 where nothing
    /// does.
    ///
    /// ```text
    /// 1 + Ks·teeth·b·G·(1 − μ·e^{−jψ}) = 0 for some ψ   ⇔   |G + z| = μ·|G|
    /// z = −Re G + √(Re²G − (1 − μ²)·|G|²),   only for Re G < 0 and a real root
    /// ```
    ///
    /// At μ = 1 it is −2·Re G, the well-known b = −1/(2·Ks·Re G).
    pub fn severity(&self, oriented: Complex<T>) -> T {
        let re = oriented.re;
        if !(re < T::ZERO) {
            return T::ZERO;
        }
        let size = oriented.abs();
        let (c, lost) = (re / size, T::ONE - self.overlap * self.overlap);
        let under = c * c - lost;
        if under < T::ZERO {
            return T::ZERO;
        }
        size * (under.sqrt() - c)
    }

    /// Width of cut, m, that this severity allows.
    pub fn width_m(&self, severity: T) -> T {
        T::ONE / (self.ks_n_per_m2 * self.teeth_in_cut * severity)
    }
}

/// Limit of one direction, over all frequencies and spindle speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit<T> {
    /// Below this width no speed is unstable.
    Width {
        /// Least limiting width of cut, m.
        width_m: T,
        /// Frequency of the chatter there, Hz.
        chatter_hz: T,
    },
    /// Re G is nowhere below zero (or never enough, with an overlap below 1): no width
    /// loses stability by regeneration in this direction.
    Unlimited,
}

impl<T: Real> Limit<T> {
    /// The width, m; infinite where there is none.
    pub fn width_m(&self) -> T {
        match self {
            Self::Width { width_m, .. } => *width_m,
            Self::Unlimited => T::ONE / T::ZERO,
        }
    }
}

/// Line by line, the least limiting width of one direction:
///
/// ```text
/// b_lim = 1/(Ks·teeth·max_f z(f)),   at an overlap of 1: −1/(2·Ks·teeth·Re G_min)
/// ```
///
/// Between the lines around the maximum a parabola through three of them is taken; with
/// ten lines in the half-power width of a mode that is exact to 0.1 %.
#[derive(Debug, Clone, Copy)]
pub struct LimitSearch<T> {
    cut: CutConfig<T>,
    /// The last two lines: frequency and severity.
    before: [Option<(T, T)>; 2],
    /// Frequency and severity of the worst so far.
    worst: (T, T),
}

impl<T: Real> LimitSearch<T> {
    /// # Errors
    /// As [`CutConfig::validate`].
    pub fn new(cut: CutConfig<T>) -> Result<Self, ElsError> {
        cut.validate()?;
        Ok(Self {
            cut,
            before: [None; 2],
            worst: (T::ZERO, T::ZERO),
        })
    }

    /// The oriented receptance at `f` Hz; frequencies rise.
    pub fn line(&mut self, f: T, oriented: Complex<T>) {
        let now = (f, self.cut.severity(oriented));
        if now.1 > self.worst.1 {
            self.worst = now;
        }
        if let [Some(first), Some(middle)] = self.before
            && let Some(top) = summit(first, middle, now)
            && top.1 > self.worst.1
        {
            self.worst = top;
        }
        self.before = [self.before[1], Some(now)];
    }

    /// The limit over all lines so far.
    pub fn finish(&self) -> Limit<T> {
        let (chatter_hz, severity) = self.worst;
        if severity > T::ZERO {
            Limit::Width {
                width_m: self.cut.width_m(severity),
                chatter_hz,
            }
        } else {
            Limit::Unlimited
        }
    }
}

/// Top of the parabola through three lines whose middle one is the highest.
fn summit<T: Real>(a: (T, T), b: (T, T), c: (T, T)) -> Option<(T, T)> {
    // Where the severity starts at zero there is a kink and no parabola.
    let inside = a.1 > T::ZERO && c.1 > T::ZERO && b.1 >= a.1 && b.1 >= c.1;
    if !inside {
        return None;
    }
    let left = (b.1 - a.1) / (b.0 - a.0);
    let right = (c.1 - b.1) / (c.0 - b.0);
    let bend = (right - left) / (c.0 - a.0);
    if !(bend < T::ZERO) {
        return None;
    }
    let half = T::from_f64(0.5);
    // Newton form through a and b: y = y_a + left·(x − a) + bend·(x − a)(x − b).
    let x = half * (a.0 + b.0) - half * left / bend;
    let y = a.1 + left * (x - a.0) + bend * (x - a.0) * (x - b.0);
    (x > a.0 && x < c.0 && y.is_finite()).then_some((x, y))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(f: f64, zeta: f64, k: f64, at: f64) -> Complex<f64> {
        let r = at / f;
        Complex::new(1.0 - r * r, 2.0 * zeta * r).scale(k).inverse()
    }

    fn limit(cut: CutConfig<f64>, sign: f64) -> Limit<f64> {
        let mut search = LimitSearch::new(cut).expect("valid");
        for i in 0..1500 {
            let f = 500.0 + f64::from(i);
            search.line(f, mode(980.0, 0.02, 11.8e6, f).scale(sign));
        }
        search.finish()
    }

    #[test]
    fn one_mode_has_its_closed_form() {
        let Limit::Width {
            width_m,
            chatter_hz,
        } = limit(CutConfig::orthogonal(2e9), 1.0)
        else {
            panic!("a limit")
        };
        // 2kζ(1 + ζ)/Ks at f·√(1 + 2ζ).
        assert!((width_m / 0.240_72e-3 - 1.0).abs() < 1e-4, "{width_m}");
        assert!((chatter_hz - 980.0 * 1.04f64.sqrt()).abs() < 0.05);
    }

    #[test]
    fn teeth_and_overlap() {
        let full = limit(CutConfig::orthogonal(2e9), 1.0).width_m();
        let of = |teeth_in_cut, overlap| {
            let cut = CutConfig {
                teeth_in_cut,
                overlap,
                ..CutConfig::orthogonal(2e9)
            };
            limit(cut, 1.0)
        };
        assert!((of(2.5, 1.0).width_m() * 2.5 / full - 1.0).abs() < 1e-12);
        // Less of the wave, wider cut; nothing of it, no regeneration.
        assert!(of(1.0, 0.9).width_m() > 1.05 * full);
        assert_eq!(of(1.0, 0.0), Limit::Unlimited);
        // The characteristic equation itself, over all phases.
        let z = 1.0 / (2e9 * of(1.0, 0.7).width_m());
        let nearest = (0..3000)
            .flat_map(|i| (0..720).map(move |p| (i, p)))
            .map(|(i, p)| {
                let g = mode(980.0, 0.02, 11.8e6, 900.0 + 0.1 * f64::from(i));
                let (s, c) = (f64::from(p).to_radians() * 0.5).sin_cos();
                let loop_gain = g * Complex::new(1.0 - 0.7 * c, 0.7 * s);
                (loop_gain + Complex::new(z, 0.0)).abs() / z
            })
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 5e-3, "{nearest}");
    }

    #[test]
    fn a_force_that_pulls_the_tool_in_has_another_limit() {
        // −G of one mode is most negative below its resonance.
        let Limit::Width { chatter_hz, .. } = limit(CutConfig::orthogonal(2e9), -1.0) else {
            panic!("a limit")
        };
        assert!((chatter_hz - 980.0 * 0.96f64.sqrt()).abs() < 0.1);
        assert_eq!(limit(CutConfig::orthogonal(2e9), 0.0), Limit::Unlimited);
        assert!(Limit::<f32>::Unlimited.width_m() > 1e30);
    }

    #[test]
    fn settings_are_named() {
        let mut cut = CutConfig::orthogonal(2e9);
        cut.overlap = 1.1;
        let why = LimitSearch::new(cut).expect_err("too much");
        assert_eq!(why, ElsError::OutOfRange { name: "overlap" });
        let none = CutConfig::orthogonal(f64::NAN).validate();
        assert_eq!(
            none,
            Err(ElsError::OutOfRange {
                name: "ks_n_per_m2"
            })
        );
    }
}
