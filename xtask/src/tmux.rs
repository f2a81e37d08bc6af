//! A terminal that programs draw on and nobody sees: `tmux`, without its status line and without the
//! user's settings.

use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::toolchain::packages;
use crate::{Failure, Result, process};

const PROGRAM: &str = "tmux";
/// What is seen is looked at this often while something is waited for.
const LOOK: Duration = Duration::from_millis(50);

static COUNT: AtomicU32 = AtomicU32::new(0);

/// Makes sure that there is one.
///
/// # Errors
/// It is not here, and may not be installed.
pub fn ensure() -> Result<()> {
    if process::find_program(PROGRAM).is_some() {
        return Ok(());
    }
    packages::install(&[PROGRAM]).map_err(|failure| {
        Failure::new(format!("no {PROGRAM} on this machine"))
            .because(&failure)
            .advise("install it with your package manager; only the live screen is seen by it")
    })
}

/// One terminal.
#[derive(Debug)]
pub struct Terminal {
    /// The name of its server, which nobody else has.
    server: String,
}

impl Terminal {
    /// A terminal of so many columns and rows, with a shell in it.
    ///
    /// # Errors
    /// It does not start.
    pub fn open((columns, rows): (u16, u16)) -> Result<Self> {
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let terminal = Self {
            server: format!("rarma-{}-{count}", std::process::id()),
        };
        let (columns, rows) = (columns.to_string(), rows.to_string());
        // Set before the first terminal is made; `;` parts commands.
        #[rustfmt::skip]
        let begin = [
            "start-server", ";",
            "set-option", "-g", "default-terminal", "tmux-256color", ";",
            "set-option", "-g", "status", "off", ";",
            "set-option", "-g", "history-limit", "5000", ";",
            "new-session", "-d", "-x", &columns, "-y", &rows, "env PS1='$ ' sh",
        ];
        terminal.say(&begin)?;
        Ok(terminal)
    }

    fn command(&self) -> Command {
        let mut command = Command::new(PROGRAM);
        command.args(["-L", &self.server, "-f", "/dev/null", "-u"]);
        // One that runs inside another is none of that one's.
        command.env_remove("TMUX");
        command
    }

    fn say(&self, words: &[&str]) -> Result<String> {
        process::output(self.command().args(words))
    }

    /// Types a text and Enter.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn enter(&self, text: &str) -> Result<()> {
        self.say(&["send-keys", "-l", text])?;
        self.press(&["Enter"])
    }

    /// Presses keys by their names, such as `Tab`, `C-c`, `PPage`, `q`.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn press(&self, keys: &[&str]) -> Result<()> {
        self.say(&[&["send-keys"], keys].concat()).map(drop)
    }

    /// Makes it larger or smaller.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn resize(&self, (columns, rows): (u16, u16)) -> Result<()> {
        let (columns, rows) = (columns.to_string(), rows.to_string());
        self.say(&["resize-window", "-x", &columns, "-y", &rows])
            .map(drop)
    }

    /// What is on it, row by row.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn seen(&self) -> Result<String> {
        self.say(&["capture-pane", "-p"])
    }

    /// The same with its colours, as escape codes.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn coloured(&self) -> Result<String> {
        self.say(&["capture-pane", "-p", "-e", "-N"])
    }

    /// Whether it is as it is for lines: the cursor is to be seen, and no program has the screen.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn is_for_lines(&self) -> Result<bool> {
        let flags = self.say(&["display-message", "-p", "#{cursor_flag} #{alternate_on}"])?;
        Ok(flags.trim() == "1 0")
    }

    /// What is on it, and what has gone off at its top.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn all_seen(&self) -> Result<String> {
        self.say(&["capture-pane", "-p", "-J", "-S", "-"])
    }

    /// Waits until a text is to be seen.
    ///
    /// # Errors
    /// It is not, after `patience`; with what is.
    pub fn wait_for(&self, text: &str, patience: Duration) -> Result<String> {
        self.wait_until(patience, text, |seen| seen.contains(text))
    }

    /// Waits until what is seen is as it should be.
    ///
    /// # Errors
    /// It is not, after `patience`; with what is.
    pub fn wait_until(
        &self,
        patience: Duration,
        what: &str,
        is: impl Fn(&str) -> bool,
    ) -> Result<String> {
        let begun = Instant::now();
        loop {
            let seen = self.seen()?;
            if is(&seen) {
                return Ok(seen);
            }
            if begun.elapsed() > patience {
                return Err(Failure::new(format!("not seen after {patience:?}: {what}"))
                    .because(format!("\n{seen}")));
            }
            thread::sleep(LOOK);
        }
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // A server that is gone needs no end.
        let _ = self.command().arg("kill-server").output();
    }
}
