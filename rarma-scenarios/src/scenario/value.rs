//! Values of a file, what is allowed of them, and how a refusal is put.

use std::ops::Range as Span;
use toml::de::DeValue;

/// What is wrong, and where.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Refusal {
    pub line: usize,
    pub field: String,
    pub what: String,
}

/// The whole text, for line numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Text<'a>(pub &'a str);

impl Text<'_> {
    pub(super) fn line(self, span: &Span<usize>) -> usize {
        let end = span.start.min(self.0.len());
        1 + self.0.as_bytes()[..end]
            .iter()
            .filter(|b| **b == b'\n')
            .count()
    }
}

/// Numbers that are allowed: what a machine can have, so that nothing that is worked out
/// from them leaves the range of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Allowed {
    pub low: f64,
    pub high: f64,
}

impl Allowed {
    pub(super) const fn within(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    pub(super) fn holds(self, x: f64) -> bool {
        (self.low..=self.high).contains(&x) && !is_tiny(x)
    }

    pub(super) fn words(self) -> String {
        format!("a number from {} to {}", self.low, self.high)
    }
}

/// Nearer to 0 nothing is: it would only leave the range of numbers further on.
const TINY: f64 = 1e-30;

pub(super) fn is_tiny(x: f64) -> bool {
    x != 0.0 && x.abs() < TINY
}

pub(super) fn integer(value: &DeValue<'_>) -> Option<i64> {
    let i = value.as_integer()?;
    i64::from_str_radix(&i.as_str().replace('_', ""), i.radix()).ok()
}

pub(super) fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(x) => x.as_str().replace('_', "").parse().ok(),
        _ => integer(value).map(|i| i as f64),
    }
}

pub(super) fn shown(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(s) => {
            let short: String = s
                .chars()
                .take(40)
                .map(|c| if c.is_control() { ' ' } else { c })
                .collect();
            format!("the text \"{short}\"")
        }
        DeValue::Integer(i) => i.as_str().to_owned(),
        DeValue::Float(x) => x.as_str().to_owned(),
        DeValue::Boolean(b) => b.to_string(),
        other => format!("a value of type {}", other.type_str()),
    }
}
