//! The application: one job, from the first sample to the last frame.

use crate::board::{Block, Board, BoardError, BoardErrorKind, Clock, Parts, SampleSource};
use crate::link::FrameSender;
use crate::monitor::MonitorDuty;
use rarma_box::wire::{MonitorJob, Refusal, Telemetry};

/// Samples taken from the source at a time.
pub const BLOCK_SAMPLES: usize = 256;

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The source ended (a recording); the totals have been sent.
    Ended,
    /// The job was refused, or the source broke off; the host has been told.
    Refused(Refusal),
}

/// Runs a monitor on a board.
#[derive(Debug)]
pub struct App<'a, B: Board> {
    board: &'a mut B,
    frames: FrameSender,
    duty: MonitorDuty,
    samples_per_us: f32,
    longest_block_us: u32,
    late_blocks: u32,
}

impl<'a, B: Board> App<'a, B> {
    /// Starts a job, and says so on the link.
    ///
    /// # Errors
    /// [`Refusal::Settings`] if the job is out of range; the link has been told.
    pub fn start(board: &'a mut B, job: &MonitorJob) -> Result<Self, Refusal> {
        let mut frames = FrameSender::default();
        let Ok(duty) = MonitorDuty::new(job) else {
            refuse(board, &mut frames, Refusal::Settings);
            return Err(Refusal::Settings);
        };
        frames.send(board.parts().link, &duty.started());
        Ok(Self {
            board,
            frames,
            duty,
            samples_per_us: (job.monitor.fs_hz * 1e-6) as f32,
            longest_block_us: 0,
            late_blocks: 0,
        })
    }

    /// Takes one block of samples. `None` means that the run goes on.
    pub fn step(&mut self) -> Option<Outcome> {
        let mut block = [0.0f32; BLOCK_SAMPLES];
        let Parts {
            samples,
            link,
            clock,
        } = self.board.parts();
        let read = samples.read(&mut block);
        let begun_us = clock.now_us();
        let Block {
            samples: count,
            missing,
        } = match read {
            Ok(read) => read,
            Err(error) => {
                let refusal = refusal(error.kind());
                self.frames.send(link, &Telemetry::Refused(refusal));
                return Some(Outcome::Refused(refusal));
            }
        };
        if missing > 0 {
            self.duty.missing(missing);
        }
        if count == 0 {
            let last = self.duty.finished(
                self.longest_block_us,
                self.late_blocks,
                self.frames.dropped(),
            );
            self.frames.send(link, &last);
            let _ = embedded_io::Write::flush(link);
            return Some(Outcome::Ended);
        }
        let taken = block.get(..count).unwrap_or(&block);
        self.duty
            .samples(taken, &mut |message| self.frames.send(link, message));
        let taken_us = clock.now_us().saturating_sub(begun_us);
        self.longest_block_us = self
            .longest_block_us
            .max(u32::try_from(taken_us).unwrap_or(u32::MAX));
        if taken_us as f32 * self.samples_per_us > count as f32 {
            self.late_blocks = self.late_blocks.saturating_add(1);
        }
        None
    }

    /// The board, for whoever runs the application step by step.
    pub fn board(&mut self) -> &mut B {
        self.board
    }

    /// Runs to the end of the source.
    pub fn run(&mut self) -> Outcome {
        loop {
            if let Some(outcome) = self.step() {
                return outcome;
            }
        }
    }
}

/// Tells the host that a job is refused before it has begun.
pub fn refuse<B: Board>(board: &mut B, frames: &mut FrameSender, refusal: Refusal) {
    frames.send(board.parts().link, &Telemetry::Refused(refusal));
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
