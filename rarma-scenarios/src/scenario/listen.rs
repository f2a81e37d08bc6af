//! The sections `[microphone]` and `[box]`.

use super::reader::{Allowed, Refusal, Section};
use rarma_core::Order;
use rarma_core::condition::Band;
use rarma_plants::converter::ConverterConfig;
use rarma_plants::sound::{Enclosure, MicrophoneConfig, Pickup, Tone};

/// Highest sample rate of a scenario, Hz.
const HIGHEST_RATE_HZ: f64 = 384_000.0;

/// Settings of the box that suit the scenario.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxHints {
    /// Model order.
    pub order: Order,
    /// Band that is analysed; the usual one if none.
    pub band: Option<Band>,
}

pub(super) fn microphone(file: &mut Section<'_>, seed: u64) -> Result<MicrophoneConfig, Refusal> {
    let read = file.table(
        "microphone",
        "What listens: a microphone, an accelerometer or a displacement probe",
        |s| sensor(s, seed),
    )?;
    read.ok_or_else(|| file.refuse("microphone", "is missing (allowed: a table [microphone])"))
}

fn sensor(s: &mut Section<'_>, seed: u64) -> Result<MicrophoneConfig, Refusal> {
    let fs = s.number(
        "sample_rate_hz",
        Allowed::within(1000.0, HIGHEST_RATE_HZ),
        Some(48_000.0),
        "Sample rate, Hz",
    )?;
    // A description knows no rate of its own: any that is allowed may come.
    let highest = if s.describes() { HIGHEST_RATE_HZ } else { fs };
    let pickup = match s.choice(
        "pickup",
        &["acceleration", "velocity", "displacement"],
        false,
        "Motion of the tool that is heard or measured",
    )? {
        1 => Pickup::Velocity,
        2 => Pickup::Displacement,
        _ => Pickup::Acceleration,
    };
    let gain = Allowed::within(-1e9, 1e9);
    let gain = [
        s.number("gain_x", gain, None, "Output per motion in x, Pa per m/s² (m/s, m); a probe or accelerometer has its own unit for Pa")?,
        s.number("gain_y", gain, None, "The same for y")?,
    ];
    let level = Allowed::within(0.0, 1e6);
    Ok(MicrophoneConfig {
        sample_rate_hz: fs,
        pickup,
        gain,
        distance_m: s.number(
            "distance_m",
            Allowed::within(0.0, 100.0),
            Some(0.0),
            "Distance, m: a delay of distance/343 s",
        )?,
        enclosure: s.table("enclosure", "A resonance of the enclosure", |s| {
            Ok(Enclosure {
                f_hz: s.number(
                    "f_hz",
                    Allowed::within(1.0, 0.499 * highest),
                    None,
                    "Frequency, Hz, below half the sample rate",
                )?,
                zeta: s.number("zeta", Allowed::within(1e-6, 1.0), None, "Damping ratio, 1")?,
                gain: s.number(
                    "gain",
                    Allowed::within(-100.0, 100.0),
                    None,
                    "Amplitude at resonance over the direct sound, 1",
                )?,
            })
        })?,
        noise_pa: s.number(
            "noise_pa",
            level,
            Some(0.0),
            "White background noise, standard deviation, Pa",
        )?,
        tones: s.tables("tone", "Steady tones of fans and pumps", |s| {
            Ok(Tone {
                f_hz: s.number("f_hz", Allowed::within(0.01, 1e5), None, "Frequency, Hz")?,
                amplitude_pa: s.number("amplitude_pa", level, None, "Amplitude, Pa")?,
            })
        })?,
        converter: ConverterConfig {
            full_scale: s.number(
                "full_scale_pa",
                Allowed::within(1e-9, 1e9),
                None,
                "Input that gives full scale, Pa",
            )?,
            bits: s.whole(
                "bits",
                (8, 24),
                Some(16),
                "Resolution of the converter, bits",
            )? as u32,
            dither: s.flag("dither", true, "Triangular dither of one code")?,
        },
        seed,
    })
}

pub(super) fn hints(file: &mut Section<'_>) -> Result<BoxHints, Refusal> {
    let names = ["8,7", "2,1", "2,2", "4,3", "4,4", "6,5", "6,6", "8,8"];
    let read = file.table("box", "Settings of the box that suit this cut", |s| {
        let word = names[s.choice("order", &names, false, "Model order P,Q")?];
        let order = Order::ALL
            .into_iter()
            .find(|o| format!("{},{}", o.p(), o.q()) == word)
            .unwrap_or(Order::O87);
        let edge = Allowed::within(0.1, 1e5);
        let low_hz = s.number(
            "band_from_hz",
            edge,
            Some(300.0),
            "Lower edge of the band that is analysed, Hz",
        )?;
        let high_hz = s.number("band_to_hz", edge, Some(2500.0), "Upper edge, Hz")?;
        if high_hz < 1.2 * low_hz && !s.describes() {
            return Err(s.refuse(
                "band_to_hz",
                format!("is {high_hz} (allowed: at least 1.2 times band_from_hz)"),
            ));
        }
        Ok(BoxHints {
            order,
            band: Some(Band { low_hz, high_hz }),
        })
    })?;
    Ok(read.unwrap_or(BoxHints {
        order: Order::O87,
        band: None,
    }))
}
