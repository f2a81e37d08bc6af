//! What most programs need: `use rarma_core::prelude::*;`.

pub use crate::estimate::{
    Arma21, Arma22, Arma43, Arma44, Arma65, Arma66, Arma87, Arma88, RarmaConfig, RecursiveArma,
    Status,
};
#[cfg(feature = "monitor")]
pub use crate::{
    Monitor, Order,
    decide::{AlarmEvent, State},
    monitor::{Identifier, MonitorConfig, Report},
};
pub use crate::{
    Real,
    spectrum::{FactorTracker, Modal, ModalDeviation, Quadratic, Roots, deviation, modal},
};
