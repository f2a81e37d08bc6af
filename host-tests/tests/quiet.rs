//! Promise: `--quiet` leaves nothing on standard error of a command that succeeds, changes nothing of its answer, and does
//! not hush an error.

use host_tests::every_command::{Inputs, cases};
use host_tests::files::Folder;
use std::process::{Command, Output};

fn run(arguments: &[String], quiet: bool) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
        .args(arguments)
        .args(quiet.then_some("--quiet"))
        .output()
        .expect("a program")
}

/// What was answered, but for lines that tell how long it took.
fn answer(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines()
        .filter(|line| !line.contains("simulated seconds per second"))
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn a_quiet_command_says_nothing_beside_its_answer() {
    let inputs = Inputs::new(host_tests::rarma!());
    let mut hushed = 0;
    for case in cases() {
        let folder = Folder::default();
        let arguments = case.arguments(&inputs, folder.path());
        let [told, quiet] = [false, true].map(|quiet| run(&arguments, quiet));
        let error = String::from_utf8_lossy(&quiet.stderr);
        assert_eq!(error, "", "{arguments:?}");
        assert_eq!(told.status.code(), quiet.status.code(), "{arguments:?}");
        // Every record of the population tells how long its cut took.
        if case.command != "population" {
            assert_eq!(answer(&told), answer(&quiet), "{arguments:?}");
        }
        hushed += usize::from(!told.stderr.is_empty());
    }
    assert!(hushed > 5, "only {hushed} commands had anything to say");
}

#[test]
fn an_error_is_told_all_the_same() {
    for words in [
        &["monitor", "not-there.wav"][..],
        &["simulate", "no-such-cut"],
        &["monitor", "--no-such-option"],
    ] {
        let words: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
        let [told, quiet] = [false, true].map(|quiet| run(&words, quiet));
        assert!(!told.status.success());
        assert_eq!(told.status.code(), quiet.status.code());
        let told = String::from_utf8_lossy(&told.stderr);
        assert!(
            told.contains("rarma: ") || told.contains("error: "),
            "{told}"
        );
        assert_eq!(told, String::from_utf8_lossy(&quiet.stderr), "{words:?}");
    }
}
