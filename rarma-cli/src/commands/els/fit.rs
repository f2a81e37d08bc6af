//! `rarma els fit`: stiffness of joints and bearings from measurements.

use super::{limit, notices};
use crate::args::ElsFitArgs;
use crate::failure::Failure;
use rarma_plants::els::fit::{Compliance, Line, LoadStep, Unknown, compliances, fit_joints};
use rarma_recordings::input::{Plane, Role, merge, read_load_steps, read_receptances};
use rarma_scenarios::scenario::load_els;
use serde_json::json;
use std::path::Path;

/// Lines of a receptance that are used at most: neighbours say the same.
const LINES: usize = 200;

pub(super) fn main(args: &ElsFitArgs) -> Result<u8, Failure> {
    let scenario = load_els(&args.scenario)?;
    let unknowns: Vec<Unknown> = args
        .unknown
        .iter()
        .map(|name| unknown(name))
        .collect::<Result<_, _>>()?;
    if args.loads.is_none() && args.receptance.is_none() {
        return Err(Failure::Usage(
            "nothing to fit to: give --loads, --receptance, or both".to_owned(),
        ));
    }
    let statics = match &args.loads {
        Some(path) => steps(path)?,
        None => Vec::new(),
    };
    let lines = match &args.receptance {
        Some(path) => lines(path, args)?,
        None => Vec::new(),
    };
    let files: Vec<String> = [&args.loads, &args.receptance]
        .into_iter()
        .flatten()
        .map(|p| p.display().to_string())
        .collect();
    let fit = fit_joints(&scenario.config, &unknowns, &statics, &lines).map_err(|why| {
        let remedy = "measure more, or ask for fewer unknowns";
        Failure::whole(files.join(", "), words(&why), remedy)
    })?;
    if args.json {
        let found: Vec<_> = fit
            .found
            .iter()
            .map(|f| json!({ "name": f.unknown.to_string(), "value": f.value, "sd": f.sd, "unit": unit(f.unknown) }))
            .collect();
        say!(
            "{}",
            json!({ "scenario": scenario.name, "found": found, "misfit": fit.misfit, "rounds": fit.rounds,
                    "directions": statics.len(), "lines": lines.len() })
        );
        return Ok(0);
    }
    for f in &fit.found {
        let name = f.unknown.to_string();
        match f.unknown {
            Unknown::JointTilt(_) => say!(
                "{name:18} {:9.1} ± {:.1} N·m/mrad",
                1e-3 * f.value,
                1e-3 * f.sd
            ),
            _ => say!("{name:18} {:9.2} ± {:.2} N/µm", 1e-6 * f.value, 1e-6 * f.sd),
        }
    }
    say!(
        "misfit {:.2} standard deviations after {} rounds",
        fit.misfit,
        fit.rounds
    );
    Ok(0)
}

fn unit(unknown: Unknown) -> &'static str {
    match unknown {
        Unknown::JointTilt(_) => "N·m/rad",
        _ => "N/m",
    }
}

fn words(why: &rarma_plants::els::ElsModelError) -> String {
    use rarma_plants::els::ElsModelError::Singular;
    match why {
        Singular { free } => format!(
            "the measurements do not determine {free} of the unknowns (ask for fewer, or add receptances)"
        ),
        other => other.to_string(),
    }
}

fn unknown(name: &str) -> Result<Unknown, Failure> {
    let mut parts = name.trim().split('.');
    let (kind, place, what) = (parts.next(), parts.next(), parts.next());
    let place = place.and_then(|p| p.parse().ok());
    match (kind, place, what, parts.next()) {
        (Some("joint"), Some(k), None, None) => Ok(Unknown::Joint(k)),
        (Some("joint"), Some(k), Some("tilt"), None) => Ok(Unknown::JointTilt(k)),
        (Some("bearing"), Some(k), Some("major"), None) => Ok(Unknown::BearingMajor(k)),
        (Some("bearing"), Some(k), Some("minor"), None) => Ok(Unknown::BearingMinor(k)),
        _ => Err(Failure::Usage(format!(
            "--unknown: `{name}` is none of joint.N, joint.N.tilt, bearing.N.major, bearing.N.minor"
        ))),
    }
}

fn steps(path: &Path) -> Result<Vec<Compliance>, Failure> {
    let steps: Vec<LoadStep> = read_load_steps(path)?
        .iter()
        .map(|step| LoadStep {
            angle_rad: step.angle_rad,
            load_n: step.load_n,
            deflection_m: step.deflection_m,
        })
        .collect();
    compliances(&steps).map_err(|why| {
        Failure::whole(
            path.display(),
            why,
            "measure more loads, in more directions",
        )
    })
}

fn lines(path: &Path, args: &ElsFitArgs) -> Result<Vec<Line>, Failure> {
    let plane: Plane = limit::within(merge(&read_receptances(path)?)?, args.band);
    let has = |r: Role| plane.measured.contains(&r);
    if !(has(Role::Uu) && has(Role::Vv) && (has(Role::Uv) || has(Role::Vu))) {
        return Err(Failure::Input(format!(
            "{}: functions: uu, vv and a cross receptance are needed (measure them all)",
            path.display()
        )));
    }
    notices(&plane.notices);
    let largest = plane.g.iter().fold(0.0, |m: f64, g| {
        m.max(g.resp_u_exc_u.abs()).max(g.resp_v_exc_v.abs())
    });
    let thin = plane.f_hz.len().div_ceil(LINES).max(1);
    Ok(plane
        .f_hz
        .iter()
        .zip(&plane.g)
        .step_by(thin)
        .map(|(&f_hz, &g)| Line {
            f_hz,
            g,
            sd: args.receptance_sd * largest,
        })
        .collect())
}
