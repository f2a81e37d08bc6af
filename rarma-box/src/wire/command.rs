//! What the host tells the box, and how the box answers.
//!
//! Every command is one frame and gets one [`Reply`] with the command's sequence number. It
//! is for one session and, if it changes anything, by one turn of control: the host that the
//! box has given that turn to, and each of its numbers once. What has come before is answered
//! again and not carried out again; [`Refused`] has the names of all that is not taken. A frame
//! that is whole but not a command is refused by its number; one that is not whole cannot be
//! answered: it is counted and told.

use crate::guard::{Denial, FaultRecord, Mode, Severity, Stage};
use crate::settings::{SettingError, SettingValue};
use crate::wire::circle::{CircleJob, StandJob};
use heapless::{String, Vec};
use rarma_rigs::cers::{ExcitationJob, OutOfReach};
use serde::{Deserialize, Serialize};

/// Nobody's number.
pub const NOBODY: u32 = 0;

/// From the host: a command and who gives it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Order {
    /// The number of the turn, from the host whose turn it is; from any other, the number it
    /// has drawn for itself.
    pub by: u32,
    /// What is to be done.
    pub command: Command,
}

/// What the host wants.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Who are you? From anybody, whatever session it names.
    Identify,
    /// The program that armed the outputs still runs and still reaches the box. They stay on
    /// for `link.heartbeat` after it.
    Heartbeat,
    /// Read a setting.
    Read {
        /// Its number.
        setting: u16,
    },
    /// Set a setting until the next reset.
    Set {
        /// Its number.
        setting: u16,
        /// Its value.
        value: SettingValue,
    },
    /// Store the value in force of a setting. Only while outputs are off.
    Save {
        /// Its number.
        setting: u16,
    },
    /// Back to the default, in force and in store. Only while outputs are off.
    Reset {
        /// Its number.
        setting: u16,
    },
    /// Start a mode. Only while outputs are off.
    Start(Mode),
    /// Let outputs down in order, then off. From anybody: whoever is not in control ends the
    /// controller's turn with it.
    Stop,
    /// Switch the outputs of the mode on.
    Arm,
    /// Forget the latched fault.
    Clear,
    /// Send raw samples for so long, s, 0 to 3600; 0 ends a stream.
    Stream {
        /// How long, s.
        seconds: f32,
    },
    /// Pressure set point of LDBB, Pa.
    Pressure {
        /// Pa.
        pa: f32,
    },
    /// Current of every coil of CERS, A, in place of the bias.
    Current {
        /// A.
        a: f32,
    },
    /// Send a status message now.
    Status,
    /// A whole test of LDBB under way: pressures, circles, findings.
    Circle(CircleJob),
    /// A static test of LDBB under way: directions, pressures up and down.
    Stand(StandJob),
    /// The machine stands in the direction that the static test asked for.
    Go,
    /// A signal on top of the bias of CERS. Taken at the working point, where it starts at
    /// once, and with outputs off: it then starts as soon as they are armed and ready.
    Excite(ExcitationJob),
    /// End the signal, keep the bias.
    Quiet,
    /// Take control from whoever has it. Outputs that are on are let down in order, and the
    /// enable input must be released and pressed before they can be armed again.
    Take {
        /// The turn that it ends, as it was told: a copy of this command ends no other.
        turn: u32,
    },
    /// Give control up. Outputs that are on are let down in order.
    Release,
}

impl Command {
    /// Whether it changes nothing: it is taken from anybody.
    pub const fn only_asks(&self) -> bool {
        matches!(self, Self::Identify | Self::Status | Self::Read { .. })
    }

    /// The setting that it changes, if any.
    pub const fn changes(&self) -> Option<u16> {
        match self {
            Self::Set { setting, .. } | Self::Save { setting } | Self::Reset { setting } => {
                Some(*setting)
            }
            _ => None,
        }
    }
}

/// Why control has changed hands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Handed {
    /// The box has started: nobody has it.
    Start,
    /// A host has taken it.
    Taken,
    /// The host that had it has given it up.
    GivenUp,
    /// The host that had it was silent while outputs were on.
    HostLost,
    /// Another host has said `stop`.
    Stopped,
}

/// Whose turn it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ControlMessage {
    /// Number of the turn: drawn by the box whenever control changes hands.
    pub turn: u32,
    /// The number that the host in control has drawn for itself; [`NOBODY`]'s if there is
    /// none.
    pub by: u32,
    /// How it came by it.
    pub why: Handed,
    /// The box has a key: what changes anything must be sealed.
    pub key: bool,
}

/// The answer to a command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// Who gave the command, as it was said there; 0 if it could not be read.
    pub by: u32,
    /// Sequence number of the command.
    pub to: u32,
    /// What came of it.
    pub answer: Answer,
}

/// What came of a command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Answer {
    /// Done.
    Done,
    /// Who the box is.
    Identity(Identity),
    /// A setting.
    Setting(SettingMessage),
    /// Refused.
    Refused(Refused),
}

/// Why a command is refused.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Refused {
    /// It is whole, but no command that this box knows.
    NotACommand,
    /// Made by another version of the protocol.
    Version {
        /// The box's.
        box_version: u8,
    },
    /// Made for another session: the box has started anew since, or the host does not know it
    /// yet. The answer's head names the box's.
    Session,
    /// Another host is in control, or nobody: take it first.
    NotInControl,
    /// `Take` names a turn that is over.
    Turn,
    /// Its number has come before in this turn, and the answer is not kept any more. It has
    /// not been carried out again.
    Repeated,
    /// A later command has come before it. It is not carried out: `stop` alone is, late or
    /// not.
    Overtaken,
    /// Its number is more than 64 behind the last one, or 0.
    Old,
    /// The box has no key, and this is not its own port: nothing may be changed over a
    /// network.
    NoKey,
    /// The box has a key, and the seal is missing or made with another one.
    Seal,
    /// The key is changed at the box's own port only.
    OwnPort,
    /// Not now.
    Denied(Denial),
    /// The setting is unknown or its value is not allowed.
    Setting(SettingError),
    /// The bias or the signal is beyond what coils and supply can do.
    OutOfReach(OutOfReach),
    /// The flash did not take it; the value is in force all the same.
    Flash,
    /// There is no room in the flash.
    FlashFull,
}

/// A setting as it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SettingMessage {
    /// Its number.
    pub setting: u16,
    /// Value in force.
    pub value: SettingValue,
    /// Value in store; none if it follows the default.
    pub stored: Option<SettingValue>,
}

/// Why the box started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Started {
    /// Power came on.
    PowerOn,
    /// The supply fell and came back.
    BrownOut,
    /// The watchdog.
    Watchdog,
    /// The program, after last words.
    Software,
    /// Reset pin, debugger, or unknown.
    Pin,
}

/// Who the box is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Name of the board.
    pub board: String<24>,
    /// Version of the firmware.
    pub version: String<16>,
    /// Version of the table of settings.
    pub schema: u8,
    /// How many settings there are.
    pub settings: u16,
    /// Rate of the microphone, Hz.
    pub sample_rate_hz: f32,
    /// Rate of the current loop, Hz.
    pub loop_rate_hz: f32,
    /// Why it started.
    pub started: Started,
    /// The last fault before the reset, if it was kept.
    pub before: Option<FaultRecord>,
    /// Whose turn it is.
    pub control: ControlMessage,
}

/// A fault, sent at once.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FaultMessage {
    /// What, where, when.
    pub record: FaultRecord,
    /// What it does.
    pub severity: Severity,
    /// In which mode.
    pub mode: Mode,
}

/// How things stand.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// The box's clock, µs.
    pub now_us: u64,
    /// The mode.
    pub mode: Mode,
    /// The stage of its outputs.
    pub stage: Stage,
    /// The gate's read-back.
    pub energised: bool,
    /// Enable input closed, stop chain closed.
    pub contacts: (bool, bool),
    /// The latched fault.
    pub fault: Option<FaultRecord>,
    /// Mean coil currents, A.
    pub current_a: [f32; 4],
    /// Greatest heat of a winding, 1 is full.
    pub heat: f32,
    /// Gaps, m.
    pub gap_m: [f32; 2],
    /// Pressure, Pa.
    pub pressure_pa: f32,
    /// Gauge, m.
    pub gauge_m: f32,
    /// Supply of the power stage, V.
    pub supply_v: f32,
    /// A set point is being held back by a limit.
    pub limiting: bool,
    /// The enable input has to be released and pressed before outputs can be armed.
    pub press_again: bool,
    /// Whose turn it is.
    pub control: ControlMessage,
}

/// Counts since start-up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// Since start-up, µs.
    pub now_us: u64,
    /// Microphone samples taken.
    pub samples: u64,
    /// Microphone samples lost.
    pub missing: u64,
    /// Verdicts made.
    pub verdicts: u32,
    /// Frames made.
    pub frames: u32,
    /// Of them, not taken by the link.
    pub dropped: u32,
    /// Commands answered.
    pub commands: u32,
    /// Of them, refused.
    pub refused: u32,
    /// Of them, not carried out because of their numbers: copies, overtaken, old.
    pub doubled: u32,
    /// Broken frames received.
    pub garbage: u32,
    /// How often a duty was late.
    pub late: u32,
    /// Longest time between two check-ins of each duty, µs.
    pub longest_us: [u32; 4],
}

/// Samples in one raw message.
pub const RAW_SAMPLES: usize = 120;

/// Raw samples of the microphone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Raw {
    /// Number of the first one, counted from start-up with those that were lost.
    pub first: u64,
    /// Pairs of bytes, little endian, 32767 is full scale.
    pub bytes: Vec<u8, { 2 * RAW_SAMPLES }>,
}

impl Raw {
    /// An empty message.
    pub fn new(first: u64) -> Self {
        Self {
            first,
            bytes: Vec::new(),
        }
    }

    /// Adds a sample in parts of full scale; false if there is no room. NaN becomes 0.
    pub fn push(&mut self, x: f32) -> bool {
        let code = (x * 32767.0) as i16;
        self.bytes.extend_from_slice(&code.to_le_bytes()).is_ok()
    }

    /// The samples in parts of full scale.
    pub fn samples(&self) -> impl Iterator<Item = f32> + '_ {
        self.bytes
            .as_chunks()
            .0
            .iter()
            .map(|b| f32::from(i16::from_le_bytes(*b)) / 32767.0)
    }

    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.bytes.len() / 2
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }
}
