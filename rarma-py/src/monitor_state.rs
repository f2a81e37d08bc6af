//! A monitor as bytes, for pickles.
//!
//! A mark and the version of the package, then what the monitor was made of and what it has said, by
//! name, and every number of its signal chain as it is in memory; then a CRC-32 of all of it. The version that
//! wrote it takes it back. Whatever else is put in is refused in one line: the chain lets no number
//! in that could not have been there, and its settings are made anew of the arguments.

use crate::options::Line;
use crc::{CRC_32_ISO_HDLC, Crc};
use rarma_cli::commands::{Feed, Said};
use rarma_core::decide::{StructuralMode, Structure};
use rarma_core::estimate::StateVisitor;
use serde::{Deserialize, Serialize};

const MARK: &[u8] = b"rarma.Monitor\0";
const VERSION: &str = env!("CARGO_PKG_VERSION");
const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// What a monitor is made of.
#[derive(Clone, Serialize, Deserialize)]
pub struct Made {
    /// Its arguments as those of the command.
    pub arguments: Vec<String>,
    pub sample_rate_hz: f64,
    pub full_scale: Option<f64>,
    /// Modes at rest: f in Hz, its deviation, ζ, its deviation. The file may be elsewhere.
    pub structure: Option<Vec<[f64; 4]>>,
}

impl Made {
    /// Keeps the modes of a structure.
    pub fn with_structure(mut self, structure: Option<&Structure<f64>>) -> Self {
        let numbers = |m: &StructuralMode<f64>| [m.f_hz, m.f_sd, m.zeta, m.zeta_sd];
        self.structure = structure.map(|s| s.modes().iter().map(numbers).collect());
        self
    }

    /// The structure again; an error where the modes are none.
    pub fn structure(&self) -> Result<Option<Structure<f64>>, String> {
        let mode = |[f_hz, f_sd, zeta, zeta_sd]: &[f64; 4]| StructuralMode {
            f_hz: *f_hz,
            f_sd: *f_sd,
            zeta: *zeta,
            zeta_sd: *zeta_sd,
        };
        let Some(modes) = &self.structure else {
            return Ok(None);
        };
        let modes: Vec<_> = modes.iter().map(mode).collect();
        let made = Structure::new(&modes);
        made.map(Some).map_err(|why| format!("structure: {why:?}"))
    }

    /// The command line.
    pub fn line(&self) -> Line {
        Line::of_words(self.arguments.clone())
    }
}

#[derive(Serialize, Deserialize)]
struct Kept {
    made: Made,
    said: Said,
    layout: u64,
}

/// A monitor as bytes.
///
/// # Errors
/// None but a defect of this package.
pub fn write(made: &Made, feed: &mut Feed) -> Result<Vec<u8>, String> {
    let mut out = Writer::default();
    if !feed.visit_state(&mut out) {
        return Err("the monitor has no state: a defect of rarma".to_owned());
    }
    let kept = Kept {
        made: made.clone(),
        said: feed.said(),
        layout: out.layout.0,
    };
    let mut bytes = [MARK, VERSION.as_bytes(), b"\0"].concat();
    let named = rmp_serde::to_vec_named(&kept).map_err(|why| why.to_string())?;
    bytes.extend((named.len() as u64).to_le_bytes());
    bytes.extend(named);
    bytes.extend(out.bytes);
    let check = CHECK.checksum(&bytes);
    bytes.extend(check.to_le_bytes());
    Ok(bytes)
}

/// Takes bytes back; `make` makes a monitor that has heard nothing.
///
/// # Errors
/// What is wrong with them, and what to do, in one line; those of `make`.
pub fn read<E>(
    bytes: &[u8],
    make: impl FnOnce(&Made) -> Result<Feed, E>,
) -> Result<(Made, Feed), String>
where
    E: std::fmt::Display,
{
    let of_a_monitor = bytes.strip_prefix(MARK);
    let rest = of_a_monitor.ok_or("these bytes are not those of a Monitor")?;
    let end = rest.iter().take(64).position(|byte| *byte == 0);
    let (version, rest) = rest.split_at(end.ok_or("cut short (pickle the Monitor again)")?);
    if version != VERSION.as_bytes() {
        return Err(format!(
            "pickled by rarma {}, and this is {VERSION} (unpickle with the version that pickled, or push the samples into a new Monitor)",
            String::from_utf8_lossy(version)
        ));
    }
    let whole = bytes
        .split_last_chunk()
        .filter(|(kept, check)| CHECK.checksum(kept) == u32::from_le_bytes(**check));
    if whole.is_none() {
        return Err("cut short, or altered on the way (pickle the Monitor again)".to_owned());
    }
    // Behind the zero of the version, up to the check.
    let body = rest.get(1..rest.len().saturating_sub(4)).unwrap_or(&[]);
    let parted = body.split_first_chunk().and_then(|(length, rest)| {
        rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)
    });
    let other = |why: &str| {
        format!(
            "written by another build of rarma {VERSION} ({why}; unpickle with the one that pickled)"
        )
    };
    let (named, chain) = parted.ok_or_else(|| other("its parts are of other lengths"))?;
    let kept: Kept = rmp_serde::from_slice(named).map_err(|why| other(&why.to_string()))?;
    let mut feed = make(&kept.made).map_err(|why| why.to_string())?;
    let mut from = Reader::new(chain);
    let sound = feed.visit_state(&mut from);
    if !sound || !from.is_used_up() || from.layout.0 != kept.layout || !feed.go_on(kept.said) {
        return Err(format!(
            "no state of a Monitor with its settings in this build of rarma {VERSION} (unpickle with the build that pickled, or push the samples into a new Monitor)"
        ));
    }
    Ok((kept.made, feed))
}

/// A hash (FNV-1a) of the names and kinds of all that was shown.
struct Layout(u64);

impl Default for Layout {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Layout {
    fn take(&mut self, names: &str) {
        for byte in names.bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    layout: Layout,
}

impl StateVisitor<f32> for Writer {
    fn number(&mut self, x: &mut f32) {
        self.bytes.extend(x.to_le_bytes());
        self.layout.take("x");
    }

    fn count(&mut self, n: &mut u32) {
        self.bytes.extend(n.to_le_bytes());
        self.layout.take("n");
    }

    fn part(&mut self, names: &'static str) {
        self.layout.take(names);
    }
}

struct Reader<'a> {
    rest: std::slice::ChunksExact<'a, u8>,
    short: bool,
    layout: Layout,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes.chunks_exact(4),
            short: !bytes.len().is_multiple_of(4),
            layout: Layout::default(),
        }
    }

    fn take(&mut self) -> [u8; 4] {
        let next = self.rest.next().and_then(|word| word.try_into().ok());
        self.short |= next.is_none();
        next.unwrap_or_default()
    }

    fn is_used_up(&self) -> bool {
        self.rest.len() == 0 && !self.short
    }
}

impl StateVisitor<f32> for Reader<'_> {
    fn number(&mut self, x: &mut f32) {
        *x = f32::from_le_bytes(self.take());
        self.layout.take("x");
    }

    fn count(&mut self, n: &mut u32) {
        *n = u32::from_le_bytes(self.take());
        self.layout.take("n");
    }

    fn part(&mut self, names: &'static str) {
        self.layout.take(names);
    }
}
