//! Files for others: responses as a table and as a universal file, modes for the monitor.

use super::{Answer, sensor_name};
use crate::args::{KindArg, ReadingArgs};
use crate::failure::Failure;
use crate::output;
use rarma_recordings::input::{Plane, Role, write_uff};
use rarma_rigs::cers::Quantity;
use rarma_rigs::els::{Complex, Receptance};
use rarma_scenarios::cers::response::{Response, Sensor};
use serde_json::json;
use std::fmt::Write as _;

/// The core's word for a kind of response.
pub(super) fn quantity(kind: KindArg) -> Quantity {
    match kind {
        KindArg::Receptance => Quantity::Receptance,
        KindArg::Mobility => Quantity::Mobility,
        KindArg::Accelerance => Quantity::Accelerance,
    }
}

fn nothing(what: &str) -> Failure {
    Failure::Usage(format!(
        "{what}: a record of a changing speed has no responses (see its tracks in the JSON)"
    ))
}

/// The responses, as soon as they are there: whatever becomes of the modes.
pub(super) fn responses(
    args: &ReadingArgs,
    name: &str,
    responses: &[Response],
) -> Result<(), Failure> {
    if let Some(path) = &args.csv {
        if responses.is_empty() {
            return Err(nothing("--csv"));
        }
        output::write(path, table(args.quantity, responses))?;
    }
    if let Some(path) = &args.uff {
        if responses.is_empty() {
            return Err(nothing("--uff"));
        }
        output::write(path, universal(name, responses))?;
    }
    Ok(())
}

/// The modes of each axis.
pub(super) fn structure(args: &ReadingArgs, answer: &Answer) -> Result<(), Failure> {
    if let Some(dir) = &args.structure {
        let Some(found) = &answer.modes else {
            return Err(nothing("--structure"));
        };
        let mut files = Vec::new();
        for axis in ["x", "y"] {
            let modes: Vec<_> = found
                .modes
                .iter()
                .filter(|m| m.axis == axis)
                .map(|m| json!({"f": m.f, "f_sd": m.f_sd, "zeta": m.zeta, "zeta_sd": m.zeta_sd}))
                .collect();
            if modes.is_empty() {
                continue;
            }
            let text = json!({
                "method": "cers",
                "name": answer.name,
                "rpm": answer.rpm.0,
                "modes": modes,
            });
            let name = format!("structure-{axis}.json");
            files.push((name, format!("{text:#}").into_bytes()));
        }
        output::write_all(dir, files)?;
    }
    Ok(())
}

/// One row a line of a response; responses one below the other, as their lines differ.
fn table(kind: KindArg, responses: &[Response]) -> String {
    let unit = match kind {
        KindArg::Receptance => "m_per_N",
        KindArg::Mobility => "m_per_s_per_N",
        KindArg::Accelerance => "m_per_s2_per_N",
    };
    let mut out = format!(
        "force,motion,sensor,freq_hz,re_{unit},im_{unit},random_error,coherence,h1_over_iv,h2_over_iv,hv_over_iv\n"
    );
    for r in responses {
        for l in &r.lines {
            let h = Quantity::Receptance.to(quantity(kind), l.receptance, l.f_hz);
            let iv = l.raw.iv.abs();
            let _ = writeln!(
                out,
                "{},{},{},{},{:e},{:e},{:.5},{:.5},{:.5},{:.5},{:.5}",
                ["x", "y"][r.from],
                ["x", "y"][r.to],
                sensor_name(r.sensor),
                l.f_hz,
                h.re,
                h.im,
                l.raw.iv_random_error,
                l.raw.coherence,
                l.raw.h1.abs() / iv,
                l.raw.h2.abs() / iv,
                l.raw.hv.abs() / iv
            );
        }
    }
    out
}

/// Receptances by the displacement sensors; the forces of a direction have lines of their
/// own, so one run of datasets each.
fn universal(name: &str, responses: &[Response]) -> String {
    let mut out = String::new();
    for from in 0..2 {
        let of = |to: usize| {
            responses
                .iter()
                .find(|r| r.from == from && r.to == to && r.sensor == Sensor::Displacement)
        };
        let (Some(direct), Some(cross)) = (of(from), of(1 - from)) else {
            continue;
        };
        let zero = Complex::ZERO;
        let (mut f_hz, mut g) = (Vec::new(), Vec::new());
        for (d, c) in direct.lines.iter().zip(&cross.lines) {
            f_hz.push(d.f_hz);
            g.push(if from == 0 {
                Receptance {
                    resp_u_exc_u: d.receptance,
                    resp_v_exc_u: c.receptance,
                    resp_u_exc_v: zero,
                    resp_v_exc_v: zero,
                }
            } else {
                Receptance {
                    resp_v_exc_v: d.receptance,
                    resp_u_exc_v: c.receptance,
                    resp_u_exc_u: zero,
                    resp_v_exc_u: zero,
                }
            });
        }
        let plane = Plane {
            f_hz,
            g,
            measured: if from == 0 {
                vec![Role::Uu, Role::Vu]
            } else {
                vec![Role::Uv, Role::Vv]
            },
            notices: Vec::new(),
        };
        let text = write_uff(&plane, name);
        // The units are said once.
        let body = if out.is_empty() {
            text.as_str()
        } else {
            text.match_indices("    -1\n")
                .nth(1)
                .map_or("", |(at, _)| &text[at + 7..])
        };
        out += body;
    }
    out
}
