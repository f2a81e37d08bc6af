//! Stores of settings made of `sequential-storage`: as the firmware had it before its own
//! journal, and the best that could be made of it, two maps with a check in every value.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use embedded_storage_async::nor_flash as asynchronous;
use hal_sim::rig::{FlashError, SECTOR, SimFlash, WORD};
use rarma_box::settings::{SETTINGS, Setting, SettingValue, Settings, from_record, to_record};
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use std::future::Future;
use std::ops::Range;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// A flash whose operations are over when they return, for an interface that may wait.
struct Ready<'a>(&'a mut SimFlash);

impl asynchronous::ErrorType for Ready<'_> {
    type Error = FlashError;
}

impl asynchronous::ReadNorFlash for Ready<'_> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        self.0.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl asynchronous::NorFlash for Ready<'_> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        self.0.erase(from, to)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.0.write(offset, bytes)
    }
}

fn finish<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => value,
        Poll::Pending => unreachable!("nothing here waits"),
    }
}

/// One map in a range of the flash.
struct Map(Range<u32>);

const FORMAT_KEY: u16 = 0;
const FORMAT: &[u8] = b"RAF1";
const BUFFER_BYTES: usize = 64;

impl Map {
    fn on<'a>(
        &self,
        flash: &'a mut SimFlash,
    ) -> MapStorage<u16, Ready<'a>, Cache<Uncached, Uncached, Uncached, u16>> {
        let config = MapConfig::try_new(self.0.clone()).expect("pages");
        MapStorage::new(Ready(flash), config, Cache::new_uncached())
    }

    /// The value of a key; an error if the map is beyond repair.
    fn get(&self, flash: &mut SimFlash, key: u16) -> Result<Option<Vec<u8>>, ()> {
        let mut buffer = [0; BUFFER_BYTES];
        let mut map = self.on(flash);
        let found = finish(map.fetch_item::<&[u8]>(&mut buffer, &key));
        found.map(|value| value.map(<[u8]>::to_vec)).map_err(|_| ())
    }

    fn put(&self, flash: &mut SimFlash, key: u16, value: &[u8]) -> bool {
        let mut buffer = [0; BUFFER_BYTES];
        finish(self.on(flash).store_item(&mut buffer, &key, &value)).is_ok()
    }

    fn is_blank(&self, flash: &SimFlash) -> bool {
        let words = self.0.start as usize / WORD..self.0.end as usize / WORD;
        words.into_iter().all(|word| flash.is_erased(word))
    }

    fn lay(&self, flash: &mut SimFlash) {
        if self.is_blank(flash) || flash.erase(self.0.start, self.0.end).is_ok() {
            self.put(flash, FORMAT_KEY, FORMAT);
        }
    }

    fn is_laid(&self, flash: &mut SimFlash) -> bool {
        matches!(self.get(flash, FORMAT_KEY), Ok(Some(format)) if format == FORMAT)
    }
}

/// The store as it was.
#[derive(Debug, Default)]
pub struct Former;

impl Former {
    /// Reads what is stored. True if something was told: a record refused, all lost.
    pub fn load(&self, flash: &mut SimFlash, settings: &mut Settings) -> bool {
        let map = Map(flash.range());
        if !map.is_laid(flash) {
            let told = !map.is_blank(flash);
            map.lay(flash);
            return told;
        }
        let mut told = false;
        for setting in &SETTINGS {
            match map.get(flash, setting.number) {
                Ok(None) => {}
                Ok(Some(record)) => match from_record(setting, &record) {
                    Ok(Some(value)) => settings.set(setting.number, value).expect("checked"),
                    Ok(None) => {}
                    Err(_) => told = true,
                },
                Err(()) => {
                    *settings = Settings::default();
                    map.lay(flash);
                    return true;
                }
            }
        }
        told
    }

    /// Stores a value; false if the flash did not take it.
    pub fn save(
        &self,
        flash: &mut SimFlash,
        setting: &Setting,
        value: Option<SettingValue>,
    ) -> bool {
        let record = to_record(setting, value);
        Map(flash.range()).put(flash, setting.number, record.as_slice())
    }
}

/// Two such maps, each with every setting; every value begins with a count and a CRC-32, and
/// the newest sound one is in force.
#[derive(Debug, Default)]
pub struct TwoMaps {
    next: u32,
}

const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

fn sound(value: &[u8]) -> Option<(u32, &[u8])> {
    let (count, rest) = value.split_first_chunk::<4>()?;
    let (check, record) = rest.split_first_chunk::<4>()?;
    let mut covered = count.to_vec();
    covered.extend_from_slice(record);
    (CRC.checksum(&covered) == u32::from_le_bytes(*check))
        .then_some((u32::from_le_bytes(*count), record))
}

impl TwoMaps {
    fn maps(flash: &SimFlash) -> [Map; 2] {
        let range = flash.range();
        let middle = range.end / 2;
        [Map(0..middle), Map(middle..range.end)]
    }

    /// As [`Former::load`]; what one map lacks is copied from the other.
    pub fn load(&mut self, flash: &mut SimFlash, settings: &mut Settings) -> bool {
        let maps = Self::maps(flash);
        let mut told = false;
        for map in &maps {
            if !map.is_laid(flash) {
                told |= !map.is_blank(flash);
                map.lay(flash);
            }
        }
        for setting in &SETTINGS {
            let values = maps.each_ref().map(|map| {
                let value = map.get(flash, setting.number);
                if value.is_err() {
                    told = true;
                    map.lay(flash);
                }
                value.ok().flatten()
            });
            let read = values
                .each_ref()
                .map(|value| value.as_deref().and_then(sound));
            let newest = read.iter().flatten().max_by_key(|(count, _)| *count);
            let Some(&(count, record)) = newest else {
                continue;
            };
            self.next = self.next.max(count);
            for ((map, read), k) in maps.iter().zip(&read).zip(0..) {
                if read.is_none_or(|(other, _)| other != count) {
                    told = true;
                    let value: &Option<Vec<u8>> = &values[1 - k];
                    map.put(flash, setting.number, value.as_deref().unwrap_or_default());
                }
            }
            match from_record(setting, record) {
                Ok(Some(value)) => settings.set(setting.number, value).expect("checked"),
                Ok(None) => {}
                Err(_) => told = true,
            }
        }
        told
    }

    /// As [`Former::save`].
    pub fn save(
        &mut self,
        flash: &mut SimFlash,
        setting: &Setting,
        value: Option<SettingValue>,
    ) -> bool {
        self.next += 1;
        let record = to_record(setting, value);
        let mut covered = self.next.to_le_bytes().to_vec();
        covered.extend_from_slice(record.as_slice());
        let mut bytes = self.next.to_le_bytes().to_vec();
        bytes.extend_from_slice(&CRC.checksum(&covered).to_le_bytes());
        bytes.extend_from_slice(record.as_slice());
        let [first, second] = Self::maps(flash);
        let first = first.put(flash, setting.number, &bytes);
        let second = second.put(flash, setting.number, &bytes);
        first || second
    }
}
