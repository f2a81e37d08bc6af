//! Functions of one argument, ours beside those of `libm` and `micromath`, and advice at an alarm: `cargo xtask count --functions`.

use super::Kernel;
use micromath::F32Ext;
use rarma_core::Real;
use rarma_core::advice::{AdviceConfig, HeardChatter, advise};
use rarma_core::decide::{StructuralMode, Structure};
use rarma_core::spectrum::{Quadratic, modal};

/// The sample's digits as a number from 1 to 2: an argument in the range of use.
fn argument(y: f32) -> f32 {
    f32::from_bits(y.to_bits() & 0x007F_FFFF | 0x3F80_0000)
}

macro_rules! functions {
    ($($kernel:ident, $name:literal, |$x:ident| $work:expr;)*) => {
        $(
            pub struct $kernel;

            impl Kernel for $kernel {
                const NAME: &'static str = $name;
                fn new() -> Self {
                    Self
                }
                fn step(&mut self, y: f32) -> f32 {
                    let $x = argument(y);
                    $work
                }
            }
        )*
    };
}

functions! {
    Argument, "argument", |x| x;
    SqrtOurs, "sqrt, ours", |x| Real::sqrt(x);
    SqrtLibm, "sqrt, libm", |x| libm::sqrtf(x);
    SqrtMicromath, "sqrt, micromath", |x| F32Ext::sqrt(x);
    LnOurs, "ln, ours", |x| Real::ln(x);
    LnLibm, "ln, libm", |x| libm::logf(x);
    LnMicromath, "ln, micromath", |x| F32Ext::ln(x);
    ExpOurs, "exp, ours", |x| Real::exp(x);
    ExpLibm, "exp, libm", |x| libm::expf(x);
    ExpMicromath, "exp, micromath", |x| F32Ext::exp(x);
    Atan2Ours, "atan2, ours", |x| Real::atan2(x - 0.9, 0.6);
    Atan2Libm, "atan2, libm", |x| libm::atan2f(x - 0.9, 0.6);
    Atan2Micromath, "atan2, micromath", |x| F32Ext::atan2(x - 0.9, 0.6);
    SinCosOurs, "sin and cos, ours", |x| sum(Real::sin_cos(x));
    SinCosLibm, "sin and cos, libm", |x| sum(libm::sincosf(x));
    SinCosMicromath, "sin and cos, micromath", |x| sum(F32Ext::sin_cos(x));
    ModeOurs, "f and zeta of a pole pair, ours", |x| ours(x);
    ModeLibm, "f and zeta of a pole pair, libm", |x| libms(x);
    ModeMicromath, "f and zeta of a pole pair, micromath", |x| micromaths(x);
}

/// [`advise`] at one sample of 2000: what an alarm would cost, spread over them.
macro_rules! advices {
    ($($kernel:ident, $name:literal, $modes:expr;)*) => {
        $(
            pub struct $kernel(Option<Structure<f32>>, u32);

            impl Kernel for $kernel {
                const NAME: &'static str = $name;
                fn new() -> Self {
                    Self(structure($modes), 0)
                }
                fn step(&mut self, y: f32) -> f32 {
                    self.1 += 1;
                    if self.1 % 2000 == 1 {
                        advice(argument(y), self.0.as_ref())
                    } else {
                        y
                    }
                }
            }
        )*
    };
}

advices! {
    AdviceAlone, "advice once in 2000, no structure", 0;
    AdviceByModes, "advice once in 2000, eight modes", 8;
}

fn structure(modes: u8) -> Option<Structure<f32>> {
    let mode = |k: u8| StructuralMode {
        f_hz: 500.0 + 200.0 * f32::from(k),
        f_sd: 2.0,
        zeta: 0.02,
        zeta_sd: 0.002,
    };
    let all = [0, 1, 2, 3, 4, 5, 6, 7].map(mode);
    Structure::new(all.get(..usize::from(modes))?).ok()
}

/// Two teeth at 9000 1/min, chatter at 1128 Hz or so.
fn advice(x: f32, structure: Option<&Structure<f32>>) -> f32 {
    let heard = HeardChatter {
        f_hz: 1127.0 + x,
        f_sd_hz: 3.0,
        spindle_hz: 150.0,
        spindle_sd_hz: 0.1,
        teeth: 2,
    };
    let said = advise(&AdviceConfig::reach(75.0, 225.0), &heard, structure, &[]);
    said.map_or(0.0, |advice| advice.best_chance)
}

fn sum((sin, cos): (f32, f32)) -> f32 {
    sin + cos
}

/// Poles (u, v) of radius 0.98 or so, at angles from 59 to 117 degrees.
fn pair(x: f32) -> (f32, f32) {
    (2.9 - 1.9 * x, 0.94 + 0.02 * x)
}

const FS_HZ: f32 = 6000.0;

fn ours(x: f32) -> f32 {
    let (u, v) = pair(x);
    modal(&Quadratic { u, v }, FS_HZ).map_or(0.0, |mode| mode.frequency + mode.damping)
}

/// The same as it is written in textbooks, by somebody's root, logarithm and arc tangent.
#[inline(always)]
fn textbook(
    x: f32,
    sqrt: impl Fn(f32) -> f32,
    ln: impl Fn(f32) -> f32,
    atan2: impl Fn(f32, f32) -> f32,
) -> f32 {
    let (u, v) = pair(x);
    let re = 0.5 * u;
    let square = v - re * re;
    if square <= 0.0 {
        return 0.0;
    }
    let (l, theta) = (0.5 * ln(v), atan2(sqrt(square), re));
    let r = sqrt(l * l + theta * theta);
    FS_HZ * r * (0.5 / core::f32::consts::PI) - l / r
}

fn libms(x: f32) -> f32 {
    textbook(x, libm::sqrtf, libm::logf, libm::atan2f)
}

fn micromaths(x: f32) -> f32 {
    textbook(x, F32Ext::sqrt, F32Ext::ln, F32Ext::atan2)
}
