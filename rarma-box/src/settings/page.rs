//! The table as a page for people and as a schema for programs.

use super::table::SETTINGS;
use super::value::Kind;
use core::fmt::{self, Write};

/// Writes the rows of the page.
///
/// # Errors
/// Those of the writer.
pub fn markdown(out: &mut impl Write) -> fmt::Result {
    writeln!(
        out,
        "| number | setting | unit | range | default | effect | takes effect |"
    )?;
    writeln!(out, "|---|---|---|---|---|---|---|")?;
    for s in &SETTINGS {
        write!(out, "| {} | `{}` | {} | ", s.number, s.name, s.unit)?;
        match s.kind {
            Kind::Real { low, high, default } => write!(out, "{low} to {high} | {default}")?,
            Kind::Whole { low, high, default } => {
                write!(out, "{low} to {high}, whole | {default}")?
            }
            Kind::Key => write!(out, "64 hexadecimal digits | none")?,
        }
        writeln!(out, " | {} | {} |", s.effect, s.takes.words())?;
    }
    Ok(())
}

/// Writes a JSON schema of an object that holds settings by name.
///
/// # Errors
/// Those of the writer.
pub fn write_schema(out: &mut impl Write) -> fmt::Result {
    write!(
        out,
        "{{\"$schema\":\"https://json-schema.org/draft/2020-12/schema\",\"title\":\"Settings of the sensor box\",\"type\":\"object\",\"additionalProperties\":false,\"properties\":{{"
    )?;
    for (k, s) in SETTINGS.iter().enumerate() {
        let comma = if k == 0 { "" } else { "," };
        write!(out, "{comma}\"{}\":{{", s.name)?;
        // Names, units and effects hold no character that JSON would escape; tested.
        match s.kind {
            Kind::Real { low, high, default } => write!(
                out,
                "\"type\":\"number\",\"minimum\":{low:e},\"maximum\":{high:e},\"default\":{default:e}"
            )?,
            Kind::Whole { low, high, default } => write!(
                out,
                "\"type\":\"integer\",\"minimum\":{low},\"maximum\":{high},\"default\":{default}"
            )?,
            Kind::Key => write!(
                out,
                "\"type\":\"string\",\"pattern\":\"^[0-9a-f]{{64}}$\",\"writeOnly\":true"
            )?,
        }
        write!(
            out,
            ",\"unit\":\"{}\",\"number\":{},\"description\":\"{}; takes effect {}\"}}",
            s.unit,
            s.number,
            s.effect,
            s.takes.words()
        )?;
    }
    writeln!(out, "}}}}")
}
