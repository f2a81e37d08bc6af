//! Licences and sources of every dependency, against `deny.toml`, and the Rust that it needs.
//!
//! `cargo deny` checks more from the same file and is called as well where it is
//! installed; this check needs nothing but cargo and always runs.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::spdx;
use crate::{Failure, Result, Workspace, process};

/// Manifests of the workspace and of the helpers that are workspaces of their own.
pub const MANIFESTS: [&str; 6] = [
    "Cargo.toml",
    crate::book::MANIFEST,
    super::python::MANIFEST,
    "tools/defmt-log/Cargo.toml",
    super::on_embassy::MANIFEST,
    "tools/m4-cycles/Cargo.toml",
];

/// Checks every package that a build on any platform could use; returns how many.
///
/// # Errors
/// Lists each package with a licence or a source that `deny.toml` does not allow.
pub fn check(workspace: &Workspace) -> Result<usize> {
    let licences = Licences::read(&workspace.root().join("deny.toml"))?;
    let mut count = 0;
    let mut objections = Vec::new();
    for manifest in MANIFESTS {
        let mut cargo = process::host_cargo(workspace);
        cargo.args([
            "metadata",
            "--format-version",
            "1",
            "--all-features",
            "--manifest-path",
        ]);
        let metadata = process::output(cargo.arg(workspace.root().join(manifest)))?;
        let packages = packages(&metadata)
            .ok_or_else(|| Failure::new(format!("cannot read `cargo metadata` of {manifest}")))?;
        count += packages.len();
        objections.extend(
            packages
                .iter()
                .filter_map(|package| package.objection(&licences)),
        );
    }
    objections.sort();
    objections.dedup();
    if objections.is_empty() {
        return Ok(count);
    }
    Err(Failure::new(format!(
        "{} packages are not allowed by deny.toml",
        objections.len()
    ))
    .because(format!("\n  {}", objections.join("\n  ")))
    .advise("choose another package, or extend the list in deny.toml and say why"))
}

/// The part of `deny.toml` that is checked here.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Licences {
    /// Allowed for every package.
    allowed: Vec<String>,
    /// Allowed besides for the package of that name.
    exceptions: Vec<(String, Vec<String>)>,
}

impl Licences {
    fn read(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path)
            .map_err(|why| Failure::new(format!("cannot read {}", path.display())).because(why))?;
        let table: toml::Table = text
            .parse()
            .map_err(|why| Failure::new(format!("{} is no TOML", path.display())).because(why))?;
        Self::from_table(&table).ok_or_else(|| {
            Failure::new(format!("cannot read [licenses] in {}", path.display()))
                .because("it needs `allow`, a list of names, and may have `exceptions`, a list of { crate, allow }")
        })
    }

    fn from_table(table: &toml::Table) -> Option<Self> {
        let licences = table.get("licenses")?.as_table()?;
        let exceptions = match licences.get("exceptions") {
            None => Vec::new(),
            Some(list) => list
                .as_array()?
                .iter()
                .map(|exception| {
                    let name = exception.get("crate")?.as_str()?.to_owned();
                    Some((name, names(exception.get("allow")?)?))
                })
                .collect::<Option<_>>()?,
        };
        Some(Self {
            allowed: names(licences.get("allow")?)?,
            exceptions,
        })
    }

    /// Every licence that a package may have.
    fn allowed_for(&self, package: &str) -> Vec<String> {
        let besides = self.exceptions.iter().filter(|(name, _)| name == package);
        self.allowed
            .iter()
            .chain(besides.flat_map(|(_, allowed)| allowed))
            .cloned()
            .collect()
    }
}

fn names(list: &toml::Value) -> Option<Vec<String>> {
    list.as_array()?
        .iter()
        .map(|name| name.as_str().map(str::to_owned))
        .collect()
}

/// What is checked of one package.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Package {
    name: String,
    version: String,
    licence: Option<String>,
    /// Where it comes from; none for a package of this repository.
    source: Option<String>,
    /// The Rust that it needs.
    rust: Option<String>,
}

/// The Rust that this workspace promises to do with.
const RUST: &str = env!("CARGO_PKG_RUST_VERSION");

/// A version of Rust as (major, minor, patch).
fn version(text: &str) -> Option<[u32; 3]> {
    let mut numbers = text.split('.').map(|n| n.parse().ok());
    let major = numbers.next()??;
    let mut or_none = || numbers.next().unwrap_or(Some(0));
    Some([major, or_none()?, or_none()?])
}

impl Package {
    /// Why this package may not be used, if so.
    fn objection(&self, licences: &Licences) -> Option<String> {
        let name = format!("{} {}", self.name, self.version);
        if let Some(source) = self
            .source
            .as_ref()
            .filter(|source| !source.starts_with("registry+"))
        {
            return Some(format!(
                "{name}: comes from {source}, not from the registry"
            ));
        }
        if let Some(rust) = &self.rust
            && version(rust) > version(RUST)
        {
            return Some(format!("{name}: needs Rust {rust}, {RUST} is promised"));
        }
        let Some(licence) = &self.licence else {
            return Some(format!("{name}: states no licence"));
        };
        match spdx::satisfied(licence, &licences.allowed_for(&self.name)) {
            Ok(true) => None,
            Ok(false) => Some(format!("{name}: licence {licence}")),
            Err(why) => Some(format!("{name}: {why}")),
        }
    }
}

/// The packages in the JSON that `cargo metadata` prints.
fn packages(metadata: &str) -> Option<Vec<Package>> {
    let metadata: Value = serde_json::from_str(metadata).ok()?;
    let text = |package: &Value, field: &str| {
        package
            .get(field)
            .and_then(Value::as_str)
            .map(str::to_owned)
    };
    metadata
        .get("packages")?
        .as_array()?
        .iter()
        .map(|package| {
            Some(Package {
                name: text(package, "name")?,
                version: text(package, "version")?,
                licence: text(package, "license"),
                source: text(package, "source"),
                rust: text(package, "rust_version"),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn licences() -> Licences {
        let text = r#"
            [licenses]
            allow = ["MIT"]
            exceptions = [{ crate = "special", allow = ["MPL-2.0"] }]
        "#;
        Licences::from_table(&text.parse().expect("is TOML")).expect("has what is needed")
    }

    #[test]
    fn an_exception_holds_for_its_package_only() {
        assert_eq!(licences().allowed_for("special"), ["MIT", "MPL-2.0"]);
        assert_eq!(licences().allowed_for("other"), ["MIT"]);
    }

    fn objection(licence: Option<&str>, source: Option<&str>) -> Option<String> {
        let package = Package {
            name: "some".into(),
            version: "1.0.0".into(),
            licence: licence.map(str::to_owned),
            source: source.map(str::to_owned),
            rust: None,
        };
        package.objection(&licences())
    }

    #[test]
    fn a_later_rust_than_promised_is_refused() {
        let with = |rust: Option<&str>| {
            let package = Package {
                name: "some".into(),
                version: "1.0.0".into(),
                licence: Some("MIT".into()),
                source: None,
                rust: rust.map(str::to_owned),
            };
            package.objection(&licences())
        };
        let [major, minor, _] = version(RUST).expect("a version");
        let later = format!("{major}.{}", minor + 1);
        for fine in [None, Some(RUST), Some("1.9"), Some("1.9.99")] {
            assert_eq!(with(fine), None, "{fine:?}");
        }
        assert!(with(Some(&later)).is_some_and(|why| why.contains(&later)));
        assert!(with(Some(&format!("{RUST}.1"))).is_some());
    }

    #[test]
    fn licences_and_sources_are_judged() {
        assert_eq!(objection(Some("MIT"), None), None);
        assert_eq!(
            objection(Some("MIT OR GPL-3.0"), Some("registry+somewhere")),
            None
        );
        assert!(objection(Some("GPL-3.0"), None).is_some_and(|why| why.contains("GPL-3.0")));
        assert!(objection(None, None).is_some_and(|why| why.contains("no licence")));
        assert!(
            objection(Some("MIT"), Some("git+somewhere")).is_some_and(|why| why.contains("git+"))
        );
    }

    #[test]
    fn reads_metadata() {
        let json = r#"{"packages":[{"name":"a","version":"1.2.3","license":"MIT","source":null}]}"#;
        let expected = Package {
            name: "a".into(),
            version: "1.2.3".into(),
            licence: Some("MIT".into()),
            source: None,
            rust: None,
        };
        assert_eq!(packages(json), Some(vec![expected]));
        assert_eq!(packages("{}"), None);
    }
}
