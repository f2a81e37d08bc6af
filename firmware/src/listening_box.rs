//! The whole box's board made of a [`Listener`].
//!
//! There is no gate, coil, valve, sensor or tacho, so nothing can be energised: arming is refused, by
//! name, as on any box whose enable input is open. The samples, the link, the settings and the watchdog are
//! those of every other box, and so are frames and commands.

use crate::board::{
    AdcCode, Block, BoardError, BoardErrorKind, BoxBoard, COILS, CoilBridge, CoilOrder, CoilReport,
    Contacts, DacCode, Emergency, GAPS, Lights, Listener, Origin, Pulse, ResetCause, SensorCodes,
};
use crate::current_loop::{CurrentLoop, MainSide};
use core::ops::Range;
use rarma_box::guard::KEPT_BYTES;
use rarma_rigs::cers::Source;

/// Periods of the current loop a second that is no interrupt's here, but the slow duty's.
const LOOP_RATE_HZ: f64 = 1000.0;

/// An error of a board that listens, or of what it does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ListenerError<E> {
    /// The board's own.
    Board(E),
    /// There is no power stage, valve or gate.
    NoOutput,
    /// There is no converter beside the microphone.
    NoConverter,
}

impl<E: BoardError> BoardError for ListenerError<E> {
    fn kind(&self) -> BoardErrorKind {
        match self {
            Self::Board(error) => error.kind(),
            Self::NoOutput => BoardErrorKind::Refused,
            Self::NoConverter => BoardErrorKind::Converter,
        }
    }
}

/// The whole box on a board that only listens.
#[derive(Debug)]
pub struct ListeningBox<L> {
    board: L,
    coils: CurrentLoop,
    main_side: MainSide,
}

impl<L> ListeningBox<L> {
    /// Of this board.
    pub fn new(board: L) -> Self {
        Self {
            board,
            coils: CurrentLoop::new(),
            main_side: MainSide::default(),
        }
    }

    /// The board.
    pub fn board(&mut self) -> &mut L {
        &mut self.board
    }
}

/// No bridges.
#[derive(Debug)]
struct NoBridges;

impl CoilBridge for NoBridges {
    type Error = ListenerError<core::convert::Infallible>;

    fn currents(&mut self) -> Result<[AdcCode; COILS], Self::Error> {
        Err(ListenerError::NoConverter)
    }

    fn gaps(&mut self) -> [AdcCode; GAPS] {
        [AdcCode(0); GAPS]
    }

    fn set_duty(&mut self, _: [f32; COILS]) -> Result<(), Self::Error> {
        Err(ListenerError::NoOutput)
    }

    fn off(&mut self) {}

    fn broken(&mut self) -> Option<u8> {
        None
    }

    fn rearm(&mut self) {}
}

impl BoardError for core::convert::Infallible {
    fn kind(&self) -> BoardErrorKind {
        match *self {}
    }
}

impl<L: Listener> Emergency for ListeningBox<L> {
    fn drop_outputs(&mut self) {}

    fn now_us(&mut self) -> u64 {
        self.board.now_us()
    }

    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]) {
        self.board.keep(bytes);
    }
}

impl<L: Listener> BoxBoard for ListeningBox<L> {
    type Error = ListenerError<L::Error>;
    type Flash = L::Flash;

    const NAME: &'static str = L::NAME;
    const SAMPLE_RATE_HZ: f64 = L::SAMPLE_RATE_HZ;
    const LOOP_RATE_HZ: f64 = LOOP_RATE_HZ;

    fn wait(&mut self) {
        self.board.wait();
    }

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, Self::Error> {
        self.board.samples(block).map_err(ListenerError::Board)
    }

    fn pulse(&mut self) -> Option<Pulse> {
        None
    }

    fn coils(&mut self, order: &CoilOrder) -> CoilReport {
        let report = self.main_side.exchange(&mut self.coils, order);
        self.coils.period(&mut NoBridges);
        report.unwrap_or_default()
    }

    fn excite(&mut self, signal: &Source) {
        self.coils.excite(signal);
    }

    fn sensors(&mut self) -> Result<SensorCodes, Self::Error> {
        Err(ListenerError::NoConverter)
    }

    fn valve(&mut self, _: DacCode) -> Result<(), Self::Error> {
        Err(ListenerError::NoOutput)
    }

    /// Nobody can have closed an enable input that is not there, nor pressed a stop.
    fn contacts(&mut self) -> Contacts {
        Contacts {
            enable: false,
            stop_chain: true,
        }
    }

    fn energise(&mut self) -> Result<(), Self::Error> {
        Err(ListenerError::NoOutput)
    }

    fn energised(&mut self) -> bool {
        false
    }

    fn feed_watchdog(&mut self) {
        self.board.feed_watchdog();
    }

    fn reset_cause(&mut self) -> ResetCause {
        self.board.reset_cause()
    }

    fn kept(&mut self) -> [u8; KEPT_BYTES] {
        self.board.kept()
    }

    fn entropy(&mut self) -> u32 {
        self.board.entropy()
    }

    fn flash(&mut self) -> (&mut Self::Flash, Range<u32>) {
        self.board.flash()
    }

    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, Self::Error> {
        self.board.receive(bytes).map_err(ListenerError::Board)
    }

    /// Wherever the link is led to: nothing can be energised.
    fn origin(&mut self) -> Origin {
        Origin::OwnPort
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), Self::Error> {
        self.board.send(frame).map_err(ListenerError::Board)
    }

    fn lights(&mut self, lights: Lights) {
        self.board.lights(lights);
    }
}
