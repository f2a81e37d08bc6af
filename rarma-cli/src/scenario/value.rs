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

/// Numbers that are allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Allowed {
    pub low: f64,
    pub high: f64,
    /// `low` itself is not allowed.
    pub open: bool,
}

impl Allowed {
    pub(super) const fn within(low: f64, high: f64) -> Self {
        Self {
            low,
            high,
            open: false,
        }
    }

    pub(super) const fn above(low: f64, high: f64) -> Self {
        Self {
            low,
            high,
            open: true,
        }
    }

    pub(super) fn holds(self, x: f64) -> bool {
        x <= self.high
            && if self.open {
                x > self.low
            } else {
                x >= self.low
            }
    }

    pub(super) fn words(self) -> String {
        if self.open {
            format!("a number above {} and up to {}", self.low, self.high)
        } else {
            format!("a number from {} to {}", self.low, self.high)
        }
    }
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
