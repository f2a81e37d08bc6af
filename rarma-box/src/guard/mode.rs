//! Modes of the box, and the stages of an output that is being used.

use serde::{Deserialize, Serialize};

/// What the box is doing. Only one of them owns the outputs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// Nothing but the link, the settings and the watch over the inputs.
    #[default]
    Safe,
    /// Listens and says what it hears. Owns no output.
    Monitor,
    /// Owns the coils.
    Cers,
    /// Owns the valve.
    Ldbb,
}

impl Mode {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Safe, Self::Monitor, Self::Cers, Self::Ldbb];

    /// Whether it may energise anything.
    pub const fn owns_outputs(self) -> bool {
        matches!(self, Self::Cers | Self::Ldbb)
    }

    /// As it is spelled on screens and in scenarios.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Safe => "safe",
            Self::Monitor => "monitor",
            Self::Cers => "cers",
            Self::Ldbb => "ldbb",
        }
    }
}

/// How far an output has come. Outputs can only be on from `Ramping` to `Stopping`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stage {
    /// Everything off.
    #[default]
    Off,
    /// Off; the supply of the power stage has to be steady.
    Precharge,
    /// Off; the sensors' zeros are being measured.
    Calibrating,
    /// Coming up to the working point.
    Ramping,
    /// At the working point.
    Ready,
    /// At the working point, and a signal on top of it.
    Exciting,
    /// Going down in order.
    Stopping,
    /// Off, and a fault is latched.
    Faulted,
}

impl Stage {
    /// Whether outputs may be on.
    pub const fn energised(self) -> bool {
        matches!(
            self,
            Self::Ramping | Self::Ready | Self::Exciting | Self::Stopping
        )
    }

    /// Whether outputs are on, or on their way there.
    pub const fn in_use(self) -> bool {
        !matches!(self, Self::Off | Self::Faulted)
    }

    /// As it is spelled on screens.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Precharge => "precharge",
            Self::Calibrating => "calibrating",
            Self::Ramping => "ramping",
            Self::Ready => "ready",
            Self::Exciting => "exciting",
            Self::Stopping => "stopping",
            Self::Faulted => "faulted",
        }
    }
}
