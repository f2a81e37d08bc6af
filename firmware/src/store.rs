//! Settings in flash: one record a setting, through `sequential-storage`.
//!
//! Slow path. That crate is asynchronous over `embedded-storage-async`; the flash of a
//! microcontroller is not: a write or erase stalls the core, or is waited for. `Ready`
//! puts the one over the other with futures that never wait, so that one poll of any
//! of the crate's futures is its end (`finish`); there is no executor.

use crate::board::BoxBoard;
use core::future::Future;
use core::ops::Range;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embedded_storage::nor_flash::NorFlash;
use embedded_storage_async::nor_flash as asynchronous;
use rarma_core::settings::{
    RecordError, SETTINGS, Setting, SettingValue, Settings, from_record, to_record,
};
use sequential_storage::Error;
use sequential_storage::cache::Cache;
use sequential_storage::map::{MapConfig, MapStorage};

/// Number of the record that says that this store is one, and what it holds. Without it the
/// range holds nothing, or something else.
const FORMAT_KEY: u16 = 0;
const FORMAT: &[u8] = b"RAF1";

/// Largest key and record, in whole words of any flash.
const BUFFER_BYTES: usize = 64;

/// Why the flash did not take a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StoreError {
    /// There is no room.
    Full,
    /// The flash failed, or its content is beyond repair.
    Flash,
    /// The range the board gives is not usable.
    Range,
}

/// What reading the store brought.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Loaded {
    /// Settings with a stored value in force.
    pub stored: u16,
    /// The first setting whose record was not usable, and how many there were.
    pub refused: Option<u16>,
    /// See [`Self::refused`].
    pub refusals: u16,
    /// The store could not be read at all and was laid anew.
    pub lost: bool,
}

/// A flash whose operations are over when they return, for an interface that may wait.
struct Ready<'a, F>(&'a mut F);

impl<F: NorFlash> asynchronous::ErrorType for Ready<'_, F> {
    type Error = F::Error;
}

impl<F: NorFlash> asynchronous::ReadNorFlash for Ready<'_, F> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.0.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl<F: NorFlash> asynchronous::NorFlash for Ready<'_, F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        self.0.erase(from, to)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.write(offset, bytes)
    }
}

/// The end of a future that never waits; none if it does wait after all.
fn finish<T>(future: impl Future<Output = T>) -> Option<T> {
    let mut context = Context::from_waker(Waker::noop());
    match pin!(future).poll(&mut context) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}

type Map<'a, F> = MapStorage<
    u16,
    Ready<'a, F>,
    Cache<
        sequential_storage::cache::Uncached,
        sequential_storage::cache::Uncached,
        sequential_storage::cache::Uncached,
        u16,
    >,
>;

fn map<F: NorFlash>(flash: &mut F, range: Range<u32>) -> Result<Map<'_, F>, StoreError> {
    let config = MapConfig::try_new(range).map_err(|_| StoreError::Range)?;
    Ok(MapStorage::new(Ready(flash), config, Cache::new_uncached()))
}

fn outcome<E>(result: Option<Result<(), Error<E>>>) -> Result<(), StoreError> {
    match result {
        Some(Ok(())) => Ok(()),
        Some(Err(Error::FullStorage)) => Err(StoreError::Full),
        _ => Err(StoreError::Flash),
    }
}

/// What is stored for one setting; none if nothing, or "not set".
///
/// # Errors
/// Inside: the record is there and not usable. Outside: the store cannot be read.
pub fn read<F: NorFlash>(
    flash: &mut F,
    range: Range<u32>,
    setting: &Setting,
) -> Result<Result<Option<SettingValue>, RecordError>, StoreError> {
    let mut buffer = [0; BUFFER_BYTES];
    let mut map = map(flash, range)?;
    let fetched = finish(map.fetch_item::<&[u8]>(&mut buffer, &setting.number));
    match fetched {
        Some(Ok(Some(record))) => Ok(from_record(setting, record)),
        Some(Ok(None)) => Ok(Ok(None)),
        _ => Err(StoreError::Flash),
    }
}

/// Stores a value; with none, that the setting follows its default.
///
/// A power cut at any point leaves the old record or the new one.
///
/// # Errors
/// See [`StoreError`]; the old record is still there then.
pub fn write<F: NorFlash>(
    flash: &mut F,
    range: Range<u32>,
    setting: &Setting,
    value: Option<SettingValue>,
) -> Result<(), StoreError> {
    let mut buffer = [0; BUFFER_BYTES];
    let record = to_record(setting, value);
    let mut map = map(flash, range)?;
    outcome(finish(map.store_item(
        &mut buffer,
        &setting.number,
        &record.as_slice(),
    )))
}

/// Reads every stored setting into `settings`. What cannot be used leaves its default;
/// records of numbers that are not in the table are left alone.
///
/// A range that is no store becomes one; that it was not empty is told as `lost`.
pub fn load<F: NorFlash>(flash: &mut F, range: Range<u32>, settings: &mut Settings) -> Loaded {
    let mut loaded = Loaded::default();
    if !is_store(flash, range.clone()) {
        loaded.lost = !is_blank(flash, range.clone());
        lay_anew(flash, range);
        return loaded;
    }
    for setting in &SETTINGS {
        match read(flash, range.clone(), setting) {
            Ok(Ok(None)) => {}
            Ok(Ok(Some(value))) => {
                // Checked by the record's reader.
                if settings.set(setting.number, value).is_ok() {
                    loaded.stored += 1;
                }
            }
            Ok(Err(_)) => {
                loaded.refused = loaded.refused.or(Some(setting.number));
                loaded.refusals += 1;
            }
            Err(_) => {
                *settings = Settings::default();
                loaded.lost = true;
                lay_anew(flash, range);
                return loaded;
            }
        }
    }
    loaded
}

fn is_store<F: NorFlash>(flash: &mut F, range: Range<u32>) -> bool {
    let mut buffer = [0; BUFFER_BYTES];
    let Ok(mut map) = map(flash, range) else {
        return false;
    };
    let found = finish(map.fetch_item::<&[u8]>(&mut buffer, &FORMAT_KEY));
    matches!(found, Some(Ok(Some(format))) if format == FORMAT)
}

fn is_blank<F: NorFlash>(flash: &mut F, range: Range<u32>) -> bool {
    let mut bytes = [0; BUFFER_BYTES];
    range
        .step_by(BUFFER_BYTES)
        .all(|at| flash.read(at, &mut bytes).is_ok() && bytes.iter().all(|byte| *byte == 0xFF))
}

/// Erases the range and makes it a store. If that fails, so does every save, and is told.
fn lay_anew<F: NorFlash>(flash: &mut F, range: Range<u32>) {
    if is_blank(flash, range.clone()) || flash.erase(range.start, range.end).is_ok() {
        let mut buffer = [0; BUFFER_BYTES];
        if let Ok(mut map) = map(flash, range) {
            let _ = finish(map.store_item(&mut buffer, &FORMAT_KEY, &FORMAT));
        }
    }
}

/// [`load`] from a board.
pub(crate) fn load_from<B: BoxBoard>(board: &mut B, settings: &mut Settings) -> Loaded {
    let (flash, range) = board.flash();
    load(flash, range, settings)
}
