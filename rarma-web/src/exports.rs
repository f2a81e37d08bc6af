//! What the page calls: numbers, and places in memory where it puts and finds the rest.
//!
//! Nothing is handed over but numbers, so that no generated code is needed on the page's side
//! (`page/core.js` is all of it). Samples go into [`samples_room`], text and files into
//! [`bytes_room`]; answers lie at [`answer`]. What can fail returns −1 and leaves the reason as
//! the answer: one line that says what, where, why and what to do.

use crate::file::{self, Opened};
use crate::session::Session;
use crate::settings::Settings;
use rarma_cli::Failure;
use serde::Serialize;
use std::cell::RefCell;

/// What [`make`] is told: the sound is live.
pub const LIVE: u32 = 1;
/// What [`make`] is told: with pictures and report.
pub const PICTURES: u32 = 2;

/// All that is kept between two calls.
#[derive(Default)]
struct Room {
    samples: Vec<f32>,
    bytes: Vec<u8>,
    answer: Vec<u8>,
    session: Option<Session>,
    opened: Option<Opened>,
}

thread_local! {
    static ROOM: RefCell<Room> = RefCell::default();
}

fn with<V>(work: impl FnOnce(&mut Room) -> V) -> V {
    ROOM.with_borrow_mut(work)
}

impl Room {
    fn session(&mut self) -> Result<&mut Session, Failure> {
        self.session.as_mut().ok_or_else(|| {
            Failure::System("nothing is listened to: a defect of the page (reload it)".to_owned())
        })
    }

    /// 0, or −1 with the reason as the answer.
    fn done(&mut self, done: Result<(), Failure>) -> i32 {
        match done {
            Ok(()) => 0,
            Err(why) => {
                self.answer = why.to_string().into_bytes();
                -1
            }
        }
    }

    /// The same, with an answer in JSON.
    fn told(&mut self, told: Result<impl Serialize, Failure>) -> i32 {
        let json = told.and_then(|told| {
            serde_json::to_vec(&told).map_err(|why| Failure::System(format!("answer: {why}")))
        });
        let done = json.map(|json| self.answer = json);
        self.done(done)
    }
}

/// Room for `n` samples.
#[unsafe(no_mangle)]
pub extern "C" fn samples_room(n: usize) -> *mut f32 {
    with(|room| {
        room.samples.resize(n, 0.0);
        room.samples.as_mut_ptr()
    })
}

/// Room for `n` bytes.
#[unsafe(no_mangle)]
pub extern "C" fn bytes_room(n: usize) -> *mut u8 {
    with(|room| {
        room.bytes.clear();
        room.bytes.resize(n, 0);
        room.bytes.as_mut_ptr()
    })
}

/// Where the last answer lies.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    with(|room| room.answer.as_ptr())
}

/// Bytes of the last answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer_length() -> usize {
    with(|room| room.answer.len())
}

/// Begins to listen, with the settings in the bytes (JSON, [`Settings`]); `how` is a sum of
/// [`LIVE`] and [`PICTURES`], `samples` how many there are, below 0 where that is not known.
#[unsafe(no_mangle)]
pub extern "C" fn make(how: u32, samples: f64) -> i32 {
    with(|room| {
        let samples = (samples >= 0.0).then_some(samples as u64);
        let made = Settings::read(&room.bytes)
            .and_then(|asked| Session::new(asked, how & LIVE != 0, how & PICTURES != 0, samples));
        let done = made.map(|session| room.session = Some(session));
        room.done(done)
    })
}

/// Takes the first `n` of the samples; 1 where the page should show something at once.
#[unsafe(no_mangle)]
pub extern "C" fn push(n: usize) -> i32 {
    with(|room| {
        let samples = room.samples.get(..n).unwrap_or(&room.samples);
        room.session
            .as_mut()
            .map_or(-1, |session| i32::from(session.push(samples)))
    })
}

/// So many samples are missing before the next one.
#[unsafe(no_mangle)]
pub extern "C" fn missing(n: f64) {
    with(|room| {
        if let Some(session) = &mut room.session {
            session.missing(n.max(0.0) as u64);
        }
    });
}

/// A block that ends with so many frames has come at this time, s; the samples that are found
/// missing by it. They are not counted yet: tell [`missing`].
#[unsafe(no_mangle)]
pub extern "C" fn note_clock(frames: f64, clock_s: f64) -> f64 {
    with(|room| {
        let session = room.session.as_mut();
        session.map_or(0.0, |s| s.note_clock(frames as u64, clock_s) as f64)
    })
}

/// The spindle turns so fast from now on, 1/min.
#[unsafe(no_mangle)]
pub extern "C" fn tell_speed(rpm: f64) -> i32 {
    with(|room| {
        let done = room.session().and_then(|session| session.tell_speed(rpm));
        room.done(done)
    })
}

/// Answers with what the page shows ([`Heard`](crate::Heard)).
#[unsafe(no_mangle)]
pub extern "C" fn heard() -> i32 {
    with(|room| {
        let told = room.session().map(Session::heard);
        room.told(told)
    })
}

/// Answers with the columns of the moving picture since the last time, a byte a value.
#[unsafe(no_mangle)]
pub extern "C" fn columns() -> i32 {
    with(|room| {
        let columns = room.session().map(Session::columns);
        let done = columns.map(|columns| room.answer = columns);
        room.done(done)
    })
}

/// Answers with the scales of the pictures ([`Scale`](crate::Scale)).
#[unsafe(no_mangle)]
pub extern "C" fn scale() -> i32 {
    with(|room| {
        let told = room.session().map(|session| session.scale());
        room.told(told)
    })
}

/// Answers with the closing record (`rarma monitor --json`), as if the sound ended now.
#[unsafe(no_mangle)]
pub extern "C" fn summary() -> i32 {
    with(|room| {
        let told = room.session().and_then(|session| session.summary());
        room.told(told)
    })
}

/// Answers with the closing record in words ([`InWords`](crate::InWords)).
#[unsafe(no_mangle)]
pub extern "C" fn headline() -> i32 {
    with(|room| {
        let told = room.session().and_then(|session| session.headline());
        room.told(told)
    })
}

/// Answers with what to do about the last alarm: a list of sentences.
#[unsafe(no_mangle)]
pub extern "C" fn advice() -> i32 {
    with(|room| {
        let told = room.session().and_then(|session| session.advice());
        room.told(told)
    })
}

/// Answers with the report, a page; `made_s` is now, seconds since 1970.
#[unsafe(no_mangle)]
pub extern "C" fn report(made_s: f64) -> i32 {
    with(|room| {
        let page = room.session().and_then(|session| session.report(made_s));
        let done = page.map(|page| room.answer = page.into_bytes());
        room.done(done)
    })
}

/// Opens a WAV file: the bytes, the first `name` of which are its name. Answers with what is
/// known of it.
#[unsafe(no_mangle)]
pub extern "C" fn open(name: usize) -> i32 {
    with(|room| {
        let mut bytes = std::mem::take(&mut room.bytes);
        let file = bytes.split_off(name.min(bytes.len()));
        let opened = Opened::new(&String::from_utf8_lossy(&bytes), file);
        match opened {
            Ok(opened) => {
                let about = opened.about().clone();
                room.opened = Some(opened);
                room.told(Ok(about))
            }
            Err(why) => room.done(Err(why)),
        }
    })
}

/// Listens to the next stretch of the open file: 1, or 0 at its end.
#[unsafe(no_mangle)]
pub extern "C" fn step() -> i32 {
    with(|room| {
        let next = match &mut room.opened {
            Some(opened) => opened.next_samples(),
            None => Ok(None),
        };
        match (next, &mut room.session) {
            (Ok(Some(samples)), Some(session)) => {
                session.push(&samples);
                1
            }
            (Ok(_), _) => {
                room.opened = None;
                0
            }
            (Err(why), _) => room.done(Err(why)),
        }
    })
}

/// Whether the first `n` samples, decoded by somebody else from the file whose name is in the
/// bytes, are fit to be analysed.
#[unsafe(no_mangle)]
pub extern "C" fn judge(n: usize, fs: f64) -> i32 {
    with(|room| {
        let name = String::from_utf8_lossy(&room.bytes).into_owned();
        let samples = room.samples.get(..n).unwrap_or(&room.samples);
        let done = file::judge(&name, samples, fs);
        room.done(done)
    })
}
