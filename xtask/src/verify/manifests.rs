//! What a crate that is published must say of itself, and that no other one is.
//!
//! A repository is not among it: this one has no address yet.

use serde_json::Value;
use std::path::Path;

/// A registry's limits.
const MOST_KEYWORDS: usize = 5;

/// A line for each thing that is missing or wrong in the JSON of `cargo metadata --no-deps`; none
/// where that cannot be read.
pub(super) fn objections(metadata: &str, published: &[&str]) -> Option<Vec<String>> {
    let metadata: Value = serde_json::from_str(metadata).ok()?;
    let mut objections = Vec::new();
    for package in metadata.get("packages")?.as_array()? {
        let name = package.get("name")?.as_str()?;
        if published.contains(&name) {
            let lacks = missing(package);
            objections.extend(lacks.into_iter().map(|field| format!("{name}: {field}")));
        } else if package
            .get("publish")
            .and_then(Value::as_array)
            .is_none_or(|to| !to.is_empty())
        {
            objections.push(format!("{name}: neither published nor `publish = false`"));
        }
    }
    for name in published {
        let is_there = |package: &Value| package.get("name").and_then(Value::as_str) == Some(name);
        if !metadata.get("packages")?.as_array()?.iter().any(is_there) {
            objections.push(format!("{name}: is no package"));
        }
    }
    Some(objections)
}

/// The fields of a published package that are not as they must be.
fn missing(package: &Value) -> Vec<&'static str> {
    let text = |field: &str| {
        let value = package.get(field).and_then(Value::as_str);
        value.is_some_and(|text| !text.is_empty())
    };
    let count = |field: &str| {
        package
            .get(field)
            .and_then(Value::as_array)
            .map_or(0, Vec::len)
    };
    let mut missing = Vec::new();
    for field in ["description", "license", "readme", "rust_version"] {
        if !text(field) {
            missing.push(field);
        }
    }
    if !(1..=MOST_KEYWORDS).contains(&count("keywords")) {
        missing.push("one to five keywords");
    }
    if !(1..=MOST_KEYWORDS).contains(&count("categories")) {
        missing.push("one to five categories");
    }
    let readme = package.get("readme").and_then(Value::as_str);
    let folder = package.get("manifest_path").and_then(Value::as_str);
    if let (Some(readme), Some(manifest)) = (readme, folder)
        && !Path::new(manifest).with_file_name(readme).is_file()
    {
        missing.push("its readme is not there");
    }
    missing
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"{"name":"a","description":"d","license":"MIT","readme":"Cargo.toml","rust_version":"1.90",
        "keywords":["k"],"categories":["c"],"publish":null,"manifest_path":"MANIFEST"}"#;

    fn said(package: &str) -> Vec<String> {
        let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
        let metadata = format!(r#"{{"packages":[{package}]}}"#).replace("MANIFEST", manifest);
        objections(&metadata, &["a"]).expect("is JSON")
    }

    #[test]
    fn a_published_crate_says_what_it_is() {
        assert_eq!(said(GOOD), [""; 0]);
        for (is, bad) in [
            (r#""d""#, "null"),
            (r#""d""#, r#""""#),
            (r#""MIT""#, "null"),
            (r#""1.90""#, "null"),
            (r#"["k"]"#, "[]"),
            (r#"["k"]"#, r#"["a","b","c","d","e","f"]"#),
            (r#"["c"]"#, "[]"),
            (r#""Cargo.toml""#, "null"),
            (r#""Cargo.toml""#, r#""Nowhere.md""#),
        ] {
            assert_eq!(said(&GOOD.replace(is, bad)).len(), 1, "{is} {bad}");
        }
        assert_eq!(said(r#"{"name":"b","publish":[]}"#), ["a: is no package"]);
    }

    #[test]
    fn every_other_one_is_kept_from_being_published() {
        let with = |publish: &str| said(&format!(r#"{GOOD},{{"name":"b","publish":{publish}}}"#));
        assert_eq!(with("[]"), [""; 0]);
        assert_eq!(with("null").len(), 1);
        assert_eq!(with(r#"["elsewhere"]"#).len(), 1);
        assert_eq!(objections("no JSON", &["a"]), None);
    }
}
