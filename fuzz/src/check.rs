//! What every refusal must be.

use std::fmt::Display;
use std::path::Path;

/// One line `FILE: PLACE: REASON (REMEDY)`.
///
/// # Panics
/// It is not.
pub fn refusal(file: &Path, why: &impl Display) {
    let (line, file) = (why.to_string(), file.display().to_string());
    one_line(&line);
    let rest = line
        .strip_prefix(&file)
        .and_then(|rest| rest.strip_prefix(": "));
    let rest = rest.unwrap_or_else(|| panic!("does not begin with the file: {line}"));
    assert!(rest.contains(": "), "names no place: {line}");
    remedy(rest);
}

/// One line `REASON (REMEDY)`, of something that is no file.
///
/// # Panics
/// It is not.
pub fn words(why: &str) {
    one_line(why);
    remedy(why);
}

/// One line.
///
/// # Panics
/// It holds a line break or another control character, or nothing.
pub fn one_line(text: &str) {
    assert!(!text.contains(char::is_control), "not one line: {text:?}");
    assert!(!text.trim().is_empty(), "says nothing");
}

fn remedy(text: &str) {
    let inside = text.rsplit_once(" (").and_then(|(reason, remedy)| {
        let remedy = remedy.strip_suffix(')')?;
        (!reason.trim().is_empty() && !remedy.trim().is_empty()).then_some(remedy)
    });
    assert!(inside.is_some(), "names no remedy: {text}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::catch_unwind;

    #[test]
    fn a_refusal_has_four_parts_in_one_line() {
        let holds =
            |line: &'static str| catch_unwind(|| refusal(Path::new("a.csv"), &line)).is_ok();
        assert!(holds("a.csv: line 3: no value (fill it in)"));
        for line in [
            "b.csv: line 3: no value (fill it in)",
            "a.csv: no value (fill it in)",
            "a.csv: line 3: no value",
            "a.csv: line 3: no value ()",
            "a.csv: line 3:\nno value (fill it in)",
        ] {
            assert!(!holds(line), "{line}");
        }
    }
}
