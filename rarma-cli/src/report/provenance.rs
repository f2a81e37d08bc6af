//! Where a page comes from: when, of what, by which command, and what its user noted.

use super::date::utc;
use rarma_pictures::text::escape;
use std::time::SystemTime;

/// What is known beside the samples. All of it may be missing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Provenance {
    /// When the recording's file was written last.
    pub recorded: Option<SystemTime>,
    /// When the page was made.
    pub made: Option<SystemTime>,
    /// The command, so that a shell takes it.
    pub command: Option<String>,
    /// What the user noted, such as machine, tool and operator, in the given order.
    pub notes: Vec<(String, String)>,
}

impl Provenance {
    /// Of a page that is made now, by the command that runs.
    pub fn of_this_run() -> Self {
        let words = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
        Self {
            made: Some(SystemTime::now()),
            command: Some(shell_words(words)),
            ..Self::default()
        }
    }

    /// The notes and the date in a line below the headline; nothing where there is neither.
    pub(super) fn line(&self) -> String {
        let notes = self
            .notes
            .iter()
            .map(|(key, value)| format!("<span><b>{}</b> {}</span>", escape(key), escape(value)));
        let dated = self.recorded.and_then(utc);
        let dated = dated.map(|date| format!("<span><b>file written</b> {date}</span>"));
        let all: Vec<String> = notes.chain(dated).collect();
        if all.is_empty() {
            return String::new();
        }
        format!("<p class=\"notes\">{}</p>\n", all.join(" "))
    }

    /// Rows of the table of settings; the second of each is HTML.
    pub(super) fn rows(&self) -> Vec<(&'static str, String)> {
        let dates = [
            ("File last written", self.recorded),
            ("Page made", self.made),
        ];
        let dates = dates.map(|(name, at)| Some((name, at.and_then(utc)?)));
        let command = self.command.as_deref();
        let command = command.map(|c| ("Command", format!("<code>{}</code>", escape(c))));
        dates.into_iter().chain([command]).flatten().collect()
    }
}

/// Words of a command as a shell takes them.
fn shell_words(words: impl IntoIterator<Item = String>) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./:,=+@%".contains(c);
    let quoted = words.into_iter().map(|word| {
        if !word.is_empty() && word.chars().all(plain) {
            word
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    });
    quoted.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_the_same_words() {
        let words = ["rarma", "a b.wav", "it's", "", "--band=300:2500"];
        assert_eq!(
            shell_words(words.map(str::to_owned)),
            r"rarma 'a b.wav' 'it'\''s' '' --band=300:2500"
        );
    }

    #[test]
    fn what_was_noted_stays_text_and_nothing_is_no_line() {
        assert_eq!(Provenance::default().line(), "");
        assert!(Provenance::default().rows().is_empty());
        let noted = Provenance {
            notes: vec![("<b>".into(), "a\u{7}\"&".into())],
            command: Some("rarma monitor '<x>'".into()),
            ..Provenance::default()
        };
        let line = noted.line();
        assert!(
            line.contains("<b>&lt;b&gt;</b> a\u{fffd}&quot;&amp;"),
            "{line}"
        );
        let rows = noted.rows();
        assert_eq!(rows.len(), 1);
        assert!(rows[0].1.contains("&lt;x&gt;"), "{rows:?}");
    }
}
