//! What types cannot say of a record: numbers that are numbers, in their ranges, and few enough.

use super::{Body, MOST_NUMBER, Record, RecordError, SCHEMA};

/// Most modes of a verdict, and most speeds of an advice.
const MOST_SHORT: usize = 8;

/// Most directions, modes or errors of a test.
const MOST_LONG: usize = 720;

/// What is wrong: the field, and why.
type Wrong = (&'static str, &'static str);

impl Record {
    /// Is every number one, in its range?
    ///
    /// # Errors
    /// [`RecordError::Value`]: the field, and what is wrong with it.
    pub fn check(&self) -> Result<(), RecordError> {
        self.checked()
            .map_err(|(field, why)| RecordError::Value { field, why })
    }

    fn checked(&self) -> Result<(), Wrong> {
        if self.schema == 0 || self.schema > SCHEMA {
            return Err(("schema", "is not a version of this program"));
        }
        if self.id.session > MOST_NUMBER {
            return Err(("session", "is above 2^53 - 1"));
        }
        if self.id.seq > MOST_NUMBER {
            return Err(("seq", "is above 2^53 - 1"));
        }
        if let Some(clock) = &self.clock {
            finite("clock", &[clock.box_s, clock.drift_ppm.unwrap_or(0.0)])?;
            least_zero(
                "clock",
                &[
                    clock.drift_sd_ppm.unwrap_or(0.0),
                    clock.time_sd_s.unwrap_or(0.0),
                ],
            )?;
        }
        self.body.check()
    }
}

impl Body {
    fn check(&self) -> Result<(), Wrong> {
        match self {
            Self::Verdict(v) => {
                least_zero("seconds", &[v.seconds, v.level.unwrap_or(0.0)])?;
                least_zero("rpm", &[v.rpm.unwrap_or(0.0)])?;
                few("modes", v.modes.len(), MOST_SHORT)?;
                for m in &v.modes {
                    least_zero("modes", &[m.f_hz, m.f_sd_hz, m.zeta_sd, m.amplitude])?;
                    finite("modes", &[m.zeta])?;
                }
            }
            Self::AlarmCalled(a) => {
                least_zero("f_hz", &[a.f_hz, a.rpm.unwrap_or(0.0)])?;
                finite("zeta", &[a.zeta])?;
            }
            Self::AlarmReleased(a) => {
                number("called", a.called)?;
                least_zero("seconds", &[a.seconds, a.f_hz, a.rpm.unwrap_or(0.0)])?;
                finite(
                    "zeta_lowest",
                    &[a.zeta_lowest, a.zeta_median.unwrap_or(0.0)],
                )?;
            }
            Self::Advice(a) => {
                number("called", a.called.unwrap_or(0))?;
                least_zero("rpm", &[a.rpm, a.f_hz])?;
                few("speeds", a.speeds.len(), MOST_SHORT)?;
                few("helps", a.helps.len(), MOST_SHORT)?;
                for s in &a.speeds {
                    let told = [s.rpm_sd, s.chance, s.margin];
                    least_zero("speeds", &[s.rpm])?;
                    least_zero("speeds", &told.map(|x| x.unwrap_or(0.0)))?;
                }
            }
            Self::Outcome(o) => {
                number("advice", o.advice)?;
                least_zero("rpm", &[o.rpm.unwrap_or(0.0)])?;
            }
            Self::Stiffness(s) => {
                above_zero("radius_mm", &[s.radius_mm])?;
                finite("inclination_deg", &[s.inclination_deg])?;
                least_zero("scale_sd", &[s.scale_sd])?;
                few("directions", s.directions.len(), MOST_LONG)?;
                few("hysteresis", s.hysteresis.len(), MOST_LONG)?;
                few("errors", s.errors.len(), MOST_LONG)?;
                for d in &s.directions {
                    finite("angle_deg", &[d.angle_deg])?;
                    above_zero("n_per_um", &[d.n_per_um])?;
                    least_zero("sd_n_per_um", &[d.sd_n_per_um])?;
                }
                for h in &s.hysteresis {
                    finite("hysteresis", &[h.angle_deg, h.um])?;
                    least_zero("hysteresis", &[h.sd_um])?;
                }
                for e in &s.errors {
                    finite("errors", &[e.force_n, e.value])?;
                    least_zero("errors", &[e.sd])?;
                }
            }
            Self::Modes(m) => {
                least_zero("rpm", &[m.rpm])?;
                few("modes", m.modes.len(), MOST_LONG)?;
                for m in &m.modes {
                    above_zero("f_hz", &[m.f_hz, m.n_per_um.unwrap_or(1.0)])?;
                    finite("zeta", &[m.zeta])?;
                    least_zero("f_sd_hz", &[m.f_sd_hz, m.zeta_sd])?;
                }
            }
            Self::Limits(l) => {
                above_zero("ks_n_per_mm2", &[l.ks_n_per_mm2])?;
                few("directions", l.directions.len(), MOST_LONG)?;
                for d in &l.directions {
                    finite("angle_deg", &[d.angle_deg])?;
                    least_zero(
                        "width_mm",
                        &[d.width_mm, d.sd_mm, d.chatter_hz.unwrap_or(0.0)],
                    )?;
                }
            }
            Self::OdrStatistics(o) => {
                least_zero("rpm", &[o.rpm, o.f_hz, o.seconds])?;
                finite("zeta_mean", &[o.zeta_mean])?;
                finite("zeta_tenths", &o.zeta_tenths)?;
                least_zero("zeta_mean_sd", &[o.zeta_mean_sd])?;
                number("count", o.count)?;
            }
        }
        Ok(())
    }
}

fn finite(field: &'static str, values: &[f64]) -> Result<(), Wrong> {
    holds(field, "is not a finite number", values, |x| x.is_finite())
}

fn least_zero(field: &'static str, values: &[f64]) -> Result<(), Wrong> {
    holds(field, "is negative, or not a finite number", values, |x| {
        x.is_finite() && x >= 0.0
    })
}

fn above_zero(field: &'static str, values: &[f64]) -> Result<(), Wrong> {
    holds(field, "is not a finite number above 0", values, |x| {
        x.is_finite() && x > 0.0
    })
}

fn holds(
    field: &'static str,
    why: &'static str,
    values: &[f64],
    rule: impl Fn(f64) -> bool,
) -> Result<(), Wrong> {
    if values.iter().all(|&x| rule(x)) {
        Ok(())
    } else {
        Err((field, why))
    }
}

fn few(field: &'static str, count: usize, most: usize) -> Result<(), Wrong> {
    if count <= most {
        Ok(())
    } else {
        Err((field, "has too many entries"))
    }
}

fn number(field: &'static str, value: u64) -> Result<(), Wrong> {
    if value <= MOST_NUMBER {
        Ok(())
    } else {
        Err((field, "is above 2^53 - 1"))
    }
}
