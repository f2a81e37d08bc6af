//! Clock tree and counts of time, as numbers: nothing here touches a register.
//!
//! One crystal and one PLL feed the core, the sampling timer and the clock, so that a
//! sample lasts a whole number of ticks for ever, and the place of a sample or of a pulse
//! in time is arithmetic on whole numbers.

/// The crystal of the board (X3), Hz.
pub const CRYSTAL_HZ: u32 = 24_000_000;
/// The PLL: crystal / 5 × 68 / 2. The fastest setting below 170 MHz that holds a whole
/// number of [`TRIGGER_HZ`].
pub const PLL: (u32, u32, u32) = (5, 68, 2);
/// Core, buses, timers and [`ticks`](TICKS_PER_SAMPLE), Hz.
pub const TICK_HZ: u32 = CRYSTAL_HZ / PLL.0 * PLL.1 / PLL.2;
/// Conversions per second and microphone, Hz.
pub const TRIGGER_HZ: u32 = 384_000;
/// Conversions that the converter adds up to one sample.
pub const OVERSAMPLING: u32 = 8;
/// Samples per second and microphone, Hz.
pub const SAMPLE_HZ: u32 = TRIGGER_HZ / OVERSAMPLING;
/// Ticks between two conversions.
pub const TICKS_PER_TRIGGER: u32 = TICK_HZ / TRIGGER_HZ;
/// Ticks between two samples.
pub const TICKS_PER_SAMPLE: u32 = TICKS_PER_TRIGGER * OVERSAMPLING;

const _: () = {
    assert!(TICK_HZ == 163_200_000);
    assert!(TICKS_PER_TRIGGER * TRIGGER_HZ == TICK_HZ);
    assert!(TICKS_PER_SAMPLE * SAMPLE_HZ == TICK_HZ);
};

/// How far the DMA's place may be from where the clock expects it, samples: conversion
/// and transfer take less than one, reading the two registers less than another.
pub const PLACE_TOLERANCE: i64 = 4;

/// Microseconds in a number of ticks: `ticks / 163.2`, rounded down, without overflow for
/// 358 years.
#[must_use]
pub fn microseconds(ticks: u64) -> u64 {
    // 163.2 = 816 / 5.
    ticks / 816 * 5 + ticks % 816 * 5 / 816
}

/// Samples written since sampling began, from the clock and the DMA's place in its ring.
///
/// The clock says about how many there are, the place in the ring says exactly which, the
/// rings before it left out. None if the two are more than [`PLACE_TOLERANCE`] apart: the
/// converter or the DMA has stopped.
///
/// * `elapsed`: ticks since sampling began.
/// * `place`: index that is written next, `< ring`.
/// * `ring`: length of the ring, a power of two.
#[must_use]
pub fn written(elapsed: u64, place: u32, ring: u32) -> Option<u64> {
    let expected = (elapsed / u64::from(TICKS_PER_SAMPLE)) as i64;
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

/// A capture of the 32-bit counter as ticks since start-up: the latest moment not after
/// `now` whose lower half it is.
#[must_use]
pub fn captured(capture: u32, now: u64) -> u64 {
    let age = (now as u32).wrapping_sub(capture);
    now.saturating_sub(u64::from(age))
}

/// The first sample that is complete at or after a moment, and how long before it the
/// moment was, 0..1 sample. Sample `n` is complete `n + 1` periods after sampling began.
#[must_use]
pub fn sample_after(started: u64, moment: u64) -> (u64, f32) {
    let period = u64::from(TICKS_PER_SAMPLE);
    let elapsed = moment.saturating_sub(started);
    let sample = elapsed.div_ceil(period).saturating_sub(1);
    let before = ((sample + 1) * period).saturating_sub(elapsed);
    if before >= period {
        // Before the first sample had begun.
        return (0, 1.0 - f32::EPSILON);
    }
    (sample, before as f32 * (1.0 / TICKS_PER_SAMPLE as f32))
}

/// Periods of the bridges and of the current loop per second, Hz: one for each sample of a
/// microphone, so that what the bridges leave in the sound stands still.
pub const PWM_HZ: u32 = SAMPLE_HZ;
/// Top of the bridges' counter, which counts up and down once a period.
pub const PWM_TOP: u16 = (TICK_HZ / PWM_HZ / 2) as u16;
const _: () = assert!(2 * PWM_TOP as u32 * PWM_HZ == TICK_HZ);
/// Both switches of a bridge are open this long between one and the other, ns.
pub const DEAD_TIME_NS: u32 = 300;
/// The lower switch of a bridge is closed for at least this part of a period: the upper
/// one's driver takes its supply then.
pub const LOWER_SHARE: f32 = 0.03;

/// Ticks of a time, rounded up.
#[must_use]
pub const fn ticks_up(ns: u32) -> u32 {
    (ns as u64 * TICK_HZ as u64).div_ceil(1_000_000_000) as u32
}

/// Compare value of a bridge for a mean voltage of −1..=1 of the supply: `top (1 + u)/2`,
/// at most what [`LOWER_SHARE`] leaves. NaN is −1: the current falls.
#[inline]
#[must_use]
pub fn compare(duty: f32) -> u16 {
    let most = f32::from(PWM_TOP) * (1.0 - LOWER_SHARE);
    let value = f32::from(PWM_TOP) * 0.5 * (1.0 + duty) + 0.5;
    // A float cast saturates, and takes NaN for 0.
    (if value > most { most } else { value }) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    const RING: u32 = 2048;
    const PERIOD: u64 = TICKS_PER_SAMPLE as u64;

    #[test]
    fn microseconds_are_exact_to_one_and_never_go_back() {
        assert_eq!(microseconds(163_200_000), 1_000_000);
        assert_eq!(microseconds(163), 0);
        assert_eq!(microseconds(164), 1);
        assert_eq!(microseconds(u64::MAX), u64::MAX / 816 * 5 + 1);
        let mut last = 0;
        for ticks in 0..5000 {
            let us = microseconds(ticks);
            assert_eq!(us, (ticks as f64 / 163.2 + 1e-9) as u64, "{ticks}");
            assert!(us >= last);
            last = us;
        }
    }

    #[test]
    fn place_and_clock_give_the_count_across_many_rings() {
        for true_count in [0u64, 1, 2047, 2048, 2049, 1_000_000, 48_000 * 86_400 * 365] {
            let place = (true_count % u64::from(RING)) as u32;
            for early in [-1i64, 0, 1, 3] {
                let elapsed = (true_count as i64 + early).max(0) as u64 * PERIOD + 17;
                assert_eq!(
                    written(elapsed, place, RING),
                    Some(true_count),
                    "{true_count} {early}"
                );
            }
        }
    }

    #[test]
    fn a_place_that_stands_still_is_noticed() {
        let stopped = written(100 * PERIOD, 100, RING);
        assert_eq!(stopped, Some(100));
        assert_eq!(written(104 * PERIOD, 100, RING), Some(100));
        assert_eq!(written(105 * PERIOD, 100, RING), None);
        assert_eq!(written(95 * PERIOD, 100, RING), None);
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

    #[test]
    fn captures_are_placed_before_now() {
        let now = (7u64 << 32) + 100;
        assert_eq!(captured(40, now), (7u64 << 32) + 40);
        assert_eq!(captured(u32::MAX, now), (7u64 << 32) - 1);
    }

    #[test]
    fn a_pulse_is_placed_to_a_fraction_of_a_sample() {
        let started = 12_345;
        let complete = started + 100 * PERIOD;
        let (sample, before) = sample_after(started, complete - PERIOD / 4);
        assert_eq!(sample, 99);
        assert!((before - 0.25).abs() < 1e-6, "{before}");
        assert_eq!(sample_after(started, complete), (99, 0.0));
        let (sample, before) = sample_after(started, complete + 1);
        assert_eq!(sample, 100);
        assert!(before > 0.999 && before < 1.0, "{before}");
        assert_eq!(sample_after(started, 3).0, 0);
        assert!(sample_after(started, 3).1 < 1.0);
    }

    #[test]
    fn bridges_are_symmetric_and_bounded() {
        assert_eq!(PWM_TOP, 1700);
        assert_eq!(compare(0.0), PWM_TOP / 2);
        assert_eq!(compare(-1.0), 0);
        assert_eq!(compare(1.0), 1649);
        assert_eq!(compare(9.0), 1649);
        assert_eq!(compare(-9.0), 0);
        assert_eq!(compare(f32::NAN), 0);
        for (u, expected) in [(-0.5, 425), (0.5, 1275), (0.9, 1615)] {
            assert_eq!(compare(u), expected, "{u}");
        }
    }

    #[test]
    fn dead_time_is_never_shorter_than_said() {
        let ticks = ticks_up(DEAD_TIME_NS);
        assert_eq!(ticks, 49);
        let ns = f64::from(ticks) / f64::from(TICK_HZ) * 1e9;
        assert!((300.0..307.0).contains(&ns), "{ns}");
    }
}
