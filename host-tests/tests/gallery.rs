//! Promise: no command that draws is missing from the gallery.

use rarma_cli::args::Cli;
use xtask::gallery::list::{ALIKE, SHOWN};

/// Names of the commands that take `--report`, as one types them.
fn drawing(command: &clap::Command, above: &str, out: &mut Vec<String>) {
    for sub in command.get_subcommands() {
        let name = format!("{above}{}", sub.get_name());
        drawing(sub, &format!("{name} "), out);
        if sub.get_arguments().any(|a| a.get_long() == Some("report")) {
            out.push(name);
        }
    }
}

#[test]
fn every_command_that_draws_is_shown() {
    let mut commands = Vec::new();
    drawing(&Cli::command_line(), "", &mut commands);
    assert!(commands.len() > 12, "{commands:?}");
    for name in &commands {
        let alike = ALIKE.iter().find(|(alike, _)| alike == name);
        let shown = alike.map_or(name.as_str(), |(_, other)| other);
        let line = format!("rarma {shown} ");
        assert!(
            SHOWN.iter().any(|one| one.line.starts_with(&line)),
            "`{name}` takes --report and is not in xtask/src/gallery/list.rs"
        );
    }
    for (name, _) in ALIKE {
        assert!(commands.iter().any(|c| c == name), "`{name}` draws nothing");
    }
}

#[test]
fn every_line_of_the_gallery_is_one_that_the_program_takes() {
    for line in SHOWN.iter().flat_map(|one| one.lines()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let Err(why) = Cli::read(&words) {
            panic!("{line}: {why}");
        }
    }
}
