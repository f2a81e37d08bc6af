//! Where a link goes: a path from the root of the workspace, and a place there.

use std::path::{Component, Path, PathBuf};

/// The path and the anchor of a link that a page in `folder` has; nothing where it goes out of
/// the workspace, to another host or up beyond the root.
pub fn inside(folder: &Path, to: &str) -> Option<(PathBuf, Option<String>)> {
    let scheme = to.split_once(':').is_some_and(|(before, _)| {
        before.chars().all(|c| c.is_ascii_alphanumeric()) && !before.is_empty()
    });
    if scheme || to.starts_with('/') {
        return None;
    }
    let (path, anchor) = match to.split_once('#') {
        Some((path, anchor)) => (path, Some(anchor.to_owned())),
        None => (to, None),
    };
    let mut out = PathBuf::new();
    for part in folder.join(path).components() {
        match part {
            Component::ParentDir if !out.pop() => return None,
            Component::Normal(name) => out.push(name),
            _ => {}
        }
    }
    Some((out, anchor))
}

/// Whether a link goes to another host.
pub fn outside(to: &str) -> bool {
    ["https://", "http://", "mailto:"]
        .iter()
        .any(|scheme| to.starts_with(scheme))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_followed_from_the_folder_of_its_page() {
        let found = |to: &str| {
            inside(Path::new("docs/decisions"), to)
                .map(|(path, anchor)| (path.display().to_string(), anchor.unwrap_or_default()))
        };
        let at = |path: &str, anchor: &str| Some((path.to_owned(), anchor.to_owned()));
        assert_eq!(
            found("../bench.md#how-fast"),
            at("docs/bench.md", "how-fast")
        );
        assert_eq!(found("../../README.md"), at("README.md", ""));
        assert_eq!(found("0001-a.md"), at("docs/decisions/0001-a.md", ""));
        assert_eq!(found("../../../else.md"), None);
        assert_eq!(found("https://a.b/c.md"), None);
        assert_eq!(found("/etc"), None);
        assert!(outside("https://a.b") && !outside("a.md"));
    }
}
