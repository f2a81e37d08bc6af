//! Records of the exciter in: `record.toml` and `signals.wav` of one folder.
//!
//! What is wrong is one line: file, place, reason.

use super::file;
use super::reader::{Allowed, Refusal, Section};
use crate::cers::record::CHANNELS;
use crate::cers::{CersRecord, Drive, Setup, Signal, Truth};
use crate::error::ScenarioError;
use rarma_recordings::input::InputError;
use rarma_rigs::cers::{Eddy, Magnet};
use serde_json::Value;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Reads a folder that `rarma cers run --out` wrote, or a rig.
///
/// # Errors
/// One line: file, place, what is wrong.
pub fn read_cers(dir: &Path) -> Result<CersRecord, ScenarioError> {
    let (notes, wav) = (dir.join("record.toml"), dir.join("signals.wav"));
    if !dir.is_dir() {
        return Err(ScenarioError::new(
            dir.display(),
            "open",
            "no such folder (name a folder that `rarma cers run --out` wrote)",
        ));
    }
    let text = file::text(&notes.display().to_string(), &[])?;
    signals(&wav, parse_record(&notes.display().to_string(), &text)?)
}

/// What must be known of a record, from the text of its `record.toml`; `file` is what messages
/// call it. [`Setup::text`] writes it.
///
/// # Errors
/// One line: file, line, field, what is allowed.
pub fn parse_record(file: &str, text: &str) -> Result<Setup, ScenarioError> {
    file::parse(file, text, &record_schema(), setup)
}

/// JSON schema of `record.toml`, from the same calls that read it.
pub fn record_schema() -> Value {
    let mut root = Section::description();
    // A description answers every question: there is nothing to refuse.
    let _ = setup(&mut root);
    root.schema()
}

fn signals(path: &Path, setup: Setup) -> Result<CersRecord, ScenarioError> {
    let refused = |place: &str, what: String, remedy: &str| {
        ScenarioError::new(path.display(), place, format_args!("{what} ({remedy})"))
    };
    const COPY: &str = "copy it again, or measure again";
    const FORM: &str = "give the signals that belong to record.toml";
    let file = File::open(path).map_err(|why| InputError::from_io(&why).in_file(path))?;
    let mut reader = hound::WavReader::new(BufReader::new(file))
        .map_err(|why| refused("header", why.to_string().to_lowercase(), COPY))?;
    let spec = reader.spec();
    if usize::from(spec.channels) != CHANNELS.len() {
        let (has, needs) = (spec.channels, CHANNELS.len());
        let what = format!("{has} channels, a record has {needs}");
        let remedy = format!("give {}", CHANNELS.join(", "));
        return Err(refused("header", what, &remedy));
    }
    if spec.sample_format != hound::SampleFormat::Float {
        let what = "integer samples".to_owned();
        return Err(refused("header", what, "write floats, in SI units"));
    }
    if (f64::from(spec.sample_rate) - setup.rate_hz).abs() > 0.5 {
        let (has, said) = (spec.sample_rate, setup.rate_hz);
        let what = format!("{has} Hz, but record.toml says {said} Hz");
        return Err(refused("header", what, FORM));
    }
    let mut lists: [Vec<f64>; 11] = Default::default();
    for (n, sample) in reader.samples::<f32>().enumerate() {
        let (frame, channel) = (n / CHANNELS.len(), n % CHANNELS.len());
        let place = || format!("frame {frame}, {}", CHANNELS[channel]);
        let x = sample.map_err(|why| refused(&place(), why.to_string().to_lowercase(), COPY))?;
        if !x.is_finite() {
            let what = format!("{x} is not a finite number");
            return Err(refused(
                &place(),
                what,
                "measure again, or cut the record there",
            ));
        }
        lists[channel].push(f64::from(x));
    }
    let n = lists[10].len();
    let block = crate::cers::BLOCK;
    if n < 2 * block {
        let what = format!("{n} frames, at least two blocks of {block} are needed");
        return Err(refused("data", what, "measure longer"));
    }
    for (k, list) in lists.iter().enumerate() {
        let rests = (k < 2 && !setup.drive.axes[k]) || k == 10;
        if !rests && list.iter().all(|x| *x == list[0]) {
            let (why, remedy) = match k {
                0 | 1 => (
                    "the command never changes: nothing was excited",
                    "excite this axis, or say in record.toml that it rests",
                ),
                6 | 7 => (
                    "the gap sensor gives one value: absent or dead, the force cannot be rebuilt",
                    "connect the sensor and measure again",
                ),
                _ => (
                    "one value throughout: a dead sensor",
                    "connect the sensor and measure again",
                ),
            };
            let place = format!("channel {}", k + 1);
            return Err(refused(&place, format!("{}: {why}", CHANNELS[k]), remedy));
        }
    }
    let [cx, cy, xp, xm, yp, ym, dx, dy, ax, ay, angle] = lists;
    let mut turns = 0.0;
    let revolutions: Vec<f64> = (0..n)
        .map(|k| {
            if k > 0 && angle[k] < angle[k - 1] - 0.5 {
                turns += 1.0;
            }
            turns + angle[k]
        })
        .collect();
    if let Some(k) = (1..n).find(|k| revolutions[*k] < revolutions[*k - 1] - 1e-4) {
        return Err(refused(
            &format!("frame {k}, {}", CHANNELS[10]),
            "the spindle turns backwards: the tacho misses pulses".to_owned(),
            "see to the tacho and measure again",
        ));
    }
    Ok(CersRecord {
        setup,
        command_a: [cx, cy],
        current_a: [xp, xm, yp, ym],
        displacement_m: [dx, dy],
        acceleration_m_per_s2: [ax, ay],
        revolutions,
    })
}

const POSITIVE: Allowed = Allowed::within(1e-12, 1e9);

fn setup(root: &mut Section<'_>) -> Result<Setup, Refusal> {
    let name = root.words("name", "Name of the structure")?;
    let rate_hz = root.number(
        "rate_hz",
        Allowed::within(1e3, 1e6),
        None,
        "Samples a second",
    )?;
    let bias_a = root.number("bias_a", Allowed::within(1e-6, 20.0), None, "Bias, A")?;
    let orders = root.numbers(
        "orders",
        Allowed::within(0.01, 100.0),
        "Orders of the spindle taken out of a turning record",
    )?;
    let tracks = root.numbers(
        "tracks_hz",
        Allowed::within(1.0, 1e5),
        "Bands of the tracks of a sweep, low and high by turns, Hz",
    )?;
    let drive = root.table("excitation", "The excitation", excitation)?;
    let gap = root.table("gap", "The gap", |s| {
        Ok((
            s.number("at_rest_m", POSITIVE, None, "Gap at rest, m")?,
            s.number(
                "pole_angle_rad",
                Allowed::within(0.0, 1.2),
                None,
                "Half the angle between the poles, rad",
            )?,
        ))
    })?;
    let magnets = root.tables("magnet", "Constants of a magnet", magnet)?;
    let lag = root.table("lag", "Lag of the flux", |s| {
        let mut n = |field, doc| s.number(field, Allowed::within(0.0, 1e9), None, doc);
        Ok([
            n("lamination_m", "Thickness of a lamination, m")?,
            n("conductivity_s_per_m", "Conductivity of the iron, S/m")?,
            n("permeability", "Relative permeability")?,
            n("iron_path_m", "Path in the iron, m")?,
        ])
    })?;
    let sensors = root.table("sensors", "The sensors", |s| {
        Ok((
            [
                s.number(
                    "displacement_corner_hz",
                    POSITIVE,
                    None,
                    "Corner of the displacement sensors, Hz",
                )?,
                s.number(
                    "acceleration_corner_hz",
                    POSITIVE,
                    None,
                    "Corner of the accelerometer, Hz",
                )?,
            ],
            s.number(
                "filter_rate_hz",
                Allowed::within(0.0, 1e9),
                Some(0.0),
                "Rate of their filters, Hz; 0: analogue",
            )?,
        ))
    })?;
    let truth = root.table("truth", "What a simulation knows", truth)?;
    if root.describes() {
        // Only the names matter.
        return Err(root.refuse("name", ""));
    }
    let missing = |field: &str, what: &str| root.refuse(field, format!("is missing ({what})"));
    let drive = drive.ok_or_else(|| missing("excitation", "what was commanded"))?;
    let (gap_m, pole_angle_rad) = gap.ok_or_else(|| missing("gap", "the force stands on it"))?;
    let (corner_hz, sensor_rate_hz) =
        sensors.ok_or_else(|| missing("sensors", "their phase is taken out"))?;
    let of = |side: &str| {
        magnets
            .iter()
            .find(|(s, _)| s == side)
            .map(|(_, m)| *m)
            .ok_or_else(|| {
                root.refuse(
                    "magnet",
                    format!("{side} has no calibration: its force would be a guess (allowed: one of each of +x, -x, +y, -y)"),
                )
            })
    };
    if tracks.chunks(2).any(|b| b.len() != 2 || b[1] <= b[0]) {
        return Err(root.refuse(
            "tracks_hz",
            "is no list of bands (allowed: low and high by turns, each band rising)",
        ));
    }
    Ok(Setup {
        name,
        rate_hz,
        bias_a,
        drive,
        orders,
        tracks_hz: tracks.chunks_exact(2).map(|b| (b[0], b[1])).collect(),
        magnets: [of("+x")?, of("-x")?, of("+y")?, of("-y")?],
        gap_m,
        pole_angle_rad,
        lag: lag.map(
            |[
                lamination_m,
                conductivity_s_per_m,
                permeability,
                iron_path_m,
            ]| Eddy {
                lamination_m,
                conductivity_s_per_m,
                permeability,
                iron_path_m,
                gap_m,
            },
        ),
        corner_hz,
        sensor_rate_hz,
        truth,
    })
}

fn excitation(s: &mut Section<'_>) -> Result<Drive, Refusal> {
    let signal = s.choice("signal", &["multisine", "noise", "prbs"], true, "Its kind")?;
    let axes = s.choice("axes", &["both", "x", "y"], true, "Directions driven")?;
    let any = Allowed::within(0.0, 1e6);
    Ok(Drive {
        signal: [Signal::Multisine, Signal::Noise, Signal::Prbs][signal],
        axes: [axes != 2, axes != 1],
        band_hz: (
            s.number("low_hz", any, None, "Lower edge, Hz")?,
            s.number("high_hz", any, None, "Upper edge, Hz")?,
        ),
        rms_a: s.number("rms_a", POSITIVE, None, "Current, A rms")?,
        dodge_hz: s.number(
            "dodge_hz",
            any,
            Some(0.0),
            "Speed whose multiples the lines dodge, revolutions/s; 0: none",
        )?,
    })
}

fn magnet(s: &mut Section<'_>) -> Result<(String, Magnet<f64>), Refusal> {
    let side = s.words("side", "+x, -x, +y or -y")?;
    if !s.describes() && !["+x", "-x", "+y", "-y"].contains(&side.as_str()) {
        return Err(s.refuse("side", format!("is \"{side}\" (allowed: +x, -x, +y, -y)")));
    }
    let magnet = Magnet {
        gain: s.number("gain_nm2_per_a2", POSITIVE, None, "K, N·m²/A²")?,
        gap_offset_m: s.number(
            "gap_offset_m",
            Allowed::within(-1e-3, 1e-3),
            None,
            "What iron and an error of the zero add to the gap, m",
        )?,
        saturation_a_per_m: s.number("saturation_a_per_m", POSITIVE, None, "Knee, A/m")?,
    };
    Ok((side, magnet))
}

fn truth(s: &mut Section<'_>) -> Result<Truth, Refusal> {
    let any = Allowed::within(-1e6, 1e6);
    let f = s.numbers("f_hz", any, "Frequencies at rest, Hz")?;
    let zeta = s.numbers("zeta", any, "Damping ratios at rest")?;
    let x = s.numbers("x", any, "Parts of the motion in x")?;
    let y = s.numbers("y", any, "Parts of the motion in y")?;
    if [&zeta, &x, &y].iter().any(|l| l.len() != f.len()) {
        return Err(s.refuse("f_hz", "and the other lists differ in length (allowed: one number a mode in each of f_hz, zeta, x, y)"));
    }
    Ok(Truth {
        modes: (0..f.len()).map(|k| [f[k], zeta[k], x[k], y[k]]).collect(),
        at_hz: s.number(
            "at_hz",
            POSITIVE,
            None,
            "Speed of the changes, revolutions/s",
        )?,
        frequency_part: s.number(
            "frequency_part",
            any,
            None,
            "Change of the frequencies there",
        )?,
        damping_part: s.number("damping_part", any, None, "Change of the damping there")?,
    })
}
