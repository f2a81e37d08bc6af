//! Promise: a write that fails ends the command with exit code 4 and one line that names the
//! file; a reader of standard output that has gone away ends it with 141 and no word.
#![cfg(unix)]

use clap::CommandFactory;
use host_tests::every_command::{ELSEWHERE, Inputs, cases, parts};
use host_tests::files::Folder;
use host_tests::frames::Sender;
use rarma_cli::args::Cli;
use std::fs::{self, File};
use std::io::Write;
use std::net::TcpListener;
use std::process::{Command, Output, Stdio};

const PROGRAM: &str = env!("CARGO_BIN_EXE_rarma-under-test");

fn run(arguments: &[String], stdout: Stdio) -> Output {
    Command::new(PROGRAM)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(stdout)
        .stderr(Stdio::piped())
        .output()
        .expect("a program")
}

/// A disk that is full.
fn full() -> Stdio {
    Stdio::from(File::create("/dev/full").expect("/dev/full"))
}

/// A pipe that nobody reads.
fn closed() -> Stdio {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    writer.into()
}

/// The last line on standard error, which no panic wrote.
fn said(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!text.contains("panicked"), "{text}");
    text.lines().last().unwrap_or_default().to_owned()
}

#[test]
fn no_command_is_missing_here() {
    fn leaves(command: &clap::Command, above: &str, out: &mut Vec<String>) {
        for sub in command.get_subcommands() {
            let name = format!("{above}{}", sub.get_name());
            if sub.has_subcommands() {
                leaves(sub, &format!("{name} "), out);
            } else {
                out.push(name);
            }
        }
    }
    let mut all = Vec::new();
    leaves(&Cli::command(), "", &mut all);
    assert!(all.len() > 20, "{all:?}");
    let cases = cases();
    for name in &all {
        let there = ELSEWHERE.contains(&name.as_str()) || cases.iter().any(|c| c.command == name);
        assert!(there, "`{name}` is not among the cases");
    }
    // And every file that an option names is written by one of them, or read.
    let reads = [
        "input",
        "more",
        "structure",
        "speed_from",
        "known",
        "uu",
        "uv",
        "vu",
        "vv",
        "force",
        "response",
        "loads",
        "key",
    ];
    let reads = [&reads[..], &["receptance", "files", "tests"]].concat();
    fn paths(command: &clap::Command, above: &str, out: &mut Vec<(String, String)>) {
        for sub in command.get_subcommands() {
            let name = format!("{above}{}", sub.get_name());
            let of_path = clap::builder::ValueParser::path_buf().type_id();
            for arg in sub.get_arguments() {
                if arg.get_value_parser().type_id() == of_path {
                    out.push((name.clone(), arg.get_id().to_string()));
                }
            }
            paths(sub, &format!("{name} "), out);
        }
    }
    let mut all = Vec::new();
    paths(&Cli::command(), "", &mut all);
    assert!(all.len() > 25, "{all:?}");
    for (command, option) in all {
        let option_of = format!("--{option}");
        let written = cases
            .iter()
            .any(|c| c.command == command && c.options().contains(&option_of.as_str()));
        let known = written
            || reads.contains(&option.as_str())
            || (command.as_str(), option.as_str()) == ("cers analyse", "record")
            || ELSEWHERE.contains(&command.as_str());
        assert!(known, "nothing tests --{option} of `{command}`");
    }
}

#[test]
fn standard_output_on_a_full_disk_or_a_closed_pipe_ends_every_command() {
    let inputs = Inputs::new(host_tests::rarma!());
    for case in cases() {
        let folder = Folder::default();
        let arguments = case.arguments(&inputs, folder.path());
        let output = run(&arguments, full());
        let line = said(&output);
        assert_eq!(output.status.code(), Some(4), "{arguments:?}: {line}");
        assert!(
            line.starts_with("rarma: standard output: ") && line.contains("the disk is full"),
            "{arguments:?}: {line}"
        );
        let output = run(&arguments, closed());
        let line = said(&output);
        assert_eq!(output.status.code(), Some(141), "{arguments:?}: {line}");
        assert!(
            !line.starts_with("rarma: standard"),
            "{arguments:?}: {line}"
        );
        // What had been asked for in files is there, or not at all.
        assert_eq!(parts(folder.path()), Vec::<std::path::PathBuf>::new());
    }
    for arguments in [
        vec!["--help".to_owned()],
        vec!["monitor".into(), "--help".into()],
    ] {
        assert_eq!(run(&arguments, full()).status.code(), Some(4));
        assert_eq!(run(&arguments, closed()).status.code(), Some(141));
    }
}

#[test]
fn a_file_that_cannot_be_written_is_named_and_the_old_one_stays() {
    let inputs = Inputs::new(host_tests::rarma!());
    let old = b"what was there before";
    for case in cases().iter().filter(|case| !case.writes.is_empty()) {
        let folder = Folder::default();
        for name in case.writes {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(&path, old).expect("a file");
        }
        let arguments = case.arguments(&inputs, folder.path());
        // No file may grow beyond 0 bytes, and that is an error, not a signal.
        let output = Command::new("sh")
            .args([
                "-c",
                "trap '' XFSZ; ulimit -f 0; exec \"$0\" \"$@\"",
                PROGRAM,
            ])
            .args(&arguments)
            .stdin(Stdio::null())
            .output()
            .expect("a shell");
        let line = said(&output);
        assert_eq!(output.status.code(), Some(4), "{arguments:?}: {line}");
        let named = |name: &&str| line.contains(&format!("/{name}: write: "));
        // A table of one run is the first file of a test of the ball bar.
        let named = case.writes.iter().any(named) || line.contains("/run-");
        assert!(named, "{arguments:?}: {line}");
        for name in case.writes {
            let now = fs::read(folder.path().join(name)).expect("the old file");
            assert_eq!(now, old, "{arguments:?}: {name} is spoilt");
        }
        assert_eq!(parts(folder.path()), Vec::<std::path::PathBuf>::new());
        // With room all of them are new.
        let output = run(&arguments, Stdio::null());
        assert_eq!(
            output.status.code(),
            Some(0),
            "{arguments:?}: {}",
            said(&output)
        );
        for name in case.writes {
            let now = fs::read(folder.path().join(name)).expect("the new file");
            assert_ne!(now, old, "{arguments:?}: {name} is still the old one");
            assert!(now.len() > 100, "{arguments:?}: {name}");
        }
        assert_eq!(parts(folder.path()), Vec::<std::path::PathBuf>::new());
    }
}

#[test]
fn a_device_that_is_full_is_told_too() {
    let inputs = Inputs::new(host_tests::rarma!());
    let record = inputs.at("box.frames").display().to_string();
    let scenario = inputs.at("box.toml").display().to_string();
    for words in [
        vec!["simulate", "turning-980", "--truth", "/dev/full"],
        vec!["simulate", "turning-980", "--out", "/dev/full"],
        vec!["decode", &record, "--wav", "/dev/full"],
        vec!["box", "--sim", &scenario, "--record", "/dev/full"],
    ] {
        let words: Vec<String> = words.into_iter().map(str::to_owned).collect();
        let output = run(&words, Stdio::null());
        let line = said(&output);
        assert_eq!(output.status.code(), Some(4), "{words:?}: {line}");
        assert!(
            line.contains("/dev/full: write: the disk is full"),
            "{words:?}: {line}"
        );
    }
}

/// A box that answers nothing, says a little, and waits to be left.
fn talking_box() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    std::thread::spawn(move || {
        while let Ok((mut socket, _)) = listener.accept() {
            let mut sender = Sender::new(3);
            // Until the other end has had enough.
            for k in 0..u64::MAX {
                let frames = [sender.started(8000.0), sender.raw(120 * k, &[1000; 120])];
                if socket.write_all(&frames.concat()).is_err() {
                    break;
                }
                std::thread::sleep(std::time::Duration::from_millis(2));
            }
        }
    });
    format!("tcp:{address}")
}

#[test]
fn connect_ends_when_it_can_no_longer_tell_or_record() {
    let port = talking_box();
    let words = |more: &[&str]| -> Vec<String> {
        let all = [&["connect", &port, "--look", "--seconds", "60"][..], more].concat();
        all.into_iter().map(str::to_owned).collect()
    };
    for more in [&[][..], &["--json"]] {
        let output = run(&words(more), full());
        assert_eq!(output.status.code(), Some(4), "{}", said(&output));
        assert!(said(&output).starts_with("rarma: standard output: "));
        assert_eq!(run(&words(more), closed()).status.code(), Some(141));
    }
    let output = run(&words(&["--json", "--record", "/dev/full"]), Stdio::null());
    assert_eq!(output.status.code(), Some(4), "{}", said(&output));
    assert!(said(&output).contains("/dev/full: write: the disk is full"));
}
