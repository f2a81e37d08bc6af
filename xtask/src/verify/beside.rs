//! Checks that stand on their own, in a process of their own beside the others, of a lower priority: they get what the
//! others leave of the cores and a fifth besides, and what is played in real time does not wait for them.
//!
//! What they print goes to a file, and comes out in one piece when they have ended.

use std::fs::{self, File};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

use super::Request;
use super::summary::{Entry, Outcome};
use crate::{Failure, Result, Workspace, process};

/// In this order: those first that build in folders of their own, or what the host tests want as well; what builds in the
/// folder of the firmware when its images are made. None is played in real time.
pub(super) const CHECKS: [&str; 12] = [
    "licences and sources",
    "packed crates",
    "python",
    "book",
    "fuzzing",
    "Pico image",
    "example on embassy",
    "rooms without std",
    "counting plugin",
    "instruction counts",
    "on-target tests",
    BOARD_FIGURES,
];
const BOARD_FIGURES: &str = "board figures";
/// What they are read of; it is there by then.
const BOARD_IMAGE: &str = "board image";

/// A quarter of the weight of the others. At the lowest it is a seventieth: an emulated chip or a case of fuzzing would
/// seem to hang.
const NICENESS: &str = "6";

/// They are running.
#[derive(Debug)]
pub(super) struct Beside {
    child: Child,
    log: PathBuf,
}

impl Beside {
    /// Begins them as `request` asks.
    ///
    /// # Errors
    /// The program cannot be started, or its log not be written.
    pub(super) fn begin(workspace: &Workspace, request: &Request) -> Result<Self> {
        let log = workspace.target_dir().join("verify-beside.log");
        let cannot = |why| Failure::new(format!("cannot write {}", log.display())).because(why);
        fs::create_dir_all(workspace.target_dir()).map_err(cannot)?;
        let out = File::create(&log).map_err(cannot)?;
        let err = out.try_clone().map_err(cannot)?;
        let itself = std::env::current_exe()
            .map_err(|why| Failure::new("cannot find this program").because(why))?;
        let mut command = match process::find_program("nice") {
            Some(nice) => {
                let mut command = Command::new(nice);
                command.args(["-n", NICENESS]).arg(&itself);
                command
            }
            None => Command::new(&itself),
        };
        command.arg("verify");
        if request.ci {
            command.arg("--ci");
        }
        for check in CHECKS {
            if check == BOARD_FIGURES {
                command.args(["--only", BOARD_IMAGE]);
            }
            command.args(["--only", check]);
        }
        command.current_dir(workspace.root());
        command.stdin(Stdio::null()).stdout(out).stderr(err);
        let child = command
            .spawn()
            .map_err(|why| process::cannot_start(&command, &why))?;
        Ok(Self { child, log })
    }

    /// Waits for their end; what they printed, and how each of them ended.
    pub(super) fn end(mut self) -> (String, Vec<Entry>) {
        let ended = match self.child.wait() {
            Ok(status) => status.to_string(),
            Err(why) => why.to_string(),
        };
        let said = fs::read(&self.log).unwrap_or_default();
        let said = String::from_utf8_lossy(&said).into_owned();
        let entries = CHECKS.map(|name| {
            said.lines()
                .find_map(|line| Entry::of_line(name, line))
                .unwrap_or_else(|| Entry {
                    name,
                    outcome: Outcome::Failed(format!("it ended before it came to this: {ended}")),
                    seconds: 0.0,
                })
        });
        (said, entries.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::stages;

    #[test]
    fn every_one_is_a_check() {
        for name in CHECKS.into_iter().chain([BOARD_IMAGE]) {
            assert!(
                stages::ALL.iter().any(|(known, _)| *known == name),
                "{name}"
            );
        }
    }

    #[test]
    fn what_did_not_end_has_failed() {
        let log = std::env::temp_dir().join(format!("beside-{}", std::process::id()));
        let said = "==> python\n<== licences and sources (12 s): passed: all\n<== packed crates (3 s): FAILED: one\nmore\n";
        fs::write(&log, said).expect("written");
        let child = Command::new("false").spawn().expect("begun");
        let (printed, entries) = Beside {
            child,
            log: log.clone(),
        }
        .end();
        fs::remove_file(log).expect("removed");
        assert_eq!(printed, said);
        let ended: Vec<_> = entries.iter().map(|e| (&e.outcome, e.seconds)).collect();
        assert_eq!(ended[0], (&Outcome::Passed("all".into()), 12.0));
        assert_eq!(ended[1], (&Outcome::Failed("one".into()), 3.0));
        assert!(
            entries[2..].iter().all(
                |e| matches!(&e.outcome, Outcome::Failed(why) if why.contains("exit status: 1"))
            )
        );
    }
}
