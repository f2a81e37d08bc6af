//! Somebody who looks on while a monitor listens, and may go at any time.

use super::source::About;
use crate::args::{InputArgs, MonitorArgs, ScreenArg};
use crate::failure::Failure;
use crate::screen::{self, Leave, Screen, Sound};
use crate::signals::{self, INTERRUPTED};
use rarma_box::wire::MonitorJob;
use rarma_recordings::input::{Stall, Stream, Until};
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// A wait is cut into pieces of so long, so that somebody may go meanwhile.
const LOOK: Duration = Duration::from_millis(50);

/// A screen is wanted.
pub(super) struct Watched {
    enough: Arc<AtomicBool>,
    leave: Leave,
}

impl Watched {
    /// Of a recording or standard input, if it is to be shown. Once the program is to end, what
    /// was heard until then counts.
    ///
    /// # Errors
    /// A screen is asked for where it cannot be.
    pub(super) fn of(args: &MonitorArgs) -> Result<Option<Self>, Failure> {
        let piped = args.input.input == Path::new("-");
        // A file is over in a second: what is to be said of it stays to be read.
        if !piped && args.screen != Some(ScreenArg::On) {
            return Ok(None);
        }
        if !screen::wanted(args.screen, args.json, piped)? {
            return Ok(None);
        }
        let enough = enough()?;
        let left = Arc::clone(&enough);
        let leave = Box::new(move || left.store(true, Ordering::Relaxed));
        Ok(Some(Self { enough, leave }))
    }

    /// Of something live that knows itself how to end.
    ///
    /// # Errors
    /// A screen is asked for where it cannot be.
    pub(super) fn of_live(args: &MonitorArgs, leave: Leave) -> Result<Option<Self>, Failure> {
        let wanted = screen::wanted(args.screen, args.json, false)?;
        let enough = Arc::default();
        Ok(wanted.then_some(Self { enough, leave }))
    }

    /// A recording is listened to as slowly as it was made.
    pub(super) fn pace(&self) -> Pace {
        Pace {
            begun: Instant::now(),
            enough: Arc::clone(&self.enough),
        }
    }

    /// The screen.
    ///
    /// # Errors
    /// The terminal cannot be taken.
    pub(super) fn screen(self, about: &About, job: &MonitorJob) -> Result<Screen, Failure> {
        let (band, order) = (job.monitor.band(), job.monitor.order);
        let sound = Sound {
            title: format!(
                "{} · {} Hz · band {:.0}:{:.0} Hz · order {},{}",
                about.path.display(),
                about.fs,
                band.low_hz,
                band.high_hz,
                order.p(),
                order.q()
            ),
            fs: about.fs,
            band_hz: (band.low_hz, band.high_hz),
            threshold: job.monitor.threshold,
        };
        Screen::of_sound(sound, self.leave)
    }
}

/// Standard input, which ends when somebody goes: whoever looks on, or an interrupt. Without
/// somebody who looks on, a pipe that stalls is told of.
///
/// # Errors
/// What comes is no recording.
pub(super) fn standard_input(
    args: &InputArgs,
    watched: Option<&Watched>,
) -> Result<Stream, Failure> {
    let source = if let Some(watched) = watched {
        Until::new(io::stdin(), Arc::clone(&watched.enough))
    } else {
        Until::new(io::stdin(), enough()?).telling(tell)
    };
    Ok(Stream::piped(Box::new(source), args.known(), args.raw())?)
}

/// Set once the program is to end; told twice it ends at once.
fn enough() -> Result<Arc<AtomicBool>, Failure> {
    let enough = Arc::new(AtomicBool::new(false));
    let interrupted = Arc::clone(&enough);
    signals::on_interrupt(move || {
        if interrupted.swap(true, Ordering::Relaxed) {
            screen::end_at_once(INTERRUPTED);
        }
    })?;
    Ok(enough)
}

fn tell(stall: Stall) {
    match stall {
        Stall::Begun(pause) => eprintln!(
            "Warning: nothing has come for {} s; still waiting (does the program before the pipe run? Ctrl-C ends)",
            pause.as_secs()
        ),
        Stall::Over(pause) => eprintln!(
            "Warning: samples come again, after {:.1} s",
            pause.as_secs_f64()
        ),
    }
}

/// The clock beside a recording.
pub(super) struct Pace {
    begun: Instant,
    enough: Arc<AtomicBool>,
}

impl Pace {
    /// Waits until the clock has come to a time of the recording, s; false: it is enough.
    pub(super) fn keep(&self, t_s: f64) -> bool {
        let until = self.begun + Duration::from_secs_f64(t_s);
        while !self.enough.load(Ordering::Relaxed) {
            let ahead = until.saturating_duration_since(Instant::now());
            if ahead.is_zero() {
                return true;
            }
            thread::sleep(ahead.min(LOOK));
        }
        false
    }
}
