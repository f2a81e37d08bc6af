//! The paths that Rust code names, as far as one can tell from the text: `crate::`, `super::`, `self::`, and what a
//! `use` begins with. No parser of Rust: this program is built before the demonstration, and one takes seconds to build.

/// A path, segment by segment, and whether a `pub use` gives it on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// `crate`, `super`, a name, …
    pub path: Vec<String>,
    /// Others see it under the module that says so.
    pub given_on: bool,
}

/// All of them, those of tests and comments left out.
pub fn named(code: &str) -> Vec<Named> {
    let mut found = Vec::new();
    for start in ["crate::", "super::", "self::"] {
        for (at, _) in code.match_indices(start) {
            let before = code[..at].chars().next_back();
            // Not the end of another word or in the middle of a path.
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                continue;
            }
            let given_on = before_use(&code[..at]).is_some_and(|visible| visible);
            expand(&code[at..], given_on, &mut found);
        }
    }
    for (at, start) in code.match_indices("use ") {
        let before = code[..at].chars().next_back();
        let rest = code[at + start.len()..].trim_start();
        let has_own = ["crate::", "super::", "self::"]
            .iter()
            .any(|own| rest.starts_with(own));
        if !has_own && before.is_none_or(char::is_whitespace) {
            let given_on = code[..at].rsplit('\n').next().is_some_and(is_visible);
            expand(rest, given_on, &mut found);
        }
    }
    found
}

/// Whether what stands before a path is a `use`, and if so whether others see it.
fn before_use(code: &str) -> Option<bool> {
    let line = code.rsplit('\n').next()?.trim_start();
    let visible = line.strip_suffix("use ")?;
    Some(is_visible(visible))
}

fn is_visible(before_use: &str) -> bool {
    before_use.trim_start().starts_with("pub")
}

/// Adds every path of a tree such as `a::{b, c::d}`.
fn expand(text: &str, given_on: bool, found: &mut Vec<Named>) {
    let mut stack: Vec<Vec<String>> = Vec::new();
    let mut path: Vec<String> = Vec::new();
    let mut rest = text;
    loop {
        let end = rest
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(rest.len());
        let (word, behind) = rest.split_at(end);
        if !word.is_empty() {
            path.push(word.to_owned());
        }
        if let Some(more) = behind.strip_prefix("::") {
            rest = more;
            if let Some(inside) = rest.strip_prefix('{') {
                stack.push(path.clone());
                rest = inside.trim_start();
            }
            continue;
        }
        let rest_of_tree = behind.strip_prefix('*');
        if !word.is_empty() || rest_of_tree.is_some() {
            found.push(Named {
                path: path.clone(),
                given_on,
            });
        }
        let behind = rest_of_tree.unwrap_or(behind);
        // Behind a path: its other name, then the next of the list, or its end.
        rest = behind.trim_start();
        if let Some(other) = rest.strip_prefix("as ") {
            let end = other.find([',', '}', ';']).unwrap_or(other.len());
            rest = &other[end..];
        }
        loop {
            let Some(outer) = stack.last() else { return };
            path = outer.clone();
            if let Some(more) = rest.strip_prefix(',') {
                rest = more.trim_start();
            } else if let Some(more) = rest.strip_prefix('}') {
                stack.pop();
                rest = more.trim_start();
            } else if rest.starts_with(|c: char| c.is_alphanumeric() || c == '_' || c == '*') {
                break;
            } else {
                // No tree after all.
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(code: &str) -> Vec<String> {
        let mut paths: Vec<String> = named(code).iter().map(|n| n.path.join("::")).collect();
        paths.sort();
        paths
    }

    #[test]
    fn trees_are_taken_apart() {
        assert_eq!(
            paths("use super::{a::{self, B}, c as d, e::*};"),
            ["super::a::B", "super::a::self", "super::c", "super::e"]
        );
        assert_eq!(
            paths("use one::Two;\npub use three::{Four, five};"),
            ["one::Two", "three::Four", "three::five"]
        );
    }

    #[test]
    fn paths_in_code_count_and_parts_of_words_do_not() {
        let code = "let x = crate::order::O + super::super::y(1);\nuse my_crate::Z;";
        assert_eq!(
            paths(code),
            ["crate::order::O", "my_crate::Z", "super::super::y"]
        );
    }

    #[test]
    fn what_is_given_on_is_marked() {
        let given: Vec<bool> = named("pub use a::B;\nuse c::D;\npub(super) use super::e;")
            .iter()
            .map(|n| n.given_on)
            .collect();
        assert_eq!(given.iter().filter(|g| **g).count(), 2);
    }
}
