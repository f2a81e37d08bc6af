//! `cargo demo`, `cargo verify`, `cargo fw …` and `cargo xtask book|count|chip|fuzz|gallery|long|qemu|rooms|screens|web`.

use std::process::ExitCode;

use xtask::{
    Failure, Workspace, book, chip, count, demo, fuzz, fw, gallery, long, qemu, rooms, screens,
    verify, web,
};

const HELP: &str = "\
The workspace's own commands.

  cargo demo [ARGS]             simulated machine tool, monitored; report in target/demo
  cargo verify [--ci]           every check; --ci: what did not run is a failure
      --long [--markdown FILE]  and every long form; each result into the table in FILE
      --only CHECK              only this one, by its name in the table
  cargo fw build|run|test [BOARD] [CARGO ARGS] [-- IMAGE ARGS]
                                the firmware for a board (default board mps2-an386);
                                run: in QEMU, or flashed onto nucleo-g474re by probe-rs, onto
                                pico2 by picotool
      --print-elf               build: last line on stdout is the image's path
  cargo xtask book              the pages of docs as a book, into target/book; links checked
      --pictures                and the gallery in it
      --serve [PORT]            and hold it on this machine's own address
  cargo xtask count [KERNEL...] instructions and estimated cycles per sample
      --functions               of functions: ours, libm's, micromath's
      --list                    name the kernels
      --markdown FILE           write the table between the markers in FILE
      --check FILE              fail if a count is 2 % off the table in FILE
  cargo xtask chip              what the image for the NUCLEO-G474RE takes of its chip
      --image ELF               of this image, already built
      --markdown FILE           write the table between the markers in FILE
      --check FILE              fail if a figure differs from the table in FILE
  cargo xtask fuzz [TARGET...]  every parser under libFuzzer, a minute each
      --seconds N               this long each
      --markdown FILE           ten minutes each, noted in the table of long forms in FILE
      --case FILE               one target: this case again
      --list                    name the targets
  cargo xtask gallery [DIR]     every picture of every command on one page, into target/gallery
      --against REV|DIR         beside those of a commit, or of a folder made before
      --only NAME               those of one command
  cargo xtask long [TEST...]    the long forms of all tests, or of these files of host-tests
      --list                    name them
      --markdown FILE           note each result in the table between the markers in FILE
      --missing                 only those that have not passed by that table
  cargo xtask rooms             who imports whom, and how large each room is
      --markdown FILE           write it between the markers in FILE
  cargo xtask screens [DIR]     pictures of the live screen, of real programs, into DIR
                                (target/screens); needs tmux
      --program FILE            of this `rarma`, already built
  cargo xtask web               the page in a browser, into target/web
      --serve [PORT]            and hold it on this machine's own address
  cargo xtask qemu ELF [ARGS]   run one image in QEMU, its log decoded
";

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let command = arguments.next().unwrap_or_default();
    let rest: Vec<String> = arguments.collect();
    let done = Workspace::locate().and_then(|workspace| match command.as_str() {
        "fw" => fw::main(&workspace, &rest),
        "qemu" => qemu::main(&workspace, &rest),
        "demo" => demo::main(&workspace, &rest),
        "verify" => verify::main(&workspace, &rest),
        "book" => book::main(&workspace, &rest),
        "gallery" => gallery::main(&workspace, &rest),
        "count" => count::main(&workspace, &rest),
        "long" => long::main(&workspace, &rest),
        "chip" => chip::main(&workspace, &rest),
        "rooms" => rooms::main(&workspace, &rest),
        "screens" => screens::main(&workspace, &rest),
        "fuzz" => fuzz::main(&workspace, &rest),
        "web" => web::main(&workspace, &rest),
        "" | "help" | "-h" | "--help" => {
            print!("{HELP}");
            Ok(0)
        }
        other => {
            Err(Failure::usage(format!("no command `{other}`")).advise("see `cargo xtask help`"))
        }
    });
    match done {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}
