//! A monitor whose order is chosen at run time.

use super::{Monitor, MonitorConfig, MonitorError, Report};
use crate::condition::{Fault, HealthCounts};
use crate::decide::Histogram;
use crate::order::Order;
use crate::real::Real;

macro_rules! any_monitor {
    ($($variant:ident: $p:literal, $q:literal, $n:literal;)*) => {
        /// A [`Monitor`] of any order the box offers. As large as the largest.
        #[derive(Debug, Clone)]
        // The sizes differ on purpose: one value lives in static memory for ever.
        #[allow(clippy::large_enum_variant)]
        pub enum AnyMonitor<T> {
            $(
                #[doc = concat!("ARMA(", $p, ",", $q, ").")]
                $variant(Monitor<T, $p, $q, $n>),
            )*
        }

        impl<T: Real> AnyMonitor<T> {
            /// A monitor of the order in `config`.
            ///
            /// # Errors
            /// See [`MonitorConfig::check`].
            pub fn new(config: &MonitorConfig) -> Result<Self, MonitorError> {
                Ok(match config.order {
                    $(Order::$variant => Self::$variant(Monitor::new(config)?),)*
                })
            }

            /// Makes `slot` a monitor of the order in `config`, in place.
            ///
            /// A monitor is 21 KB, and every function that hands one on by value may need
            /// its size on the stack again; this needs it twice, whatever the caller.
            ///
            /// # Errors
            /// See [`MonitorConfig::check`]; `slot` is then as it was.
            pub fn place(slot: &mut Option<Self>, config: &MonitorConfig) -> Result<(), MonitorError> {
                match config.order {
                    $(Order::$variant => place_as(slot, config, Self::$variant),)*
                }
            }

            /// Takes one sample; see [`Monitor::push`].
            #[inline]
            pub fn push(&mut self, x: T) -> Option<Report<T>> {
                match self {
                    $(Self::$variant(m) => m.push(x),)*
                }
            }

            /// See [`Monitor::missing`].
            pub fn missing(&mut self, samples: u32) {
                match self {
                    $(Self::$variant(m) => m.missing(samples),)*
                }
            }

            /// See [`Monitor::pulse`].
            pub fn pulse(&mut self, fraction: T) {
                match self {
                    $(Self::$variant(m) => m.pulse(fraction),)*
                }
            }

            /// See [`Monitor::histogram`].
            pub fn histogram(&self) -> Histogram<T> {
                match self {
                    $(Self::$variant(m) => m.histogram(),)*
                }
            }

            /// See [`Monitor::health`].
            pub fn health(&self) -> HealthCounts {
                match self {
                    $(Self::$variant(m) => m.health(),)*
                }
            }

            /// See [`Monitor::fault`].
            pub fn fault(&self) -> Option<Fault> {
                match self {
                    $(Self::$variant(m) => m.fault(),)*
                }
            }

            /// See [`Monitor::samples`].
            pub fn samples(&self) -> u64 {
                match self {
                    $(Self::$variant(m) => m.samples(),)*
                }
            }
        }
    };
}

/// One order's part of [`AnyMonitor::place`]: not inlined, so that the temporaries of the
/// orders do not lie on the stack side by side.
#[inline(never)]
fn place_as<T: Real, const P: usize, const Q: usize, const N: usize>(
    slot: &mut Option<AnyMonitor<T>>,
    config: &MonitorConfig,
    variant: impl FnOnce(Monitor<T, P, Q, N>) -> AnyMonitor<T>,
) -> Result<(), MonitorError> {
    *slot = Some(variant(Monitor::new(config)?));
    Ok(())
}

any_monitor! {
    O21: 2, 1, 3;
    O22: 2, 2, 4;
    O43: 4, 3, 7;
    O44: 4, 4, 8;
    O65: 6, 5, 11;
    O66: 6, 6, 12;
    O87: 8, 7, 15;
    O88: 8, 8, 16;
}
