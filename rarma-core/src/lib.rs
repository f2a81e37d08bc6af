//! Recursive ARMA identification of machine-tool vibration.
#![no_std]
