//! A real controller is looked after on a thread of its own, by the clock: a sound that stops
//! does not stop it, and is a reason to give back.

use super::STEP;
use super::ear::Ear;
use crate::collect::News;
use crate::commands::monitor::Beside;
use crate::controller::{ActRecord, Actor, words};
use crate::failure::Failure;
use crate::signals::{self, INTERRUPTED};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Instant;

/// The thread that looks after the controller, as the listening sees it.
pub(super) struct ByClock {
    /// It listens, and it chatters at this frequency, Hz, or does not.
    tell: Sender<Option<f64>>,
    said: Receiver<ActRecord>,
    speed_hz: Arc<Mutex<Option<f64>>>,
    thread: Option<JoinHandle<Result<(), Failure>>>,
    ear: Ear,
    needs_live: bool,
}

impl ByClock {
    /// Begins to look after it. An interrupt ends the program once what is ordered has been given back, unless
    /// somebody else `ends` it.
    ///
    /// # Errors
    /// The system does not let it hear of an interrupt.
    pub(super) fn start(
        actor: Actor,
        first: ActRecord,
        needs_live: bool,
        ends: bool,
    ) -> Result<Self, Failure> {
        let (tell, told) = channel();
        let (say, said) = channel();
        let _ = say.send(first);
        let speed_hz = Arc::new(Mutex::new(turning(&actor)));
        let interrupted = Arc::new(AtomicBool::new(false));
        let set = Arc::clone(&interrupted);
        signals::on_interrupt(move || set.store(true, Ordering::SeqCst))?;
        let thread = thread::spawn({
            let speed_hz = Arc::clone(&speed_hz);
            move || look_after(actor, &told, &say, &speed_hz, &interrupted, ends)
        });
        Ok(Self {
            tell,
            said,
            speed_hz,
            thread: Some(thread),
            ear: Ear::default(),
            needs_live,
        })
    }

    /// Gives back what is ordered, and what has been said until then goes to standard error.
    pub(super) fn end(self) -> Result<(), Failure> {
        let Self {
            tell, said, thread, ..
        } = self;
        drop(tell);
        let ended = thread.map(JoinHandle::join);
        for record in said.try_iter() {
            eprintln!("{}", words(&record));
        }
        match ended {
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(Failure::System(
                "the thread of the controller has failed: a defect of this program; see that the override is as it should be".to_owned(),
            )),
            None => Ok(()),
        }
    }
}

fn turning(actor: &Actor) -> Option<f64> {
    actor.reading().and_then(|r| r.spindle_hz())
}

/// Until the listening ends, and what is ordered has been given back.
fn look_after(
    mut actor: Actor,
    told: &Receiver<Option<f64>>,
    say: &Sender<ActRecord>,
    speed_hz: &Mutex<Option<f64>>,
    interrupted: &AtomicBool,
    ends: bool,
) -> Result<(), Failure> {
    let begun = Instant::now();
    let mut ended = false;
    loop {
        let t_s = begun.elapsed().as_secs_f64();
        loop {
            match told.try_recv() {
                Ok(chatter_hz) => actor.heard(t_s, chatter_hz),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    ended = true;
                    break;
                }
            }
        }
        let interrupts = interrupted.load(Ordering::SeqCst);
        if ended || interrupts {
            actor.end(t_s);
        }
        actor.step(t_s, |record| {
            // Where nobody listens any more it stands in the log.
            let _ = say.send(record);
        })?;
        *speed_hz.lock().unwrap_or_else(PoisonError::into_inner) = turning(&actor);
        if !actor.holds() {
            if interrupts && !ends {
                std::process::exit(INTERRUPTED);
            }
            if ended || interrupts {
                return Ok(());
            }
        }
        thread::sleep(STEP);
    }
}

impl Beside for ByClock {
    fn begins(&mut self, live: bool) -> Result<(), Failure> {
        if self.needs_live && !live {
            return Err(Failure::Usage(
                "--act: a recording is over, and nothing can be done about it: give the live sound on standard input (-), or leave out --act".to_owned(),
            ));
        }
        Ok(())
    }

    fn speed_rpm(&mut self, _: f64) -> Option<f64> {
        let hz = *self.speed_hz.lock().unwrap_or_else(PoisonError::into_inner);
        hz.map(|hz| 60.0 * hz)
    }

    fn take(&mut self, news: &News) {
        let chatter_hz = self.ear.take(news);
        let _ = self.tell.send(chatter_hz);
    }

    fn said(&mut self) -> Option<ActRecord> {
        self.said.try_recv().ok()
    }

    fn failed(&self) -> bool {
        // While it is listened the thread ends for no other reason.
        self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }
}
