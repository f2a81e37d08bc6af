//! `rarma els hammer`: a blow to receptance, modes and limits.

use super::{name_of, notices, out, pictures, tell};
use crate::args::ElsHammerArgs;
use crate::failure::Failure;
use crate::output;
use rarma_pictures::table;
use rarma_recordings::input::{self, Plane, ReadOptions, Recording, Role, write_uff};
use rarma_rigs::els::{AgreedMode, Complex, Receptance, fit_modes, static_stiffness};
use rarma_scenarios::els::diagram::{Diagram, diagram};
use rarma_scenarios::els::hammer::{Blow, modes_in_frequency};
use serde::Serialize;
use std::path::Path;

/// A mode on which the orders agree.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Mode {
    /// Hz.
    f: f64,
    /// Half the range of the middle half of the orders, Hz.
    f_spread: f64,
    zeta: f64,
    zeta_spread: f64,
    /// Orders that found it.
    orders: u32,
}

impl From<&AgreedMode<f64>> for Mode {
    fn from(m: &AgreedMode<f64>) -> Self {
        Self {
            f: m.f_hz,
            f_spread: m.f_spread_hz,
            zeta: m.zeta,
            zeta_spread: m.zeta_spread,
            orders: m.fits,
        }
    }
}

/// The JSON of `els hammer`.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Answer<'a> {
    fs: f64,
    /// Lines of the receptance in the band.
    lines: usize,
    band_hz: (f64, f64),
    /// Rational functions through the receptance.
    modes_rational: Vec<Mode>,
    /// Least squares on the record itself.
    modes_arx: Vec<Mode>,
    /// Static stiffness in the measured direction, N/µm; null without --static.
    stiffness_n_per_um: Option<f64>,
    stiffness_sd_n_per_um: Option<f64>,
    limits: &'a Diagram,
}

pub(super) fn main(args: &ElsHammerArgs) -> Result<u8, Failure> {
    let force = channel(&args.force, args.force_channel)?;
    let response = channel(&args.response, args.response_channel)?;
    let file = args.force.display().to_string();
    let heading = format!("{}, {}", name_of(&args.force), name_of(&args.response));
    let refused =
        |why: String| Failure::whole(&file, why, "record the blow whole, or choose another band");
    if force.fs != response.fs || force.samples.len() != response.samples.len() {
        return Err(Failure::Input(format!(
            "{}: whole file: {} samples at {} Hz, but the force {file} has {} at {} Hz (cut both to one record)",
            args.response.display(),
            response.samples.len(),
            response.fs,
            force.samples.len(),
            force.fs
        )));
    }
    if args.band.1 > 0.45 * force.fs {
        return Err(Failure::Usage(format!(
            "--band: ends at {} Hz, the rate {} Hz allows {:.0}",
            args.band.1,
            force.fs,
            0.45 * force.fs
        )));
    }
    let blow = Blow {
        force: &force.samples,
        response: &response.samples,
        fs: force.fs,
        sensor: args.sensor.into(),
    };
    let (f, g) = blow.receptance(args.band).map_err(refused)?;
    let plane: Vec<Receptance<f64>> = g
        .iter()
        .map(|&g| Receptance {
            resp_v_exc_v: if args.round { g } else { Complex::ZERO },
            ..Receptance::along_u(g)
        })
        .collect();
    // What was measured is written before anything is made of it.
    if let Some(path) = &args.uff {
        let plane = Plane {
            f_hz: f.clone(),
            g: plane.clone(),
            measured: vec![Role::Uu],
            notices: Vec::new(),
        };
        output::write(path, write_uff(&plane, &heading))?;
    }
    let rational = modes_in_frequency(&f, &g).map_err(refused)?;
    let arx = blow.modes_in_time(args.band).map_err(refused)?;
    let stiffness = match args.static_band {
        None => None,
        Some(band) => {
            let (f, g) = blow.receptance(band).map_err(refused)?;
            let k = static_stiffness(&f, &g, band.0, band.1);
            Some(k.map_err(|why| refused(why.to_string()))?)
        }
    };
    let mut notes = vec![if args.round {
        "v is taken like u, without cross talk (--round)".to_owned()
    } else {
        "v is taken as rigid: the diagram shows what the measured direction contributes".to_owned()
    }];
    notes.extend(force.notices.iter().chain(&response.notices).cloned());
    notices(&notes);
    let limits = diagram(&f, &plane, &args.cut.cut(), false, None)
        .map_err(|why| refused(why.to_string()))?;
    let answer = Answer {
        fs: force.fs,
        lines: f.len(),
        band_hz: args.band,
        modes_rational: rational.iter().map(Mode::from).collect(),
        modes_arx: arx.iter().map(Mode::from).collect(),
        stiffness_n_per_um: stiffness.map(|k| 1e-6 * k.n_per_m),
        stiffness_sd_n_per_um: stiffness.map(|k| 1e-6 * k.sd_n_per_m),
        limits: &limits,
    };
    let body = page(&answer, &f, &g, args.out.report.is_some());
    if out(&args.out, "Hammer test", &heading, &body, &answer)? {
        words(&answer);
    }
    Ok(0)
}

fn channel(path: &Path, channel: usize) -> Result<Recording, Failure> {
    let options = ReadOptions {
        channel,
        ..ReadOptions::default()
    };
    Ok(input::read(path, &options)?)
}

fn page(answer: &Answer<'_>, f: &[f64], g: &[Complex<f64>], wanted: bool) -> String {
    if !wanted {
        return String::new();
    }
    let mut functions = vec![("measured".to_owned(), g.to_vec())];
    // The fit with as many modes as were agreed on, to be seen beside the measurement.
    let n = answer.modes_rational.len().clamp(1, 8);
    if let Ok(fit) = fit_modes::<f64, 36>(f, g, n) {
        let curve = f.iter().map(|f| fit.at(*f)).collect();
        functions.push((
            format!(
                "rational function of {n} modes, {:.1} % left",
                100.0 * fit.residual()
            ),
            curve,
        ));
    }
    let rows: Vec<Vec<String>> = [
        ("rational function", &answer.modes_rational),
        ("time series", &answer.modes_arx),
    ]
    .iter()
    .flat_map(|(name, modes)| {
        modes.iter().map(move |m| {
            vec![
                (*name).to_owned(),
                format!("{:.1} ± {:.1} Hz", m.f, m.f_spread),
                format!("{:.2} ± {:.2} %", 100.0 * m.zeta, 100.0 * m.zeta_spread),
                m.orders.to_string(),
            ]
        })
    })
    .collect();
    pictures::receptances(f, &functions)
        + "<h2>Modes on which the orders agree</h2>\n"
        + &table(&["method", "frequency", "damping ratio", "orders"], &rows)
        + &pictures::limits(answer.limits)
}

fn words(answer: &Answer<'_>) {
    for (name, modes) in [
        ("rational function", &answer.modes_rational),
        ("time series", &answer.modes_arx),
    ] {
        say!("{name}:");
        for m in modes {
            say!(
                "  {:8.1} ± {:5.1} Hz   damping {:6.2} ± {:.2} %   {} orders",
                m.f,
                m.f_spread,
                100.0 * m.zeta,
                100.0 * m.zeta_spread,
                m.orders
            );
        }
    }
    if let (Some(k), Some(sd)) = (answer.stiffness_n_per_um, answer.stiffness_sd_n_per_um) {
        say!("static stiffness {k:.2} ± {sd:.2} N/µm");
    }
    tell(answer.limits);
}
