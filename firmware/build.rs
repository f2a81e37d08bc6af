//! Hands the chosen board's memory map to the linker.
//!
//! On the target, exactly one `board-<name>` feature must be on; its map,
//! `memory/<name>.x`, is copied to the build directory as `board-memory.x`, which
//! the workspace's `memory.x` includes. On the host this script emits nothing,
//! so that every feature can be on at once there.
//!
//! A new board needs its map in `memory/` and its feature in `Cargo.toml`.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// Name under which the workspace's `memory.x` includes the map.
const INCLUDED_AS: &str = "board-memory.x";

/// Linker arguments of every image: start-up code, defmt's tables, no page alignment.
const LINK_ARGS: [&str; 3] = ["-Tlink.x", "-Tdefmt.x", "--nmagic"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=memory");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    if let Err(message) = prepare_link() {
        println!("cargo::error={message}");
    }
}

/// Copies the map of the one chosen board and emits the linker arguments.
fn prepare_link() -> Result<(), String> {
    let maps = memory_maps(Path::new("memory"))?;
    let names = || {
        maps.iter()
            .map(|(board, _)| board.as_str())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let chosen: Vec<_> = maps
        .iter()
        .filter(|(board, _)| feature_is_on(board))
        .collect();
    let map = match chosen.as_slice() {
        [(_, map)] => map,
        [] => {
            return Err(format!(
                "no board chosen: turn on one feature `board-<name>`; boards with a memory map: {}",
                names()
            ));
        }
        several => {
            let on: Vec<_> = several
                .iter()
                .map(|(board, _)| format!("board-{board}"))
                .collect();
            return Err(format!(
                "one image is for one board, but these features are on together: {}",
                on.join(", ")
            ));
        }
    };

    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo did not set OUT_DIR")?);
    fs::copy(map, out.join(INCLUDED_AS))
        .map_err(|why| format!("cannot copy {} to {}: {why}", map.display(), out.display()))?;
    println!("cargo::rustc-link-search={}", out.display());
    for arg in LINK_ARGS {
        println!("cargo::rustc-link-arg={arg}");
    }
    Ok(())
}

/// Every board that has a memory map, with the map's path, sorted by name.
fn memory_maps(folder: &Path) -> Result<Vec<(String, PathBuf)>, String> {
    let entries = fs::read_dir(folder).map_err(|why| {
        format!(
            "cannot list memory maps in firmware/{}: {why}",
            folder.display()
        )
    })?;
    let mut maps: Vec<_> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "x"))
        .filter_map(|path| Some((path.file_stem()?.to_str()?.to_owned(), path)))
        .collect();
    maps.sort();
    Ok(maps)
}

/// Whether cargo turned on the feature `board-<board>`.
fn feature_is_on(board: &str) -> bool {
    let variable = format!(
        "CARGO_FEATURE_BOARD_{}",
        board.to_uppercase().replace('-', "_")
    );
    env::var_os(variable).is_some()
}
