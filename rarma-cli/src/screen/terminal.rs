//! The terminal: taken for the screen, and left as it was found, whether the program ends, fails,
//! panics, or is ended.

use crate::failure::Failure;
use crate::output::{self, aside, failed};
use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::buffer::Buffer;
use ratatui::crossterm::cursor::{Hide, Show};
use ratatui::crossterm::execute;
use ratatui::crossterm::terminal::{
    EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode,
};
use ratatui::layout::Rect;
use std::io::{self, Stdout};
use std::panic;
use std::process;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

/// A screen is up.
static UP: AtomicBool = AtomicBool::new(false);
/// A panic's words are to be read.
static BEFORE_A_PANIC: Once = Once::new();

/// Gives the terminal back, if it was taken; then what was said meanwhile is written. May be
/// called by anybody at any time, also twice.
pub(super) fn restore() {
    if UP.swap(false, Ordering::SeqCst) {
        // A terminal that is gone needs nothing back.
        let _ = execute!(io::stdout(), LeaveAlternateScreen, Show);
        let _ = disable_raw_mode();
        output::end_aside();
    }
}

/// Ends the program at once, its terminal as it was found.
pub(crate) fn end_at_once(code: i32) -> ! {
    restore();
    process::exit(code);
}

/// The terminal while it is the screen's.
pub(super) struct Taken {
    terminal: Terminal<CrosstermBackend<Stdout>>,
}

impl Taken {
    /// Takes it.
    ///
    /// # Errors
    /// It cannot be drawn on; it is as it was.
    pub(super) fn take() -> Result<Self, Failure> {
        BEFORE_A_PANIC.call_once(|| {
            let before = panic::take_hook();
            panic::set_hook(Box::new(move |what| {
                restore();
                before(what);
            }));
        });
        UP.store(true, Ordering::SeqCst);
        aside::begin();
        let taken = enable_raw_mode()
            .and_then(|()| execute!(io::stdout(), EnterAlternateScreen, Hide))
            .and_then(|()| Terminal::new(CrosstermBackend::new(io::stdout())));
        taken.map(|terminal| Self { terminal }).map_err(|why| {
            restore();
            failed("terminal", "take", &why).into()
        })
    }

    /// Draws; `draw` says where the cursor is to stand, if anywhere.
    ///
    /// # Errors
    /// The terminal is gone.
    pub(super) fn draw(
        &mut self,
        draw: impl FnOnce(Rect, &mut Buffer) -> Option<(u16, u16)>,
    ) -> io::Result<()> {
        self.terminal.draw(|frame| {
            let area = frame.area();
            if let Some(place) = draw(area, frame.buffer_mut()) {
                frame.set_cursor_position(place);
            }
        })?;
        Ok(())
    }

    /// All of it is drawn anew the next time.
    ///
    /// # Errors
    /// The terminal is gone.
    pub(super) fn forget(&mut self) -> io::Result<()> {
        self.terminal.clear()
    }
}

impl Drop for Taken {
    fn drop(&mut self) {
        restore();
    }
}
