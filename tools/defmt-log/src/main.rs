//! `defmt-log ELF < STREAM`: turns an image's defmt stream into lines of text.
//!
//! An image sends indices into a table that its ELF holds; this program looks them up.
//! Warnings and errors come with the source line that logged them.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{env, fs};

use defmt_decoder::{DecodeError, Frame, Location, StreamDecoder, Table};

fn main() -> ExitCode {
    let Some(elf) = env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("error: defmt-log needs the path of the image whose log it decodes");
        return ExitCode::from(2);
    };
    match decode_all(&elf) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Decodes standard input until it ends.
fn decode_all(elf: &Path) -> Result<(), String> {
    let place = elf.display();
    let bytes = fs::read(elf).map_err(|why| format!("cannot read {place}: {why}"))?;
    let table = Table::parse(&bytes)
        .map_err(|why| format!("cannot read the log table of {place}: {why}"))?
        .ok_or_else(|| format!("{place} has no log table: it does not log with defmt"))?;
    // Without debug information there are no source lines; the messages stay.
    let locations = table.get_locations(&bytes).unwrap_or_default();

    let mut decoder = table.new_stream_decoder();
    let mut input = io::stdin().lock();
    let mut chunk = [0; 4096];
    loop {
        let length = input
            .read(&mut chunk)
            .map_err(|why| format!("cannot read the log: {why}"))?;
        if length == 0 {
            return Ok(());
        }
        decoder.received(&chunk[..length]);
        print_frames(&table, &mut *decoder, &locations)?;
    }
}

/// Prints every frame that has arrived whole.
fn print_frames(
    table: &Table,
    decoder: &mut dyn StreamDecoder,
    locations: &BTreeMap<u64, Location>,
) -> Result<(), String> {
    let mut output = io::stdout().lock();
    loop {
        match decoder.decode() {
            Ok(frame) => writeln!(output, "{}", line(&frame, locations))
                .and_then(|()| output.flush())
                .map_err(|why| format!("cannot write the decoded log: {why}"))?,
            Err(DecodeError::UnexpectedEof) => return Ok(()),
            Err(DecodeError::Malformed) if table.encoding().can_recover() => {
                writeln!(output, "(bytes that are no log message)")
                    .map_err(|why| format!("cannot write the decoded log: {why}"))?;
            }
            Err(DecodeError::Malformed) => {
                return Err("the log is damaged, or from another build of the image".to_owned());
            }
        }
    }
}

/// One message as one line: level, text, and for what went wrong the place.
fn line(frame: &Frame<'_>, locations: &BTreeMap<u64, Location>) -> String {
    let text = frame.display_message();
    let Some(level) = frame.level() else {
        return text.to_string();
    };
    let name = level.as_str();
    let place = locations
        .get(&frame.index())
        .filter(|_| matches!(name, "warn" | "error"));
    match place {
        Some(place) => format!("{name:<5} {text} ({}:{})", place.file.display(), place.line),
        None => format!("{name:<5} {text}"),
    }
}
