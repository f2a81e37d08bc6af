//! What was executed: a counter per instruction, and the switch that turns counting on.
//!
//! Rate: [`Trace::execute`] runs once per emulated instruction. The emulated chip has one
//! core, so the atomics only satisfy the compiler; relaxed order suffices.

use std::collections::BTreeMap;
use std::ptr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU64, Ordering::Relaxed};

/// One instruction of the image and how often it was executed while counting.
#[derive(Debug)]
pub struct Site {
    /// Where it is.
    pub address: u64,
    /// Its bytes: 2 or 4.
    pub size: u64,
    /// Its disassembly.
    pub line: String,
    executed: AtomicU64,
    taken: AtomicU64,
}

impl Site {
    /// An instruction that was not executed yet.
    pub fn new(address: u64, size: u64, line: String) -> Self {
        Self {
            address,
            size,
            line,
            executed: AtomicU64::new(0),
            taken: AtomicU64::new(0),
        }
    }

    /// Times it was executed.
    pub fn executed(&self) -> u64 {
        self.executed.load(Relaxed)
    }

    /// Times the instruction executed after it was not the next one in memory.
    pub fn taken(&self) -> u64 {
        self.taken.load(Relaxed)
    }

    /// Address of the next instruction in memory.
    pub fn next_address(&self) -> u64 {
        self.address + self.size
    }
}

/// All instructions seen so far, and whether they are being counted.
///
/// Sites live as long as the process: QEMU keeps pointers to them in translated code.
#[derive(Debug)]
pub struct Trace {
    begin: u64,
    end: u64,
    counting: AtomicBool,
    previous: AtomicPtr<Site>,
    sites: Mutex<BTreeMap<u64, &'static Site>>,
}

impl Trace {
    /// Counts from the instruction at `begin` up to the one at `end`.
    pub fn new(begin: u64, end: u64) -> Self {
        Self {
            begin,
            end,
            counting: AtomicBool::new(false),
            previous: AtomicPtr::new(ptr::null_mut()),
            sites: Mutex::new(BTreeMap::new()),
        }
    }

    /// The site at an address, made by `new` when it is seen for the first time.
    pub fn site(&self, address: u64, new: impl FnOnce() -> Site) -> &'static Site {
        let mut sites = self
            .sites
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        sites
            .entry(address)
            .or_insert_with(|| Box::leak(Box::new(new())))
    }

    /// Every site, sorted by address.
    pub fn sites(&self) -> Vec<&'static Site> {
        let sites = self
            .sites
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        sites.values().copied().collect()
    }

    /// Called when the instruction at `site` is executed.
    pub fn execute(&self, site: &'static Site) {
        if site.address == self.begin {
            self.counting.store(true, Relaxed);
        }
        if !self.counting.load(Relaxed) {
            return;
        }
        if site.address == self.end {
            self.counting.store(false, Relaxed);
            self.previous.store(ptr::null_mut(), Relaxed);
            return;
        }
        site.executed.fetch_add(1, Relaxed);
        let previous = self.previous.swap(ptr::from_ref(site).cast_mut(), Relaxed);
        // SAFETY: `previous` is null or was stored here from a `&'static Site`.
        if let Some(previous) = unsafe { previous.as_ref() }
            && previous.next_address() != site.address
        {
            previous.taken.fetch_add(1, Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_between_the_marks_only_and_sees_jumps() {
        let trace = Trace::new(0x10, 0x20);
        let at = |address| trace.site(address, || Site::new(address, 2, String::new()));
        for address in [0x0, 0x10, 0x12, 0x10, 0x12, 0x20, 0x22, 0x10, 0x20] {
            trace.execute(at(address));
        }
        assert_eq!(
            (at(0x0).executed(), at(0x22).executed(), at(0x20).executed()),
            (0, 0, 0)
        );
        assert_eq!((at(0x10).executed(), at(0x12).executed()), (3, 2));
        // 0x12 to 0x10 is the one jump between two counted instructions.
        assert_eq!((at(0x10).taken(), at(0x12).taken()), (0, 1));
    }
}
