//! Fields of JSON objects, as the tests of the interfaces ask for them.

use serde_json::Value;

/// Names of an object's fields, sorted.
///
/// # Panics
/// Where it is none.
#[must_use]
pub fn keys(object: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = object
        .as_object()
        .unwrap_or_else(|| panic!("not an object: {object}"))
        .keys()
        .map(String::as_str)
        .collect();
    keys.sort_unstable();
    keys
}

/// A field that must be a finite number.
///
/// # Panics
/// Where it is none.
pub fn number(object: &Value, key: &str) -> f64 {
    let value = object[key].as_f64();
    value
        .filter(|x| x.is_finite())
        .unwrap_or_else(|| panic!("{key} of {object}"))
}

/// A list that must hold finite numbers.
///
/// # Panics
/// Where it does not.
#[must_use]
pub fn numbers(array: &Value) -> Vec<f64> {
    let items = array.as_array().unwrap_or_else(|| panic!("{array}"));
    items
        .iter()
        .map(|x| x.as_f64().expect("a finite number"))
        .collect()
}

/// A field that must be a text.
///
/// # Panics
/// Where it is none.
#[must_use]
pub fn word<'a>(object: &'a Value, key: &str) -> &'a str {
    object[key]
        .as_str()
        .unwrap_or_else(|| panic!("{key} of {object}"))
}
