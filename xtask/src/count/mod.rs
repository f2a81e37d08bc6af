//! `cargo xtask count`: instructions and estimated cycles per sample on the Cortex-M4F, and instructions on
//! the Cortex-M33.
//!
//! The image `count` runs a kernel over a fixed signal between the functions `roi_begin`
//! and `roi_end`. QEMU runs it with the plugin in `tools/m4-cycles`, which counts what is
//! executed between the two. The kernel `nop` is the empty loop; its counts are subtracted.

pub mod calls;
mod image;
mod plugin;
pub mod table;

use std::path::PathBuf;

use crate::side_by_side::side_by_side;
use crate::toolchain::Toolchain;
use crate::{Failure, Result, Workspace, page, qemu};
use image::{Core, CountImage};
use table::{Row, Table};

/// The kernel that does nothing.
const EMPTY_KERNEL: &str = "nop";

/// A parsed `cargo xtask count` command line.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Request {
    /// Only these kernels; all when empty.
    pub kernels: Vec<String>,
    /// Single functions, ours beside those of libraries, in the place of kernels.
    pub functions: bool,
    /// Only name the kernels.
    pub list: bool,
    /// Write the table into this file.
    pub markdown: Option<PathBuf>,
    /// Compare with the table in this file.
    pub check: Option<PathBuf>,
}

impl Request {
    /// Reads the arguments after `count`.
    ///
    /// # Errors
    /// Names the option that is unknown or lacks its file.
    pub fn parse(arguments: &[String]) -> Result<Self> {
        let mut request = Self::default();
        let mut words = arguments.iter();
        while let Some(word) = words.next() {
            let mut file = || {
                words
                    .next()
                    .map(PathBuf::from)
                    .ok_or_else(|| Failure::usage(format!("`{word}` needs a file")))
            };
            match word.as_str() {
                "--list" => request.list = true,
                "--functions" => request.functions = true,
                "--markdown" => request.markdown = Some(file()?),
                "--check" => request.check = Some(file()?),
                option if option.starts_with('-') => {
                    return Err(Failure::usage(format!("`count` knows no `{option}`"))
                        .advise("cargo xtask count [--functions] [--list] [--markdown FILE] [--check FILE] [KERNEL...]"));
                }
                kernel => request.kernels.push(kernel.to_owned()),
            }
        }
        Ok(request)
    }
}

/// The command `count`.
///
/// # Errors
/// When the image cannot be built or run, or a count differs from the table to check.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let request = Request::parse(arguments)?;
    let toolchain = Toolchain::find_or_make(workspace, Core::M4.target())?;
    eprintln!("count: {}", toolchain.description());
    qemu::ensure_installed()?;
    let image = CountImage::build(workspace, &toolchain, Core::M4, request.functions)?;
    if request.list {
        for kernel in image.kernels()? {
            println!("{kernel}");
        }
        return Ok(0);
    }
    let table = measure(workspace, &image, &request, &toolchain)?;
    println!("{}", table.markdown());
    if let Some(path) = &request.markdown {
        let text = page::read(path)?;
        let text = table.written_into(&text).map_err(|why| {
            Failure::new(format!("cannot put the table into {}", path.display())).because(why)
        })?;
        page::write(path, &text)?;
    }
    if let Some(path) = &request.check {
        check(&table, path)?;
    }
    Ok(0)
}

/// Builds the images and measures all kernels.
///
/// # Errors
/// When something cannot be built or run, or a kernel is unknown.
pub fn measure_all(workspace: &Workspace, toolchain: &Toolchain) -> Result<Table> {
    let image = CountImage::build(workspace, toolchain, Core::M4, false)?;
    measure(workspace, &image, &Request::default(), toolchain)
}

/// Fails unless the counts are within the tolerance of the table in the file.
///
/// # Errors
/// When the file has no such table, or for every kernel whose count differs.
pub fn check(table: &Table, path: &std::path::Path) -> Result<()> {
    let committed = Table::found_in(&page::read(path)?).map_err(|why| {
        Failure::new(format!("cannot read the table in {}", path.display())).because(why)
    })?;
    let differences = table.differences_from(&committed);
    if differences.is_empty() {
        eprintln!("count: all counts and sizes agree with {}", path.display());
        return Ok(());
    }
    Err(
        Failure::new(format!("counts or sizes differ from {}", path.display()))
            .because(format!("\n  {}", differences.join("\n  ")))
            .advise(format!(
                "if the change is meant: cargo xtask count --markdown {}",
                path.display()
            )),
    )
}

fn measure(
    workspace: &Workspace,
    image: &CountImage,
    request: &Request,
    toolchain: &Toolchain,
) -> Result<Table> {
    let plugin = plugin::build(workspace)?;
    let known = image.kernels()?;
    let only = &request.kernels;
    let on_m33 = Toolchain::find_or_make(workspace, Core::M33.target())?;
    let same = (toolchain.compiler_version()?, on_m33.compiler_version()?);
    if same.0 != same.1 {
        return Err(Failure::new(format!(
            "two compilers for one table: {} for the Cortex-M4F, {} for the Cortex-M33",
            same.0, same.1
        )));
    }
    let m33_image = CountImage::build(workspace, &on_m33, Core::M33, request.functions)?;
    if let Some(unknown) = only.iter().find(|name| !known.contains(name)) {
        return Err(
            Failure::usage(format!("no kernel `{unknown}` in the image"))
                .advise(format!("kernels: {}", known.join(", "))),
        );
    }
    let chosen = |name: &&String| *name == EMPTY_KERNEL || only.is_empty() || only.contains(name);
    let chosen: Vec<&String> = known.iter().filter(chosen).collect();
    let measured = side_by_side(&chosen, |kernel| {
        let on_m4 = image.measure(&plugin, kernel)?;
        Ok((
            (*kernel).clone(),
            on_m4,
            m33_image.measure(&plugin, kernel)?,
        ))
    });
    let measured = measured.into_iter().collect::<Result<Vec<_>>>()?;
    let (empty, kernels): (Vec<_>, Vec<_>) =
        (measured.into_iter()).partition(|(kernel, ..)| kernel == EMPTY_KERNEL);
    let [(_, empty, m33_empty)] = &empty[..] else {
        return Err(Failure::new(format!(
            "the image has no kernel `{EMPTY_KERNEL}`"
        )));
    };
    let mut rows = Vec::new();
    let mut unwanted = calls::Unwanted::default();
    for (kernel, measured, on_m33) in kernels {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^52")]
        let per_sample = |all: u64, loop_alone: u64| {
            all.saturating_sub(loop_alone) as f64 / measured.samples as f64
        };
        rows.push(Row {
            kernel,
            instructions: per_sample(measured.instructions, empty.instructions),
            cycles: per_sample(measured.cycles, empty.cycles),
            m33_instructions: per_sample(on_m33.instructions, m33_empty.instructions),
            code_bytes: measured.code_bytes.saturating_sub(empty.code_bytes),
            stack_bytes: measured.stack_bytes.saturating_sub(empty.stack_bytes),
            state_bytes: measured.state_bytes,
            double_calls: measured.unwanted.double.len() as u64,
            panic_calls: measured.unwanted.panic.len() as u64,
        });
        unwanted.add(measured.unwanted);
    }
    for line in unwanted.summary() {
        eprintln!("count: in the sample path: {line}");
    }
    Ok(Table {
        compiler: same.0,
        rows,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Request> {
        Request::parse(
            &line
                .split_whitespace()
                .map(str::to_owned)
                .collect::<Vec<_>>(),
        )
    }

    #[test]
    fn reads_files_and_kernels() {
        let request =
            parse("--check README.md roots --markdown a.md gain --functions").expect("valid");
        assert!(request.functions);
        assert_eq!(request.check, Some("README.md".into()));
        assert_eq!(request.markdown, Some("a.md".into()));
        assert_eq!(request.kernels, ["roots", "gain"]);
    }

    #[test]
    fn refuses_what_it_does_not_know() {
        assert!(
            parse("--check").is_err_and(|failure| failure.to_string().contains("needs a file"))
        );
        assert!(parse("--fast").is_err_and(|failure| failure.exit_code() == 2));
    }
}
