//! Where there is no screen: a browser, or a program that was built without.

use crate::args::ScreenArg;
use crate::collect::News;
use crate::failure::Failure;
use rarma_box::wire::Telemetry;
use std::sync::mpsc::SyncSender;

/// What brings a program to its end in order.
pub(crate) type Leave = Box<dyn Fn() + Send>;

/// What is listened to.
#[allow(dead_code, reason = "filled in as for the screen that there is")]
pub(crate) struct Sound {
    pub title: String,
    pub fs: f64,
    pub band_hz: (f64, f64),
    pub threshold: f64,
}

/// A screen that cannot be opened, so there is none.
pub(crate) enum Screen {}

/// Whether a screen is wanted and can be.
///
/// # Errors
/// It is asked for.
pub(crate) fn wanted(asked: Option<ScreenArg>, _: bool, _: bool) -> Result<bool, Failure> {
    match asked {
        Some(ScreenArg::On) => Err(Failure::System(
            "--screen on: this program was built without a screen (build it with `cargo build --release -p rarma-cli`, or leave --screen out)"
                .to_owned(),
        )),
        _ => Ok(false),
    }
}

/// None are shown.
pub(crate) fn settings() -> Vec<u16> {
    Vec::new()
}

fn never<S>() -> Result<S, Failure> {
    wanted(Some(ScreenArg::On), false, false).and_then(|_| Err(Failure::Closed))
}

impl Screen {
    pub(crate) fn of_sound(_: Sound, _: Leave) -> Result<Self, Failure> {
        never()
    }

    pub(crate) fn of_box(_: String, _: SyncSender<String>, _: Leave) -> Result<Self, Failure> {
        never()
    }

    pub(crate) fn samples(&self, _: &[f64]) {
        match *self {}
    }

    pub(crate) fn news(&self, _: &News) {
        match *self {}
    }

    pub(crate) fn advice(&self, _: Vec<String>) {
        match *self {}
    }

    pub(crate) fn message(&self, _: &Telemetry, _: bool) {
        match *self {}
    }

    pub(crate) fn frames(&self, _: u64, _: Option<String>) {
        match *self {}
    }

    pub(crate) fn event(&self, _: String) {
        match *self {}
    }

    pub(crate) fn close(self) -> Result<(), Failure> {
        match self {}
    }
}

/// Ends the program at once; there is nothing to give back.
pub(crate) fn end_at_once(code: i32) -> ! {
    std::process::exit(code);
}
