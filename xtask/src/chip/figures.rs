//! The figures of the image: as a table, back from it, and compared on both sides.

use std::fmt::Write as _;

use crate::arm_image::ArmImage;
use crate::count::calls::Unwanted;
use crate::page::{Part, TOLERANCE};
use crate::{Failure, Result};

/// Where the table is in a file that holds it.
const PART: Part = Part("chip");

/// The chip's flash for the image, and its memory: the memory map's. The stack has all of its memory at
/// the start, and afterwards what the program leaves of it.
const FLASH_BYTES: u64 = 480 * 1024;
const STATIC_BYTES: u64 = 96 * 1024;
const STACK_BYTES: [(&str, u64); 2] = [("at the start", 32 * 1024), ("afterwards", 12 * 1024)];

/// Samples a second, and millions of the core's cycles: no instruction takes less than one.
const SAMPLES_PER_S: f64 = 48_000.0;
const MEGACYCLES_PER_S: f64 = 163.2;

/// One figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    name: String,
    value: f64,
    /// The most it may be, where there is a limit.
    limit: Option<f64>,
    /// How far it may be from the committed one, relative.
    tolerance: f64,
}

/// All figures, and the compiler that they belong to.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    compiler: String,
    figures: Vec<Figure>,
}

impl Figures {
    /// Gathers the figures.
    ///
    /// # Errors
    /// One is beyond its limit.
    pub fn new(
        compiler: String,
        image: &ArmImage,
        stacks: [[u64; 2]; 2],
        instructions: f64,
        unwanted: &[(String, Unwanted)],
    ) -> Result<Self> {
        let figure = |name: &str, value: f64, limit: Option<u64>, tolerance| Figure {
            name: name.to_owned(),
            value,
            limit: limit.map(|limit| limit as f64),
            tolerance,
        };
        let size =
            |name: &str, value: u64, limit| figure(name, value as f64, Some(limit), TOLERANCE);
        let mut figures = vec![
            size("flash, bytes", image.flash_bytes(), FLASH_BYTES),
            size("static memory, bytes", image.static_bytes(), STATIC_BYTES),
        ];
        for ((when, most), [seen, by_code]) in STACK_BYTES.into_iter().zip(stacks) {
            for (what, bytes) in [("seen", seen), ("by the code", by_code)] {
                let name = format!("deepest stack {when}, {what}, bytes");
                figures.push(size(&name, bytes, most));
            }
        }
        figures.extend([
            figure(
                "instructions per sample, everything that runs",
                instructions.round(),
                None,
                TOLERANCE,
            ),
            Figure {
                name: "millions of instructions a second".to_owned(),
                value: (instructions * SAMPLES_PER_S * 1e-5).round() / 10.0,
                limit: Some(MEGACYCLES_PER_S),
                tolerance: TOLERANCE,
            },
        ]);
        for (duty, found) in unwanted {
            for (what, sites) in [
                ("panics", &found.panic),
                ("double precision", &found.double),
                ("an allocator", &found.heap),
                ("a pointer", &found.pointer),
            ] {
                let name = format!("calls to {what} that `{duty}` can reach");
                figures.push(figure(&name, sites.len() as f64, None, 0.0));
            }
        }
        for figure in &figures {
            if figure.limit.is_some_and(|limit| figure.value > limit) {
                return Err(Failure::new(format!(
                    "{}: {}, the chip has {}",
                    figure.name,
                    figure.value,
                    figure.limit.unwrap_or_default()
                )));
            }
        }
        Ok(Self { compiler, figures })
    }

    /// The table.
    pub fn markdown(&self) -> String {
        let mut text = "| figure | value | the chip has |\n|---|---:|---:|\n".to_owned();
        for figure in &self.figures {
            let limit = figure
                .limit
                .map_or(String::new(), |limit| limit.to_string());
            // Writing to a String cannot fail.
            let _ = writeln!(text, "| {} | {} | {limit} |", figure.name, figure.value);
        }
        let _ = writeln!(text, "\nMade with {}.", self.compiler);
        text
    }

    /// `document` with this table between its markers.
    ///
    /// # Errors
    /// A marker is missing.
    pub fn written_into(&self, document: &str) -> std::result::Result<String, String> {
        PART.written_into(document, &self.markdown())
    }

    /// The compiler that a document's table belongs to.
    ///
    /// # Errors
    /// The document has no such table, or the table no such line.
    pub fn compiler_in(document: &str) -> std::result::Result<String, String> {
        let (_, table, _) = PART.split(document)?;
        table
            .lines()
            .find_map(|line| line.strip_prefix("Made with "))
            .map(|line| line.trim_end_matches('.').to_owned())
            .ok_or_else(|| "the table does not say what it was made with".to_owned())
    }

    /// The compiler that made the image.
    pub fn compiler(&self) -> &str {
        &self.compiler
    }

    /// A line for each figure that is not the document's, or has no partner there.
    ///
    /// # Errors
    /// The document has no such table.
    pub fn differences_from(&self, document: &str) -> std::result::Result<Vec<String>, String> {
        let (_, table, _) = PART.split(document)?;
        let mut committed: Vec<(&str, f64)> = table.lines().filter_map(row).collect();
        let mut lines = Vec::new();
        for figure in &self.figures {
            let Some(place) = committed.iter().position(|(name, _)| *name == figure.name) else {
                lines.push(format!("{}: not in the table", figure.name));
                continue;
            };
            let (_, was) = committed.swap_remove(place);
            if (figure.value - was).abs() > figure.tolerance * was.abs() {
                lines.push(format!(
                    "{}: {}, {was} in the table",
                    figure.name, figure.value
                ));
            }
        }
        lines.extend(
            committed
                .iter()
                .map(|(name, _)| format!("{name}: in the table, but not measured")),
        );
        Ok(lines)
    }
}

fn row(line: &str) -> Option<(&str, f64)> {
    let mut cells = line.strip_prefix('|')?.split('|').map(str::trim);
    let name = cells.next()?;
    Some((name, cells.next()?.parse().ok()?))
}

/// Codes of a microphone that hears noise and a resonance at 900 Hz: sums of eight
/// conversions.
pub fn sound(seconds: f64) -> Vec<u16> {
    let (mut seed, mut y1, mut y2) = (1u32, 0.0f64, 0.0f64);
    // Poles of 900 Hz and a damping ratio of 1 % at 48 kHz.
    let (a1, a2) = (1.983_74, -0.997_65);
    let samples = (seconds * 48_000.0) as usize;
    let mut next = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = f64::from(seed >> 8) / 8_388_608.0 - 1.0;
        let y = noise + a1 * y1 + a2 * y2;
        y2 = y1;
        y1 = y;
        (16_380.0 + 40.0 * y).clamp(0.0, 32_760.0) as u16
    };
    (0..samples).map(|_| next()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const EMPTY: &str = "<!-- chip:begin -->\n<!-- chip:end -->\n";

    fn figures(stack: u64) -> Result<Figures> {
        let none = [("sample_duty".to_owned(), Unwanted::default())];
        Figures::new(
            "rustc 1.96.0".to_owned(),
            &ArmImage::default(),
            [[stack, 20_000], [6_000, 7_000]],
            900.4,
            &none,
        )
    }

    #[test]
    fn a_table_agrees_with_itself_and_two_percent_around() {
        let empty = format!("before\n{EMPTY}\nafter\n");
        let document = figures(10_000).unwrap().written_into(&empty).unwrap();
        let differences = |stack| figures(stack).unwrap().differences_from(&document).unwrap();
        for same in [9_800, 10_000, 10_200] {
            assert!(differences(same).is_empty(), "{:?}", differences(same));
        }
        for other in [9_799, 10_201] {
            assert_eq!(differences(other).len(), 1);
        }
        assert_eq!(Figures::compiler_in(&document), Ok("rustc 1.96.0".into()));
        assert!(Figures::compiler_in(EMPTY).is_err_and(|why| why.contains("made with")));
        assert!(figures(1).unwrap().differences_from("no table").is_err());
    }

    #[test]
    fn a_figure_that_comes_or_goes_is_a_difference() {
        let whole = figures(10).unwrap();
        let mut less = whole.clone();
        less.figures.pop();
        let page = |figures: &Figures| figures.written_into(EMPTY).unwrap();
        assert!(less.differences_from(&page(&whole)).unwrap()[0].contains("not measured"));
        assert!(whole.differences_from(&page(&less)).unwrap()[0].contains("not in the table"));
    }

    #[test]
    fn more_instructions_than_cycles_are_refused() {
        let with = |instructions| {
            let image = ArmImage::default();
            Figures::new("rustc".to_owned(), &image, [[1, 1]; 2], instructions, &[])
        };
        assert!(with(3399.0).is_ok());
        assert!(with(3402.0).is_err_and(|why| why.to_string().contains("163.2")));
    }

    #[test]
    fn what_the_chip_does_not_have_is_refused() {
        let (_, most) = STACK_BYTES[0];
        assert!(figures(most).is_ok());
        assert!(figures(most + 1).is_err_and(|why| why.to_string().contains("stack")));
    }

    #[test]
    fn the_sound_is_loud_and_never_clips() {
        let codes: Vec<f64> = sound(0.5).into_iter().map(f64::from).collect();
        let rms =
            (codes.iter().map(|c| (c - 16_380.0).powi(2)).sum::<f64>() / codes.len() as f64).sqrt();
        assert!((200.0..6_000.0).contains(&rms), "{rms}");
        assert!(codes.iter().all(|&c| c > 0.0 && c < 32_760.0));
    }
}
