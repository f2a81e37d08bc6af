//! Tests that run on the emulated Cortex-M4F: `cargo fw test`.
//!
//! They check what only the target can tell: that its arithmetic gives the very
//! bits the host gives, and that the application runs on its memory and stack.
//! On the host this file is an empty program, so that host test runners pass it by.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod runtime {
    use {cortex_m as _, cortex_m_rt as _, defmt_semihosting as _};

    defmt::timestamp!("{=u32}", 0u32);

    firmware::emulated_handlers!();
}

#[cfg(target_os = "none")]
#[defmt_test::tests]
mod tests {
    use core::hint::black_box;

    use defmt::{assert, assert_eq};
    use rarma_box::wire::{Deframer, MAX_FRAME, Telemetry, Verdict, encode};
    use rarma_core::decide::{AlarmEvent, Reason, State};
    use rarma_core::estimate::{Arma87, RarmaConfig};
    use rarma_core::monitor::{Monitor, MonitorConfig};
    use rarma_core::{Order, Real};

    /// Uniform noise of −1 to 1, the same on every machine.
    struct Noise(u32);

    impl Noise {
        fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
        }
    }

    /// One multiplication and one addition round twice, whatever the optimiser does.
    #[test]
    fn multiply_add_is_not_fused() {
        let (a, b) = (
            black_box(1.0_f32 + f32::EPSILON),
            black_box(1.0_f32 - f32::EPSILON),
        );
        assert_eq!(a * b - 1.0, 0.0);
    }

    /// The functions of the signal path, bit by bit as on the host.
    #[test]
    fn functions_give_the_bits_of_the_host() {
        assert_eq!(
            firmware::bits::function_bits(),
            firmware::bits::FUNCTION_BITS
        );
    }

    /// A resonance at a sixth of the rate is found; its parameters stay definite.
    #[test]
    fn estimator_finds_a_resonance() {
        let mut model = Arma87::<f32>::new(RarmaConfig::default());
        let (mut y1, mut y2, mut noise) = (0.0f32, 0.0f32, Noise(1));
        for _ in 0..4000 {
            let y = noise.next() + 0.95 * y1 - 0.9 * y2;
            y2 = y1;
            y1 = y;
            model.update(y);
        }
        assert!(model.covariance().is_definite(15));
        assert!(model.ready());
        // The input is AR(2): the variance of the innovations is that of the noise.
        let ratio = model.sigma2() * 3.0;
        assert!(ratio > 0.9 && ratio < 1.1);
    }

    /// A tone off the multiples of the speed is called; one on a multiple is forced; and
    /// where no speed is known it is told that nobody can tell.
    #[test]
    fn verdict_tells_a_harmonic_from_chatter_and_from_an_unknown_tone() {
        let cases = [
            (Some(72.0), true, Reason::None),
            (Some(100.0), false, Reason::ForcedOnly),
            (None, false, Reason::OriginUnknown),
        ];
        for (spindle_hz, called, reason) in cases {
            let config = MonitorConfig {
                spindle_hz,
                order: Order::O43,
                ..MonitorConfig::new(6000.0)
            };
            let Ok(mut monitor) = Monitor::<f32>::new(&config) else {
                defmt::panic!("settings are in range");
            };
            let mut noise = Noise(3);
            let mut alarms = 0;
            let mut last = None;
            for n in 0..18_000u32 {
                let phase = (n % 60) as f32 * (core::f32::consts::TAU * 9.0 / 60.0);
                let (tone, _) = Real::sin_cos(phase % core::f32::consts::TAU);
                if let Some(report) = monitor.push(tone + 0.1 * noise.next()) {
                    if matches!(report.event, AlarmEvent::On { .. }) {
                        alarms += 1;
                    }
                    last = Some(report.reason);
                }
            }
            assert_eq!(alarms > 0, called);
            assert!(last == Some(reason));
        }
    }

    /// Bad samples end in a named state, and a report survives its frame.
    #[test]
    fn bad_samples_are_named_and_frames_survive() {
        let Ok(mut monitor) = Monitor::<f32>::new(&MonitorConfig::new(6000.0)) else {
            defmt::panic!("settings are in range");
        };
        let mut noise = Noise(5);
        let mut last = None;
        for n in 0..6000 {
            let x = if n > 5900 { f32::NAN } else { noise.next() };
            last = monitor.push(x).or(last);
        }
        let Some(report) = last else {
            defmt::panic!("no report in a second");
        };
        assert!(report.state == State::Invalid);
        let message = Telemetry::Verdict(Verdict::from_report(&report));
        let mut buffer = [0; MAX_FRAME];
        let Ok(frame) = encode(&message, 5, 9, &mut buffer) else {
            defmt::panic!("a verdict fits a frame");
        };
        let mut deframer = Deframer::default();
        let mut back = None;
        for &b in frame {
            back = deframer.push::<Telemetry>(b).or(back);
        }
        let Some(Ok((head, back))) = back else {
            defmt::panic!("it comes back");
        };
        assert!((head.session, head.sequence) == (5, 9) && back == message);
    }
}
