//! Receptances from a table.
//!
//! ```text
//! freq_hz,uu_re_m_per_N,uu_im_m_per_N,vv_re_m_per_N,vv_im_m_per_N
//! ```
//!
//! A table with one function may leave out `uu_`. Units: `m`, `mm`, `um`, `nm`, `m_per_s`,
//! `m_per_s2`, each `_per_N` or `_per_kN`.

use super::super::table::{Dialect, hole, not_a_number};
use super::super::{InputError, Problem};
use super::{Function, Motion, Role};
use rarma_rigs::els::Complex;

/// A column name taken apart.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Column {
    role: Option<Role>,
    imaginary: bool,
    motion: Motion,
    scale: f64,
}

impl Column {
    fn of(name: &str) -> Option<Self> {
        let name = name.trim().replace('µ', "u");
        let (role, rest) = match name.split_once('_') {
            Some((role, rest)) if Role::of(role).is_some() => (Role::of(role), rest),
            _ => (None, name.as_str()),
        };
        let (part, unit) = rest.split_once('_')?;
        let imaginary = match part.to_ascii_lowercase().as_str() {
            "re" | "real" => false,
            "im" | "imag" => true,
            _ => return None,
        };
        let (motion, force) = unit.rsplit_once("_per_")?;
        let (motion, length) = match motion {
            "m" => (Motion::Displacement, 1.0),
            "mm" => (Motion::Displacement, 1e-3),
            "um" => (Motion::Displacement, 1e-6),
            "nm" => (Motion::Displacement, 1e-9),
            "m_per_s" => (Motion::Velocity, 1.0),
            "m_per_s2" => (Motion::Acceleration, 1.0),
            _ => return None,
        };
        let force = match force {
            "N" => 1.0,
            "kN" => 1e3,
            _ => return None,
        };
        Some(Self {
            role,
            imaginary,
            motion,
            scale: length / force,
        })
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Vec<Function>, InputError> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(i, l)| (i + 1, l.trim()))
        .filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
    let Some((head_line, head)) = lines.next() else {
        return Err(header(1, "there is no line with names"));
    };
    let dialect = Dialect::of(head);
    let names = dialect.fields(head);
    let columns = columns(head_line, &names)?;
    let mut functions: Vec<Function> = columns
        .iter()
        .step_by(2)
        .map(|c| Function {
            path: std::path::PathBuf::new(),
            place: c
                .role
                .map_or("table".to_owned(), |r| format!("function {}", r.name())),
            role: c.role,
            f_hz: Vec::new(),
            g: Vec::new(),
            notices: Vec::new(),
        })
        .collect();
    for (number, line) in lines {
        let fields = dialect.fields(line);
        let value = |k: usize| match fields.get(k) {
            None | Some(&"") => Err(hole(number, k + 1)),
            Some(field) => dialect
                .number(field)
                .ok_or_else(|| not_a_number(number, k + 1, field)),
        };
        let f = value(0)?;
        for (k, function) in functions.iter_mut().enumerate() {
            let c = columns[2 * k];
            let z = Complex::new(value(1 + 2 * k)?, value(2 + 2 * k)?).scale(c.scale);
            function.f_hz.push(f);
            function.g.push(c.motion.displacement(z, f));
        }
    }
    Ok(functions)
}

/// Real and imaginary columns by turns, in one unit each pair.
fn columns(line: usize, names: &[&str]) -> Result<Vec<Column>, InputError> {
    if !matches!(names.first(), Some(&("freq_hz" | "f_hz" | "frequency_hz"))) {
        return Err(header(line, "the first column is not freq_hz"));
    }
    if names.len() < 3 || names.len().is_multiple_of(2) {
        return Err(header(
            line,
            "the columns are no pairs of real and imaginary part",
        ));
    }
    let columns: Vec<Column> = names[1..]
        .iter()
        .map(|name| {
            Column::of(name).ok_or_else(|| {
                let shown: String = name.chars().take(40).collect();
                header(line, &format!("'{shown}' names no part and unit"))
            })
        })
        .collect::<Result<_, _>>()?;
    for (k, pair) in columns.chunks(2).enumerate() {
        let [re, im] = pair else { continue };
        let place = format!("line {line}, columns {} and {}", 2 + 2 * k, 3 + 2 * k);
        if re.role != im.role || re.imaginary || !im.imaginary {
            return Err(InputError::new(
                Problem::Header,
                place,
                "not the real and the imaginary part of one function",
                "put them side by side, the real part first",
            ));
        }
        if re.scale != im.scale || re.motion != im.motion {
            return Err(InputError::new(
                Problem::Units,
                place,
                format!(
                    "units disagree: {} and {}",
                    names[1 + 2 * k],
                    names[2 + 2 * k]
                ),
                "give both parts in one unit",
            ));
        }
    }
    let twice = columns
        .iter()
        .step_by(2)
        .enumerate()
        .find(|(k, c)| columns.iter().step_by(2).take(*k).any(|d| d.role == c.role));
    if let Some((_, c)) = twice {
        let name = c.role.map_or("one without directions", Role::name);
        return Err(header(line, &format!("two functions are called {name}")));
    }
    Ok(columns)
}

fn header(line: usize, what: &str) -> InputError {
    InputError::new(
        Problem::Header,
        format!("line {line}"),
        what,
        "name the columns freq_hz,uu_re_m_per_N,uu_im_m_per_N,…",
    )
}
