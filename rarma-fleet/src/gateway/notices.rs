//! What there is to tell people: lines to whoever runs the gateway, and the last one as a metric.

use crate::record::Name;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The same line is said again after so long at the earliest.
const QUIET: Duration = Duration::from_secs(60);
/// So many lines are remembered.
const MOST: usize = 1000;

/// How much a line weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// It is good to know.
    Notice,
    /// Something does not work, was lost or was refused.
    Error,
}

/// Where lines go to.
pub type Tell = Arc<dyn Fn(Weight, &str) + Send + Sync>;

/// Tells lines to whoever runs the gateway. Clones share what was said.
#[derive(Clone)]
pub(super) struct Notices {
    said: Arc<Mutex<Said>>,
    tell: Tell,
}

#[derive(Default)]
struct Said {
    last: Option<String>,
    at: HashMap<String, Instant>,
}

impl Notices {
    pub fn new(tell: Tell) -> Self {
        Self {
            said: Arc::default(),
            tell,
        }
    }

    /// What does not work with a box.
    pub fn of_box(&self, name: &Name, what: &str) {
        self.say(format!("{name}: {what}"));
    }

    /// What does not work, was lost or was refused.
    pub fn say(&self, line: String) {
        self.put(Weight::Error, line);
    }

    /// What is good to know.
    pub fn note(&self, line: String) {
        self.put(Weight::Notice, line);
    }

    fn put(&self, weight: Weight, line: String) {
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        if said.at.get(&line).is_some_and(|at| at.elapsed() < QUIET) {
            return;
        }
        if said.at.len() >= MOST {
            said.at.clear();
        }
        (self.tell)(weight, &line);
        said.at.insert(line.clone(), Instant::now());
        said.last = Some(line);
    }

    /// The last line.
    pub fn last(&self) -> Option<String> {
        self.said
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .last
            .clone()
    }
}
