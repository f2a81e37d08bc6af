//! Universal files: datasets 58 (function at a node), 58b (the same, binary) and 164
//! (units). Others are passed over.
//!
//! The layout is fixed by columns. What a number means follows from its record:
//! function type 4 is a frequency response, ordinate 8, 11 and 12 are displacement,
//! velocity and acceleration, 13 is force.

use super::super::{InputError, Problem};
use super::uff_numbers::{
    Cursor, cut_short, each_dataset, field, force_of, length_of, number, numbers_binary,
    numbers_text, whole,
};
use super::{Function, Motion, Role};
use rarma_rigs::els::Complex;

/// Units of a file, factors that divide its numbers to give SI (dataset 164).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Units {
    length: f64,
    force: f64,
}

pub(super) fn read(bytes: &[u8]) -> Result<Vec<Function>, InputError> {
    let (mut functions, mut units, mut skipped) = (Vec::new(), None, 0);
    let mut sets = 0;
    each_dataset(bytes, |cursor, line, kind| {
        sets += 1;
        match kind.split_whitespace().next() {
            Some("58" | "58b") => match function(cursor, sets, kind)? {
                Some(f) => functions.push((line, f)),
                None => skipped += 1,
            },
            Some("164") => units = Some(dataset_164(cursor)?),
            _ => {}
        }
        Ok(())
    })?;
    if functions.is_empty() {
        return Err(InputError::new(
            Problem::NoSamples,
            format!("{sets} datasets"),
            format!(
                "no frequency response (dataset 58, function type 4); {skipped} of other types"
            ),
            "export frequency response functions",
        ));
    }
    functions
        .into_iter()
        .map(|(line, f)| f.finish(line, units))
        .collect()
}

fn dataset_164(cursor: &mut Cursor<'_>) -> Result<Units, InputError> {
    let mut next = || cursor.line().ok_or_else(|| cut_short(0));
    next()?;
    let (line, text) = next()?;
    let factors: Vec<f64> = text
        .split_whitespace()
        .map(|t| number(line, t))
        .collect::<Result<_, _>>()?;
    match factors[..] {
        [length, force, ..] if length > 0.0 && force > 0.0 => Ok(Units { length, force }),
        _ => Err(InputError::new(
            Problem::Units,
            format!("line {line}"),
            "dataset 164 holds no positive factors of length and force",
            "correct the units dataset",
        )),
    }
}

/// A function as the file has it.
struct Raw {
    dataset: usize,
    role: Option<Role>,
    sign: f64,
    f_hz: Vec<f64>,
    z: Vec<Complex<f64>>,
    motion: Motion,
    length_label: String,
    force_label: String,
}

/// Dataset 58; none if it is another function than a frequency response.
fn function(
    cursor: &mut Cursor<'_>,
    dataset: usize,
    kind: &str,
) -> Result<Option<Raw>, InputError> {
    let binary = kind.split_whitespace().next() == Some("58b");
    let mut head: Vec<(usize, String)> = Vec::with_capacity(11);
    for _ in 0..11 {
        let (line, text) = cursor.line().ok_or_else(|| cut_short(cursor.line))?;
        if text.trim() == "-1" {
            return Err(cut_short(line));
        }
        head.push((line, text));
    }
    let (line6, r6) = &head[5];
    let (line7, r7) = &head[6];
    let data_type = whole(*line7, r7, (0, 10), 0)?;
    let count = usize::try_from(whole(*line7, r7, (10, 10), 1)?).unwrap_or(0);
    let even = whole(*line7, r7, (20, 10), 2)? == 1;
    let words: Vec<&str> = r7.split_whitespace().collect();
    let real = |k: usize| number(*line7, words.get(k).copied().unwrap_or(""));
    let (start, step) = (real(3)?, real(4)?);
    let bytes = if binary {
        let words: Vec<&str> = kind.split_whitespace().collect();
        // By record 7: a common writer announces half the bytes of complex numbers.
        let (real, double) = (data_type < 5, matches!(data_type, 4 | 6));
        let size = if double { 8 } else { 4 };
        let each = if real { size } else { 2 * size } + if even { 0 } else { 4 };
        let length = count.saturating_mul(each);
        let big = words.get(1) == Some(&"2");
        Some((
            cursor.raw(length).ok_or_else(|| cut_short(cursor.line))?,
            big,
        ))
    } else {
        None
    };
    if whole(*line6, r6, (0, 5), 0)? != 4 {
        return Ok(None);
    }
    if !matches!(data_type, 5 | 6) {
        return Err(InputError::new(
            Problem::Unsupported,
            format!("line {line7}"),
            format!("ordinate type {data_type}: a frequency response must be complex (5 or 6)"),
            "export real and imaginary part",
        ));
    }
    let values = match bytes {
        Some((bytes, big)) => numbers_binary(bytes, big, data_type == 6, even),
        None => numbers_text(cursor, data_type == 6, even, count)?,
    };
    let per_line = if even { 2 } else { 3 };
    if values.len() < count.saturating_mul(per_line) || count == 0 {
        return Err(InputError::new(
            Problem::Truncated,
            format!("dataset {dataset}"),
            format!("{} values, {count} lines were announced", values.len()),
            "export it again",
        ));
    }
    let (mut f_hz, mut z) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for (k, v) in values.chunks(per_line).take(count).enumerate() {
        f_hz.push(if even { start + step * k as f64 } else { v[0] });
        z.push(Complex::new(v[per_line - 2], v[per_line - 1]));
    }
    let (role, sign) = directions(r6);
    let motion = match whole(head[8].0, &head[8].1, (0, 10), 0)? {
        11 => Motion::Velocity,
        12 => Motion::Acceleration,
        8 | 0 => Motion::Displacement,
        other => {
            return Err(InputError::new(
                Problem::Units,
                format!("line {}", head[8].0),
                format!("the ordinate is of type {other}, no motion (8, 11 or 12)"),
                "export displacement, velocity or acceleration over force",
            ));
        }
    };
    Ok(Some(Raw {
        dataset,
        role,
        sign,
        f_hz,
        z,
        motion,
        length_label: label(&head[8].1),
        force_label: label(&head[9].1),
    }))
}

/// Units label of records 9 and 10: the last 20 characters.
fn label(text: &str) -> String {
    let fixed = field(text, 47, 20);
    if fixed.eq_ignore_ascii_case("none") {
        String::new()
    } else {
        fixed
    }
}

/// Response and reference direction of record 6.
fn directions(text: &str) -> (Option<Role>, f64) {
    let of = |from: usize| field(text, from, 4).parse::<i32>().unwrap_or(0);
    // 2(I5,I10),2(1X,10A1,I10,I4)
    let (response, reference) = (of(51), of(76));
    let role = match (response.abs(), reference.abs()) {
        (1, 1) => Some(Role::Uu),
        (1, 2) => Some(Role::Uv),
        (2, 1) => Some(Role::Vu),
        (2, 2) => Some(Role::Vv),
        _ => None,
    };
    (
        role,
        f64::from(response.signum() * reference.signum()).clamp(-1.0, 1.0),
    )
}

impl Raw {
    fn finish(self, line: usize, units: Option<Units>) -> Result<Function, InputError> {
        let place = format!("dataset {} in line {line}", self.dataset);
        let mut notices = Vec::new();
        let labels = (length_of(&self.length_label), force_of(&self.force_label));
        let units_disagree = |what: String| {
            InputError::new(
                Problem::Units,
                place.clone(),
                what,
                "correct the units dataset or the labels",
            )
        };
        for (label, known) in [
            (&self.length_label, labels.0),
            (&self.force_label, labels.1),
        ] {
            if !label.is_empty() && known.is_none() {
                return Err(units_disagree(format!(
                    "'{label}' is no unit that is known here"
                )));
            }
        }
        let by_label = labels.0.unwrap_or(1.0) / labels.1.unwrap_or(1.0);
        let scale = match units {
            Some(u) => {
                let by_dataset = u.force / u.length;
                let labelled = labels.0.is_some() && labels.1.is_some();
                if labelled && (by_label / by_dataset - 1.0).abs() > 1e-6 {
                    return Err(units_disagree(format!(
                        "units disagree: labels {} per {}, dataset 164 a length of 1/{} m and a force of 1/{} N",
                        self.length_label, self.force_label, u.length, u.force
                    )));
                }
                by_dataset
            }
            None => {
                if labels.0.is_none() || labels.1.is_none() {
                    notices.push(format!(
                        "{place}: neither labels nor dataset 164 say the units: taken as SI"
                    ));
                }
                by_label
            }
        };
        let g = self
            .f_hz
            .iter()
            .zip(&self.z)
            .map(|(&f, z)| {
                let sign = if self.sign == 0.0 { 1.0 } else { self.sign };
                self.motion.displacement(z.scale(sign * scale), f)
            })
            .collect();
        Ok(Function {
            path: std::path::PathBuf::new(),
            place,
            role: self.role,
            f_hz: self.f_hz,
            g,
            notices,
        })
    }
}
