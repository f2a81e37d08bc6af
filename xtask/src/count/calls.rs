//! Which calls that the sample path should not have are there all the same: to double
//! precision, which is software on a Cortex-M4F, and to a panic.
//!
//! Static, from the linked image: every function that was entered, or that is named as a
//! root, and every one these can call directly, is searched for call instructions. Calls
//! through a pointer are not followed, but counted: a path that has none is searched whole.

use crate::arm_image::{ArmImage, Function};

/// Call sites of the sample path that should not be there.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Unwanted {
    /// To routines of double precision.
    pub double: Vec<Site>,
    /// To what ends in a panic.
    pub panic: Vec<Site>,
    /// To an allocator.
    pub heap: Vec<Site>,
    /// Through a pointer: the callee is not known.
    pub pointer: Vec<Site>,
}

/// One place that calls, by names as linked.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Site {
    callee: String,
    caller: String,
}

impl Unwanted {
    /// In what was executed and in what that can call.
    pub fn find(image: &ArmImage, executed: &[u64]) -> Self {
        Self::reachable(image, image.entered(executed).collect())
    }

    /// In some functions and in what they can call, executed or not.
    pub fn reachable(image: &ArmImage, roots: Vec<&Function>) -> Self {
        let mut found = Self::default();
        let mut waiting = roots;
        let mut seen = Vec::new();
        while let Some(function) = waiting.pop() {
            if seen.contains(&function.code.start) {
                continue;
            }
            seen.push(function.code.start);
            found
                .pointer
                .extend((0..image.pointer_calls(function)).map(|_| Site {
                    callee: "a pointer".to_owned(),
                    caller: function.name.clone(),
                }));
            for target in image.calls(function) {
                let names = || image.at(target).map(|callee| callee.name.as_str());
                let site = |name: &str| Site {
                    callee: name.to_owned(),
                    caller: function.name.clone(),
                };
                if let Some(name) = names().find(|name| is_double(name)) {
                    found.double.push(site(name));
                } else if let Some(name) = names().find(|name| is_panic(name)) {
                    found.panic.push(site(name));
                } else if let Some(name) = names().find(|name| is_heap(name)) {
                    found.heap.push(site(name));
                } else {
                    waiting.extend(image.at(target).next());
                }
            }
        }
        found
    }

    /// Takes over what another kernel has.
    pub fn add(&mut self, other: Self) {
        self.double.extend(other.double);
        self.panic.extend(other.panic);
        self.heap.extend(other.heap);
        self.pointer.extend(other.pointer);
    }

    /// A line for each routine that is called, with its callers.
    pub fn summary(&self) -> Vec<String> {
        let mut sites: Vec<&Site> = self
            .double
            .iter()
            .chain(&self.panic)
            .chain(&self.heap)
            .chain(&self.pointer)
            .collect();
        sites.sort();
        sites.dedup();
        let same = sites.chunk_by(|x, y| x.callee == y.callee);
        same.map(|sites| {
            let callers: Vec<&str> = sites.iter().map(|site| &*site.caller).collect();
            let shown = callers.len().min(3);
            let rest = match callers.len() - shown {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let (callee, callers) = (&sites[0].callee, callers[..shown].join(", "));
            format!("{callee}, called by {callers}{rest}")
        })
        .collect()
    }
}

/// A routine of the run-time ABI for the ARM architecture that takes or gives a double.
fn is_double(name: &str) -> bool {
    let routine = name.strip_prefix("__aeabi_");
    routine.is_some_and(|r| r.starts_with('d') || r.starts_with("cd") || r.ends_with("2d"))
}

/// Names of the core library's ways into a panic, mangled or not.
fn is_panic(name: &str) -> bool {
    ["panic", "_fail", "unwrap_failed", "expect_failed"]
        .iter()
        .any(|part| name.contains(part))
}

/// Names of allocators and of what calls them.
fn is_heap(name: &str) -> bool {
    ["__rust_alloc", "__rg_alloc", "__rust_realloc", "malloc"]
        .iter()
        .any(|part| name.contains(part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knows_double_precision_by_name() {
        for name in [
            "__aeabi_dadd",
            "__aeabi_f2d",
            "__aeabi_cdcmple",
            "__aeabi_ui2d",
        ] {
            assert!(is_double(name), "{name}");
        }
        for name in ["__aeabi_fadd", "__aeabi_memcpy4", "__aeabi_uidiv", "dadd"] {
            assert!(!is_double(name), "{name}");
        }
    }

    #[test]
    fn callers_are_gathered_by_routine() {
        let site = |callee: &str, caller: &str| Site {
            callee: callee.to_owned(),
            caller: caller.to_owned(),
        };
        let found = Unwanted {
            double: vec![site("__aeabi_dadd", "f")],
            panic: ["d", "c", "b", "a", "a"].map(|f| site("panic", f)).into(),
            ..Unwanted::default()
        };
        let lines = [
            "__aeabi_dadd, called by f",
            "panic, called by a, b, c and 1 more",
        ];
        assert_eq!(found.summary(), lines);
    }

    #[test]
    fn knows_a_panic_by_name() {
        assert!(is_panic("_RNvNtCs1_4core9panicking18panic_bounds_check"));
        assert!(is_panic("_RNvNtNtCs1_4core5slice5index16slice_index_fail"));
        assert!(!is_panic("_ZN10rarma_core7monitor4push"));
    }
}
