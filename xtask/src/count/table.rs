//! The table of counts: as markdown, back from markdown, and compared.

use std::fmt::Write as _;

use crate::page::{Part, TOLERANCE};

/// Where the table is in a file that holds it.
const PART: Part = Part("count");

const HEADER: &str = "| kernel | instructions/sample | est. cycles/sample | on Cortex-M33, instructions/sample | code bytes | stack bytes | state bytes | f64 calls | panic calls |";

/// What a reader must know of the numbers, kept with them.
const LABEL: &str =
    "estimated cycles: zero wait states, ARM timing table, never compared with hardware";

/// And of those of the other core.
const M33_LABEL: &str = "Cortex-M33 in QEMU (mps2-an505): instructions alone, \
    for the core's manual has no table of times; bytes and calls are the Cortex-M4F's";

/// One kernel, the empty loop subtracted.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its name.
    pub kernel: String,
    /// Instructions per sample: exact, the same at every run of the same image.
    pub instructions: f64,
    /// Estimated Cortex-M4F cycles per sample.
    pub cycles: f64,
    /// Instructions per sample on the Cortex-M33, likewise exact.
    pub m33_instructions: f64,
    /// Bytes of the functions it enters.
    pub code_bytes: u64,
    /// Stack it uses.
    pub stack_bytes: u64,
    /// Size of its state.
    pub state_bytes: u64,
    /// Call sites of double precision in what it enters and that can call.
    pub double_calls: u64,
    /// Call sites of a panic, likewise.
    pub panic_calls: u64,
}

impl Row {
    /// The whole numbers by name, and how far two may differ and count as equal.
    fn sizes(&self) -> [(&'static str, u64, f64); 5] {
        [
            ("code bytes", self.code_bytes, TOLERANCE),
            ("stack bytes", self.stack_bytes, TOLERANCE),
            ("state bytes", self.state_bytes, 0.0),
            ("f64 calls", self.double_calls, 0.0),
            ("panic calls", self.panic_calls, 0.0),
        ]
    }
}

/// All kernels, and the compiler that the counts belong to.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name and version of the compiler.
    pub compiler: String,
    /// One row per kernel.
    pub rows: Vec<Row>,
}

impl Table {
    /// The table and its label.
    pub fn markdown(&self) -> String {
        let mut text = format!("{HEADER}\n|---|---:|---:|---:|---:|---:|---:|---:|---:|\n");
        for row in &self.rows {
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "| {} | {:.1} | {:.1} | {:.1} | {} | {} | {} | {} | {} |",
                row.kernel,
                row.instructions,
                row.cycles,
                row.m33_instructions,
                row.code_bytes,
                row.stack_bytes,
                row.state_bytes,
                row.double_calls,
                row.panic_calls
            );
        }
        let _ = writeln!(
            text,
            "\nCortex-M4F in QEMU (mps2-an386), {}; {LABEL}. {M33_LABEL}.",
            self.compiler
        );
        text
    }

    /// `document` with this table between its markers.
    ///
    /// # Errors
    /// When a marker is missing.
    pub fn written_into(&self, document: &str) -> Result<String, String> {
        PART.written_into(document, &self.markdown())
    }

    /// The table between the markers of `document`.
    ///
    /// # Errors
    /// When a marker is missing or a row is not understood.
    pub fn found_in(document: &str) -> Result<Self, String> {
        let (_, text, _) = PART.split(document)?;
        let compiler = text
            .lines()
            .find_map(|line| line.split_once("(mps2-an386), ")?.1.split_once(';'))
            .map(|(compiler, _)| compiler.to_owned())
            .ok_or("the table does not say what it was made with")?;
        let rows = text
            .lines()
            .filter(|line| {
                line.starts_with('|') && !line.starts_with("|--") && !line.starts_with("| kernel")
            })
            .map(|line| row(line).ok_or_else(|| format!("row `{line}` is not understood")))
            .collect::<Result<_, _>>()?;
        Ok(Self { compiler, rows })
    }

    /// A line for each count or size that is off the committed one, or has no partner.
    pub fn differences_from(&self, committed: &Self) -> Vec<String> {
        let find =
            |table: &Self, name: &str| table.rows.iter().find(|row| row.kernel == name).cloned();
        let mut lines = Vec::new();
        for was in &committed.rows {
            let Some(is) = find(self, &was.kernel) else {
                lines.push(format!("{}: in the table, but not measured", was.kernel));
                continue;
            };
            for (core, is, was_count) in [
                ("", is.instructions, was.instructions),
                (" on Cortex-M33", is.m33_instructions, was.m33_instructions),
            ] {
                if differ(is, was_count) {
                    lines.push(format!(
                        "{}: {is:.1} instructions/sample{core}, {was_count:.1} in the table ({:+.1} %)",
                        was.kernel,
                        100.0 * (is / was_count - 1.0)
                    ));
                }
            }
            for ((what, is, tolerance), (_, was_size, _)) in is.sizes().into_iter().zip(was.sizes())
            {
                if is.abs_diff(was_size) as f64 > tolerance * was_size as f64 {
                    lines.push(format!(
                        "{}: {is} {what}, {was_size} in the table",
                        was.kernel
                    ));
                }
            }
        }
        for is in self
            .rows
            .iter()
            .filter(|row| find(committed, &row.kernel).is_none())
        {
            lines.push(format!("{}: measured, but not in the table", is.kernel));
        }
        if !lines.is_empty() && self.compiler != committed.compiler {
            lines.push(format!(
                "compiler: {}, the table's is {}",
                self.compiler, committed.compiler
            ));
        }
        lines
    }
}

fn differ(is: f64, was: f64) -> bool {
    // The table rounds to a tenth.
    (is - was).abs() > TOLERANCE * was.abs() + 0.051
}

fn row(line: &str) -> Option<Row> {
    let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
    let [
        kernel,
        instructions,
        cycles,
        m33,
        code,
        stack,
        state,
        double,
        panic,
    ] = cells.as_slice()
    else {
        return None;
    };
    Some(Row {
        kernel: (*kernel).to_owned(),
        instructions: instructions.parse().ok()?,
        cycles: cycles.parse().ok()?,
        m33_instructions: m33.parse().ok()?,
        code_bytes: code.parse().ok()?,
        stack_bytes: stack.parse().ok()?,
        state_bytes: state.parse().ok()?,
        double_calls: double.parse().ok()?,
        panic_calls: panic.parse().ok()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(instructions: f64) -> Table {
        let row = Row {
            kernel: "gain".into(),
            instructions,
            cycles: 20.5,
            m33_instructions: 90.0,
            code_bytes: 64,
            stack_bytes: 8,
            state_bytes: 4,
            double_calls: 0,
            panic_calls: 1,
        };
        Table {
            compiler: "rustc 1.90.0".into(),
            rows: vec![row],
        }
    }

    #[test]
    fn survives_being_written_and_read_back() {
        let document = "before\n<!-- count:begin -->\nold\n<!-- count:end -->\nafter\n";
        let written = table(100.0).written_into(document).expect("has markers");
        assert!(
            written.starts_with("before\n")
                && written.ends_with("after\n")
                && !written.contains("old")
        );
        assert!(written.contains("never compared with hardware"));
        assert_eq!(Table::found_in(&written), Ok(table(100.0)));
        assert_eq!(
            table(100.0).written_into(&written),
            Ok(written),
            "writing twice changes nothing"
        );
    }

    #[test]
    fn two_percent_either_way_is_equal() {
        assert!(table(102.0).differences_from(&table(100.0)).is_empty());
        assert!(table(98.0).differences_from(&table(100.0)).is_empty());
        assert_eq!(table(102.2).differences_from(&table(100.0)).len(), 1);
        assert_eq!(table(97.8).differences_from(&table(100.0)).len(), 1);
    }

    #[test]
    fn sizes_and_calls_are_compared() {
        let with = |change: fn(&mut Row)| {
            let mut changed = table(100.0);
            change(&mut changed.rows[0]);
            changed.differences_from(&table(100.0))
        };
        let m33 = with(|row| row.m33_instructions += 2.0);
        assert!(m33[0].contains("92.0 instructions/sample on Cortex-M33, 90.0"));
        assert!(with(|row| row.code_bytes += 1).is_empty());
        assert!(with(|row| row.code_bytes += 2)[0].contains("66 code bytes, 64"));
        assert!(with(|row| row.state_bytes += 1)[0].contains("5 state bytes, 4"));
        assert!(with(|row| row.double_calls += 1)[0].contains("1 f64 calls, 0"));
        assert!(with(|row| row.panic_calls = 0)[0].contains("0 panic calls, 1"));
    }

    #[test]
    fn kernels_that_come_or_go_are_differences() {
        let none = Table {
            rows: vec![],
            ..table(1.0)
        };
        assert!(none.differences_from(&table(1.0))[0].contains("not measured"));
        assert!(table(1.0).differences_from(&none)[0].contains("not in the table"));
    }
}
