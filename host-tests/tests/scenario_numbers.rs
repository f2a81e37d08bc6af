//! Promise: whatever number stands in a scenario, the command ends, well or with one line
//! of refusal, in bounded time and memory.

use host_tests::files::Folder;
use host_tests::hard::{Bounds, Verdict, bounded};
use host_tests::rarma;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::path::PathBuf;

/// What is put in the place of every number.
const ODD: [&str; 11] = [
    "0",
    "-1",
    "1e-308",
    "1e308",
    "nan",
    "inf",
    "9223372036854775807",
    "-9223372036854775808",
    "0.5",
    "1e6",
    "1000000",
];

/// A command and the shipped scenarios it reads.
struct Reader {
    /// `{}` stands for the file.
    command: &'static str,
    shipped: &'static [&'static str],
}

const READERS: [Reader; 5] = [
    Reader {
        command: "simulate {} --json",
        shipped: &[
            "chatter-onset",
            "three-mode-resonance",
            "three-mode-chatter",
            "override-turned",
            "spindle-10000",
            "slotted-workpiece",
            "slender-bar",
            "damped-bar",
            "turning-980",
            "two-tooth-benchmark",
            "two-tooth-up",
            "helix-run-up",
        ],
    },
    Reader {
        command: "els model {} --json",
        shipped: &["els-holder", "els-load-bar", "els-short-tool"],
    },
    Reader {
        command: "cers run {} --quick --json",
        shipped: &["cers-rest", "cers-turning", "cers-sweep"],
    },
    Reader {
        command: "ldbb run {} --json",
        shipped: &["ldbb-m3", "ldbb-m5", "ldbb-weak"],
    },
    Reader {
        command: "box --sim {} --json",
        shipped: &[
            "box-cers-steps",
            "box-cers-fault",
            "box-ldbb-leak",
            "box-bad-link",
        ],
    },
];

fn shipped(name: &str) -> String {
    let path = format!(
        "{}/../rarma-scenarios/scenarios/{name}.toml",
        env!("CARGO_MANIFEST_DIR")
    );
    std::fs::read_to_string(&path).unwrap_or_else(|why| panic!("{path}: {why}"))
}

/// Where numbers stand in a text: outside of comments and strings, behind `=`, `[` or `,`.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let bytes = text.as_bytes();
    let (mut out, mut at) = (Vec::new(), 0);
    let mut value = false;
    while at < bytes.len() {
        match bytes[at] {
            b'#' => {
                at += text[at..].find('\n').unwrap_or(text.len() - at);
                continue;
            }
            b'"' => at += 1 + text[at + 1..].find('"').expect("a string's end"),
            b'\n' | b'{' => value = false,
            b'=' | b'[' | b',' => value = true,
            c if value && (c.is_ascii_digit() || b"+-.".contains(&c)) => {
                let rest = &text[at..];
                let end = rest
                    .find(|c: char| !(c.is_ascii_alphanumeric() || "+-._".contains(c)))
                    .unwrap_or(rest.len());
                if rest[..end].replace('_', "").parse::<f64>().is_ok() {
                    out.push((at, at + end));
                }
                at += end;
                value = false;
                continue;
            }
            c if c.is_ascii_whitespace() => {}
            _ => value = false,
        }
        at += 1;
    }
    out
}

/// A scenario with one number changed.
struct Case {
    command: &'static str,
    what: String,
    text: String,
}

fn cases() -> Vec<Case> {
    let mut out = Vec::new();
    for reader in &READERS {
        for name in reader.shipped {
            let text = shipped(name);
            let found = numbers(&text);
            assert!(!found.is_empty(), "{name} has no numbers");
            for (from, to) in found {
                let line = 1 + text[..from].matches('\n').count();
                out.extend(ODD.map(|odd| Case {
                    command: reader.command,
                    what: format!("{name} line {line}: {} for {}", odd, &text[from..to]),
                    text: format!("{}{odd}{}", &text[..from], &text[to..]),
                }));
            }
        }
    }
    out
}

fn walk(cases: &[Case], bounds: Bounds) {
    let bad: Vec<String> = cases
        .par_iter()
        // Some take a minute, most an instant.
        .with_max_len(1)
        .filter_map(|case| {
            let folder = Folder::default();
            let file: PathBuf = folder.file("s.toml", case.text.as_bytes());
            let arguments = case.command.replace("{}", file.to_str().expect("UTF-8"));
            match bounded(rarma!(), arguments.split(' '), bounds) {
                Verdict::Well => None,
                Verdict::Bad(why) => Some(format!("{}: {}: {why}", case.command, case.what)),
            }
        })
        .collect();
    assert!(
        bad.is_empty(),
        "{} of {}:\n{}",
        bad.len(),
        cases.len(),
        bad.join("\n")
    );
}

#[test]
fn numbers_are_used_or_refused() {
    let all = cases();
    assert!(all.len() > 4_000, "{}", all.len());
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let some: Vec<Case> = all.into_iter().filter(|_| rng.random_bool(0.03)).collect();
    walk(&some, Bounds::default());
}

#[test]
#[ignore = "every number of every shipped scenario: hours"]
fn numbers_are_used_or_refused_long() {
    walk(&cases(), Bounds::default());
}

/// Products of numbers that are each in their range.
#[test]
fn what_would_not_fit_is_refused_before_it_is_begun() {
    let folder = Folder::default();
    let with = |name: &str, changes: &[(&str, &str)]| {
        let mut text = shipped(name);
        for (from, to) in changes {
            assert!(text.contains(from), "{name}: {from}");
            text = text.replacen(from, to, 1);
        }
        text
    };
    let holders = "\n[[holder]]\nlength_mm = 1\nouter_mm = 20\nelements = 200\n".repeat(200);
    let modes = "\n[[milling.mode]]\nf_hz = 900\nzeta = 0.01\nstiffness_n_per_um = 30\ny = 1\n";
    let milling = shipped("two-tooth-benchmark");
    let rows: Vec<String> = (0..1001)
        .map(|i| format!("{{ t_s = {i}, depth_mm = 1 }}"))
        .collect();
    let depth = format!("depth = [{}]", rows.join(", "));
    let long = with("two-tooth-benchmark", &[]);
    let duration = |text: &str| {
        let at = text.find("duration_s = ").expect("a length");
        let end = at + text[at..].find('\n').expect("a line");
        format!("{}duration_s = 3600{}", &text[..at], &text[end..])
    };
    let fast = |text: String| text.replacen("[milling]", "[milling]\nstep_rate_hz = 5e6", 1);
    let cases = [
        ("els model {}", shipped("els-holder") + &holders, "holder"),
        (
            "simulate {}",
            milling.clone() + &modes.repeat(40),
            "milling",
        ),
        ("simulate {}", fast(duration(&long)), "duration_s"),
        (
            "simulate {}",
            milling
                .lines()
                .map(|l| {
                    if l.starts_with("depth") {
                        depth.as_str()
                    } else {
                        l
                    }
                })
                .collect::<Vec<_>>()
                .join("\n"),
            "milling.depth",
        ),
    ];
    for (n, (command, text, field)) in cases.into_iter().enumerate() {
        let file = folder.file(&format!("p{n}.toml"), text.as_bytes());
        let arguments = command.replace("{}", file.to_str().expect("UTF-8"));
        let ended = rarma!().run(arguments.split(' '));
        assert_eq!(ended.code, Some(3), "{command}: {ended:?}");
        assert_eq!(ended.stderr.lines().count(), 1, "{ended:?}");
        let says = format!(": {field} ");
        assert!(
            ended.stderr.contains(&says) && ended.stderr.contains("(allowed: "),
            "{ended:?}"
        );
    }
}
