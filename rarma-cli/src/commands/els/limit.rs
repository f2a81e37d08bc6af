//! `rarma els limit`: measured receptances to limits and static stiffness all round.

use super::{name_of, notices, out, pictures, tell};
use crate::args::ElsLimitArgs;
use crate::failure::Failure;
use crate::output;
use rarma_recordings::input::{Function, Plane, Role, merge, read_receptances, write_uff};
use rarma_rigs::els::{ElsError, static_stiffness};
use rarma_scenarios::els::diagram::{Diagram, diagram};
use serde::Serialize;
use std::path::Path;

/// The JSON of `els limit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Answer<'a> {
    /// Lines used.
    lines: usize,
    /// Lowest and highest, Hz.
    band_hz: (f64, f64),
    /// The functions there were: `uu`, `uv`, `vu`, `vv`.
    measured: Vec<&'static str>,
    #[serde(flatten)]
    limits: &'a Diagram,
}

pub(super) fn main(args: &ElsLimitArgs) -> Result<u8, Failure> {
    let mut functions = match &args.input {
        Some(path) => read_receptances(path)?,
        None => Vec::new(),
    };
    let own = [
        (Role::Uu, &args.uu),
        (Role::Uv, &args.uv),
        (Role::Vu, &args.vu),
        (Role::Vv, &args.vv),
    ];
    for (role, path) in own {
        if let Some(path) = path {
            functions.push(one(path, role)?);
        }
    }
    let plane = within(merge(&functions)?, args.band);
    let file = functions
        .first()
        .map_or(String::new(), |f| f.path.display().to_string());
    let heading = functions
        .first()
        .map_or(String::new(), |f| name_of(&f.path));
    if plane.f_hz.len() < 3 {
        return Err(Failure::Input(format!(
            "{file}: band: {} lines inside --band (widen it)",
            plane.f_hz.len()
        )));
    }
    if let Some((low, high)) = args.static_band {
        let uu: Vec<_> = plane.g.iter().map(|g| g.resp_u_exc_u).collect();
        if let Err(why @ ElsError::TooFewLines { .. }) =
            static_stiffness(&plane.f_hz, &uu, low, high)
        {
            let (first, last) = (plane.f_hz[0], plane.f_hz[plane.f_hz.len() - 1]);
            return Err(Failure::Input(format!(
                "{file}: --static {low}:{high}: {why} and the lines here are those from {first} to {last} Hz (name a \
                 band below the first mode, measure further down, or leave --static out)"
            )));
        }
    }
    notices(&plane.notices);
    let both = [Role::Uv, Role::Vu]
        .iter()
        .all(|r| plane.measured.contains(r));
    let limits = diagram(
        &plane.f_hz,
        &plane.g,
        &args.cut.cut(),
        both,
        args.static_band,
    )
    .map_err(|why| Failure::whole(&file, why, "measure again, or choose another --band"))?;
    if let Some(path) = &args.uff {
        output::write(path, write_uff(&plane, &heading))?;
    }
    let answer = Answer {
        lines: plane.f_hz.len(),
        band_hz: (plane.f_hz[0], plane.f_hz[plane.f_hz.len() - 1]),
        measured: plane.measured.iter().map(|r| r.name()).collect(),
        limits: &limits,
    };
    let body = pictures::receptances(&plane.f_hz, &drawn(&plane))
        + &pictures::limits(&limits)
        + &pictures::stiffness(&limits);
    if out(
        &args.out,
        "Limits from measured receptances",
        &heading,
        &body,
        &answer,
    )? {
        say!(
            "{} lines from {} to {} Hz: {}",
            answer.lines,
            answer.band_hz.0,
            answer.band_hz.1,
            answer.measured.join(", ")
        );
        tell(&limits);
    }
    Ok(0)
}

/// The one function of a file, under a name.
pub(super) fn one(path: &Path, role: Role) -> Result<Function, Failure> {
    let found = read_receptances(path)?;
    let count = found.len();
    let own = found.iter().position(|f| f.role == Some(role));
    let pick = own.or((count == 1).then_some(0));
    let function = pick.and_then(|k| found.into_iter().nth(k));
    let function = function.ok_or_else(|| {
        Failure::Input(format!(
            "{}: functions: {count} of them, none called {} (name it, or give one file each)",
            path.display(),
            role.name()
        ))
    })?;
    Ok(Function {
        role: Some(role),
        ..function
    })
}

/// The lines of a band.
pub(super) fn within(plane: Plane, band: Option<(f64, f64)>) -> Plane {
    let Some((low, high)) = band else {
        return plane;
    };
    let (f_hz, g) = plane
        .f_hz
        .iter()
        .zip(&plane.g)
        .filter(|(f, _)| (low..=high).contains(*f))
        .map(|(f, g)| (*f, *g))
        .unzip();
    Plane { f_hz, g, ..plane }
}

fn drawn(plane: &Plane) -> Vec<(String, Vec<rarma_rigs::els::Complex<f64>>)> {
    plane
        .measured
        .iter()
        .map(|role| {
            let g = plane.g.iter().map(|g| match role {
                Role::Uu => g.resp_u_exc_u,
                Role::Uv => g.resp_u_exc_v,
                Role::Vu => g.resp_v_exc_u,
                Role::Vv => g.resp_v_exc_v,
            });
            (role.name().to_owned(), g.collect())
        })
        .collect()
}
