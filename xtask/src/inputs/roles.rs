//! What the arguments of a `rarma` command line are: inputs to be made, files that must be
//! there afterwards, the box at the other end.

/// What stands in for a reader's own file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Input {
    /// A recording with chatter.
    Recording,
    /// The force of a hammer's blow.
    Force,
    /// What an accelerometer says to that.
    Acceleration,
    /// Receptances as a universal file.
    Receptances,
    /// Deflections under load.
    Loads,
    /// What a box sent.
    Frames,
    /// A link's key.
    Key,
    /// A mill that was tapped.
    Machine,
}

/// Commands whose first file is a recording.
const LISTENERS: [&str; 8] = [
    "monitor", "advise", "act", "target", "identify", "order", "psd", "convert",
];

/// Options that name a file or folder the command writes.
const OUTPUTS: [&str; 9] = [
    "--out",
    "--truth",
    "--save",
    "--record",
    "--uff",
    "--csv",
    "--wav",
    "--settings",
    "--report",
];

fn leading(arguments: &[String], from: usize) -> impl Iterator<Item = usize> + '_ {
    (from..arguments.len()).take_while(|k| !arguments[*k].starts_with('-'))
}

/// The place after an option, if it has a value.
fn value_of(arguments: &[String], option: &str) -> Option<usize> {
    let at = arguments.iter().position(|a| a == option)? + 1;
    arguments
        .get(at)
        .filter(|a| !a.starts_with('-'))
        .map(|_| at)
}

/// Places of the arguments that are inputs, and what they are.
pub fn inputs(arguments: &[String]) -> Vec<(usize, Input)> {
    let word = |k: usize| arguments.get(k).map_or("", String::as_str);
    let first = |from, all: &[Input]| -> Vec<(usize, Input)> {
        leading(arguments, from).zip(all.iter().copied()).collect()
    };
    let mut out = match (word(0), word(1)) {
        // Of several recordings each is one.
        ("monitor", _) => leading(arguments, 1)
            .map(|k| (k, Input::Recording))
            .collect(),
        (listener, _) if LISTENERS.contains(&listener) => first(1, &[Input::Recording]),
        ("els", "hammer") => first(2, &[Input::Force, Input::Acceleration]),
        ("els", "limit") => first(2, &[Input::Receptances]),
        ("decode", _) => first(1, &[Input::Frames]),
        _ => Vec::new(),
    };
    if (word(0), word(1)) == ("els", "fit") {
        let named = [
            ("--loads", Input::Loads),
            ("--receptance", Input::Receptances),
        ];
        let found = named.map(|(option, input)| value_of(arguments, option).map(|k| (k, input)));
        out.extend(found.into_iter().flatten());
    }
    if ["advise", "act"].contains(&word(0)) {
        out.extend(value_of(arguments, "--machine").map(|k| (k, Input::Machine)));
    }
    if ["box", "connect"].contains(&word(0)) {
        let keys = ["--key", "--set-key"].map(|option| value_of(arguments, option));
        out.extend(keys.into_iter().flatten().map(|k| (k, Input::Key)));
    }
    out
}

/// Files and folders the command says it writes; of a report its page.
pub fn outputs(arguments: &[String]) -> Vec<String> {
    let written = |option: &&str| {
        let value = &arguments[value_of(arguments, option)?];
        Some(if *option == "--report" {
            format!("{}/index.html", value.trim_end_matches('/'))
        } else {
            value.clone()
        })
    };
    // What `monitor` reads, `cers` writes.
    let cers = arguments.first().is_some_and(|word| word == "cers");
    let modes = cers.then_some("--structure");
    OUTPUTS
        .iter()
        .copied()
        .chain(modes)
        .filter_map(|option| written(&option))
        .collect()
}

/// The place of the address at which a simulated box listens.
pub fn listens(arguments: &[String]) -> Option<usize> {
    (arguments.first()? == "box").then(|| value_of(arguments, "--listen"))?
}

/// The place of the port at whose other end a box is.
pub fn port(arguments: &[String]) -> Option<usize> {
    let told = arguments.first()? == "connect" && arguments.get(1)? != "--help";
    told.then_some(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn inputs_by_their_command() {
        let found = |text| inputs(&words(text));
        assert_eq!(found("monitor my.wav --rpm 1656"), [(1, Input::Recording)]);
        assert_eq!(
            found("monitor a.wav b.wav --report out/"),
            [(1, Input::Recording), (2, Input::Recording)]
        );
        assert_eq!(
            found("els hammer f.wav a.wav --band 500:3000"),
            [(2, Input::Force), (3, Input::Acceleration)]
        );
        assert_eq!(
            found("els fit els-load-bar --unknown joint.0 --loads l.csv --receptance m.uff"),
            [(6, Input::Loads), (8, Input::Receptances)]
        );
        assert_eq!(
            found("advise my.wav --rpm 9000 --machine m.toml"),
            [(1, Input::Recording), (5, Input::Machine)]
        );
        assert_eq!(found("connect PORT --set-key a.key"), [(3, Input::Key)]);
        for none in [
            "simulate --list",
            "els model els-load-bar --uff m.uff",
            "connect PORT",
        ] {
            assert!(found(none).is_empty(), "{none}");
        }
    }

    #[test]
    fn what_must_be_there_afterwards() {
        let found = |text| outputs(&words(text));
        assert_eq!(
            found("ldbb run x --out m3/ --report page/"),
            ["m3/", "page/index.html"]
        );
        assert_eq!(found("cers analyse a/ --structure m/"), ["m/"]);
        assert!(found("monitor a.wav --structure m.json").is_empty());
        assert!(found("box --settings --json").is_empty());
        assert!(found("connect PORT --settings").is_empty());
        assert_eq!(found("choose-order x --settings box.json"), ["box.json"]);
    }

    #[test]
    fn both_ends_of_a_link() {
        assert_eq!(
            listens(&words("box --sim a --listen 127.0.0.1:7000")),
            Some(4)
        );
        assert_eq!(listens(&words("box --sim a")), None);
        assert_eq!(port(&words("connect PORT --say status")), Some(1));
        assert_eq!(port(&words("box --list")), None);
    }
}
