//! The whole box: every verb beside the current loop's.

use super::{AdcCode, Board, Clock, CoilOrder, CoilReport, DacCode, GAPS};
use core::ops::Range;
use rarma_box::guard::KEPT_BYTES;
use rarma_rigs::cers::Source;

/// Why the controller started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResetCause {
    /// Power came on.
    PowerOn,
    /// The supply fell too low and came back.
    BrownOut,
    /// The watchdog was not fed.
    Watchdog,
    /// The program asked for it, after last words.
    Software,
    /// The reset pin, a debugger, or a cause the board cannot tell.
    Pin,
}

/// A pulse of the tacho.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulse {
    /// The first microphone sample at or after it, counted from start-up with those that
    /// were lost.
    pub sample: u64,
    /// How long before that sample it came, 0..1 sample.
    pub before: f32,
}

/// One reading of everything slow, all taken within one millisecond.
///
/// A sensor that is disconnected reads an end of the range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SensorCodes {
    /// Displacement X and Y.
    pub gap: [AdcCode; GAPS],
    /// Pressure transducer.
    pub pressure: AdcCode,
    /// Length gauge.
    pub gauge: AdcCode,
    /// Supply of the power stage.
    pub supply: AdcCode,
}

/// Contacts that people and machines close. Both are wired so that a broken wire reads
/// like an open contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contacts {
    /// The enable input is closed: outputs may be switched on.
    pub enable: bool,
    /// The emergency-stop chain is closed: nobody has pressed it.
    pub stop_chain: bool,
}

/// Where the bytes of the host come from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Origin {
    /// The port at the box itself: whoever speaks there stands beside it, or has put a
    /// program there.
    #[default]
    OwnPort,
    /// A network, or anything that others can reach.
    Network,
}

/// What the lights show.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Lights {
    /// The program runs; toggles.
    pub alive: bool,
    /// Outputs are on.
    pub energised: bool,
    /// A fault is latched, or chatter is called.
    pub warning: bool,
}

/// What works when nothing else does: the panic and exception handlers have only this.
///
/// No call here may block, allocate, log, or need anything that could itself be the
/// fault.
pub trait Emergency: Clock {
    /// Opens the output gate and all switches by the shortest way there is (registers),
    /// and shuts the valve. The first statement of every handler. Always works, any
    /// number of times, from any context.
    fn drop_outputs(&mut self);

    /// Puts bytes where a reset, though not a power cut, leaves them.
    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]);
}

/// What check bits of a flash have said.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FlashSeen {
    /// Words that could not be read, because a power cut ended their writing or they have
    /// aged. What they hold is handed out as it is: the store's own checks refuse it.
    pub unreadable_words: u32,
    /// Words that were read with one bit mended.
    pub corrected_words: u32,
}

/// The verbs of the whole box. At reset, and before the first call, every output is off:
/// gate open, switches open, valve shut. That is the hardware's doing (pull-downs).
///
/// No call waits for more than 50 µs except [`Self::wait`], [`Self::entropy`] and the flash's.
pub trait BoxBoard: Board + Emergency {
    /// Flash that holds the settings and nothing else.
    type Flash: embedded_storage::nor_flash::NorFlash;

    /// Name of the board, for the host.
    const NAME: &'static str;
    /// Rate of the microphone's samples, Hz.
    const SAMPLE_RATE_HZ: f64;
    /// Rate of the current loop, Hz.
    const LOOP_RATE_HZ: f64;

    /// Sleeps until something may have to be done, at most 1 ms. May return early.
    fn wait(&mut self);

    /// From now on [`Board::samples`] are those of this microphone, 0 or 1; their count and time
    /// go on. A board with one microphone keeps it.
    fn listen_to(&mut self, microphone: u8) {
        let _ = microphone;
    }

    /// The oldest pulse of the tacho not taken yet. The board keeps 16 and drops the
    /// newest beyond that.
    fn pulse(&mut self) -> Option<Pulse>;

    /// Hands the current loop its order and takes its report; see
    /// [`MainSide::exchange`](crate::current_loop::MainSide::exchange). Fails in no way: a loop
    /// that does not run is known by its count of periods.
    fn coils(&mut self, order: &CoilOrder) -> CoilReport;

    /// Starts a signal in the current loop; see
    /// [`CurrentLoop::excite`](crate::CurrentLoop::excite). What becomes of it is in the reports.
    fn excite(&mut self, signal: &Source);

    /// Reads the slow sensors.
    ///
    /// # Errors
    /// The conversion did not happen: no codes are given again.
    fn sensors(&mut self) -> Result<SensorCodes, Self::Error>;

    /// Sets the valve; code 0 vents. Acts only while the gate is on.
    ///
    /// # Errors
    /// The converter refused; the valve is then vented by the gate.
    fn valve(&mut self, code: DacCode) -> Result<(), Self::Error>;

    /// The contacts as they are now, debounced by no more than 1 ms.
    fn contacts(&mut self) -> Contacts;

    /// Closes the output gate: bridges may switch, the valve is supplied. The only way to
    /// energise anything.
    ///
    /// # Errors
    /// The gate did not close (its read-back says so), or the hardware holds it open
    /// (emergency stop).
    fn energise(&mut self) -> Result<(), Self::Error>;

    /// Opens the output gate. Always works; the same as [`Emergency::drop_outputs`].
    fn de_energise(&mut self) {
        self.drop_outputs();
    }

    /// The gate's read-back: whether outputs can carry energy now.
    fn energised(&mut self) -> bool;

    /// Feeds the watchdog, whose time is [`WATCHDOG_US`]. It runs before the first call and cannot be
    /// stopped.
    fn feed_watchdog(&mut self);

    /// Why the controller started. The same at every call.
    fn reset_cause(&mut self) -> ResetCause;

    /// The bytes of [`Emergency::keep`], from before the reset; anything after a power-up.
    fn kept(&mut self) -> [u8; KEPT_BYTES];

    /// Voltage of the controller's supply below which its reset comes, mV; none where that is
    /// not the firmware's to know.
    fn brown_out_mv(&mut self) -> Option<u16> {
        None
    }

    /// A number for this moment: not the same in two runs of the box, and not to be foreseen.
    /// It names the run, and each turn of control in it, so that nothing said in another one
    /// counts in this. May take a millisecond. How good it is stands with the board.
    fn entropy(&mut self) -> u32;

    /// The flash and the addresses of it that are the settings': a whole number of
    /// erase sectors, at least 2. A write or erase that returns an error, or that a power
    /// cut ends, may have done any part of its work.
    fn flash(&mut self) -> (&mut Self::Flash, Range<u32>);

    /// What the flash's own check bits have said of that flash since the last call; nothing
    /// on a flash that has none.
    fn flash_seen(&mut self) -> FlashSeen {
        FlashSeen::default()
    }

    /// Takes bytes of the host that have come, at most `bytes.len()`. Does not wait. Bytes
    /// that came faster than they were taken are lost and show as broken frames.
    ///
    /// # Errors
    /// The link is down.
    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, Self::Error>;

    /// Where those bytes come from. A board that cannot tell one link from another says
    /// [`Origin::Network`] if any of them is one.
    fn origin(&mut self) -> Origin;

    /// Sets the lights.
    fn lights(&mut self, lights: Lights);
}

/// Time of the watchdog, µs. The slowest duty has 20 ms; erasing a sector of flash, with the
/// outputs off, takes 25 ms on the slowest board known.
pub const WATCHDOG_US: u64 = 100_000;

/// A controller whose reset comes below this goes on while the parts at its side that are made
/// for 3.3 V, gate drivers and sensors, need not work any more, mV.
pub const LEAST_BROWN_OUT_MV: u16 = 2700;
