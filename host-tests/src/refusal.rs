//! A refusal, as a user sees it.

use crate::process::Ended;

/// One line on standard error, `rarma: NAME: PLACE: REASON (REMEDY)`, that says these words,
/// this exit code, and nothing on standard output.
///
/// # Panics
/// It is not.
pub fn assert_one_line(ended: &Ended, code: i32, name: &str, words: &[&str]) {
    assert_eq!(ended.code, Some(code), "{ended:?}");
    assert_eq!(ended.stdout, "", "{ended:?}");
    let text = ended.stderr.strip_suffix('\n').unwrap_or(&ended.stderr);
    assert!(!text.contains(char::is_control), "not one line: {ended:?}");
    let rest = text
        .strip_prefix("rarma: ")
        .and_then(|rest| rest.strip_prefix(name))
        .and_then(|rest| rest.strip_prefix(": "));
    let rest = rest.unwrap_or_else(|| panic!("{text} does not begin with {name}"));
    let (place, reason) = rest.split_once(": ").unwrap_or_default();
    assert!(!place.is_empty() && !reason.is_empty(), "no place: {text}");
    assert!(
        text.ends_with(')') && reason.contains(" ("),
        "no remedy: {text}"
    );
    // Words of people, not of the program's own types or of the system's numbers.
    for strange in [
        "os error",
        "Some(",
        "Err(",
        " { ",
        "panicked",
        "Kind::",
        "out of memory",
    ] {
        assert!(!text.contains(strange), "`{strange}` in {text}");
    }
    for word in words {
        assert!(text.contains(word), "{text} does not say `{word}`");
    }
}
