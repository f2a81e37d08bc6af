//! What later checks need, made while the first ones run: what comes over a network, and the page in a browser, whose last
//! step keeps one core busy for minutes.
//!
//! Nothing is done here that a check would not do itself, by the same function; what cannot be had is told by that
//! check, with the reason. No check that needs what is fetched may begin before the thread of [`begin`] has ended; for what
//! is built cargo's own locks see to it.

use std::thread::{self, JoinHandle};
use std::time::Instant;

use crate::chip::model::Model;
use crate::fuzz::Engine;
use crate::needs::{broker::broker, browser::browser, controller, databases::databases};
use crate::toolchain::{ARM, Toolchain};
use crate::{Result, Workspace, qemu, sound, tmux, web};

type Need = (&'static str, fn(&Workspace) -> Result<()>);

/// In the order in which checks ask for them.
const FETCHED: [Need; 11] = [
    ("a compiler for boards", |w| {
        Toolchain::find_or_make(w, ARM).map(drop)
    }),
    ("the model of the board's chip", |w| {
        Model::find_or_make(w).map(drop)
    }),
    ("the emulator", |_| qemu::ensure_installed()),
    ("an encoder of sound", |_| sound::ensure_encoder()),
    ("a terminal", |_| tmux::ensure()),
    ("a library for sound cards", |_| {
        sound::ensure_card_library()
    }),
    ("databases", |w| databases(w).map(drop)),
    ("a broker", |w| broker(w).map(drop)),
    ("LinuxCNC", |_| controller::linuxcnc()),
    ("a browser", |_| browser()),
    ("a compiler of C++", |_| Engine::needs()),
];

/// Likewise; nothing before its check is built in the same folder.
const BUILT: [Need; 1] = [("the page in a browser", |w| web::build(w).map(drop))];

/// Begins to fetch, and to build; what is fetched is there once the thread has ended.
pub(super) fn begin(workspace: &Workspace) -> JoinHandle<()> {
    // Nobody waits for the end of this one: who needs an image builds it, and finds it there or being built.
    drop(side_lane(workspace, &BUILT));
    side_lane(workspace, &FETCHED)
}

fn side_lane(workspace: &Workspace, needs: &'static [Need]) -> JoinHandle<()> {
    let workspace = workspace.clone();
    thread::spawn(move || {
        for (what, make) in needs {
            let begun = Instant::now();
            let told = match make(&workspace) {
                Ok(()) => "here",
                Err(_) => "not to be had",
            };
            let seconds = begun.elapsed().as_secs_f32();
            eprintln!("ahead: {what}: {told} ({seconds:.0} s)");
        }
    })
}
