//! The Rust half of the Python package `rarma`: arrays in, arrays and records out. What is
//! computed, the core and the command's own library compute.

mod array;
mod batch;
mod channels;
mod error;
mod estimator;
mod frames;
mod json;
mod monitor;
mod monitor_state;
mod options;
mod read;
mod recursive;
mod results;
mod scenario;
mod settings;
mod shared;
mod state;

use pyo3::prelude::*;

#[pymodule]
mod _rarma {
    #[pymodule_export]
    use crate::batch::{identify, order, psd};
    #[pymodule_export]
    use crate::channels::identify_channels;
    #[pymodule_export]
    use crate::frames::decode;
    #[pymodule_export]
    use crate::monitor::{Monitor, monitor_of_state};
    #[pymodule_export]
    use crate::read::read;
    #[pymodule_export]
    use crate::recursive::RecursiveArma;
    #[pymodule_export]
    use crate::scenario::{lobes, scenarios, simulate};
    #[pymodule_export]
    use crate::shared::RecursiveChannels;
}
