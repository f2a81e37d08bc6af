//! Sound as it comes, for the monitor: waits for samples, notices what goes wrong, records.

use super::level::{FLOAT_BITS, Level, step};
use super::offer::{Choice, Form};
use super::ring::{Drain, Piece, Told};
use super::watch::Watch;
use crate::failure::Failure;
use crate::output::LiveWav;
use rarma_recordings::input::{Begin, Blocks, End, InputError, Problem, Stream};
use std::any::Any;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Samples are looked for this often.
const LOOK: Duration = Duration::from_millis(5);
/// A card that gives nothing at its beginning is given up after this long.
const FIRST_WITHIN: Duration = Duration::from_secs(10);
/// A card may take this long to be closed.
const CLOSED_WITHIN: Duration = Duration::from_secs(1);

/// What the card's threads, and whoever ends it, tell the monitor's.
#[derive(Debug, Default)]
pub struct Signals {
    /// It is to end.
    pub stop: AtomicBool,
    /// What went through the ring, and what did not.
    pub told: Arc<Told>,
    /// Why no more samples will come.
    gone: Mutex<Option<String>>,
    /// Other things to say.
    said: Mutex<VecDeque<String>>,
}

impl Signals {
    /// No more samples will come.
    pub fn gone(&self, why: String) {
        let mut gone = self.gone.lock().unwrap_or_else(PoisonError::into_inner);
        gone.get_or_insert(why);
    }

    /// Something odd, but it goes on. Of many at once the first are said.
    pub fn say(&self, what: String) {
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        if said.len() < 8 && said.back() != Some(&what) {
            said.push_back(what);
        }
    }
}

/// A card that has been opened.
#[derive(Debug, Clone, PartialEq)]
pub struct Card {
    /// Its name.
    pub name: String,
    /// What was taken of its offers.
    pub choice: Choice,
}

/// How it ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// As it was told to.
    Told,
    /// The card went away: why.
    Gone(String),
}

/// An open input.
pub struct Live {
    /// What it is.
    pub card: Card,
    /// Bits of the converter behind it.
    bits: u32,
    drain: Drain,
    signals: Arc<Signals>,
    /// The open card, to be kept and at last dropped.
    open: Option<Box<dyn Any + Send>>,
    watch: Watch,
    /// Heard while its level was measured.
    held: VecDeque<Piece>,
    wanted: Vec<usize>,
    /// Samples of a channel that are still to be heard.
    left: u64,
    /// Samples of a channel that have been heard, those that are missing among them.
    heard: u64,
    /// Of the block just given.
    missing_now: u64,
    gaps: Gaps,
    record: Option<LiveWav>,
    record_failed: Option<Failure>,
    ended: Option<Ended>,
}

/// Where samples are missing.
#[derive(Debug, Default)]
struct Gaps {
    /// How often, and how many samples.
    count: u64,
    samples: u64,
    /// Where the first began, samples.
    first: u64,
    /// The last piece was one.
    open: bool,
}

impl Live {
    /// An input whose samples come out of `drain`; `open` keeps it going.
    pub fn new(
        card: Card,
        drain: Drain,
        signals: Arc<Signals>,
        open: Option<Box<dyn Any + Send>>,
    ) -> Self {
        let bits = match card.choice.form {
            Form::Integer(bits) => u32::from(bits),
            Form::Float => FLOAT_BITS,
        };
        Self {
            bits,
            watch: Watch::new(f64::from(card.choice.rate_hz), Instant::now()),
            card,
            drain,
            signals,
            open,
            held: VecDeque::new(),
            wanted: vec![0],
            left: u64::MAX,
            heard: 0,
            missing_now: 0,
            gaps: Gaps::default(),
            record: None,
            record_failed: None,
            ended: None,
        }
    }

    /// Sampling rate, Hz.
    pub fn fs(&self) -> f64 {
        f64::from(self.card.choice.rate_hz)
    }

    /// Its name in messages.
    pub fn name(&self) -> String {
        format!("sound card {}", self.card.name)
    }

    /// By which it is told to end.
    pub fn signals(&self) -> Arc<Signals> {
        Arc::clone(&self.signals)
    }

    /// It ends after so many seconds.
    pub fn end_after(&mut self, seconds: f64) {
        self.left = (seconds * self.fs()).round() as u64;
    }

    /// Waits for `seconds` of sound and measures the level of every channel; they are heard again
    /// afterwards, so that nothing is lost. Empty where it was ended before anything came.
    ///
    /// # Errors
    /// Nothing comes.
    pub fn measure(&mut self, seconds: f64) -> Result<Vec<Level>, Failure> {
        let channels = self.card.choice.channels;
        let wanted = (seconds * self.fs()).ceil() as usize * channels;
        let (mut here, mut samples) = (0, Vec::new());
        while here < wanted {
            let Some(piece) = self.wait(Some(FIRST_WITHIN)) else {
                break;
            };
            if let Piece::Frames(frames) = &piece {
                here += frames.len();
                samples.extend_from_slice(frames);
            }
            self.held.push_back(piece);
        }
        if samples.is_empty() {
            if wanted == 0 || self.signals.stop.load(Ordering::Relaxed) {
                return Ok(Vec::new());
            }
            let why = match &self.ended {
                Some(Ended::Gone(why)) => why.clone(),
                _ => format!("no samples within {} s", FIRST_WITHIN.as_secs()),
            };
            return Err(Failure::NoSound(format!(
                "{}: start: {why} (choose another --device of `rarma listen --list`)",
                self.name()
            )));
        }
        let levels: Vec<Level> = (0..channels)
            .map(|c| {
                let one: Vec<f32> = samples.iter().skip(c).step_by(channels).copied().collect();
                Level::of(&one)
            })
            .collect();
        let bits = levels.iter().map(|level| level.bits).max();
        self.bits = self.bits.min(bits.unwrap_or(FLOAT_BITS).max(16));
        Ok(levels)
    }

    /// Records what is heard from now on into a new file.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn record(&mut self, path: &Path, channels: usize) -> Result<(), Failure> {
        let bits = (self.bits < FLOAT_BITS).then_some(self.bits);
        let wav = LiveWav::create(path, self.card.choice.rate_hz, channels, bits)?;
        self.record = Some(wav);
        Ok(())
    }

    /// It is heard by whoever reads a [`Stream`].
    pub fn stream(shared: &Rc<RefCell<Self>>) -> Stream {
        let live = shared.borrow();
        let Choice { channels, form, .. } = live.card.choice;
        let begin = Begin {
            format: format!("sound card, {form}"),
            fs: Some(live.fs()),
            step: Some(step(live.bits)),
            channels,
            blocks: Box::new(Shared(Rc::clone(shared))),
        };
        Stream::live(PathBuf::from(live.name()), begin)
    }

    /// Closes the card and the recording; how it ended.
    ///
    /// # Errors
    /// The recording could not be written.
    pub fn close(&mut self) -> Result<Ended, Failure> {
        if let Some(open) = self.open.take() {
            // A driver that hangs does not keep the verdict and the recording.
            let closing = thread::spawn(move || drop(open));
            let begun = Instant::now();
            while !closing.is_finished() && begun.elapsed() < CLOSED_WITHIN {
                thread::sleep(LOOK);
            }
        }
        if let Some(record) = self.record.take() {
            let name = record.name();
            if record.finish()? {
                eprintln!("recorded: {}", name.display());
            }
        }
        match self.record_failed.take() {
            Some(failure) => Err(failure),
            None => Ok(self.ended.take().unwrap_or(Ended::Told)),
        }
    }

    /// What comes next; none: it has ended. With `patience` it also ends after so long without
    /// samples.
    fn wait(&mut self, patience: Option<Duration>) -> Option<Piece> {
        loop {
            if self.signals.stop.load(Ordering::Relaxed) {
                return self.end(Ended::Told);
            }
            self.pass_on();
            // Asked first: what came before it went is still to be heard.
            let gone = self.signals.gone.lock();
            let gone = gone.unwrap_or_else(PoisonError::into_inner).clone();
            let (piece, now) = (self.drain.piece(), Instant::now());
            if piece.is_some() {
                let said = self.watch.something(now);
                self.say(said);
                return piece;
            }
            if let Some(why) = gone {
                return self.end(Ended::Gone(why));
            }
            let said = self.watch.nothing(now);
            self.say(said);
            if patience.is_some_and(|most| self.watch.pause(now) > most) {
                return None;
            }
            thread::sleep(LOOK);
        }
    }

    fn end(&mut self, how: Ended) -> Option<Piece> {
        self.ended.get_or_insert(how);
        None
    }

    fn say(&self, said: Option<String>) {
        if let Some(text) = said {
            eprintln!("{}: {text}", self.name());
        }
    }

    /// What others have to say.
    fn pass_on(&mut self) {
        let said = self.signals.said.lock();
        let said = std::mem::take(&mut *said.unwrap_or_else(PoisonError::into_inner));
        for text in said {
            self.say(Some(text));
        }
        let rate = self.watch.rate(self.signals.told.rate_hz());
        self.say(rate);
    }

    /// The next block, one row for each wanted channel; false at the end.
    fn block(&mut self, rows: &mut [Vec<f64>]) -> bool {
        if self.left == 0 {
            self.end(Ended::Told);
            return false;
        }
        let held = self.held.pop_front();
        let Some(piece) = held.or_else(|| self.wait(None)) else {
            return false;
        };
        let channels = self.card.choice.channels;
        let samples = match piece {
            Piece::Missing(samples) => {
                let samples = samples.min(self.left);
                self.gaps.add(samples, self.heard);
                self.missing_now = samples;
                for row in rows.iter_mut() {
                    row.resize(samples as usize, 0.0);
                }
                samples
            }
            Piece::Frames(frames) => {
                let samples = (frames.len() / channels).min(self.left as usize);
                self.gaps.open = false;
                self.missing_now = 0;
                for (row, channel) in rows.iter_mut().zip(&self.wanted) {
                    let one = frames.iter().skip(*channel).step_by(channels);
                    row.extend(one.take(samples).map(|x| f64::from(*x)));
                }
                samples as u64
            }
        };
        self.heard += samples;
        self.left -= samples;
        self.keep(rows);
        true
    }

    /// Records a block. A disk that is full ends the recording, not the listening.
    fn keep(&mut self, rows: &[Vec<f64>]) {
        let Some(record) = &mut self.record else {
            return;
        };
        if let Err(failure) = record.write(rows) {
            eprintln!("{failure}; no more is recorded, it listens on");
            self.record = None;
            self.record_failed = Some(failure.into());
        }
    }
}

impl Gaps {
    fn add(&mut self, samples: u64, at: u64) {
        if !self.open {
            if self.count == 0 {
                self.first = at;
            }
            self.count += 1;
        }
        self.open = true;
        self.samples += samples;
    }

    fn notice(&self, fs: f64) -> Option<String> {
        let places = match self.count {
            0 => return None,
            1 => "one place".to_owned(),
            n => format!("{n} places, the first"),
        };
        Some(format!(
            "{} samples are missing ({:.3} s) in {places} at {:.3} s: the card paused, or this computer was too slow for it (end other programs; the monitor was told, and says `samples-missing` there)",
            self.samples,
            self.samples as f64 / fs,
            self.first as f64 / fs
        ))
    }
}

/// A [`Live`] as a format to be read, while its owner keeps it.
struct Shared(Rc<RefCell<Live>>);

impl Blocks for Shared {
    fn want(&mut self, channels: &[usize]) {
        self.0.borrow_mut().wanted = channels.to_vec();
    }

    fn next(&mut self, rows: &mut [Vec<f64>]) -> Result<bool, InputError> {
        Ok(self.0.borrow_mut().block(rows))
    }

    fn missing(&self) -> u64 {
        self.0.borrow().missing_now
    }

    fn end(&mut self) -> Result<End, InputError> {
        let live = self.0.borrow();
        if live.heard == live.gaps.samples {
            return Err(InputError::new(
                Problem::NoSamples,
                "end",
                "nothing was heard",
                "let it listen longer",
            ));
        }
        Ok(End {
            fs: live.fs(),
            notices: live.gaps.notice(live.fs()).into_iter().collect(),
        })
    }

    fn no_channel(&self, asked: usize, channels: usize) -> InputError {
        rarma_recordings::input::no_channel("channels", asked, channels)
    }
}
