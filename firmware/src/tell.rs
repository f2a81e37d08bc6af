//! Frames out: numbers them, hands them over whole, counts what the link did not take.

use crate::board::Board;
use rarma_box::guard::{FaultCode, FaultRecord, Mode, Severity};
use rarma_box::wire::{FaultMessage, MAX_FRAME, Telemetry, encode};

/// Says things to the host.
#[derive(Debug)]
pub struct Teller {
    session: u32,
    sequence: u32,
    dropped: u32,
}

impl Teller {
    /// A teller of the session of this number.
    pub fn new(session: u32) -> Self {
        Self {
            session,
            sequence: 0,
            dropped: 0,
        }
    }

    /// The number of this run of the box.
    pub fn session(&self) -> u32 {
        self.session
    }

    /// Sends one message. One that the link does not take is counted and left behind; the
    /// gap in the numbers tells the host. True if it was taken.
    pub fn tell<B: Board>(&mut self, board: &mut B, message: &Telemetry) -> bool {
        let mut buffer = [0u8; MAX_FRAME];
        let sent = match encode(message, self.session, self.sequence, &mut buffer) {
            Ok(frame) => board.send(frame).is_ok(),
            Err(_) => false,
        };
        self.sequence = self.sequence.wrapping_add(1);
        if !sent {
            self.dropped = self.dropped.saturating_add(1);
        }
        sent
    }

    /// Frames made.
    pub fn frames(&self) -> u32 {
        self.sequence
    }

    /// Of them, not taken by the link.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }
}

/// The same fault at the same place is told again after this long, µs.
const SAME_FAULT_US: u64 = 1_000_000;

#[derive(Debug, Clone, Copy)]
struct Told {
    place: u8,
    severity: Severity,
    at_us: u64,
}

/// Faults that have been told, so that one that lasts is not told without end.
#[derive(Debug)]
pub(crate) struct ToldFaults([Option<Told>; FaultCode::ALL.len()]);

impl ToldFaults {
    /// None.
    pub fn new() -> Self {
        Self([None; FaultCode::ALL.len()])
    }

    /// Tells of a fault, unless the same one at the same place has just been told, as grave. A
    /// message the link did not take has not been told.
    pub fn tell<B: Board>(
        &mut self,
        teller: &mut Teller,
        board: &mut B,
        record: FaultRecord,
        severity: Severity,
        mode: Mode,
    ) {
        let place = FaultCode::ALL.iter().position(|code| *code == record.code);
        let known = place.and_then(|k| self.0.get(k).copied().flatten());
        let same = known.is_some_and(|told| {
            told.place == record.place
                && told.severity >= severity
                && record.at_us.saturating_sub(told.at_us) < SAME_FAULT_US
        });
        if same || severity == Severity::Unused {
            return;
        }
        let message = FaultMessage {
            record,
            severity,
            mode,
        };
        if teller.tell(board, &Telemetry::Fault(message))
            && let Some(told) = place.and_then(|k| self.0.get_mut(k))
        {
            *told = Some(Told {
                place: record.place,
                severity,
                at_us: record.at_us,
            });
        }
    }

    /// What was told may be told again: the host has cleared the fault.
    pub fn forget(&mut self) {
        *self = Self::new();
    }
}
