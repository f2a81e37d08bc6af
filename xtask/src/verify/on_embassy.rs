//! The example on embassy: a program of somebody else's, with the core as its only package of this
//! workspace. It is built, and run on the model of its chip: a tone that swells must light its lamp.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::bench::Bench;
use super::summary::Outcome;
use crate::arm_image::ArmImage;
use crate::chip::model::{Model, Run};
use crate::toolchain::Toolchain;
use crate::{Failure, Result, TARGET, Workspace, process};

/// Its folder, a workspace of its own.
const PROGRAM: &str = "tools/embassy";
/// Its manifest.
pub(super) const MANIFEST: &str = "tools/embassy/Cargo.toml";
/// Pin of the lamp.
const LAMP: &str = "PA5";
/// Length of the sound, and when the tone begins, s of the model. The lamp has to come on in between, and to stay.
const SECONDS: f64 = 1.5;
const BEGINS_S: f64 = 0.8;
/// Samples a second of the example, and in the model, whose clock is that of the box: 163.2 MHz for 76.8.
const FS_HZ: f64 = 24_000.0;
const MODEL_FS_HZ: f64 = 51_000.0;
/// The tone, Hz.
const TONE_HZ: f64 = 900.0;

/// The check.
pub(super) fn check(bench: &mut Bench<'_>) -> Result<Outcome> {
    let toolchain = match bench.toolchain() {
        Ok(toolchain) => toolchain,
        Err(why) => return Ok(Outcome::Skipped(why)),
    };
    let elf = build(bench.workspace, &toolchain)?;
    let image = ArmImage::read(&elf)?;
    let (flash, memory) = (image.flash_bytes(), image.static_bytes());
    let size = format!("{flash} bytes of flash, {memory} of static memory");
    let model = match Model::find_or_make(bench.workspace) {
        Ok(model) => model,
        Err(why) => return Ok(Outcome::Partly(format!("{size}; not run: {why}"))),
    };
    let seen = run(bench.workspace, &model, &elf)?;
    let findings = &seen["judged"]["findings"];
    if findings.as_array().is_none_or(|list| !list.is_empty()) {
        return Err(Failure::new("the example sets the chip as its data forbid").because(findings));
    }
    let lit_s = lamp(&seen)?;
    Ok(Outcome::Passed(format!(
        "{size}; its lamp is lit {:.2} s after the tone begins",
        (lit_s - BEGINS_S) * MODEL_FS_HZ / FS_HZ
    )))
}

/// Builds the program.
///
/// # Errors
/// It does not build.
pub(super) fn build(workspace: &Workspace, toolchain: &Toolchain) -> Result<PathBuf> {
    let target_dir = workspace.tools_target_dir();
    // The linker's script, which a program of its own names itself.
    let flags = "[\"-Clink-arg=-Tlink.x\", \"-Clink-arg=--nmagic\"]";
    let mut build = toolchain.cargo(workspace);
    build
        .current_dir(workspace.root().join(PROGRAM))
        .args(["build", "--release", "--locked", "--target", TARGET])
        .arg("--config")
        .arg(format!("target.{TARGET}.rustflags={flags}"))
        .env("CARGO_TARGET_DIR", &target_dir);
    process::run(&mut build)?;
    Ok(target_dir.join(TARGET).join("release/on-embassy"))
}

fn run(workspace: &Workspace, model: &Model, elf: &Path) -> Result<Value> {
    let folder = workspace.target_dir().join("embassy");
    let sound = folder.join("sound.u16");
    let bytes: Vec<u8> = tone().into_iter().flat_map(u16::to_le_bytes).collect();
    fs::create_dir_all(&folder)
        .and_then(|()| fs::write(&sound, bytes))
        .map_err(|why| Failure::new(format!("cannot write {}", sound.display())).because(why))?;
    let run = Run {
        seconds: SECONDS,
        microphone: Some(&sound),
        ..Run::default()
    };
    model.run(elf, &folder, &run)
}

/// Noise, and a tone that swells out of it: samples as the example takes them, in the model's measure, sums of
/// eight conversions.
fn tone() -> Vec<u16> {
    let mut seed = 1u32;
    (0..(SECONDS * MODEL_FS_HZ) as u32)
        .map(|n| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(seed >> 8) / 8_388_608.0 - 1.0;
            let t_s = f64::from(n) / FS_HZ;
            let since_s = t_s - BEGINS_S * MODEL_FS_HZ / FS_HZ;
            let swells = (since_s >= 0.0).then(|| (0.003 * (6.0 * since_s).exp()).min(0.3));
            let tone = swells.unwrap_or(0.0) * (core::f64::consts::TAU * TONE_HZ * t_s).sin();
            (16_380.0 * (1.0 + 0.002 * noise + tone)) as u16
        })
        .collect()
}

/// When the lamp came on, s, to stay.
fn lamp(seen: &Value) -> Result<f64> {
    let events = seen["trace"].as_array().into_iter().flatten();
    let changes: Vec<(f64, u64)> = events
        .filter(|event| event["kind"] == "pin" && event["name"] == LAMP)
        .filter_map(|event| Some((event["s"].as_f64()?, event["value"].as_u64()?)))
        .collect();
    match changes[..] {
        [(s, 1)] if s > BEGINS_S => Ok(s),
        _ => Err(Failure::new(format!(
            "the example's lamp has to come on once, after {BEGINS_S} s; it changed at {changes:?}"
        ))),
    }
}
