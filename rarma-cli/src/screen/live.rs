//! The thread that draws, and what listening tells it.
//!
//! Who listens changes the model under a lock and goes on; the thread copies the model and draws
//! the copy. A terminal that takes its time holds up nothing but the picture.

use super::keys::{Act, Ui, press};
use super::model::{Kind, Model};
use super::spectrum::Spectra;
use super::terminal::{Taken, end_at_once, restore};
use super::view::{self, Look, Palette};
use crate::args::ScreenArg;
use crate::collect::News;
use crate::failure::Failure;
use crate::output::{failed, is_quiet};
use crate::signals::INTERRUPTED;
use rarma_box::wire::Telemetry;
use ratatui::crossterm::event::{self, Event};
use std::fs::File;
use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// The picture is drawn this often,
const REDRAW: Duration = Duration::from_millis(100);
/// and so long after a key at the earliest: 20 times a second at most.
const SOON: Duration = Duration::from_millis(50);
/// The drawing thread is waited for so long at the end: who reads the keys for us never comes back from a
/// terminal that has hung up, as when a line to a far machine breaks.
const LAST: Duration = Duration::from_secs(2);

/// What brings a program to its end in order.
pub(crate) type Leave = Box<dyn Fn() + Send>;

/// A screen that is up.
pub(crate) struct Screen {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

struct Shared {
    heard: Mutex<Heard>,
    closing: AtomicBool,
}

struct Heard {
    model: Model,
    spectra: Option<Spectra>,
    /// When something came last.
    came: Instant,
}

/// What is listened to.
pub(crate) struct Sound {
    /// Its name.
    pub title: String,
    /// Sampling rate, Hz.
    pub fs: f64,
    /// Band that is analysed, Hz.
    pub band_hz: (f64, f64),
    /// Damping ratio below which a mode counts as undamped.
    pub threshold: f64,
}

/// Whether a screen is wanted and can be; `piped`: standard input is the sound, and keys come from
/// the terminal itself.
///
/// # Errors
/// It is asked for where it cannot be.
pub(crate) fn wanted(asked: Option<ScreenArg>, json: bool, piped: bool) -> Result<bool, Failure> {
    let asked = asked.unwrap_or(ScreenArg::Auto);
    if asked == ScreenArg::Off {
        return Ok(false);
    }
    let dumb = match std::env::var("TERM") {
        Ok(term) => term == "dumb" || term.is_empty(),
        Err(_) => cfg!(unix),
    };
    let keys = if piped {
        File::open("/dev/tty").is_ok()
    } else {
        io::stdin().is_terminal()
    };
    let why_not = [
        (json, "--json is asked for, too", "leave one of them out"),
        (
            !io::stdout().is_terminal(),
            "standard output is no terminal",
            "leave it out, or do not redirect the output",
        ),
        (
            !keys,
            "there is no terminal to take keys from",
            "leave it out, or start it in a terminal",
        ),
        (
            dumb,
            "this terminal cannot be drawn on: TERM is dumb or not set",
            "leave it out, or set TERM to what the terminal is, such as xterm-256color",
        ),
    ];
    match why_not.iter().find(|(holds, ..)| *holds) {
        None => Ok(asked == ScreenArg::On || !is_quiet()),
        Some(_) if asked == ScreenArg::Auto => Ok(false),
        Some((_, why, remedy)) => Err(Failure::Usage(format!("--screen on: {why} ({remedy})"))),
    }
}

impl Screen {
    /// Of a monitor; `leave` is called when somebody wants to go.
    ///
    /// # Errors
    /// The terminal cannot be taken.
    pub(crate) fn of_sound(sound: Sound, leave: Leave) -> Result<Self, Failure> {
        let spectra = Spectra::new(sound.fs, sound.band_hz);
        let model = Model::new(sound.title, sound.band_hz, sound.threshold);
        Self::open(model, Some(spectra), Ui::default(), None, leave)
    }

    /// Of a box, to which what is typed is said.
    ///
    /// # Errors
    /// The terminal cannot be taken.
    pub(crate) fn of_box(
        title: String,
        say: SyncSender<String>,
        leave: Leave,
    ) -> Result<Self, Failure> {
        let ui = Ui::with_input();
        Self::open(Model::of_a_box(title), None, ui, Some(say), leave)
    }

    fn open(
        model: Model,
        spectra: Option<Spectra>,
        ui: Ui,
        say: Option<SyncSender<String>>,
        leave: Leave,
    ) -> Result<Self, Failure> {
        let shared = Arc::new(Shared {
            heard: Mutex::new(Heard {
                model,
                spectra,
                came: Instant::now(),
            }),
            closing: AtomicBool::new(false),
        });
        let terminal = Taken::take()?;
        let drawer = Drawer {
            shared: Arc::clone(&shared),
            terminal,
            ui,
            palette: Palette::of_this_terminal(),
            say,
            leave: Leaving { leave, left: false },
        };
        let thread = thread::Builder::new().name("screen".to_owned());
        let thread = thread.spawn(move || drawer.run());
        Ok(Self {
            shared,
            thread: Some(thread.map_err(|why| failed("terminal", "draw", &why))?),
        })
    }

    fn heard(&self) -> MutexGuard<'_, Heard> {
        self.shared.heard()
    }

    /// Samples have come.
    pub(crate) fn samples(&self, samples: &[f64]) {
        let Heard {
            model,
            spectra,
            came,
        } = &mut *self.heard();
        *came = Instant::now();
        if let Some(spectra) = spectra {
            spectra.take(samples, |row, rms| model.row(row, rms));
        }
    }

    /// The monitor has said something.
    pub(crate) fn news(&self, news: &News) {
        self.heard().model.news(news);
    }

    /// What to do about the last alarm.
    pub(crate) fn advice(&self, advice: Vec<String>) {
        self.heard().model.advice = advice;
    }

    /// A box has said something; `own`: it answers what nobody has typed.
    pub(crate) fn message(&self, message: &Telemetry, own: bool) {
        let heard = &mut *self.heard();
        heard.came = Instant::now();
        if let Telemetry::Raw(raw) = message {
            let (fs, band_hz) = (heard.model.fs(), heard.model.band_hz);
            let spectra = heard
                .spectra
                .get_or_insert_with(|| Spectra::new(fs, band_hz));
            let samples: Vec<f64> = raw.samples().map(f64::from).collect();
            spectra.take(&samples, |row, _| heard.model.spectrum_row(row));
        }
        heard.model.message(message, own);
    }

    /// Frames of a box so far, and what was lost of them.
    pub(crate) fn frames(&self, whole: u64, losses: Option<String>) {
        self.heard().model.frames(whole, losses);
    }

    /// Something to be told.
    pub(crate) fn event(&self, text: String) {
        self.heard().model.log(None, Kind::Answer, text);
    }

    /// Gives the terminal back.
    ///
    /// # Errors
    /// It could not be drawn on to the end.
    pub(crate) fn close(mut self) -> Result<(), Failure> {
        match self.join() {
            Some(Ok(Err(why))) => Err(failed("terminal", "draw", &why).into()),
            Some(Err(_)) => Err(Failure::System(
                "the screen has failed: a defect of this program (--screen off does without it)"
                    .to_owned(),
            )),
            Some(Ok(Ok(()))) | None => Ok(()),
        }
    }

    fn join(&mut self) -> Option<thread::Result<io::Result<()>>> {
        self.shared.closing.store(true, Ordering::Relaxed);
        let thread = self.thread.take()?;
        let asked = Instant::now();
        while !thread.is_finished() {
            if asked.elapsed() > LAST {
                restore();
                return None;
            }
            thread::sleep(Duration::from_millis(5));
        }
        Some(thread.join())
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // What went wrong with the picture is told by `close`; here there is a greater trouble.
        let _ = self.join();
    }
}

impl Shared {
    fn heard(&self) -> MutexGuard<'_, Heard> {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Whatever ends the thread, the program ends in order.
struct Leaving {
    leave: Leave,
    left: bool,
}

impl Leaving {
    fn leave(&mut self) {
        if self.left {
            end_at_once(INTERRUPTED);
        }
        self.left = true;
        (self.leave)();
    }
}

impl Drop for Leaving {
    fn drop(&mut self) {
        (self.leave)();
    }
}

struct Drawer {
    shared: Arc<Shared>,
    terminal: Taken,
    ui: Ui,
    palette: Palette,
    say: Option<SyncSender<String>>,
    leave: Leaving,
}

impl Drawer {
    fn run(mut self) -> io::Result<()> {
        let mut model = self.shared.heard().model.clone();
        let mut drawn: Option<Instant> = None;
        let mut pressed = false;
        while !self.shared.closing.load(Ordering::Relaxed) {
            let due = if pressed { SOON } else { REDRAW };
            let wait = drawn.map_or(Duration::ZERO, |at| due.saturating_sub(at.elapsed()));
            if event::poll(wait.min(SOON))? {
                let event = event::read()?;
                pressed = true;
                self.take(&event)?;
                continue;
            }
            if drawn.is_some_and(|at| at.elapsed() < due) {
                continue;
            }
            let silent_s = {
                let heard = &mut *self.shared.heard();
                heard.model.take_aside();
                if !self.ui.paused {
                    model.clone_from(&heard.model);
                }
                heard.came.elapsed().as_secs_f64()
            };
            let (ui, palette) = (&self.ui, self.palette);
            let look = Look { palette, silent_s };
            self.terminal
                .draw(|area, buffer| view::draw(&model, ui, look, area, buffer))?;
            (drawn, pressed) = (Some(Instant::now()), false);
        }
        Ok(())
    }

    fn take(&mut self, event: &Event) -> io::Result<()> {
        let Event::Key(key) = event else {
            return Ok(());
        };
        match press(&mut self.ui, *key) {
            Act::Draw => {}
            Act::Leave => self.leave.leave(),
            Act::Anew => self.terminal.forget()?,
            Act::Say(line) => {
                let mut heard = self.shared.heard();
                heard.model.log(None, Kind::Said, line.clone());
                let full = self
                    .say
                    .as_ref()
                    .is_some_and(|say| say.try_send(line).is_err());
                if full {
                    let text = "not said: too much was typed at once; say it again".to_owned();
                    heard.model.log(None, Kind::Notice, text);
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::env;
    use xtask::process::find_program;
    use xtask::tmux::Terminal;

    /// Set, the first test panics.
    const PANICS: &str = "RARMA_PANICS_WITH_A_SCREEN_UP";
    const PATIENCE: Duration = Duration::from_secs(30);

    /// Nothing, but for the other test.
    #[test]
    fn a_program_that_panics() {
        if env::var_os(PANICS).is_none() {
            return;
        }
        let sound = Sound {
            title: "a defect".to_owned(),
            fs: 8000.0,
            band_hz: (300.0, 2500.0),
            threshold: 0.01,
        };
        let _screen = Screen::of_sound(sound, Box::new(|| {})).expect("a terminal");
        thread::sleep(Duration::from_millis(500));
        panic!("a defect, on purpose");
    }

    #[test]
    fn a_panic_gives_the_terminal_back_and_can_be_read() {
        if find_program("tmux").is_none() {
            let required = env::var("RARMA_REQUIRE_TMUX").is_ok_and(|value| value == "1");
            assert!(!required, "no tmux, and skipping is not allowed here");
            std::eprintln!("SKIPPED: a panic with a screen up: no tmux on this machine");
            return;
        }
        let terminal = Terminal::open((80, 24)).expect("a terminal");
        let me = env::current_exe().expect("its name");
        let line = format!(
            "m=$(stty -g); RUST_BACKTRACE=0 {PANICS}=1 '{}' --nocapture --exact screen::live::tests::a_program_that_panics; [ \"$m\" = \"$(stty -g)\" ] && echo modes'=same'",
            me.display()
        );
        terminal.enter(&line).expect("typed");
        terminal.wait_for("starting", PATIENCE).expect("a screen");
        terminal.wait_for("modes=same", PATIENCE).expect("an end");
        let seen = terminal.all_seen().expect("there");
        assert!(seen.contains("a defect, on purpose"), "{seen}");
        assert!(terminal.is_for_lines().expect("there"), "{seen}");
    }
}
