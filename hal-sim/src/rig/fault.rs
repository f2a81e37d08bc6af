//! The catalogue of what can be made to go wrong, by name and time.

macro_rules! catalogue {
    ($($(#[doc = $doc:literal])+ $variant:ident = $name:literal;)*) => {
        /// What can be made to go wrong.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum FaultKind {
            $($(#[doc = $doc])+ $variant,)*
        }

        impl FaultKind {
            /// The whole catalogue.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// As it is spelled in scenarios.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// What it is, in a line.
            pub const fn about(self) -> &'static str {
                match self { $(Self::$variant => concat!($($doc,)+),)* }
            }

            /// The fault of a name.
            pub fn named(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|kind| kind.name() == name)
            }
        }
    };
}

catalogue! {
    /// the microphone's value stays where it is
    MicStuck = "mic-stuck";
    /// white noise up to 98 % of full scale on the microphone
    MicNoisy = "mic-noisy";
    /// the microphone's gain is 40 times too high
    MicClipped = "mic-clipped";
    /// the microphone's converter delivers NaN
    MicNan = "mic-nan";
    /// 500 microphone samples are lost in an overrun, once
    MicOverrun = "mic-overrun";
    /// the microphone's converter is not triggered any more
    MicDead = "mic-dead";
    /// no pulses of the tacho
    TachoLost = "tacho-lost";
    /// pulses of the tacho at random
    TachoNoisy = "tacho-noisy";
    /// a coil's current sensor is torn off: end of range
    CurrentSensorLost = "current-sensor-lost";
    /// a coil's current sensor stays where it is
    CurrentSensorStuck = "current-sensor-stuck";
    /// a coil's wire breaks
    CoilOpen = "coil-open";
    /// 70 % of a coil's turns are shorted
    CoilShort = "coil-short";
    /// a coil is shorted at its terminals
    CoilDeadShort = "coil-dead-short";
    /// something pushes a coil's current up slowly: beyond the trip, below the comparator
    CurrentSurge = "current-surge";
    /// the bridge's timer refuses orders
    BridgeRefuses = "bridge-refuses";
    /// the current converter is not triggered any more
    CurrentDead = "current-dead";
    /// the current loop's interrupt does not come any more
    LoopDead = "loop-dead";
    /// a displacement sensor is torn off
    GapLost = "gap-lost";
    /// a displacement sensor stays where it is
    GapStuck = "gap-stuck";
    /// a gap closes at 2 mm/s
    GapClosing = "gap-closing";
    /// the spindle runs too fast
    Overspeed = "overspeed";
    /// the supply of the power stage falls to 30 V
    SupplyLow = "supply-low";
    /// the supply of the power stage hunts by 2 V
    SupplyUnsteady = "supply-unsteady";
    /// a winding is hotter than its current explains
    WindingHot = "winding-hot";
    /// the winding's thermistor is torn off
    ThermistorLost = "thermistor-lost";
    /// the supply of the power stage rises to 62 V
    SupplyHigh = "supply-high";
    /// the supply of the power stage falls to 30 V and comes back; the controller lives on
    SupplyDip = "supply-dip";
    /// the slow converter does not convert any more
    SensorsDead = "sensors-dead";
    /// the pressure regulator stays where it is
    ValveStuck = "valve-stuck";
    /// 40 % of the pressure leaks away
    PressureLeak = "pressure-leak";
    /// the pressure transducer is torn off
    PressureLost = "pressure-lost";
    /// the regulator runs away upwards
    PressureHigh = "pressure-high";
    /// the gauge is torn off
    GaugeLost = "gauge-lost";
    /// the bar leaves its seat: the gauge runs beyond its travel
    GaugeRange = "gauge-range";
    /// the valve's converter refuses orders
    ValveRefuses = "valve-refuses";
    /// the output gate does not close
    GateRefuses = "gate-refuses";
    /// the output gate does not open any more
    GateWelded = "gate-welded";
    /// no byte comes from the host
    LinkSilent = "link-silent";
    /// the host's bytes are replaced by garbage
    LinkGarbage = "link-garbage";
    /// far more bytes come than the link can carry
    LinkFlood = "link-flood";
    /// the host takes no bytes
    LinkBlocked = "link-blocked";
    /// 3 % of the bytes are dropped, doubled or changed, both ways
    LinkNoisy = "link-noisy";
    /// the host sends no heartbeats
    HeartbeatLost = "heartbeat-lost";
    /// the main loop stands still for 8 ms
    MainLate = "main-late";
    /// the main loop stands still for ever
    MainHangs = "main-hangs";
    /// the controller's supply falls for 5 ms
    BrownOut = "brown-out";
    /// all power goes away for 50 ms
    PowerCut = "power-cut";
    /// the emergency stop is pressed
    EmergencyStop = "emergency-stop";
    /// the enable input opens
    EnableLost = "enable-lost";
    /// the program panics
    Panic = "panic";
    /// the processor takes an exception it cannot return from
    HardFault = "hard-fault";
    /// the flash of the settings does not write any more
    FlashWorn = "flash-worn";
    /// records of settings that this firmware does not know fill the flash
    FlashFull = "flash-full";
}

impl FaultKind {
    /// It changes a coil's circuit, which only the rig without magnets can do.
    pub const fn needs_chokes(self) -> bool {
        matches!(
            self,
            Self::CoilOpen
                | Self::CoilShort
                | Self::CoilDeadShort
                | Self::CurrentSurge
                | Self::SupplyLow
                | Self::SupplyHigh
                | Self::SupplyUnsteady
        )
    }
}

/// A fault, where, from when to when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultEvent {
    /// What.
    pub kind: FaultKind,
    /// Coil or axis, from 0.
    pub place: usize,
    /// From, µs.
    pub from_us: u64,
    /// To, µs.
    pub to_us: u64,
}
