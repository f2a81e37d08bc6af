//! What `rarma els` computes, without its screens: hammer records to receptances and
//! modes, diagrams of limits and stiffness, and the computational model's pictures.

pub mod diagram;
pub mod hammer;
pub mod machine;

pub use diagram::{Cut, Diagram};
