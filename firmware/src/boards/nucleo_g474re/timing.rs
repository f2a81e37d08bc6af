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

/// Microseconds in a number of ticks: `ticks / 163.2`, rounded down, without overflow for
/// 358 years.
#[must_use]
pub fn microseconds(ticks: u64) -> u64 {
    // 163.2 = 816 / 5.
    ticks / 816 * 5 + ticks % 816 * 5 / 816
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
    const HALF: f32 = PWM_TOP as f32 * 0.5;
    const MOST: u16 = (PWM_TOP as f32 * (1.0 - LOWER_SHARE)) as u16;
    // A float cast saturates, and takes NaN for 0.
    ((HALF * duty + (HALF + 0.5)) as u16).min(MOST)
}

#[cfg(test)]
mod tests {
    use super::*;

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
