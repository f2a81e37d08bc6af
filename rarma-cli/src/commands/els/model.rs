//! `rarma els model`: the computational model.

use super::{out, pictures, tell};
use crate::args::ElsModelArgs;
use crate::failure::Failure;
use crate::output;
use rarma_plants::els::{Clamping, ElsModel, Place};
use rarma_recordings::input::{Plane, Role, write_uff};
use rarma_scenarios::els::diagram::{Cut, Diagram, diagram};
use rarma_scenarios::els::machine::{
    DeflectionCase, LoadCase, Picture, deflections, load_cases, shapes,
};
use rarma_scenarios::scenario::{SHIPPED_ELS, els_schema, load_els, parse_els};
use serde::Serialize;

/// Step of the receptance, Hz.
const STEP_HZ: f64 = 2.0;

/// The JSON of `els model`.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Answer {
    scenario: String,
    /// Natural frequencies under each load.
    loads: Vec<LoadCase>,
    /// Shapes without link, and with the tip grounded.
    free: Vec<Picture>,
    grounded: Vec<Picture>,
    /// Static deflection, µm.
    deflections: Vec<DeflectionCase>,
    /// Load of the link in the diagram of limits, N.
    limit_load_n: f64,
    /// Limits all round; null if the system has no place that moves.
    limits: Diagram,
}

pub(super) fn main(args: &ElsModelArgs) -> Result<u8, Failure> {
    if args.schema {
        say!("{:#}", els_schema());
        return Ok(0);
    }
    if args.list {
        for (name, text) in SHIPPED_ELS {
            say!("{name:16} {}", parse_els(name, text)?.about);
        }
        return Ok(0);
    }
    let file = args.scenario.as_deref().unwrap_or_default();
    let s = load_els(file)?;
    let refused =
        |why: &dyn std::fmt::Display| Failure::whole(file, why, "correct the fields it names");
    let model = ElsModel::new(&s.config).map_err(|e| refused(&e))?;
    let bearing = match &s.config.clamping {
        Clamping::Spindle { bearings, .. } => bearings.first().map(|b| b.0),
        _ => None,
    };
    let loads = load_cases(&model, &s.config.link, &s.loads_n, s.modes).map_err(|e| refused(&e))?;
    let (free, grounded) = shapes(&s.config, s.modes.min(6)).map_err(|e| refused(&e))?;
    let deflections =
        deflections(&model, s.middle_m, bearing, &s.deflection_loads_n).map_err(|e| refused(&e))?;
    let f: Vec<f64> = (0..=(s.top_hz / STEP_HZ) as usize)
        .map(|k| STEP_HZ * k as f64)
        .collect();
    let g = model
        .receptance(args.load, Place::Holder(0.0), &f)
        .map_err(|e| refused(&e))?;
    let cut = Cut {
        config: s.cut,
        chip_angle_rad: s.chip_angle_rad,
        symmetrise: false,
    };
    let first = loads[0].modes.iter().find(|m| m.shape == "bending");
    let static_band = first
        .map(|m| (0.0, 0.33 * m.f))
        .filter(|b| b.1 > 8.0 * STEP_HZ);
    let limits = diagram(&f, &g, &cut, true, static_band).map_err(|e| refused(&e))?;
    if let Some(path) = &args.uff {
        let plane = Plane {
            f_hz: f.clone(),
            g: g.clone(),
            measured: Role::ALL.to_vec(),
            notices: Vec::new(),
        };
        output::write(path, write_uff(&plane, &s.name))?;
    }
    let answer = Answer {
        scenario: s.name.clone(),
        loads,
        free,
        grounded,
        deflections,
        limit_load_n: args.load,
        limits,
    };
    let functions = [("uu", 0), ("vv", 1), ("uv", 2)].map(|(name, k)| {
        let pick = g
            .iter()
            .map(|g| [g.resp_u_exc_u, g.resp_v_exc_v, g.resp_u_exc_v][k]);
        (name.to_owned(), pick.collect())
    });
    let body = [
        pictures::frequencies(&answer.loads),
        pictures::shapes(
            "Natural modes, tip free",
            &answer.free[..answer.free.len().min(4)],
        ),
        pictures::shapes(
            "Natural modes, tip grounded",
            &answer.grounded[..answer.grounded.len().min(4)],
        ),
        pictures::deflections(&answer.deflections),
        pictures::receptances(&f, &functions),
        pictures::limits(&answer.limits),
        pictures::stiffness(&answer.limits),
    ]
    .concat();
    if out(&args.out, "Elastic linked system", &s.name, &body, &answer)? {
        words(&answer);
    }
    Ok(0)
}

fn words(answer: &Answer) {
    say!("{}", answer.scenario);
    for case in &answer.loads {
        let modes: Vec<String> = case
            .modes
            .iter()
            .map(|m| format!("{:.1}{}", m.f, if m.shape == "torsion" { "t" } else { "" }))
            .collect();
        say!(
            "{:6.0} N, link {:6.1} N/µm: {} Hz",
            case.load_n,
            case.link_n_per_um,
            modes.join(" ")
        );
    }
    let range = |x: &[f64]| {
        let low = x.iter().copied().fold(f64::INFINITY, f64::min);
        let high = x.iter().copied().fold(0.0, f64::max);
        if x.is_empty() {
            "-".to_owned()
        } else {
            format!("{low:.1} to {high:.1}")
        }
    };
    for case in &answer.deflections {
        say!(
            "{:6.0} N: tool joint {} µm, middle {} µm, bearing {} µm",
            case.load_n,
            range(&case.tool_joint_um),
            range(&case.middle_um),
            range(&case.bearing_um)
        );
    }
    tell(&answer.limits);
}
