//! What the checks share: the toolchain and the images, once they are there.

use std::path::PathBuf;
use std::process::Command;
use std::thread::JoinHandle;

use super::Request;
use super::beside::Beside;
use super::summary::Outcome;
use crate::chip::model::Model;
use crate::toolchain::{ARM, Toolchain};
use crate::{Result, Workspace, process, qemu};

/// What the checks share.
#[derive(Debug)]
pub struct Bench<'a> {
    pub(super) workspace: &'a Workspace,
    pub(super) request: Request,
    /// The target's toolchain, or why there is none; nothing until it has been looked for.
    toolchain: Option<std::result::Result<Toolchain, String>>,
    /// The emulated board's image, once built.
    pub(super) image: Option<PathBuf>,
    /// The image for the real board and the model of its chip, once both are there.
    pub(super) board: Option<(PathBuf, Model)>,
    /// What later checks need is being fetched.
    pub(super) fetching: Option<JoinHandle<()>>,
    /// Checks that run beside the others.
    pub(super) beside: Option<Beside>,
}

impl<'a> Bench<'a> {
    /// Nothing made yet.
    pub fn new(workspace: &'a Workspace, request: Request) -> Self {
        Self {
            workspace,
            request,
            toolchain: None,
            image: None,
            board: None,
            fetching: None,
            beside: None,
        }
    }

    /// All of it is here, or cannot be had.
    pub(super) fn wait_for_what_is_fetched(&mut self) {
        if let Some(thread) = self.fetching.take() {
            // A fetch that panics is told by the check that asks for the same.
            let _ = thread.join();
        }
    }

    /// Whether the long forms run, too.
    pub fn long(&self) -> bool {
        self.request.long
    }

    pub(super) fn look_for_toolchain(&mut self) -> Result<Toolchain> {
        let found = Toolchain::find_or_make(self.workspace, ARM)
            .and_then(|toolchain| qemu::ensure_installed().map(|()| toolchain));
        let kept = found.clone();
        self.toolchain = Some(kept.map_err(|failure| {
            let story = failure.to_string();
            format!(
                "no target toolchain: {}",
                story.lines().next().unwrap_or_default()
            )
        }));
        found
    }

    /// The target's toolchain, or in one line why there is none. A check that runs alone looks for
    /// it itself.
    pub(super) fn toolchain(&mut self) -> std::result::Result<Toolchain, String> {
        if self.toolchain.is_none() {
            // The reason is kept.
            let _ = self.look_for_toolchain();
        }
        self.toolchain
            .clone()
            .unwrap_or_else(|| Err("no target toolchain".to_owned()))
    }

    pub(super) fn cargo(&self, arguments: &[&str]) -> Command {
        let mut cargo = process::host_cargo(self.workspace);
        cargo.args(arguments);
        cargo
    }

    pub(super) fn pass_if(&self, command: &mut Command) -> Result<Outcome> {
        println!("{}", process::spelled(command));
        process::run(command).map(|()| Outcome::passed())
    }

    /// The variables that tell the host tests what they must not skip.
    pub(super) fn require(&self, tests: &mut Command) {
        if let Some(image) = &self.image {
            tests
                .env("RARMA_TARGET_ELF", image)
                .env("RARMA_REQUIRE_TARGET", "1");
        }
        if let Some((image, model)) = &self.board {
            model.tell(tests);
            tests
                .env("RARMA_BOARD_ELF", image)
                .env("RARMA_REQUIRE_BOARD", "1");
        }
        if self.request.ci {
            tests.env("RARMA_REQUIRE_SHARED", "1");
        }
    }
}
