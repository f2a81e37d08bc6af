//! Two or three lines to copy under the help of each command.

use clap::Command;

/// What a line does, and the line.
type Example = (&'static str, &'static str);

/// Examples by command; a command of a command stands behind it.
const EXAMPLES: &[(&[&str], &[Example])] = &[
    (
        &["monitor"],
        &[
            (
                "A recording whose speed and teeth are known, with a page of pictures",
                "rarma monitor cut.wav --rpm 1656 --teeth 6 --report page/",
            ),
            (
                "Seconds 7 to 18 of it closely, with what is to be remembered",
                "rarma monitor cut.wav --rpm 1656 --report close/ --window 7:18 --note machine=M3",
            ),
            (
                "Two recordings, a page of each and one that compares them",
                "rarma monitor before.wav after.wav --rpm 1656 --teeth 6 --report page/",
            ),
            (
                "What a phone has recorded, one JSON object a line",
                "rarma monitor cut.m4a --rpm 12000 --teeth 2 --json",
            ),
            (
                "What LabVIEW has logged, its second channel",
                "rarma monitor run.tdms --channel 1 --rpm 1656 --teeth 6",
            ),
            (
                "What another program plays or records: ffmpeg -i cut.mkv -f wav -, or arecord -f S16_LE -r 48000 -t wav",
                "rarma monitor - --rpm 1656 --teeth 6",
            ),
            (
                "Raw samples from a microphone that another program reads",
                "rarma monitor - --raw s16 --fs 48000 --rpm 1656",
            ),
        ],
    ),
    (
        &["listen"],
        &[
            ("The inputs there are", "rarma listen --list"),
            (
                "What is heard is kept, too",
                "rarma listen --rpm 12000 --teeth 2 --record heard.wav",
            ),
        ],
    ),
    (
        &["target"],
        &[(
            "The same sound through the firmware, instruction by instruction",
            "rarma target cut.wav --rpm 1656 --teeth 6",
        )],
    ),
    (
        &["advise"],
        &[
            (
                "The speed may be turned from 80 to 120 %",
                "rarma advise cut.wav --rpm 12000 --teeth 2 --reach 80:120",
            ),
            (
                "The structure's modes are known from a hammer test",
                "rarma advise cut.wav --rpm 12000 --teeth 2 --structure modes.json",
            ),
            (
                "The machine is known: its modes with stiffness and direction, the cutter, the depth",
                "rarma advise cut.wav --rpm 12000 --teeth 2 --machine mill.toml",
            ),
            (
                "What came of other cuts with this tool counts, and this one is added to them",
                "rarma advise cut.wav --rpm 12000 --teeth 2 --known cuts.csv --depth-mm 2 --remember",
            ),
        ],
    ),
    (
        &["act"],
        &[
            (
                "Orders nothing: says what it would order of a spindle that chatters",
                "rarma act cut.wav --rpm 12000 --teeth 2 --controller dry --override 80:120",
            ),
            (
                "Live sound, and LinuxCNC may be told 80 to 120 % of the programmed speed",
                "rarma act - --raw f32 --fs 48000 --teeth 3 --controller linuxcnc --act --override 80:120",
            ),
        ],
    ),
    (
        &["identify"],
        &[
            (
                "Frequency and damping, with their deviations, of two modes",
                "rarma identify cut.wav --order 4,3 --band 300:2500",
            ),
            (
                "What `monitor --structure` reads",
                "rarma identify hammer.wav --order 6,5 --json",
            ),
            (
                "The same beside other orders and methods, in pictures",
                "rarma identify cut.wav --order 8,7 --report page/",
            ),
            (
                "Modes and their shapes from all sensors of a file",
                "rarma identify beam.csv --channels all --order 6,0",
            ),
        ],
    ),
    (
        &["order"],
        &[(
            "How many poles this recording needs",
            "rarma order cut.wav --band 300:2500 --report page/",
        )],
    ),
    (
        &["psd"],
        &[(
            "A spectrum by Welch's method",
            "rarma psd cut.wav --method welch",
        )],
    ),
    (
        &["convert"],
        &[
            (
                "All channels of a recording for MATLAB, Octave or scipy",
                "rarma convert cut.wav --out cut.mat",
            ),
            (
                "An accelerometer's as a universal file",
                "rarma convert cut.csv --unit m/s^2 --out cut.uff",
            ),
        ],
    ),
    (
        &["lobes"],
        &[(
            "Two machines in one diagram",
            "rarma lobes two-tooth-benchmark two-tooth-up --rpm 5000:25000 --max-depth-mm 3 --report page/",
        )],
    ),
    (
        &["simulate"],
        &[
            (
                "A cut that chatters, and what is true of it",
                "rarma simulate three-mode-chatter --out cut.wav --truth cut.json",
            ),
            ("The shipped scenarios", "rarma simulate --list"),
        ],
    ),
    (
        &["choose-order"],
        &[(
            "And the settings for a box",
            "rarma choose-order spindle-10000 --settings box.json",
        )],
    ),
    (
        &["sweep"],
        &[(
            "True damping and what is read, over depth",
            "rarma sweep turning-980 --rpm 12000,1500 --depth-mm 0.02:0.6 --report page/",
        )],
    ),
    (
        &["population"],
        &[(
            "A hundred machines, their speed told within 1 % and not told",
            "rarma population --seeds 0:100 --told 1,none --report page/",
        )],
    ),
    (
        &["els", "model"],
        &[(
            "A shipped system",
            "rarma els model els-load-bar --report page/",
        )],
    ),
    (
        &["els", "limit"],
        &[(
            "Receptances from a file, the chip at 60°",
            "rarma els limit machine.uff --chip-angle 60 --static 30:250 --report page/",
        )],
    ),
    (
        &["els", "hammer"],
        &[(
            "A hammer's force and what an accelerometer answered",
            "rarma els hammer force.wav response.wav --band 500:3000 --report page/",
        )],
    ),
    (
        &["els", "fit"],
        &[(
            "Two stiffnesses of a joint, from load steps and receptances",
            "rarma els fit els-load-bar --unknown joint.0,joint.0.tilt --loads loads.csv --receptance machine.uff",
        )],
    ),
    (
        &["ldbb", "run"],
        &[(
            "A whole test, its readings and its page",
            "rarma ldbb run ldbb-m3 --out m3/ --report page/",
        )],
    ),
    (
        &["ldbb", "analyse"],
        &[(
            "Readings that were taken before, judged by a tolerance of 10 µm",
            "rarma ldbb analyse m3/ --tolerance 10 --report page/",
        )],
    ),
    (
        &["ldbb", "compare"],
        &[(
            "Two machines side by side",
            "rarma ldbb compare m3/ m5/ --report page/",
        )],
    ),
    (
        &["cers", "run"],
        &[(
            "A measurement at rest, its record kept",
            "rarma cers run cers-rest --report page/ --out rest/",
        )],
    ),
    (
        &["cers", "analyse"],
        &[(
            "A record to responses for other programs",
            "rarma cers analyse rest/ --uff rest.uff --csv rest.csv",
        )],
    ),
    (
        &["box"],
        &[
            (
                "A cut that the whole firmware listens to",
                "rarma box --sim chatter-onset",
            ),
            (
                "A box on a socket, in real time, for `rarma connect`",
                "rarma box --sim box-ldbb-leak --listen 127.0.0.1:7000",
            ),
        ],
    ),
    (
        &["decode"],
        &[(
            "A record of a box; its raw samples to a file",
            "rarma decode box.frames --wav heard.wav",
        )],
    ),
    (
        &["connect"],
        &[
            ("A box at the serial port", "rarma connect /dev/ttyACM0"),
            (
                "A box on the network, everything it says kept",
                "rarma connect tcp:192.168.0.7:7000 --record box.frames",
            ),
        ],
    ),
    (
        &["gateway"],
        &[
            (
                "Is the file right, and all that it names there?",
                "rarma gateway plant.toml --check",
            ),
            (
                "Boxes to the plant's broker, until Ctrl-C",
                "rarma gateway plant.toml",
            ),
        ],
    ),
    (
        &["store", "add"],
        &[
            (
                "Records as they come, each once",
                "rarma store add records.jsonl --store plant.db",
            ),
            (
                "What a test with the ball bar printed",
                "rarma store add m3.json --machine M3 --time 2026-03-01T12:00:00Z --store plant.db",
            ),
        ],
    ),
    (
        &["store", "receive"],
        &[(
            "What all gateways of the plant send",
            "rarma store receive store.toml --store plant.db",
        )],
    ),
    (
        &["store", "show"],
        &[("Kinds and machines", "rarma store show --store plant.db")],
    ),
    (
        &["store", "ask"],
        &[
            (
                "Alarms of March by tool",
                "rarma store ask alarms --by tool --from 2026-03 --to 2026-03 --store plant.db",
            ),
            (
                "How often advice helped, for another program",
                "rarma store ask advice --csv advice.csv --store plant.db",
            ),
            (
                "Every capability over time, for pandas or DuckDB",
                "rarma store ask readings --parquet readings.parquet --store plant.db",
            ),
        ],
    ),
    (
        &["store", "export"],
        &[(
            "Into another store",
            "rarma store export --store plant.db --out all.jsonl",
        )],
    ),
    (
        &["store", "thin"],
        &[(
            "Keep verdicts from March on",
            "rarma store thin --before 2026-03-01 --store plant.db",
        )],
    ),
    (
        &["trends"],
        &[(
            "What has changed, with pictures",
            "rarma trends --store plant.db --report page/",
        )],
    ),
    (
        &["plant"],
        &[(
            "A year of fifty machines",
            "rarma plant --machines 50 --months 12 --seed 1 --out plant/",
        )],
    ),
    (&["demo"], &[("Another virtual cut", "rarma demo --seed 7")]),
    (
        &["completions"],
        &[(
            "For bash, for this user",
            "rarma completions bash > ~/.local/share/bash-completion/completions/rarma",
        )],
    ),
    (
        &["man"],
        &[(
            "All pages, for this user",
            "rarma man --out ~/.local/share/man/man1",
        )],
    ),
];

/// Of these the whole program's help shows the first example.
const FIRST: [&str; 4] = ["demo", "monitor", "listen", "connect"];

/// A command line with its examples: a command has its own, a group of commands the first of each of them.
pub(super) fn with_examples(mut command: Command) -> Command {
    for (path, examples) in EXAMPLES {
        command = put(command, path, &told(examples));
        if let [group, _] = path {
            command = put(command, &[group], &told(&first(|of| of[0] == *group)));
        }
    }
    let examples = told(&first(|of| FIRST.contains(&of[0])));
    let rest = command.get_after_help().map(ToString::to_string);
    command.after_help(examples + "\n\n" + &rest.unwrap_or_default())
}

/// The first example of each command that is asked for.
fn first(asked: impl Fn(&[&str]) -> bool) -> Vec<Example> {
    let of = EXAMPLES.iter().filter(|(path, _)| asked(path));
    of.filter_map(|(_, examples)| examples.first().copied())
        .collect()
}

fn put(command: Command, path: &[&'static str], text: &str) -> Command {
    match path.split_first() {
        Some((name, rest)) => command.mut_subcommand(name, |sub| put(sub, rest, text)),
        None => command.after_help(text.to_owned()),
    }
}

fn told(examples: &[Example]) -> String {
    let mut text = "Examples:".to_owned();
    for (what, line) in examples {
        text += &format!("\n  {what}:\n    {line}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::Cli;
    use super::EXAMPLES;

    #[test]
    fn every_command_has_examples_that_it_takes() {
        let mut leaves = Vec::new();
        collect(&Cli::command_line(), &mut Vec::new(), &mut leaves);
        assert!(leaves.len() > 20, "{leaves:?}");
        for leaf in &leaves {
            let has = EXAMPLES.iter().any(|(path, _)| path == leaf);
            assert!(has, "no example for `{}`", leaf.join(" "));
        }
        assert_eq!(leaves.len(), EXAMPLES.len());
        for (path, examples) in EXAMPLES {
            for (_, line) in *examples {
                let words = line.split(" > ").next().expect("a first part");
                let words: Vec<&str> = words.split_whitespace().collect();
                assert_eq!(words[1..=path.len()], **path, "{line}");
                if let Err(why) = Cli::read(&words) {
                    panic!("{line}: {why}");
                }
            }
        }
    }

    #[test]
    fn groups_show_the_first_example_of_each_of_their_commands() {
        let mut line = Cli::command_line();
        let whole = line.render_help().to_string();
        assert!(
            whole.contains("    rarma monitor cut.wav --rpm 1656"),
            "{whole}"
        );
        assert!(whole.contains("Exit codes: 0 done"), "{whole}");
        for group in line.get_subcommands_mut().filter(|c| c.has_subcommands()) {
            let help = group.clone().render_help().to_string();
            for sub in group.get_subcommands() {
                let begins = format!("    rarma {} {} ", group.get_name(), sub.get_name());
                assert_eq!(help.matches(&begins).count(), 1, "{help}");
            }
        }
    }

    /// Names of the commands that are no groups of others.
    fn collect(command: &clap::Command, above: &mut Vec<String>, leaves: &mut Vec<Vec<String>>) {
        for sub in command.get_subcommands() {
            above.push(sub.get_name().to_owned());
            if sub.has_subcommands() {
                collect(sub, above, leaves);
            } else {
                leaves.push(above.clone());
            }
            above.pop();
        }
    }
}
