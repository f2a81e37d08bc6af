//! What a sound card offers, and what is taken of it.

use std::fmt;

/// Rate that is taken where nobody asks for another, Hz: what the box hears with, and more than twice
/// the usual band's upper edge.
const USUAL_RATE_HZ: f64 = 48_000.0;
/// Rate of a telephone call, Hz.
const CALL_HZ: f64 = 8_000.0;
/// Rate of a call in "HD voice" or of a headset's microphone, Hz.
const WIDE_CALL_HZ: f64 = 16_000.0;
/// Channels that are opened where fewer are asked for: opened with one, the system may give
/// the mean of two.
const USUAL_CHANNELS: usize = 2;

/// How a sample comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Form {
    /// A number of so many bits.
    Integer(u8),
    /// Single or double precision, full scale being 1.
    Float,
}

impl Form {
    /// The best first: all bits of the converter, in a form that shows where its range ends.
    fn rank(self) -> u8 {
        match self {
            Self::Integer(bits) if bits >= 16 => bits,
            Self::Float => 15,
            Self::Integer(bits) => bits,
        }
    }
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(bits) => write!(f, "{bits} bit"),
            Self::Float => f.write_str("float"),
        }
    }
}

/// One combination that a card offers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Offer {
    /// Channels.
    pub channels: usize,
    /// Lowest and highest rate, Hz.
    pub rates_hz: (u32, u32),
    /// How samples come.
    pub form: Form,
}

/// What is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// Channels.
    pub channels: usize,
    /// Sampling rate, Hz.
    pub rate_hz: u32,
    /// How samples come.
    pub form: Form,
}

/// Chooses what suits best: `rate_hz` where it is asked for, else 48 kHz or the nearest; at least
/// `channels`.
///
/// # Errors
/// The card has no such thing: what it has, and what to do.
pub fn choose(offers: &[Offer], rate_hz: Option<f64>, channels: usize) -> Result<Choice, String> {
    if offers.is_empty() {
        return Err(
            "it offers no format that is read here, such as 24 bit in three bytes (name the device of the same card that converts: plughw:… in place of hw:…)"
                .to_owned(),
        );
    }
    let most = offers.iter().map(|o| o.channels).max().unwrap_or(0);
    if channels > most {
        return Err(format!(
            "channel {} asked for, but it has {most}, counted from 0 (choose another --channel, --second or --tacho)",
            channels - 1
        ));
    }
    let enough = || offers.iter().filter(|o| o.channels >= channels);
    let nearest = |o: &Offer, hz: f64| hz.clamp(o.rates_hz.0.into(), o.rates_hz.1.into());
    let wanted = rate_hz.unwrap_or(USUAL_RATE_HZ);
    let off = |hz: &f64| (hz / wanted).ln().abs();
    let rate = enough()
        .map(|o| nearest(o, wanted).round())
        .min_by(|a, b| off(a).total_cmp(&off(b)))
        .unwrap_or(wanted);
    if rate_hz.is_some_and(|asked| asked != rate) {
        return Err(format!(
            "it does not have a rate of {wanted} Hz (it has {}; leave out --fs, or give one of these)",
            rates(offers)
        ));
    }
    enough()
        .filter(|o| nearest(o, rate) == rate)
        .min_by_key(|o| {
            let few = o.channels < channels.max(USUAL_CHANNELS);
            (few, o.channels, u8::MAX - o.form.rank())
        })
        .map(|o| Choice {
            channels: o.channels,
            rate_hz: rate as u32,
            form: o.form,
        })
        .ok_or_else(|| "it offers nothing that can be read".to_owned())
}

/// What a rate means for those who listen to a machine, where it is one of telephones: what is lost.
pub fn rate_warning(fs: f64) -> Option<String> {
    if fs <= CALL_HZ {
        Some(format!(
            "{fs} Hz is the rate of a telephone call: nothing above {:.0} Hz is heard, and what makes calls clear (noise suppression, automatic gain) takes the machine's sound away",
            fs / 2.0 * 0.85
        ))
    } else if fs <= WIDE_CALL_HZ {
        Some(format!(
            "{fs} Hz is the rate of a headset in a call: noise suppression and automatic gain may be on"
        ))
    } else {
        None
    }
}

/// Rates in words, Hz.
pub fn rates(offers: &[Offer]) -> String {
    let mut all: Vec<(u32, u32)> = offers.iter().map(|o| o.rates_hz).collect();
    all.sort_unstable();
    all.dedup();
    let words: Vec<String> = all
        .iter()
        .map(|(low, high)| match low == high {
            true => low.to_string(),
            false => format!("{low} to {high}"),
        })
        .collect();
    format!("{} Hz", words.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offer(channels: usize, rates_hz: (u32, u32), form: Form) -> Offer {
        Offer {
            channels,
            rates_hz,
            form,
        }
    }

    #[test]
    fn takes_48_khz_where_there_is_and_the_nearest_elsewhere() {
        let form = Form::Integer(16);
        let rates = |all: &[u32]| -> Vec<Offer> {
            all.iter().map(|hz| offer(1, (*hz, *hz), form)).collect()
        };
        let taken = |all: &[u32]| choose(&rates(all), None, 1).expect("one").rate_hz;
        assert_eq!(taken(&[8_000, 44_100, 48_000, 96_000]), 48_000);
        assert_eq!(taken(&[8_000, 44_100, 96_000]), 44_100);
        assert_eq!(taken(&[8_000, 16_000]), 16_000);
        assert_eq!(
            choose(&[offer(1, (4_000, 192_000), form)], None, 1)
                .expect("one")
                .rate_hz,
            48_000
        );
        let why = choose(&rates(&[8_000, 44_100]), Some(96_000.0), 1).expect_err("not there");
        assert!(why.contains("8000, 44100 Hz"), "{why}");
        let asked = choose(&rates(&[8_000, 44_100]), Some(8_000.0), 1);
        assert_eq!(asked.expect("there").rate_hz, 8_000);
    }

    #[test]
    fn takes_two_channels_rather_than_their_mean() {
        let of = |all: &[usize], asked| {
            let offers: Vec<Offer> = all
                .iter()
                .map(|n| offer(*n, (48_000, 48_000), Form::Integer(16)))
                .collect();
            choose(&offers, None, asked).map(|choice| choice.channels)
        };
        assert_eq!(of(&[1, 2, 3, 4], 1), Ok(2));
        assert_eq!(of(&[1], 1), Ok(1));
        assert_eq!(of(&[8], 1), Ok(8));
        assert_eq!(of(&[1, 2, 4, 8], 3), Ok(4));
        assert!(of(&[1, 2], 3).is_err_and(|why| why.contains("channel 2")));
    }

    #[test]
    fn takes_all_bits_there_are() {
        let of = |forms: &[Form]| {
            let offers: Vec<Offer> = forms
                .iter()
                .map(|form| offer(2, (48_000, 48_000), *form))
                .collect();
            choose(&offers, None, 1).map(|choice| choice.form)
        };
        let (i8, i16, i32) = (Form::Integer(8), Form::Integer(16), Form::Integer(32));
        assert_eq!(of(&[i8, i16, Form::Float, i32]), Ok(i32));
        assert_eq!(of(&[i8, Form::Float, i16]), Ok(i16));
        assert_eq!(of(&[i8, Form::Float]), Ok(Form::Float));
        assert!(of(&[]).is_err_and(|why| why.contains("plughw")));
    }

    #[test]
    fn rates_of_telephones_are_named() {
        assert!(rate_warning(8_000.0).is_some_and(|why| why.contains("telephone call")));
        assert!(rate_warning(16_000.0).is_some_and(|why| why.contains("headset")));
        assert_eq!(rate_warning(44_100.0), None);
    }
}
