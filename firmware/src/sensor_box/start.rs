//! The box starts: why there was a reset, what is stored, what is said first.

use super::SensorBox;
use super::findings::Findings;
use crate::board::{BoxBoard, ResetCause};
use crate::commands::Commands;
use crate::control::{Control, other_than};
use crate::listen::Listening;
use crate::rig::{RigDuty, RigPlan};
use crate::store::{Loaded, Store};
use crate::tell::{Teller, ToldFaults};
use rarma_box::guard::{
    CheckIns, FaultCode, FaultRecord, InARow, KEPT_BYTES, Mode, RigState, RigWatch, Severity,
    Supervisor,
};
use rarma_box::settings::{BOX_START, Settings};
use rarma_box::wire::{NO_SESSION, NOBODY, Started, Telemetry};

impl SensorBox {
    /// Starts: reads why there was a reset and what is stored, and says so. Outputs are off.
    pub fn start<B: BoxBoard>(board: &mut B) -> Self {
        let mut this = Self::blank::<B>();
        this.prepare(board);
        this.open(board);
        this
    }

    /// A box that has not started: default settings, nothing heard, nothing ordered. A board that keeps
    /// the box in a static, because it is large, makes it there; [`Self::prepare`] and [`Self::open`]
    /// then start it.
    #[inline(always)]
    pub fn blank<B: BoxBoard>() -> Self {
        let settings = Settings::default();
        Self {
            supervisor: Supervisor::new(None),
            listening: Listening::new(B::SAMPLE_RATE_HZ),
            // Not armed with this plan: arming makes its own and refuses settings that disagree.
            rig: RigDuty::new(RigPlan::unchecked(&settings, B::LOOP_RATE_HZ)),
            tell: Teller::new(NO_SESSION),
            told: ToldFaults::new(),
            control: Control::new(NOBODY),
            commands: Commands::default(),
            watch: RigWatch::default(),
            check_ins: CheckIns::new(0),
            next_tick_us: 0,
            next_status_us: 0,
            next_health_us: 0,
            state: RigState::default(),
            sensors_lost: InARow::default(),
            dropped_told: 0,
            alive: false,
            loop_hz: B::LOOP_RATE_HZ,
            sample_hz: B::SAMPLE_RATE_HZ,
            settings,
            store: Store::default(),
            findings: Findings::new(Loaded::default()),
            started: Started::PowerOn,
            before: None,
            unsaid: None,
        }
    }

    /// First half of a start, once: reads why there was a reset and what is stored.
    #[inline(never)]
    pub fn prepare<B: BoxBoard>(&mut self, board: &mut B) {
        board.drop_outputs();
        let now_us = board.now_us();
        (self.started, self.before, self.unsaid) = past(board, now_us);
        self.supervisor = Supervisor::new(self.unsaid);
        // Read once: the next reset without a fault must not tell this one again.
        board.keep(&[0; KEPT_BYTES]);
        let (store, loaded) = Store::load_from(board, &mut self.settings);
        self.store = store;
        self.findings = Findings::new(loaded);
        self.rig
            .set_out(RigPlan::unchecked(&self.settings, B::LOOP_RATE_HZ));
        self.tell = Teller::new(other_than(NO_SESSION, board.entropy()));
        self.control = Control::new(other_than(NOBODY, board.entropy()));
        self.check_ins = CheckIns::new(now_us);
        self.next_tick_us = now_us;
        self.next_status_us = now_us;
        self.next_health_us = now_us;
    }

    /// Second half of a start, once: says what was found, and begins to listen if the
    /// settings say so.
    pub fn open<B: BoxBoard>(&mut self, board: &mut B) {
        let hello = self.identity::<B>();
        self.tell.tell(board, &Telemetry::Hello(hello));
        if let Some(record) = self.unsaid.take() {
            self.told
                .tell(&mut self.tell, board, record, Severity::Trip, Mode::Safe);
        }
        if self.settings.whole(BOX_START) == 1 {
            // Settings that do not fit leave the box in Safe; the host sees the mode.
            let _ = self.start_mode(board, Mode::Monitor);
        }
    }
}

/// Why the box started, the record that was kept, and what of it is to be latched.
fn past<B: BoxBoard>(
    board: &mut B,
    now_us: u64,
) -> (Started, Option<FaultRecord>, Option<FaultRecord>) {
    let kept = FaultRecord::from_kept(&board.kept());
    let of = |code| FaultRecord {
        code,
        place: 0,
        value: 0.0,
        at_us: now_us,
    };
    match board.reset_cause() {
        // After a power-up the memory holds anything.
        ResetCause::PowerOn => (Started::PowerOn, None, None),
        ResetCause::BrownOut => (Started::BrownOut, kept, Some(of(FaultCode::BrownOut))),
        ResetCause::Watchdog => (Started::Watchdog, kept, Some(of(FaultCode::Watchdog))),
        ResetCause::Software => (Started::Software, kept, kept.or(Some(of(FaultCode::Panic)))),
        ResetCause::Pin => (Started::Pin, kept, None),
    }
}
