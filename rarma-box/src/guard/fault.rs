//! The faults of the box: what can go wrong, where, with which value and when.
//!
//! Glossary. *Trip*: the outputs go off and stay off until the fault is cleared.
//! *Notice*: the host is told, the box goes on. Which of the two a fault is depends
//! on the mode; see [`Severity`].

use super::mode::Mode;
use crc::{CRC_16_IBM_SDLC, Crc};
use serde::{Deserialize, Serialize};

macro_rules! faults {
    ($($(#[doc = $doc:literal])+ $name:ident = $number:literal, $text:literal, $unit:literal, $class:ident;)*) => {
        /// What has gone wrong. The numbers are part of the wire and of the record kept
        /// across a reset: they are never used again for something else.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[repr(u8)]
        pub enum FaultCode {
            $($(#[doc = $doc])+ $name = $number,)*
        }

        impl FaultCode {
            /// All of them, in the order of their numbers.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// As it is spelled in records and on screens.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }

            /// Unit of the value that is told with it.
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$name => $unit,)* }
            }

            /// Which modes it stops.
            pub const fn class(self) -> Class {
                match self { $(Self::$name => Class::$class,)* }
            }

            /// The fault of a number.
            pub fn from_number(number: u8) -> Option<Self> {
                match number { $($number => Some(Self::$name),)* _ => None }
            }
        }
    };
}

/// Which modes a fault stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// No mode: the host is told.
    Listening,
    /// Any mode that owns outputs.
    Outputs,
    /// Any mode that owns outputs; elsewhere the host is told.
    Timing,
    /// CERS only; elsewhere the part is not in use.
    Cers,
    /// LDBB only; elsewhere the part is not in use.
    Ldbb,
    /// Every mode: nothing can be armed until it is cleared. Listening goes on.
    All,
    /// Told after a reset; the reset has switched everything off.
    Past,
}

faults! {
    /// Emergency stop pressed.
    EmergencyStop = 1, "emergency-stop", "1", All;
    /// The enable input fell while outputs were on.
    EnableLost = 2, "enable-lost", "1", Outputs;
    /// No heartbeat of the host for longer than the setting; value: silence, s.
    HeartbeatLost = 3, "heartbeat-lost", "s", Outputs;
    /// A duty did not check in within its deadline; place: the duty; value: age, s.
    DeadlineMissed = 4, "deadline-missed", "s", Timing;
    /// The current loop ran without a fresh order and let go; value: periods.
    OrderStale = 5, "order-stale", "periods", Outputs;
    /// The current loop does not run.
    LoopSilent = 6, "loop-silent", "s", Cers;
    /// A number that reached a limit check was NaN or infinite.
    NotFinite = 7, "not-finite", "1", Timing;
    /// The output gate did not do what it was told.
    Gate = 8, "gate", "1", All;
    /// Supply of the power stage too low; value: V.
    SupplyLow = 9, "supply-low", "V", Outputs;
    /// Supply of the power stage too high; value: V.
    SupplyHigh = 10, "supply-high", "V", Outputs;

    /// Comparator trip: the hardware took the bridges down by itself; place: coil.
    Comparator = 20, "comparator", "A", Cers;
    /// A coil's current beyond the limit; place: coil; value: A.
    OverCurrent = 21, "over-current", "A", Cers;
    /// The thermal model of a winding is full; place: coil; value: (i/i_n)².
    Overload = 22, "overload", "1", Cers;
    /// Voltage without current; place: coil; value: A.
    CoilOpen = 23, "coil-open", "A", Cers;
    /// Current with hardly any voltage; place: coil; value: Ω.
    CoilShort = 24, "coil-short", "ohm", Cers;
    /// A current sensor at the end of its range; place: coil; value: code.
    CurrentSensorLost = 25, "current-sensor-lost", "code", Cers;
    /// A current sensor that does not move at all; place: coil; value: code.
    CurrentSensorStuck = 26, "current-sensor-stuck", "code", Cers;
    /// A current sensor's zero is too far off with the bridge off; place: coil; value: A.
    CurrentSensorOffset = 27, "current-sensor-offset", "A", Cers;
    /// The bridge refused an order.
    Bridge = 28, "bridge", "1", Cers;
    /// A displacement sensor at the end of its range; place: axis; value: code.
    GapSensorLost = 29, "gap-sensor-lost", "code", Cers;
    /// A displacement sensor that does not move at all; place: axis; value: code.
    GapSensorStuck = 30, "gap-sensor-stuck", "code", Cers;
    /// The gap is below the trip limit; place: axis; value: m.
    GapClosed = 31, "gap-closed", "m", Cers;
    /// The spindle is faster than allowed; value: Hz.
    Overspeed = 32, "overspeed", "Hz", Cers;
    /// The supply does not come to rest before the outputs are switched on; value: waited, s.
    SupplyUnsteady = 33, "supply-unsteady", "s", Outputs;
    /// A winding is hotter than allowed; value: K.
    WindingHot = 34, "winding-hot", "K", Cers;
    /// The winding's thermistor is torn off or shorted; value: code.
    ThermistorLost = 35, "thermistor-lost", "code", Cers;

    /// The pressure transducer is out of its range; value: code.
    PressureSensorLost = 40, "pressure-sensor-lost", "code", Ldbb;
    /// Pressure beyond the limit; value: Pa.
    PressureHigh = 41, "pressure-high", "Pa", Ldbb;
    /// The pressure does not follow the valve at all; value: Pa.
    ValveStuck = 42, "valve-stuck", "Pa", Ldbb;
    /// The pressure stays below what the valve should give; value: Pa short.
    PressureLeak = 43, "pressure-leak", "Pa", Ldbb;
    /// The gauge is out of its electrical range; value: code.
    GaugeLost = 44, "gauge-lost", "code", Ldbb;
    /// The gauge is beyond its travel: a ball is about to leave its seat; value: m.
    GaugeRange = 45, "gauge-range", "m", Ldbb;
    /// The valve's converter refused an order.
    Valve = 46, "valve", "1", Ldbb;
    /// The other sensors could not be read at all.
    SensorsLost = 47, "sensors-lost", "1", Outputs;

    /// The microphone's samples stopped; value: s.
    SamplesStopped = 60, "samples-stopped", "s", Listening;
    /// Samples were lost; value: how many.
    SamplesMissing = 61, "samples-missing", "samples", Listening;
    /// The samples do not move.
    SamplesStuck = 62, "samples-stuck", "1", Listening;
    /// The samples are clipped.
    SamplesClipped = 63, "samples-clipped", "1", Listening;
    /// Samples are NaN, infinite or impossibly large.
    SamplesNotFinite = 64, "samples-not-finite", "1", Listening;
    /// The microphone is louder than any cut: noise or a loose cable; value: RMS.
    SamplesLoud = 65, "samples-loud", "full scale", Listening;
    /// No pulses of the tacho for longer than the setting; value: s.
    TachoSilent = 66, "tacho-silent", "s", Listening;
    /// Pulses of the tacho without a rhythm, or far too many; value: Hz.
    TachoNoisy = 67, "tacho-noisy", "Hz", Listening;
    /// A gap is below the warning limit; place: axis; value: m.
    GapNarrow = 68, "gap-narrow", "m", Listening;
    /// A microphone is not listened to any more, the other one is; value: which, 1 or 2.
    MicrophoneDropped = 69, "microphone-dropped", "number", Listening;

    /// Bytes on the link that are no frame; value: broken frames since the last notice.
    LinkGarbage = 80, "link-garbage", "frames", Listening;
    /// More bytes than the link duty takes; value: bytes left behind.
    LinkFlood = 81, "link-flood", "bytes", Listening;
    /// The host does not take frames; value: frames dropped.
    LinkBlocked = 82, "link-blocked", "frames", Listening;
    /// A setting could not be written; value: its number.
    FlashWrite = 83, "flash-write", "1", Listening;
    /// There is no room left for settings.
    FlashFull = 84, "flash-full", "1", Listening;
    /// A stored setting was not usable: its default is in force; place: in the table; value:
    /// its number.
    SettingRefused = 85, "setting-refused", "number", Listening;
    /// The store of settings could not be read: all defaults are in force.
    SettingsLost = 86, "settings-lost", "1", Listening;

    /// The watchdog reset the box.
    Watchdog = 100, "watchdog", "1", Past;
    /// The supply of the controller fell: reset.
    BrownOut = 101, "brown-out", "1", Past;
    /// The program gave up; value: none.
    Panic = 102, "panic", "1", Past;
    /// The processor took an exception it cannot return from.
    HardFault = 103, "hard-fault", "1", Past;
    /// Memory of the program gave what it was not given: it cannot be trusted; value: address.
    MemoryError = 104, "memory-error", "address", Past;
    /// Damaged words where settings are, mostly one whose writing a power cut ended; what
    /// that did to a setting is told beside it; value: words.
    FlashUnreadable = 105, "flash-unreadable", "words", Listening;
    /// Words where settings are in which the flash has mended a bit: it ages; value: words.
    FlashCorrected = 106, "flash-corrected", "words", Listening;
    /// One of a setting's two records was missing or damaged; the good one is in force and
    /// stands twice again; place: in the table; value: its number.
    SettingRepaired = 107, "setting-repaired", "number", Listening;
    /// A setting's newest records are damaged: an older value is in force; place: in the
    /// table; value: its number.
    SettingOlder = 108, "setting-older", "number", Listening;
    /// A setting's only records are damaged: its default is in force; place: in the table;
    /// value: its number.
    SettingDefault = 109, "setting-default", "number", Listening;
    /// A setting is stored once and not twice: one half of the flash did not take it; place:
    /// in the table; value: its number.
    SettingOnce = 110, "setting-once", "number", Listening;
    /// The crystal of the controller stopped: reset.
    ClockFailed = 111, "clock-failed", "1", Past;
    /// The controller's brown-out reset comes far below what the parts at its side need: its option
    /// byte is not set; value: where it comes, V.
    BrownOutLow = 112, "brown-out-low", "V", Listening;
}

/// What a fault does in a mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Severity {
    /// The part is not in use in this mode: nothing is said.
    Unused,
    /// The host is told.
    Notice,
    /// The outputs go off, the fault is latched, the host is told.
    Trip,
}

impl FaultCode {
    /// What this fault does in a mode.
    pub const fn severity(self, mode: Mode) -> Severity {
        match (self.class(), mode) {
            (Class::All, _)
            | (Class::Outputs | Class::Timing, Mode::Cers | Mode::Ldbb)
            | (Class::Cers, Mode::Cers)
            | (Class::Ldbb, Mode::Ldbb)
            | (Class::Past, _) => Severity::Trip,
            (Class::Listening | Class::Timing, _) => Severity::Notice,
            _ => Severity::Unused,
        }
    }
}

/// A fault, where and when.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultRecord {
    /// What.
    pub code: FaultCode,
    /// Which coil, axis or duty, from 0; 0 where there is only one.
    pub place: u8,
    /// Value that made it, in [`FaultCode::unit`].
    pub value: f32,
    /// Since start-up, µs.
    pub at_us: u64,
}

/// Bytes of a record that is kept across a reset.
pub const KEPT_BYTES: usize = 20;
const KEPT_MARK: [u8; 4] = *b"RAF1";
const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_SDLC);

impl FaultRecord {
    /// The record as it is kept in memory that a reset does not clear.
    pub fn to_kept(self) -> [u8; KEPT_BYTES] {
        let mut kept = [0; KEPT_BYTES];
        kept[..4].copy_from_slice(&KEPT_MARK);
        kept[4] = self.code as u8;
        kept[5] = self.place;
        kept[6..10].copy_from_slice(&self.value.to_le_bytes());
        kept[10..18].copy_from_slice(&self.at_us.to_le_bytes());
        let crc = CRC.checksum(&kept[..18]).to_le_bytes();
        kept[18..].copy_from_slice(&crc);
        kept
    }

    /// The record that was kept; none after a power-up, when the memory holds anything.
    pub fn from_kept(kept: &[u8; KEPT_BYTES]) -> Option<Self> {
        let [.., low, high] = *kept;
        let sound =
            kept[..4] == KEPT_MARK && CRC.checksum(&kept[..18]) == u16::from_le_bytes([low, high]);
        if !sound {
            return None;
        }
        let mut value = [0; 4];
        let mut at = [0; 8];
        value.copy_from_slice(&kept[6..10]);
        at.copy_from_slice(&kept[10..18]);
        Some(Self {
            code: FaultCode::from_number(kept[4])?,
            place: kept[5],
            value: f32::from_le_bytes(value),
            at_us: u64::from_le_bytes(at),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_records_come_back_and_anything_else_does_not() {
        for &code in FaultCode::ALL {
            let record = FaultRecord {
                code,
                place: 3,
                value: -0.25,
                at_us: 1 << 40,
            };
            let kept = record.to_kept();
            assert_eq!(FaultRecord::from_kept(&kept), Some(record));
            for bit in 0..8 * KEPT_BYTES {
                let mut spoilt = kept;
                spoilt[bit / 8] ^= 1 << (bit % 8);
                assert_eq!(FaultRecord::from_kept(&spoilt), None, "bit {bit}");
            }
        }
        assert_eq!(FaultRecord::from_kept(&[0; KEPT_BYTES]), None);
        assert_eq!(FaultRecord::from_kept(&[0xFF; KEPT_BYTES]), None);
    }

    #[test]
    fn numbers_and_names_are_unique() {
        for (k, a) in FaultCode::ALL.iter().enumerate() {
            assert_eq!(FaultCode::from_number(*a as u8), Some(*a));
            for b in &FaultCode::ALL[k + 1..] {
                assert!(a.name() != b.name() && *a as u8 != *b as u8);
            }
        }
    }
}
