//! Words: commands as they are typed, and options of the command line.

use crate::{Target, check};
use clap::Parser;
use rarma_box::settings::SETTINGS;
use rarma_box::wire::Command;
use rarma_cli::args::Cli;
use rarma_scenarios::speech;

pub(super) const WORDS: Target = Target {
    name: "words",
    reads: "command words, values of settings, options",
    run: |bytes| {
        let Ok(text) = std::str::from_utf8(bytes) else {
            return;
        };
        for line in text.lines() {
            said_line(line);
        }
        for setting in &SETTINGS {
            match speech::value(setting, text) {
                // What it takes it shows so that it is taken again.
                Ok(value) => {
                    let again = speech::value(setting, &speech::shown(value));
                    let shown = again.map(speech::shown);
                    assert_eq!(shown, Ok(speech::shown(value)), "{}", setting.name);
                }
                Err(why) => check::words(&why),
            }
        }
        let options = std::iter::once("rarma").chain(text.split_whitespace());
        if let Err(why) = Cli::try_parse_from(options) {
            assert!(!why.to_string().is_empty());
        }
    },
    words: || {
        let mut all = said();
        all.extend(options());
        all
    },
};

/// A command that is said is carried whole over the wire, and read the same.
fn said_line(line: &str) {
    match speech::command(line) {
        Ok(command) => super::link::there_and_back::<Command>(&command),
        Err(why) => check::words(&why),
    }
}

/// What can be said to a box.
pub(super) fn said() -> Vec<String> {
    let words = speech::WORDS.split(|c: char| !c.is_ascii_lowercase());
    let names = SETTINGS.iter().map(|s| s.name);
    words.chain(names).map(|word| format!("{word} ")).collect()
}

/// Commands and options of the program.
fn options() -> Vec<String> {
    fn of(command: &clap::Command, out: &mut Vec<String>) {
        out.push(format!("{} ", command.get_name()));
        for argument in command.get_arguments() {
            out.extend(argument.get_long().map(|long| format!("--{long} ")));
            let values = argument.get_possible_values();
            out.extend(values.iter().map(|value| format!("{} ", value.get_name())));
        }
        command.get_subcommands().for_each(|inner| of(inner, out));
    }
    let mut out = Vec::new();
    of(&<Cli as clap::CommandFactory>::command(), &mut out);
    out
}
