//! Simulated hardware and plants.
pub mod plant;
