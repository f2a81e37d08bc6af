//! The findings in words.

use super::Answer;
use rarma_scenarios::cers::time::Read;

pub(super) fn tell(answer: &Answer) {
    for r in &answer.responses {
        say!(
            "{} over force {}, {:13} {:4} lines, {} blocks, coherence {:.3}, random error {:.2} %, H1 {:+.2} %, H2 {:+.2} %",
            r.motion,
            r.force,
            r.sensor,
            r.lines,
            r.blocks,
            r.coherence_median,
            100.0 * r.random_error_median,
            100.0 * r.h1_bias,
            100.0 * r.h2_bias
        );
    }
    if let Some(found) = &answer.modes {
        say!("principal direction {:.2}° from x", found.principal_deg);
        say!(
            "   rational functions                     ARX, force known        ARMA(30,29) alone       table 3 EMA     Para            truth"
        );
        let read = |r: &Option<Read>| {
            r.map_or(format!("{:23}", "-"), |r| {
                format!(
                    "{:7.1} Hz {:5.2} ± {:4.2} %",
                    r.f,
                    100.0 * r.zeta,
                    100.0 * r.zeta_sd
                )
            })
        };
        let pair = |p: Option<(f64, f64)>| {
            p.map_or(format!("{:15}", "-"), |(f, z)| {
                format!("{f:6.0} Hz {:4.1} %", 100.0 * z)
            })
        };
        for m in &found.modes {
            say!(
                "{} {:7.1} ± {:4.2} Hz {:6.3} ± {:5.3} %   {}   {}   {} {} {}",
                m.axis,
                m.f,
                m.f_sd,
                100.0 * m.zeta,
                100.0 * m.zeta_sd,
                read(&m.arx),
                read(&m.arma),
                pair(m.table_3.map(|t| t.ema)),
                pair(m.table_3.and_then(|t| t.para)),
                pair(m.truth)
            );
        }
    }
    if let Some(sweep) = &answer.sweep {
        for t in &sweep.tracks {
            say!(
                "{} {:.0} to {:.0} Hz, {}: {} points, {} of them crossings{}",
                t.axis,
                t.band_hz.0,
                t.band_hz.1,
                t.method,
                t.points.len(),
                t.points.iter().filter(|p| p.crossing.is_some()).count(),
                t.against_truth.as_ref().map_or(String::new(), |e| format!(
                    "; believed: f {:.2} % median {:.2} % of 95 in 100, damping {:.1} % and {:.1} %",
                    100.0 * e.f_median,
                    100.0 * e.f_95,
                    100.0 * e.zeta_median,
                    100.0 * e.zeta_95
                ))
            );
        }
    }
}
