//! What is under way of a box, and the records that it becomes.

use super::GAP_S;
use crate::gateway::words;
use crate::record::{
    AlarmReleased, Body, Clock, Id, Mode, Name, Record, SCHEMA, State, Utc, Verdict,
};
use rarma_box::wire::Head;
use rarma_core::named::Named;
use serde::{Deserialize, Serialize};

/// Numbers of records of one frame.
const OF_A_FRAME: u64 = 16;
/// Places of records in a frame, in the order in which they are made.
pub(super) const STRETCH: u64 = 0;
pub(super) const HOLE: u64 = 1;
pub(super) const CALLED: u64 = 2;
pub(super) const RELEASED: u64 = 3;
/// What ended at a frame because the next one did not come.
pub(super) const STRETCH_ENDED: u64 = 4;
pub(super) const ALARM_ENDED: u64 = 5;

/// Of which box and machine, and what stands in the head of its records.
#[derive(Debug, Clone)]
pub struct Whose {
    /// The box.
    pub sender: Name,
    /// The machine it listens to.
    pub machine: Name,
    /// Tool in the spindle, as the controller told it.
    pub tool: Option<Name>,
    /// Teeth of the tool, as the controller told it.
    pub teeth: Option<u32>,
    /// Hash of the settings in force.
    pub settings: Option<Name>,
    /// Version of the firmware.
    pub firmware: Option<Name>,
}

impl Whose {
    /// A box of which nothing else is known.
    #[must_use]
    pub fn new(sender: Name, machine: Name) -> Self {
        Self {
            sender,
            machine,
            tool: None,
            teeth: None,
            settings: None,
            firmware: None,
        }
    }
}

/// What is under way. It is kept in the journal, so that a gateway that was killed goes on
/// where it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnderWay {
    pub(super) session: u64,
    /// Number of the last frame with a verdict or an alarm.
    pub(super) sequence: u32,
    /// The box's clock at that verdict, s.
    pub(super) box_s: f64,
    /// Rate of the box's samples, Hz.
    pub(super) fs_hz: f64,
    /// Time between the last two verdicts, s.
    pub(super) every_s: Option<f64>,
    pub(super) stretch: Stretch,
    pub(super) alarm: Option<Alarm>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    pub(super) from: Utc,
    pub(super) from_box_s: f64,
    #[serde(with = "rarma_core::named")]
    pub(super) state: State,
    pub(super) reason: Name,
    pub(super) level: Option<f64>,
    pub(super) rpm: Option<f64>,
    pub(super) modes: Vec<Mode>,
    /// The tool at the last verdict.
    #[serde(default)]
    pub(super) tool: Option<Name>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alarm {
    pub(super) called: u64,
    pub(super) at_box_s: f64,
    pub(super) f_hz: f64,
    pub(super) zeta_lowest: f64,
    pub(super) rpm: Option<f64>,
}

/// A frame as it came, and when that was.
pub struct Seen {
    pub(super) head: Head,
    pub(super) time: Utc,
    pub(super) clock: Clock,
}

impl Seen {
    pub(super) fn session(&self) -> u64 {
        u64::from(self.head.session)
    }
}

impl UnderWay {
    /// When it was last heard.
    pub(super) fn last(&self) -> Utc {
        self.stretch
            .from
            .plus_s(self.box_s - self.stretch.from_box_s)
    }

    /// Whether a verdict of this state follows the last one without a hole. Where verdicts are lost
    /// between two states nobody knows when one became the other.
    pub(super) fn goes_on(&self, seen: &Seen, state: State, lost: bool) -> bool {
        let since_s = seen.clock.box_s - self.box_s;
        let next_s = 1.5 * self.every_s.unwrap_or(0.0);
        let most_s = match state == self.stretch.state {
            true => GAP_S.max(next_s),
            false => next_s,
        };
        self.session == seen.session() && since_s >= 0.0 && (!lost || since_s <= most_s)
    }
}

pub(super) fn stretch(
    verdict: &rarma_box::wire::Verdict,
    from: Utc,
    from_box_s: f64,
    tool: Option<Name>,
) -> Stretch {
    Stretch {
        tool,
        from,
        from_box_s,
        state: verdict.state,
        reason: words::name(verdict.reason.name()),
        level: Some(words::decimal(verdict.level).max(0.0)),
        rpm: verdict
            .spindle
            .hz
            .map(|hz| words::decimal(hz * 60.0).max(0.0)),
        modes: verdict.modes.iter().map(words::mode).collect(),
    }
}

impl Whose {
    pub(super) fn record(
        &self,
        (session, seq): (u64, u64),
        tool: Option<Name>,
        time: Utc,
        clock: Clock,
        body: Body,
    ) -> Record {
        Record {
            schema: SCHEMA,
            id: Id {
                sender: self.sender.clone(),
                session,
                seq,
            },
            machine: self.machine.clone(),
            time,
            clock: Some(clock),
            tool,
            operator: None,
            settings: self.settings.clone(),
            firmware: self.firmware.clone(),
            body,
        }
    }
}

impl Stretch {
    /// Another verdict of the same state: the modes are those where the least damped is lowest.
    pub(super) fn merge(&mut self, next: Self) {
        let least = |modes: &[Mode]| modes.iter().map(|m| m.zeta).fold(f64::INFINITY, f64::min);
        if least(&next.modes) < least(&self.modes) {
            self.modes = next.modes;
        }
        self.tool = next.tool;
        self.level = next.level.or(self.level);
        self.rpm = next.rpm.or(self.rpm);
    }

    pub(super) fn body(self, seconds: f64) -> Body {
        Body::Verdict(Verdict {
            state: self.state,
            reason: self.reason,
            seconds: rounded_s(seconds),
            level: self.level,
            rpm: self.rpm,
            modes: self.modes,
        })
    }
}

impl Alarm {
    /// Its release, with what the box said of it, or else with what was seen of it.
    pub(super) fn released(self, said: Option<(f64, f64)>, at_box_s: f64) -> Body {
        let (f_hz, zeta_lowest) = said.unwrap_or((self.f_hz, self.zeta_lowest));
        Body::AlarmReleased(AlarmReleased {
            called: self.called,
            seconds: rounded_s((at_box_s - self.at_box_s).max(0.0)),
            f_hz,
            zeta_lowest,
            zeta_median: None,
            rpm: self.rpm,
        })
    }
}

/// To a microsecond, as times are.
pub(super) fn rounded_s(seconds: f64) -> f64 {
    (1e6 * seconds).round() / 1e6
}

pub(super) fn number(sequence: u32, place: u64) -> u64 {
    u64::from(sequence) * OF_A_FRAME + place
}
