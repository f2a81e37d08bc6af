//! Universal files out: dataset 164 once, then one dataset 58 a function.

use super::{Plane, Role};
use rarma_rigs::els::Complex;
use std::fmt::Write as _;

/// The measured functions of a plane as a universal file, double precision, SI.
///
/// An even grid is written as one; else every line carries its frequency (in single
/// precision: that is the format).
pub fn write_uff(plane: &Plane, title: &str) -> String {
    let mut out = String::new();
    // 1 is SI; the factors divide the file's numbers to give SI.
    let _ = writeln!(out, "    -1\n   164\n{:10}{:<20}{:10}", 1, "SI: m, N", 2);
    let _ = writeln!(
        out,
        "{}{}{}\n{}\n    -1",
        exponent(1.0, 17, 25),
        exponent(1.0, 17, 25),
        exponent(1.0, 17, 25),
        exponent(273.15, 17, 25)
    );
    for &role in &plane.measured {
        let line = |k: usize| -> Complex<f64> {
            let g = plane.g[k];
            match role {
                Role::Uu => g.resp_u_exc_u,
                Role::Uv => g.resp_u_exc_v,
                Role::Vu => g.resp_v_exc_u,
                Role::Vv => g.resp_v_exc_v,
            }
        };
        dataset(&mut out, title, role, &plane.f_hz, line);
    }
    out
}

fn dataset(
    out: &mut String,
    title: &str,
    role: Role,
    f: &[f64],
    g: impl Fn(usize) -> Complex<f64>,
) {
    let n = f.len();
    let step = (f[n - 1] - f[0]) / (n - 1) as f64;
    let even = f
        .iter()
        .enumerate()
        .all(|(k, x)| (x - f[0] - step * k as f64).abs() < 1e-6 * step);
    let (response, reference) = match role {
        Role::Uu => (1, 1),
        Role::Uv => (1, 2),
        Role::Vu => (2, 1),
        Role::Vv => (2, 2),
    };
    let title: String = title.chars().filter(char::is_ascii).take(79).collect();
    let _ = writeln!(
        out,
        "    -1\n    58\n{title}\nreceptance {}\nNONE\nNONE\nNONE",
        role.name()
    );
    let _ = writeln!(
        out,
        "{:5}{:10}{:5}{:10} {:<10}{:10}{response:4} {:<10}{:10}{reference:4}",
        4, 1, 1, 0, "TOOL", 1, "TOOL", 1
    );
    let (first, step) = if even { (f[0], step) } else { (0.0, 0.0) };
    let _ = writeln!(
        out,
        "{:10}{n:10}{:10}{}{}{}",
        6,
        u8::from(even),
        exponent(first, 5, 13),
        exponent(step, 5, 13),
        exponent(0.0, 5, 13)
    );
    for (kind, exponents, name, unit) in [
        (18, (0, 0), "Frequency", "Hz"),
        (8, (1, 0), "Displacement", "m"),
        (13, (0, 1), "Excitation force", "N"),
        (0, (0, 0), "NONE", "NONE"),
    ] {
        let (length, force) = exponents;
        let _ = writeln!(
            out,
            "{kind:10}{length:5}{force:5}{:5} {name:<20} {unit:<20}",
            0
        );
    }
    for k in 0..n {
        let z = g(k);
        if even {
            let _ = write!(out, "{}{}", exponent(z.re, 12, 20), exponent(z.im, 12, 20));
            if k % 2 == 1 || k + 1 == n {
                out.push('\n');
            }
        } else {
            let _ = writeln!(
                out,
                "{}{}{}",
                exponent(f[k], 5, 13),
                exponent(z.re, 12, 20),
                exponent(z.im, 12, 20)
            );
        }
    }
    out.push_str("    -1\n");
}

/// A number as Fortran's E format has it: two digits of exponent and its sign.
pub(crate) fn exponent(x: f64, digits: usize, width: usize) -> String {
    let text = format!("{x:.digits$E}");
    let (mantissa, power) = text.split_once('E').unwrap_or((&text, "0"));
    let power: i32 = power.parse().unwrap_or(0);
    format!("{:>width$}", format!("{mantissa}E{power:+03}"))
}
