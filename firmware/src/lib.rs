//! The sensor box application.
#![no_std]
