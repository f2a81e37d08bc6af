//! One job, from the first sample to the last frame: a monitor over a board whose samples end.
//!
//! Monitor, frames and board are those of the whole box; what it has beside them, commands, settings and
//! a supervisor, a recording has no use for.

use crate::board::{Board, BoardError, BoardErrorKind};
use crate::monitor::MonitorDuty;
use crate::tell::Teller;
use rarma_box::wire::{MonitorJob, Refusal, Telemetry};

/// Samples taken at a time.
const BLOCK: usize = 256;
/// The session of every job: there is one run and one stream.
const SESSION: u32 = 1;

/// How a job ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The samples have ended (a recording); the totals have been sent.
    Ended,
    /// The job was refused, or the source broke off; the host has been told.
    Refused(Refusal),
}

/// One job.
#[derive(Debug)]
pub struct Job<'a, B> {
    board: &'a mut B,
    tell: Teller,
    duty: MonitorDuty,
    samples_per_us: f32,
    longest_block_us: u32,
    late_blocks: u32,
}

impl<'a, B: Board> Job<'a, B> {
    /// Starts it, and says so on the link.
    ///
    /// # Errors
    /// [`Refusal::Settings`] if it is out of range; the link has been told.
    pub fn start(board: &'a mut B, job: &MonitorJob) -> Result<Self, Refusal> {
        let mut tell = Teller::new(SESSION);
        let Ok(duty) = MonitorDuty::new(job) else {
            return Err(refuse(board, &mut tell, Refusal::Settings));
        };
        tell.tell(board, &duty.started());
        Ok(Self {
            board,
            tell,
            duty,
            samples_per_us: (job.monitor.fs_hz * 1e-6) as f32,
            longest_block_us: 0,
            late_blocks: 0,
        })
    }

    /// Takes one block of samples. `None` means that it goes on.
    pub fn step(&mut self) -> Option<Outcome> {
        let mut block = [0.0f32; BLOCK];
        let read = self.board.samples(&mut block);
        let begun_us = self.board.now_us();
        let read = match read {
            Ok(read) => read,
            Err(error) => {
                let why = refusal(error.kind());
                let why = refuse(self.board, &mut self.tell, why);
                return Some(Outcome::Refused(why));
            }
        };
        if read.missing > 0 {
            self.duty.missing(read.missing);
        }
        if read.samples == 0 {
            let (longest_us, late) = (self.longest_block_us, self.late_blocks);
            let last = self.duty.finished(longest_us, late, self.tell.dropped());
            self.tell.tell(self.board, &last);
            return Some(Outcome::Ended);
        }
        let taken = block.get(..read.samples).unwrap_or(&block);
        self.duty.samples(taken, &mut |message| {
            self.tell.tell(self.board, message);
        });
        let took_us = self.board.now_us().saturating_sub(begun_us);
        self.longest_block_us = self
            .longest_block_us
            .max(u32::try_from(took_us).unwrap_or(u32::MAX));
        if took_us as f32 * self.samples_per_us > taken.len() as f32 {
            self.late_blocks = self.late_blocks.saturating_add(1);
        }
        None
    }

    /// The board, for whoever runs the job step by step.
    pub fn board(&mut self) -> &mut B {
        self.board
    }

    /// Runs to the end of the samples.
    pub fn run(&mut self) -> Outcome {
        loop {
            if let Some(outcome) = self.step() {
                return outcome;
            }
        }
    }
}

fn refuse<B: Board>(board: &mut B, tell: &mut Teller, why: Refusal) -> Refusal {
    tell.tell(board, &Telemetry::Refused(why));
    why
}

fn refusal(kind: BoardErrorKind) -> Refusal {
    match kind {
        BoardErrorKind::Source => Refusal::Source,
        BoardErrorKind::Channel => Refusal::Channel,
        BoardErrorKind::Job => Refusal::Job,
        // A source has no other failures than these.
        _ => Refusal::SourceLost,
    }
}
