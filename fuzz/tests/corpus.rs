//! Promise: no case of the corpus shows a defect: what fuzzing found once stays mended.

use cap::Cap;
use fuzz::{CASE_S, MEMORY_BYTES, TARGETS, Target};
use std::alloc::System;
use std::sync::mpsc;
use std::time::Duration;

#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, MEMORY_BYTES);

/// Runs a target over its cases, each within the time one may take; how many there were.
fn run(target: &'static Target) -> usize {
    let folder = target.corpus();
    let entries = std::fs::read_dir(&folder);
    let entries = entries.unwrap_or_else(|why| panic!("{}: {why}", folder.display()));
    let mut cases: Vec<_> = entries.map(|e| e.expect("an entry").path()).collect();
    cases.sort();
    for path in &cases {
        let bytes = std::fs::read(path).expect("a case");
        let (done, ended) = mpsc::channel();
        let running = std::thread::spawn(move || {
            (target.run)(&bytes);
            // Nobody waits any more once the time is over.
            let _ = done.send(());
        });
        match ended.recv_timeout(Duration::from_secs(CASE_S)) {
            Ok(()) => {}
            Err(mpsc::RecvTimeoutError::Timeout) => {
                panic!("{}: not done after {CASE_S} s", path.display())
            }
            Err(mpsc::RecvTimeoutError::Disconnected) => {
                let why = running.join().expect_err("it ended without its last word");
                let why = why.downcast_ref::<String>().map_or("", String::as_str);
                panic!("{}: {why}", path.display())
            }
        }
    }
    cases.len()
}

#[test]
fn every_case_of_the_corpus_holds() {
    for target in &TARGETS {
        let cases = run(target);
        println!("{:16} {cases} cases", target.name);
        assert!(cases > 0, "{} has no corpus", target.name);
    }
}

#[test]
fn the_corpus_is_small_and_of_known_targets() {
    let root = TARGETS[0].corpus();
    let root = root.parent().expect("the corpus");
    for folder in std::fs::read_dir(root).expect("the corpus") {
        let folder = folder.expect("a folder").path();
        let name = folder.file_name().and_then(|name| name.to_str());
        let name = name.expect("a plain name");
        assert!(fuzz::target(name).is_some(), "{name} is no target");
        let sizes = std::fs::read_dir(&folder).expect("a folder");
        let bytes: u64 = sizes
            .map(|e| e.and_then(|e| e.metadata()).expect("a case").len())
            .sum();
        assert!(bytes < 48_000, "{name}: {bytes} bytes");
    }
}

#[test]
fn every_target_has_a_dictionary_that_can_be_read() {
    for target in &TARGETS {
        // An empty one is refused by the engine.
        assert!(!target.dictionary().is_empty(), "{}", target.name);
        for line in target.dictionary().lines() {
            let inside = line.strip_prefix('"').and_then(|l| l.strip_suffix('"'));
            assert!(inside.is_some_and(|word| !word.is_empty()), "{line}");
            assert!(line.is_ascii(), "{line}");
        }
    }
}
