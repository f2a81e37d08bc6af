//! Numbers and strings as a page needs them: with units, and never as markup.

/// Stands between a number and its unit, so that a line never breaks there.
const NBSP: char = '\u{a0}';

/// Makes a string from outside safe as element text or in a quoted attribute.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c if c.is_control() && c != '\n' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// At most three significant digits, whole numbers in full; a dash if there is
/// none.
pub fn significant(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e7).contains(&size) {
        return format!("{value:.2e}").replace('-', "−");
    }
    // Digits are counted after rounding: 9.996 has one decimal, 10.0, and not two.
    let decimals = (0..=6)
        .rev()
        .find(|&d| {
            let rounded = (size * 10_f64.powi(d)).round();
            rounded < 1000.0 || d == 0
        })
        .unwrap_or(0);
    let mut text = format!("{value:.*}", decimals as usize).replace('-', "−");
    if text.contains('.') {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    text
}

/// A number with its unit.
pub fn with_unit(value: f64, unit: &str) -> String {
    format!("{}{NBSP}{unit}", significant(value))
}

/// A frequency.
pub fn hertz(value: f64) -> String {
    with_unit(value, "Hz")
}

/// A time or duration.
pub fn seconds(value: f64) -> String {
    with_unit(value, "s")
}

/// An instant, told to a tenth where three digits would be less.
pub fn instant(value: f64) -> String {
    if value.is_finite() && value.abs() >= 1000.0 {
        format!("{value:.1}{NBSP}s").replace('-', "−")
    } else {
        seconds(value)
    }
}

/// A ratio such as ζ in percent.
pub fn percent(ratio: f64) -> String {
    with_unit(100.0 * ratio, "%")
}

/// A ratio and its deviation in percent, with the digits that the deviation leaves.
pub fn percent_within(ratio: f64, deviation: f64) -> String {
    let (value, deviation) = (100.0 * ratio, 100.0 * deviation);
    if !(value.is_finite() && deviation.is_finite() && deviation > 0.0) {
        return percent(ratio);
    }
    // One digit of the deviation; two where it begins with a 1.
    let first = deviation.log10().floor();
    let leading = deviation / 10_f64.powf(first);
    let decimals = (if leading < 1.95 { 1.0 } else { 0.0 } - first).clamp(0.0, 4.0) as usize;
    let value = format!("{value:.decimals$}").replace('-', "−");
    format!("{value} ± {deviation:.decimals$}{NBSP}%")
}

/// A count with thin gaps between thousands.
pub fn count(value: u64) -> String {
    let digits = value.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) && digits.len() > 4 {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    out
}

/// A coordinate in an SVG: tenths of a pixel, as short as it goes.
pub fn px(value: f64) -> String {
    // Coordinates are clamped by the axes; this is the last line of defence.
    let tenths = if value.is_finite() {
        (value * 10.0).round() / 10.0
    } else {
        0.0
    };
    format!("{}", tenths + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits() {
        for (value, want) in [
            (0.0, "0"),
            (9.996, "10"),
            (898.4, "898"),
            (2.3149, "2.31"),
            (12_345.6, "12346"),
            (-0.1234, "−0.123"),
            (0.001_234, "0.00123"),
            (3.2e-7, "3.20e−7"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(significant(value), want);
        }
        assert_eq!(percent(0.01234), "1.23\u{a0}%");
        for (ratio, deviation, want) in [
            (-0.00312, 0.0042, "−0.3 ± 0.4\u{a0}%"),
            (0.012_34, 0.000_151, "1.234 ± 0.015\u{a0}%"),
            (0.5, 0.3, "50 ± 30\u{a0}%"),
            (0.01, 0.0, "1\u{a0}%"),
            (f64::NAN, 0.1, "–"),
        ] {
            assert_eq!(
                percent_within(ratio, deviation).replace("–\u{a0}%", "–"),
                want
            );
        }
        assert_eq!(instant(72.712), "72.7\u{a0}s");
        assert_eq!(instant(3541.26), "3541.3\u{a0}s");
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(px(-0.01), "0");
        assert_eq!(px(f64::NAN), "0");
    }

    #[test]
    fn markup_is_defused() {
        assert_eq!(escape("<a b='\"&"), "&lt;a b=&#39;&quot;&amp;");
    }
}
