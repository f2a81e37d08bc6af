//! Duties check in; who is late is named, and the watchdog is fed only when all have.
//!
//! Rate: once a millisecond.

use serde::{Deserialize, Serialize};

/// The duties of the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Duty {
    /// Takes the microphone's samples.
    Samples,
    /// Reads the slow sensors and contacts, moves the set points.
    Slow,
    /// Reads commands, sends telemetry.
    Link,
    /// The current loop, told by its count of periods.
    Loop,
}

impl Duty {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Samples, Self::Slow, Self::Link, Self::Loop];

    /// Longest time between two check-ins, µs. The loop's is 2 ms although it runs every
    /// 25 µs, because it is looked at once a millisecond.
    pub const fn deadline_us(self) -> u64 {
        match self {
            Self::Samples | Self::Link => 10_000,
            Self::Slow => 4_000,
            Self::Loop => 3_000,
        }
    }
}

/// When each duty was here last.
#[derive(Debug, Clone)]
pub struct CheckIns {
    last_us: [u64; Duty::ALL.len()],
    since_feed: [bool; Duty::ALL.len()],
    longest_us: [u64; Duty::ALL.len()],
    late: u32,
}

impl CheckIns {
    /// Everybody has just been here.
    pub fn new(now_us: u64) -> Self {
        Self {
            last_us: [now_us; Duty::ALL.len()],
            since_feed: [false; Duty::ALL.len()],
            longest_us: [0; Duty::ALL.len()],
            late: 0,
        }
    }

    /// A duty is here.
    pub fn here(&mut self, duty: Duty, now_us: u64) {
        let k = duty as usize;
        if let (Some(last), Some(since), Some(longest)) = (
            self.last_us.get_mut(k),
            self.since_feed.get_mut(k),
            self.longest_us.get_mut(k),
        ) {
            *longest = (*longest).max(now_us.saturating_sub(*last));
            *last = now_us;
            *since = true;
        }
    }

    /// The duty that is late the longest beyond its deadline, and its age, µs.
    pub fn late(&mut self, now_us: u64) -> Option<(Duty, u64)> {
        let mut worst: Option<(Duty, u64)> = None;
        for (duty, last) in Duty::ALL.iter().zip(&self.last_us) {
            let age = now_us.saturating_sub(*last);
            if age > duty.deadline_us() && worst.is_none_or(|(_, most)| age > most) {
                worst = Some((*duty, age));
            }
        }
        if worst.is_some() {
            self.late = self.late.saturating_add(1);
        }
        worst
    }

    /// Whether the watchdog may be fed: all have been here since it was fed last.
    pub fn feed(&mut self) -> bool {
        let all = self.since_feed.iter().all(|here| *here);
        if all {
            self.since_feed = [false; Duty::ALL.len()];
        }
        all
    }

    /// Longest time between two check-ins of each duty, µs.
    pub fn longest_us(&self) -> [u64; Duty::ALL.len()] {
        self.longest_us
    }

    /// How often somebody was late.
    pub fn times_late(&self) -> u32 {
        self.late
    }
}
