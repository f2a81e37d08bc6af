//! Stand-ins for a reader's own files, made by the program itself where it can.

pub mod roles;

use crate::{Failure, Result, process};
use roles::Input;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The recording's scenario.
const RECORDING: &str = include_str!("recording.toml");
/// A shipped one.
const MACHINE: &str = include_str!("../../../rarma-scenarios/scenarios/three-mode-chatter.toml");

/// A structure hit by a hammer: frequency Hz, damping ratio, stiffness N/µm.
const STRUCK: [(f64, f64, f64); 2] = [(1070.0, 0.034, 12.0), (1960.0, 0.025, 30.0)];
const STRUCK_HZ: f64 = 51_200.0;
const STRUCK_S: f64 = 0.5;

/// Makes inputs once and keeps them.
#[derive(Debug)]
pub struct Maker {
    rarma: PathBuf,
    folder: PathBuf,
    made: BTreeMap<Input, PathBuf>,
}

impl Maker {
    /// Makes in `folder`, with this program.
    pub fn new(rarma: &Path, folder: &Path) -> Self {
        Self {
            rarma: rarma.to_path_buf(),
            folder: folder.to_path_buf(),
            made: BTreeMap::new(),
        }
    }

    /// Puts an input at `place`.
    ///
    /// # Errors
    /// It cannot be made or written.
    pub fn put(&mut self, input: Input, place: &Path) -> Result<()> {
        if !self.made.contains_key(&input) {
            let path = self.make(input)?;
            self.made.insert(input, path);
        }
        let cannot = |why| Failure::new(format!("cannot write {}", place.display())).because(why);
        if let Some(folder) = place.parent() {
            fs::create_dir_all(folder).map_err(cannot)?;
        }
        fs::copy(&self.made[&input], place).map_err(cannot)?;
        Ok(())
    }

    fn rarma(&self, arguments: &[&str]) -> Result<String> {
        let mut command = Command::new(&self.rarma);
        process::output(command.args(arguments).current_dir(&self.folder))
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<PathBuf> {
        let path = self.folder.join(name);
        fs::write(&path, bytes)
            .map_err(|why| Failure::new(format!("cannot write {}", path.display())).because(why))?;
        Ok(path)
    }

    fn make(&self, input: Input) -> Result<PathBuf> {
        let at = |name: &str| Ok(self.folder.join(name));
        match input {
            Input::Recording => {
                self.write("recording.toml", RECORDING.as_bytes())?;
                self.rarma(&["simulate", "recording.toml", "--out", "recording.wav"])?;
                at("recording.wav")
            }
            Input::Force => self.write("force.wav", &wav(&blow())),
            Input::Acceleration => self.write("acceleration.wav", &wav(&answer(&blow()))),
            Input::Receptances => {
                self.rarma(&["els", "model", "els-load-bar", "--uff", "machine.uff"])?;
                at("machine.uff")
            }
            Input::Loads => {
                let model = self.rarma(&["els", "model", "els-load-bar", "--json"])?;
                self.write("loads.csv", loads(&model)?.as_bytes())
            }
            Input::Frames => {
                let mut command = Command::new(&self.rarma);
                command
                    .args(["box", "--sim", "box-ldbb-leak", "--record", "box.frames"])
                    .current_dir(&self.folder);
                // 1: the scenario's fault switched outputs off.
                process::status(command.stdout(std::process::Stdio::null()))?;
                at("box.frames")
            }
            Input::Machine => self.write("machine.toml", MACHINE.as_bytes()),
            Input::Key => self.write(
                "link.key",
                format!("{}\n", "0123456789abcdef".repeat(4)).as_bytes(),
            ),
        }
    }
}

/// Load steps of the shipped model: deflections of its tool joint, read to 0.1 µm.
fn loads(model: &str) -> Result<String> {
    let strange = || Failure::new("`rarma els model --json` tells no deflections");
    let model: serde_json::Value = serde_json::from_str(model).map_err(|_| strange())?;
    let numbers = |value: &serde_json::Value| -> Option<Vec<f64>> {
        value
            .as_array()?
            .iter()
            .map(serde_json::Value::as_f64)
            .collect()
    };
    let mut out = "angle_deg,load_n,deflection_um\n".to_owned();
    for step in model["deflections"].as_array().ok_or_else(strange)? {
        let load_n = step["load_n"].as_f64().ok_or_else(strange)?;
        let angles = numbers(&step["angle_deg"]).ok_or_else(strange)?;
        let deflections = numbers(&step["tool_joint_um"]).ok_or_else(strange)?;
        for (angle_deg, um) in angles.iter().zip(deflections) {
            // A String takes everything.
            let _ = writeln!(out, "{angle_deg},{load_n},{um:.1}");
        }
    }
    Ok(out)
}

/// Half a sine of 0.3 ms, 800 N.
fn blow() -> Vec<f64> {
    let (begin_s, length_s) = (5e-3, 3e-4);
    (0..(STRUCK_S * STRUCK_HZ) as usize)
        .map(|k| (k as f64 / STRUCK_HZ - begin_s) / length_s)
        .map(|part| {
            if (0.0..1.0).contains(&part) {
                800.0 * (0.5 * TAU * part).sin()
            } else {
                0.0
            }
        })
        .collect()
}

/// Acceleration of the structure: ẍ of each mode, by small steps.
fn answer(force: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; force.len()];
    for (f_hz, zeta, n_per_um) in STRUCK {
        let (w, k) = (TAU * f_hz, 1e6 * n_per_um);
        let (mut x, mut v) = (0.0, 0.0);
        let parts = 16;
        let dt = 1.0 / (STRUCK_HZ * f64::from(parts));
        for (n, f) in force.iter().enumerate() {
            let a = |x: f64, v: f64| w * w * (f / k - x) - 2.0 * zeta * w * v;
            out[n] += a(x, v);
            for _ in 0..parts {
                v += dt * a(x, v);
                x += dt * v;
            }
        }
    }
    out
}

/// One channel of 32-bit float.
fn wav(samples: &[f64]) -> Vec<u8> {
    let bytes = 4 * samples.len() as u32;
    let rate = STRUCK_HZ as u32;
    let mut out = b"RIFF".to_vec();
    out.extend((36 + bytes).to_le_bytes());
    out.extend(b"WAVEfmt ");
    out.extend(16u32.to_le_bytes());
    for half in [3u16, 1] {
        out.extend(half.to_le_bytes());
    }
    for whole in [rate, 4 * rate] {
        out.extend(whole.to_le_bytes());
    }
    for half in [4u16, 32] {
        out.extend(half.to_le_bytes());
    }
    out.extend(b"data");
    out.extend(bytes.to_le_bytes());
    out.extend(samples.iter().flat_map(|x| (*x as f32).to_le_bytes()));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_struck_structure_rings_at_its_modes() {
        let ringing = answer(&blow());
        // Magnitude at a frequency, by its own sum.
        let at = |f_hz: f64| {
            let (re, im) = ringing
                .iter()
                .enumerate()
                .fold((0.0, 0.0), |(re, im), (k, x)| {
                    let p = TAU * f_hz * k as f64 / STRUCK_HZ;
                    (re + x * p.cos(), im + x * p.sin())
                });
            f64::hypot(re, im)
        };
        for (f_hz, ..) in STRUCK {
            assert!(at(f_hz) > 2.0 * at(f_hz - 150.0), "{f_hz}");
            assert!(at(f_hz) > 2.0 * at(f_hz + 150.0), "{f_hz}");
        }
    }

    #[test]
    fn a_wav_says_its_length() {
        let bytes = wav(&[0.0, 1.0]);
        assert_eq!(bytes.len(), 44 + 8);
        assert_eq!(bytes[40..44], 8u32.to_le_bytes());
        assert_eq!(bytes[48..], 1f32.to_le_bytes());
    }
}
