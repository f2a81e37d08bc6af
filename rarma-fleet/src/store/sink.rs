//! A store at the end of a broker.

use super::{Store, StoreError, Taken};
use crate::gateway::host::{Numbered, Sink};
use std::collections::HashMap;

/// A store that takes what gateways send, and remembers how far each journal is stored.
///
/// Records first, then how far: what is cut off in between comes again, and is known by its name. So
/// nothing is acknowledged that is not there, and nothing is there twice, on a database with
/// transactions and on one without.
pub struct Receiving<'a> {
    store: &'a mut Store,
    positions: HashMap<String, u64>,
    /// What became of all records so far.
    pub taken: Taken,
    /// Called after every message that was stored.
    told: &'a mut dyn FnMut(&Taken),
}

impl<'a> Receiving<'a> {
    /// With what is called after every message that was stored.
    pub fn new(store: &'a mut Store, told: &'a mut dyn FnMut(&Taken)) -> Self {
        Self {
            store,
            positions: HashMap::new(),
            taken: Taken::default(),
            told,
        }
    }

    fn put(&mut self, identity: &str, number: u64, records: &[Numbered]) -> Result<(), StoreError> {
        let lines = records
            .iter()
            .map(|(_, line, record)| (record, line.clone()));
        let taken = self.store.add_pairs(lines.collect())?;
        let value = i64::try_from(number)
            .map_err(|_| StoreError::Answer(format!("{number} for the number of a record")))?;
        self.store.set_meta(&key(identity), value)?;
        self.taken.add(taken);
        self.positions.insert(identity.to_owned(), number);
        Ok(())
    }
}

/// What `meta` calls the position of a journal.
fn key(identity: &str) -> String {
    format!("journal {identity}")
}

impl Sink for Receiving<'_> {
    fn position(&mut self, identity: &str) -> Result<u64, String> {
        if let Some(&number) = self.positions.get(identity) {
            return Ok(number);
        }
        let number = self
            .store
            .meta(&key(identity))
            .map_err(|why| format!("store: {why}"))?;
        let number = number.and_then(|n| u64::try_from(n).ok()).unwrap_or(0);
        self.positions.insert(identity.to_owned(), number);
        Ok(number)
    }

    fn store(&mut self, identity: &str, number: u64, records: &[Numbered]) -> Result<(), String> {
        self.put(identity, number, records)
            .map_err(|why| format!("store: {why}"))?;
        (self.told)(&self.taken);
        Ok(())
    }
}
