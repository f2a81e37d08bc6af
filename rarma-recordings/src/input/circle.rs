//! Readings of a ball bar: tables in (out: `circle_write`).
//!
//! ```text
//! # machine = M3
//! # plane = XY
//! # radius_mm = 150
//! # feed_mm_min = 1000
//! # inclination_deg = 0
//! angle_deg,dr_um,dir,way,run,p_bar,F_N
//! 0.10,1.4,ccw,up,0,0.400,36.4
//! ```
//!
//! `dir`: `ccw`, `cw`, or `static` (standing); `way`: `up` or `down`, `up` where the column is
//! left out. F is the force in the plane, Δr the length change in it; the two columns
//! may come in other units (`dr_mm`, `dr_m`, `p_pa`, `F_kN`). Angles of a run rise (ccw) or fall
//! (cw) and may pass 360°. A column `set_bar` (`set_pa`), the pressure that was asked for, says
//! which runs were made at one step of the load; without it nearness of their forces does.

use super::table::{Dialect, MOST_SI, hole, not_a_number};
use super::{Conditions, RunData, Static};
use super::{InputError, Problem, whole};
use rarma_rigs::ldbb::Sense;
use std::path::Path;

/// Degrees between neighbours that are a gap.
const GAP_DEG: f64 = 5.0;

/// Highest number of a run.
const MOST_RUNS: f64 = 1e6;

/// What a file, or several, hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Circles {
    /// Under which conditions.
    pub conditions: Conditions,
    /// Circles.
    pub runs: Vec<RunData>,
    /// Readings of a static test.
    pub readings: Vec<Static>,
}

/// Reads tables that belong to one test.
///
/// # Errors
/// A file cannot be read, has other columns or units, a gap, angles out of order, or was
/// made under other conditions than the first.
pub fn read_circles(paths: &[impl AsRef<Path>]) -> Result<Circles, InputError> {
    let mut out: Option<Circles> = None;
    for path in paths {
        let path = path.as_ref();
        let bytes = whole::bytes(path, whole::MOST_TABLE)?;
        let text = String::from_utf8_lossy(&bytes);
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let mut one = parse(text).map_err(|e| e.in_file(path))?;
        match &mut out {
            None => out = Some(one),
            Some(all) => {
                same(&all.conditions, &one.conditions).map_err(|e| e.in_file(path))?;
                all.runs.append(&mut one.runs);
                all.readings.append(&mut one.readings);
            }
        }
    }
    let mut all = out
        .ok_or_else(|| InputError::new(Problem::NoSamples, "files", "there is none", "name one"))?;
    all.runs.sort_by_key(|r| r.number);
    if let Some(pair) = all.runs.windows(2).find(|p| p[0].number == p[1].number) {
        return Err(InputError::new(
            Problem::Header,
            format!("run {}", pair[0].number),
            "is there twice",
            "number the runs",
        )
        .in_file(paths.last().map_or(Path::new(""), AsRef::as_ref)));
    }
    Ok(all)
}

fn same(a: &Conditions, b: &Conditions) -> Result<(), InputError> {
    let near = |x: f64, y: f64| (x - y).abs() <= 1e-6 * x.abs().max(1.0);
    let other = [
        ("machine", a.machine == b.machine),
        ("plane", a.plane == b.plane),
        ("radius_mm", near(a.radius_m, b.radius_m)),
        ("feed_mm_min", near(a.feed_m_s, b.feed_m_s)),
        (
            "inclination_deg",
            near(a.inclination_rad, b.inclination_rad),
        ),
    ]
    .into_iter()
    .find(|(_, same)| !same);
    match other {
        None => Ok(()),
        Some((name, _)) => Err(InputError::new(
            Problem::Header,
            name,
            "differs from the first file's",
            "give the files of one test",
        )),
    }
}

/// Units of pressure in the names of columns, Pa.
const PRESSURE: [(&str, f64); 3] = [("bar", 1e5), ("Pa", 1.0), ("pa", 1.0)];

/// Columns, and how many SI units one of theirs is.
struct Columns {
    angle: usize,
    dr: (usize, f64),
    dir: usize,
    way: Option<usize>,
    run: usize,
    pressure: (usize, f64),
    set: Option<(usize, f64)>,
    force: (usize, f64),
}

fn columns(number: usize, names: &[&str]) -> Result<Columns, InputError> {
    let place = || format!("line {number}");
    let at = |name: &str| names.iter().position(|n| *n == name);
    let needed = |name: &str| {
        at(name).ok_or_else(|| {
            InputError::new(
                Problem::Header,
                place(),
                format!("there is no column {name}"),
                "name the columns angle_deg, dr_um, dir, run, p_bar, F_N",
            )
        })
    };
    let unit = |stem: &str, units: &[(&str, f64)]| {
        let column = names.iter().position(|n| {
            n.strip_prefix(stem)
                .is_some_and(|rest| rest.starts_with('_'))
        });
        let Some(column) = column else {
            return Err(InputError::new(
                Problem::Header,
                place(),
                format!("there is no column {stem}_{}", units[0].0),
                "name the columns angle_deg, dr_um, dir, run, p_bar, F_N",
            ));
        };
        let given = &names[column][stem.len() + 1..];
        let known = units.iter().find(|(u, _)| *u == given);
        known.map(|(_, factor)| (column, *factor)).ok_or_else(|| {
            let allowed: Vec<String> = units.iter().map(|(u, _)| format!("{stem}_{u}")).collect();
            InputError::new(
                Problem::Units,
                format!("line {number}, column {}", column + 1),
                format!("unknown unit in {}", names[column]),
                format!("use {}", allowed.join(", ")),
            )
        })
    };
    let (angle, to_deg) = unit("angle", &[("deg", 1.0)])?;
    debug_assert!(to_deg == 1.0);
    Ok(Columns {
        angle,
        dr: unit("dr", &[("um", 1e-6), ("mm", 1e-3), ("m", 1.0)])?,
        dir: needed("dir")?,
        way: at("way"),
        run: needed("run")?,
        pressure: unit("p", &PRESSURE)?,
        set: if names.iter().any(|n| n.starts_with("set_")) {
            Some(unit("set", &PRESSURE)?)
        } else {
            None
        },
        force: unit("F", &[("N", 1.0), ("kN", 1e3)])?,
    })
}

fn parse(text: &str) -> Result<Circles, InputError> {
    let mut conditions = Conditions {
        machine: "unnamed".to_owned(),
        plane: "XY".to_owned(),
        radius_m: 0.15,
        feed_m_s: 1.0 / 60.0,
        inclination_rad: 0.0,
    };
    let mut table: Option<(Dialect, Columns, usize)> = None;
    let mut out = Reader::default();
    let mut empty = None;
    for (i, line) in text.lines().enumerate() {
        let (number, line) = (i + 1, line.trim());
        if let Some(comment) = line.strip_prefix('#') {
            condition(number, comment, &mut conditions)?;
            continue;
        }
        if line.is_empty() {
            empty = empty.or(table.as_ref().map(|_| number));
            continue;
        }
        let Some((dialect, columns, count)) = &table else {
            let dialect = Dialect::of(line);
            let names = dialect.fields(line);
            table = Some((dialect, columns(number, &names)?, names.len()));
            continue;
        };
        if let Some(gap) = empty {
            return Err(InputError::new(
                Problem::Hole,
                format!("line {gap}"),
                "an empty line in the middle of the data",
                "fill in the readings or leave the run out",
            ));
        }
        let fields = dialect.fields(line);
        if fields.len() < *count {
            return Err(hole(number, fields.len() + 1));
        }
        out.line(number, &fields, *dialect, columns)?;
    }
    out.finish(conditions)
}

fn condition(number: usize, comment: &str, c: &mut Conditions) -> Result<(), InputError> {
    let Some((name, value)) = comment.split_once('=') else {
        return Ok(());
    };
    let (name, value) = (name.trim(), value.trim());
    let parsed = || {
        value
            .parse::<f64>()
            .ok()
            .filter(|x| x.is_finite())
            .ok_or_else(|| not_a_number(number, 1, value))
    };
    let wrong = |what: String, remedy: &str| {
        Err(InputError::new(
            Problem::Range,
            format!("line {number}"),
            what,
            remedy,
        ))
    };
    match name {
        "machine" => value.clone_into(&mut c.machine),
        "plane" if ["XY", "YZ", "ZX"].contains(&value) => value.clone_into(&mut c.plane),
        "plane" => return wrong(format!("plane {value}"), "use XY, YZ or ZX"),
        "radius_mm" => c.radius_m = 1e-3 * parsed()?,
        "feed_mm_min" => c.feed_m_s = parsed()? / 6e4,
        "inclination_deg" => c.inclination_rad = parsed()?.to_radians(),
        _ => {}
    }
    let there = |x: f64| x > 0.0 && x <= MOST_SI;
    if !(there(c.radius_m) && there(c.feed_m_s) && c.inclination_rad.abs() < 1.5) {
        return wrong(format!("{name} is {value}"), "give what the test had");
    }
    Ok(())
}

#[derive(Default)]
struct Reader {
    runs: Vec<(RunData, usize)>,
    readings: Vec<Static>,
}

impl Reader {
    fn line(
        &mut self,
        number: usize,
        fields: &[&str],
        dialect: Dialect,
        c: &Columns,
    ) -> Result<(), InputError> {
        let value = |(column, unit): (usize, f64)| {
            dialect.quantity((number, column), fields.get(column), unit)
        };
        let word = |column: usize, allowed: &[&str]| {
            let field = fields.get(column).copied().unwrap_or_default();
            allowed.iter().position(|w| *w == field).ok_or_else(|| {
                InputError::new(
                    Problem::Range,
                    format!("line {number}, column {}", column + 1),
                    format!("'{field}'"),
                    format!("use {}", allowed.join(", ")),
                )
            })
        };
        let angle_rad = value((c.angle, 1_f64.to_radians()))?;
        let dr_m = value(c.dr)?;
        let dir = word(c.dir, &["ccw", "cw", "static"])?;
        let rising = match c.way {
            Some(column) => word(column, &["up", "down"])? == 0,
            None => true,
        };
        let run = value((c.run, 1.0))?;
        if run.fract() != 0.0 || !(0.0..=MOST_RUNS).contains(&run) {
            return Err(InputError::new(
                Problem::Range,
                format!("line {number}, column {}", c.run + 1),
                format!("run is {run}"),
                "number the runs, whole numbers from 0 on",
            ));
        }
        let run = run as u32;
        let pressure_pa = value(c.pressure)?;
        let force_n = value(c.force)?;
        let set_pa = c.set.map(value).transpose()?;
        if dir == 2 {
            self.readings.push(Static {
                angle_rad,
                rising,
                pressure_pa,
                force_n,
                dr_m,
            });
            return Ok(());
        }
        let sense = [Sense::Ccw, Sense::Cw][dir];
        match self.runs.last_mut() {
            Some((last, n)) if last.number == run => {
                let changed = if last.sense != sense || last.rising != rising {
                    Some("direction")
                } else if last.set_pa != set_pa {
                    Some("set pressure")
                } else {
                    None
                };
                if let Some(what) = changed {
                    return Err(InputError::new(
                        Problem::Header,
                        format!("line {number}"),
                        format!("run {run} changes its {what}"),
                        format!("give every {what} a number of its own"),
                    ));
                }
                let before = last.points.last().map_or(angle_rad, |p| p.0);
                order(number, run, sense, before, angle_rad)?;
                *n += 1;
                last.force_n += (force_n - last.force_n) / *n as f64;
                last.pressure_pa += (pressure_pa - last.pressure_pa) / *n as f64;
                last.points.push((angle_rad, dr_m));
                last.forces_n.push(force_n);
            }
            _ => self.runs.push((
                RunData {
                    number: run,
                    sense,
                    rising,
                    set_pa,
                    pressure_pa,
                    force_n,
                    points: vec![(angle_rad, dr_m)],
                    forces_n: vec![force_n],
                },
                1,
            )),
        }
        Ok(())
    }

    fn finish(self, conditions: Conditions) -> Result<Circles, InputError> {
        if self.runs.is_empty() && self.readings.is_empty() {
            return Err(InputError::new(
                Problem::NoSamples,
                "data",
                "there is no line with numbers",
                "check that these are readings of a ball bar",
            ));
        }
        Ok(Circles {
            conditions,
            runs: self.runs.into_iter().map(|(r, _)| r).collect(),
            readings: self.readings,
        })
    }
}

fn order(line: usize, run: u32, sense: Sense, before: f64, now: f64) -> Result<(), InputError> {
    let step = sense.sign::<f64>() * (now - before).to_degrees();
    let name = sense.name();
    if step < 0.0 {
        return Err(InputError::new(
            Problem::Grid,
            format!("line {line}"),
            format!(
                "angles out of order: {:.2}° after {:.2}° in run {run}, which is {name}",
                now.to_degrees(),
                before.to_degrees()
            ),
            "keep the order of the readings, past 360° where the run does",
        ));
    }
    if step > GAP_DEG {
        return Err(InputError::new(
            Problem::Hole,
            format!("line {line}"),
            format!("a gap of {step:.1}° in run {run}"),
            "measure again, or cut the run there and give two",
        ));
    }
    Ok(())
}
