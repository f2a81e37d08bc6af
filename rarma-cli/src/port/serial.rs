//! Serial ports; a browser has none.

#[cfg(not(target_family = "wasm"))]
pub(super) use serial2::SerialPort;

/// A port that cannot be opened, so there is none.
#[cfg(target_family = "wasm")]
pub(super) enum SerialPort {}

#[cfg(target_family = "wasm")]
mod none {
    use super::SerialPort;
    use std::io::{Error, ErrorKind, Result};
    use std::time::Duration;

    impl SerialPort {
        pub(in super::super) fn open(_: &str, _: u32) -> Result<Self> {
            Err(Error::from(ErrorKind::Unsupported))
        }

        pub(in super::super) fn set_read_timeout(&mut self, _: Duration) -> Result<()> {
            match *self {}
        }

        pub(in super::super) fn read(&self, _: &mut [u8]) -> Result<usize> {
            match *self {}
        }

        pub(in super::super) fn write_all(&self, _: &[u8]) -> Result<()> {
            match *self {}
        }
    }
}
