//! A ring that a DMA writes without asking: which samples are in it, from its place and the clock. Pure.

/// How far the DMA's place may be from where the clock expects it, samples: conversion
/// and transfer take less than one, reading the two registers less than another.
pub const PLACE_TOLERANCE: i64 = 4;

/// Samples written since sampling began, from the clock and the DMA's place in its ring.
///
/// The clock says about how many there are, the place in the ring says exactly which, the
/// rings before it left out. None if the two are more than [`PLACE_TOLERANCE`] apart: the
/// converter or the DMA has stopped.
///
/// * `expected`: samples by the clock since sampling began.
/// * `place`: index that is written next, `< ring`.
/// * `ring`: length of the ring, a power of two.
#[must_use]
pub fn written(expected: u64, place: u32, ring: u32) -> Option<u64> {
    let expected = expected.cast_signed();
    let ahead = (i64::from(place) - expected) & i64::from(ring - 1);
    let half = i64::from(ring / 2);
    let ahead = if ahead >= half {
        ahead - i64::from(ring)
    } else {
        ahead
    };
    if ahead.abs() > PLACE_TOLERANCE {
        return None;
    }
    u64::try_from(expected + ahead).ok()
}

/// Which samples to take next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Number of the first sample to take.
    pub from: u64,
    /// Samples that were overwritten before they were taken.
    pub missing: u32,
}

/// Where to go on, when `taken` samples have been taken and `written` written.
///
/// A ring that has been written past is entered again in its middle: what lies there is
/// still whole when it is read.
#[must_use]
pub fn window(taken: u64, written: u64, ring: u32) -> Window {
    let guard = u64::from(ring) - u64::from(ring / 8);
    if written.saturating_sub(taken) <= guard {
        return Window {
            from: taken,
            missing: 0,
        };
    }
    let from = written - u64::from(ring / 2);
    Window {
        from,
        missing: u32::try_from(from - taken).unwrap_or(u32::MAX),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RING: u32 = 2048;

    #[test]
    fn place_and_clock_give_the_count_across_many_rings() {
        for true_count in [0u64, 1, 2047, 2048, 2049, 1_000_000, 48_000 * 86_400 * 365] {
            let place = (true_count % u64::from(RING)) as u32;
            for early in [-1i64, 0, 1, 3] {
                let expected = (true_count as i64 + early).max(0) as u64;
                assert_eq!(
                    written(expected, place, RING),
                    Some(true_count),
                    "{true_count} {early}"
                );
            }
        }
    }

    #[test]
    fn a_place_that_stands_still_is_noticed() {
        let stopped = written(100, 100, RING);
        assert_eq!(stopped, Some(100));
        assert_eq!(written(104, 100, RING), Some(100));
        assert_eq!(written(105, 100, RING), None);
        assert_eq!(written(95, 100, RING), None);
        assert_eq!(
            written(0, 2047, RING),
            None,
            "before the first sample there is none"
        );
    }

    #[test]
    fn an_overwritten_ring_is_entered_in_its_middle() {
        assert_eq!(
            window(1000, 1256, RING),
            Window {
                from: 1000,
                missing: 0
            }
        );
        let late = window(1000, 1000 + 1793, RING);
        assert_eq!(
            late,
            Window {
                from: 1769,
                missing: 769
            }
        );
        assert_eq!(window(0, 1 << 40, RING).missing, u32::MAX);
    }
}
