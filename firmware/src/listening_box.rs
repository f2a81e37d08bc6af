//! The whole box's board made of a [`Listener`].
//!
//! There is no gate, coil, valve, sensor or tacho, so nothing can be energised: arming is refused, by
//! name, as on any box whose enable input is open. The samples, the link, the settings and the watchdog are
//! those of every other box, and so are frames and commands.

use crate::board::{
    AdcCode, Block, Board, BoardError, BoardErrorKind, BoxBoard, COILS, Clock, CoilBridge,
    CoilOrder, CoilReport, Contacts, DacCode, Emergency, GAPS, Lights, Listener, Origin, Pulse,
    ResetCause, SensorCodes,
};
use crate::current_loop::{CurrentLoop, MainSide};
use core::ops::Range;
use rarma_box::guard::KEPT_BYTES;
use rarma_rigs::cers::Source;

/// Periods of the current loop a second that is no interrupt's here, but the slow duty's.
const LOOP_RATE_HZ: f64 = 1000.0;

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
    type Error = BoardErrorKind;

    fn currents(&mut self) -> Result<[AdcCode; COILS], Self::Error> {
        Err(BoardErrorKind::Converter)
    }

    fn gaps(&mut self) -> [AdcCode; GAPS] {
        [AdcCode(0); GAPS]
    }

    fn set_duty(&mut self, _: [f32; COILS]) -> Result<(), Self::Error> {
        Err(BoardErrorKind::Refused)
    }

    fn off(&mut self) {}

    fn broken(&mut self) -> Option<u8> {
        None
    }

    fn rearm(&mut self) {}
}

impl<L: Listener> Clock for ListeningBox<L> {
    fn now_us(&mut self) -> u64 {
        self.board.now_us()
    }
}

impl<L: Listener> Board for ListeningBox<L> {
    type Error = BoardErrorKind;

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, Self::Error> {
        self.board.samples(block).map_err(|error| error.kind())
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), Self::Error> {
        self.board.send(frame).map_err(|error| error.kind())
    }
}

impl<L: Listener> Emergency for ListeningBox<L> {
    fn drop_outputs(&mut self) {}

    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]) {
        self.board.keep(bytes);
    }
}

impl<L: Listener> BoxBoard for ListeningBox<L> {
    type Flash = L::Flash;

    const NAME: &'static str = L::NAME;
    const SAMPLE_RATE_HZ: f64 = L::SAMPLE_RATE_HZ;
    const LOOP_RATE_HZ: f64 = LOOP_RATE_HZ;

    fn wait(&mut self) {
        self.board.wait();
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
        Err(BoardErrorKind::Converter)
    }

    fn valve(&mut self, _: DacCode) -> Result<(), Self::Error> {
        Err(BoardErrorKind::Refused)
    }

    /// Nobody can have closed an enable input that is not there, nor pressed a stop.
    fn contacts(&mut self) -> Contacts {
        Contacts {
            enable: false,
            stop_chain: true,
        }
    }

    fn energise(&mut self) -> Result<(), Self::Error> {
        Err(BoardErrorKind::Refused)
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
        self.board.receive(bytes).map_err(|error| error.kind())
    }

    /// Wherever the link is led to: nothing can be energised.
    fn origin(&mut self) -> Origin {
        Origin::OwnPort
    }

    fn lights(&mut self, lights: Lights) {
        self.board.lights(lights);
    }
}
