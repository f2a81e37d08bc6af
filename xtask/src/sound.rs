//! Programs and libraries that tests of sound need.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::toolchain::packages;
use crate::{Failure, Result, process};

/// The encoder that most people have.
const ENCODER: &str = "ffmpeg";

/// What a program that listens to sound cards is built with: the system's library for sound, and what
/// finds it. And `arecord`, which its tests compare with.
const CARD_PACKAGES: [&str; 3] = ["libasound2-dev", "pkg-config", "alsa-utils"];

/// Makes sure that programs for sound cards can be built.
///
/// # Errors
/// The system's library for sound is not here, and may not be installed.
pub fn ensure_card_library() -> Result<()> {
    let mut asked = Command::new("pkg-config");
    asked.args(["--exists", "alsa"]);
    if process::output(&mut asked).is_ok() && process::find_program("arecord").is_some() {
        return Ok(());
    }
    packages::install(&CARD_PACKAGES).map_err(|failure| {
        Failure::new("no library for sound cards (ALSA) to build with")
            .because(&failure)
            .advise("install it with your package manager; only `rarma listen` needs it")
    })
}

/// Makes sure that there is an encoder of sound.
///
/// # Errors
/// There is none, and it may not be installed here.
pub fn ensure_encoder() -> Result<()> {
    if process::find_program(ENCODER).is_some() {
        return Ok(());
    }
    packages::install(&[ENCODER]).map_err(|failure| {
        Failure::new(format!("no {ENCODER} on this machine"))
            .because(&failure)
            .advise("install it with your package manager; the rest works without it")
    })
}

/// A sound card that plays a recording: the system's library for sound reads a pipe in place of
/// hardware (ALSA's `file` device). Gone with this.
#[derive(Debug)]
pub struct PipeCard {
    home: PathBuf,
    ends: Arc<AtomicBool>,
}

impl PipeCard {
    /// The card's name.
    pub const NAME: &'static str = "pipe";

    /// A card that plays a WAV of one channel of 16 bits at 48 kHz, once, on both its channels.
    ///
    /// # Errors
    /// The WAV is another, or the pipe cannot be made.
    pub fn open(wav: &Path) -> Result<Self> {
        let codes = codes(wav)?;
        let home = std::env::temp_dir().join(format!("rarma-card-{}", std::process::id()));
        let pipe = home.join("pipe");
        let cannot = |why| Failure::new(format!("cannot make {}", home.display())).because(why);
        fs::create_dir_all(&home).map_err(cannot)?;
        let card = Self {
            ends: Arc::default(),
            home: home.clone(),
        };
        process::run(Command::new("mkfifo").arg(&pipe))?;
        let entry = format!(
            "pcm.{} {{ type file; slave.pcm \"null\"; file \"/dev/null\"; infile \"{}\"; format \"raw\"; hint {{ show on; description \"a recording\" }} }}\n",
            Self::NAME,
            pipe.display()
        );
        fs::write(home.join(".asoundrc"), entry).map_err(cannot)?;
        // For reading, too: the pipe stays while a program asks what the card offers.
        let both = File::options().read(true).write(true).open(&pipe);
        let mut pipe = both.map_err(cannot)?;
        let ends = Arc::clone(&card.ends);
        thread::spawn(move || {
            let begun = Instant::now();
            for (block, k) in codes.chunks(480).zip(0_u32..) {
                // Two channels of 32 bits.
                let frame = |code: &i16| [(i32::from(*code) << 16).to_le_bytes(); 2].concat();
                let bytes: Vec<u8> = block.iter().flat_map(frame).collect();
                let due = begun + k * Duration::from_millis(10);
                thread::sleep(due.saturating_duration_since(Instant::now()));
                if ends.load(Ordering::Relaxed) || pipe.write_all(&bytes).is_err() {
                    break;
                }
            }
        });
        Ok(card)
    }

    /// The home in which the system finds it.
    pub fn folder(&self) -> &Path {
        &self.home
    }
}

impl Drop for PipeCard {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        // What cannot be removed does no harm: it is in the folder for what may go.
        let _ = fs::remove_dir_all(&self.home);
    }
}

/// The samples of a WAV of one channel of 16 bits.
fn codes(wav: &Path) -> Result<Vec<i16>> {
    let bytes = fs::read(wav)
        .map_err(|why| Failure::new(format!("cannot read {}", wav.display())).because(why))?;
    let data = bytes.windows(4).position(|four| four == b"data");
    let one_channel_of_16_bits = bytes.get(20..24) == Some(&[1, 0, 1, 0]);
    match data.filter(|_| one_channel_of_16_bits) {
        Some(data) => Ok(bytes[data + 8..]
            .as_chunks()
            .0
            .iter()
            .map(|two| i16::from_le_bytes(*two))
            .collect()),
        None => Err(Failure::new(format!(
            "{}: not a WAV of one channel of 16 bits",
            wav.display()
        ))),
    }
}
