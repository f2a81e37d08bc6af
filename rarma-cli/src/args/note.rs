//! What the user notes of a run.

use std::collections::BTreeMap;

/// Characters of a key and of a value at most.
const LONGEST: usize = 1000;

/// One `KEY=VALUE`.
///
/// # Errors
/// No `=`, nothing before it, or too long.
pub(super) fn note(text: &str) -> Result<(String, String), String> {
    let (key, value) = text
        .split_once('=')
        .ok_or("must have the form KEY=VALUE, such as machine=\"DMU 50\"")?;
    let (key, value) = (key.trim(), value.trim());
    if key.is_empty() {
        return Err("there is nothing before the `=`: give a key, such as machine=…".to_owned());
    }
    if key.chars().count() > LONGEST || value.chars().count() > LONGEST {
        return Err(format!("is longer than {LONGEST} characters"));
    }
    Ok((key.to_owned(), value.to_owned()))
}

/// All notes by their keys.
///
/// # Errors
/// A key that is there twice.
pub fn by_key(notes: &[(String, String)]) -> Result<BTreeMap<String, String>, String> {
    let mut all = BTreeMap::new();
    for (key, value) in notes {
        if all.insert(key.clone(), value.clone()).is_some() {
            return Err(format!(
                "--note: {key:?} is given twice (give each key once)"
            ));
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms() {
        let of = |key: &str, value: &str| Ok((key.to_owned(), value.to_owned()));
        assert_eq!(note("tool = 10 mm, z=4"), of("tool", "10 mm, z=4"));
        assert_eq!(note("checked="), of("checked", ""));
        for (bad, why) in [
            ("machine", "KEY=VALUE"),
            ("=x", "nothing before"),
            (" =x", "nothing before"),
            (&format!("a={}", "x".repeat(1001)), "longer than 1000"),
        ] {
            let said = note(bad).expect_err("refused");
            assert!(said.contains(why), "{said}");
        }
    }

    #[test]
    fn a_key_twice_is_refused_by_name() {
        let two = [("a", "1"), ("b", "2"), ("a", "1")];
        let two = two.map(|(k, v)| (k.to_owned(), v.to_owned()));
        assert!(
            by_key(&two)
                .expect_err("refused")
                .contains("\"a\" is given twice")
        );
        assert_eq!(by_key(&two[..2]).expect("two").len(), 2);
    }
}
