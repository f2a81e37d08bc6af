//! Readings of a ball bar: tables out, as `circle` reads them.

use super::{Conditions, RunData, Static};
use std::fmt::Write as _;

/// A table of one run, or of a static test.
pub fn circle_file(c: &Conditions, run: Option<&RunData>, readings: &[Static]) -> String {
    let set_pa = run.and_then(|r| r.set_pa);
    let mut out = format!(
        "# machine = {}\n# plane = {}\n# radius_mm = {}\n# feed_mm_min = {}\n# inclination_deg = {}\nangle_deg,dr_um,dir,way,run,p_bar,F_N{}\n",
        c.machine,
        c.plane,
        1e3 * c.radius_m,
        6e4 * c.feed_m_s,
        c.inclination_rad.to_degrees(),
        if set_pa.is_some() { ",set_bar" } else { "" }
    );
    let set_bar = set_pa.map_or(String::new(), |pa| format!(",{:.5}", 1e-5 * pa));
    let mut line = |angle: f64, dr: f64, dir: &str, rising: bool, run: u32, p: f64, f: f64| {
        let way = if rising { "up" } else { "down" };
        // A String takes everything.
        let _ = writeln!(
            out,
            "{:.4},{:.4},{dir},{way},{run},{:.4},{f:.2}{set_bar}",
            angle.to_degrees(),
            1e6 * dr,
            1e-5 * p
        );
    };
    if let Some(r) = run {
        for (k, (theta, dr)) in r.points.iter().enumerate() {
            line(
                *theta,
                *dr,
                r.sense.name(),
                r.rising,
                r.number,
                r.pressure_pa,
                r.forces_n.get(k).copied().unwrap_or(r.force_n),
            );
        }
    }
    for (k, s) in readings.iter().enumerate() {
        line(
            s.angle_rad,
            s.dr_m,
            "static",
            s.rising,
            k as u32,
            s.pressure_pa,
            s.force_n,
        );
    }
    out
}
