//! A command line as a shell would take it apart: words, pipes, redirections, comment.
//!
//! What the pages need and no more; a form that is not known is refused, so that nothing
//! is run otherwise than a reader's shell would run it.

use std::fmt;
use std::mem::take;

/// One program of a pipeline.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Step {
    /// Variables set for it.
    pub variables: Vec<(String, String)>,
    /// The program and its arguments.
    pub words: Vec<String>,
    /// File it reads from.
    pub from: Option<String>,
    /// File it writes to.
    pub to: Option<String>,
}

/// Programs, each reading what the one before it writes.
pub type Pipeline = Vec<Step>;

/// A command line.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Line {
    /// Pipelines, one after the other (`;` and `&&`).
    pub pipelines: Vec<Pipeline>,
    /// Text after the `#`.
    pub comment: String,
}

impl Line {
    /// A command behind the `#`, where nobody runs it.
    pub fn commented(&self) -> Option<&str> {
        let starts = ["rarma ", "cargo "].into_iter();
        let at = starts.filter_map(|start| self.comment.find(start)).min()?;
        Some(&self.comment[at..])
    }
}

impl fmt::Display for Step {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, value) in &self.variables {
            write!(out, "{name}={value} ")?;
        }
        let words = self.words.iter().map(|word| {
            if word.contains(' ') {
                format!("'{word}'")
            } else {
                word.clone()
            }
        });
        out.write_str(&words.collect::<Vec<_>>().join(" "))
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Token {
    Word(String),
    Operator(String),
}

/// Takes a command line apart.
///
/// # Errors
/// What is not known here.
pub fn parse(text: &str) -> Result<Line, String> {
    let (tokens, comment) = tokens(text)?;
    let mut line = Line {
        pipelines: Vec::new(),
        comment,
    };
    let (mut pipeline, mut step) = (Pipeline::new(), Step::default());
    let mut tokens = tokens.into_iter().peekable();
    let mut last = None;
    while let Some(token) = tokens.next() {
        last = Some(token.clone());
        match token {
            Token::Word(word) => match assignment(&word) {
                Some(pair) if step.words.is_empty() => step.variables.push(pair),
                _ => step.words.push(word),
            },
            Token::Operator(operator) => match operator.as_str() {
                "<" | ">" => {
                    let Some(Token::Word(file)) = tokens.next() else {
                        return Err(format!("no file after `{operator}`"));
                    };
                    last = None;
                    let place = if operator == "<" {
                        &mut step.from
                    } else {
                        &mut step.to
                    };
                    if place.replace(file).is_some() {
                        return Err(format!("`{operator}` twice"));
                    }
                }
                "|" => pipeline.push(filled(take(&mut step))?),
                ";" | "&&" => {
                    pipeline.push(filled(take(&mut step))?);
                    line.pipelines.push(take(&mut pipeline));
                }
                other => return Err(format!("`{other}` is not known here")),
            },
        }
    }
    if let Some(Token::Operator(operator)) = last
        && operator != ";"
    {
        return Err(format!("nothing after `{operator}`"));
    }
    if step != Step::default() {
        pipeline.push(filled(step)?);
        line.pipelines.push(pipeline);
    }
    Ok(line)
}

/// A step with its program; `time` only says how long another took.
fn filled(mut step: Step) -> Result<Step, String> {
    if step.words.first().is_some_and(|word| word == "time") {
        step.words.remove(0);
    }
    if step.words.is_empty() {
        return Err("no program".to_owned());
    }
    Ok(step)
}

fn assignment(word: &str) -> Option<(String, String)> {
    let (name, value) = word.split_once('=')?;
    let named = !name.is_empty()
        && name
            .chars()
            .all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_');
    named.then(|| (name.to_owned(), value.to_owned()))
}

fn tokens(text: &str) -> Result<(Vec<Token>, String), String> {
    let mut out = Vec::new();
    let mut word: Option<String> = None;
    let mut chars = text.char_indices().peekable();
    while let Some((at, c)) = chars.next() {
        match c {
            '#' if word.is_none() => {
                return Ok((out, text[at + 1..].trim().to_owned()));
            }
            '\'' | '"' => {
                let word = word.get_or_insert_default();
                loop {
                    match chars.next() {
                        Some((_, end)) if end == c => break,
                        Some((_, '$' | '`' | '\\')) if c == '"' => {
                            return Err("a substitution in quotes".to_owned());
                        }
                        Some((_, inner)) => word.push(inner),
                        None => return Err("quotes that are not closed".to_owned()),
                    }
                }
            }
            c if c.is_whitespace() => out.extend(word.take().map(Token::Word)),
            '|' | '&' | ';' | '<' | '>' => {
                out.extend(word.take().map(Token::Word));
                let mut operator = c.to_string();
                while let Some((_, next)) = chars.next_if(|(_, next)| "|&<>".contains(*next)) {
                    operator.push(next);
                }
                out.push(Token::Operator(operator));
            }
            '$' | '`' | '*' | '?' | '(' | ')' | '{' | '}' | '[' | ']' | '\\' => {
                return Err(format!("`{c}` outside quotes"));
            }
            c => word.get_or_insert_default().push(c),
        }
    }
    out.extend(word.map(Token::Word));
    Ok((out, String::new()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(step: &Step) -> Vec<&str> {
        step.words.iter().map(String::as_str).collect()
    }

    #[test]
    fn words_quotes_comment() {
        let line =
            parse("A_1=x time rarma connect P --say 'set a 1' \"b c\"   # it says").expect("sound");
        assert_eq!(line.comment, "it says");
        let [pipeline] = &line.pipelines[..] else {
            panic!("{line:?}")
        };
        let [step] = &pipeline[..] else {
            panic!("{line:?}")
        };
        assert_eq!(
            words(step),
            ["rarma", "connect", "P", "--say", "set a 1", "b c"]
        );
        assert_eq!(step.variables, [("A_1".to_owned(), "x".to_owned())]);
        assert_eq!(
            step.to_string(),
            "A_1=x rarma connect P --say 'set a 1' 'b c'"
        );
        // No comment: in a word, in quotes.
        assert_eq!(parse("a#b '# c'").expect("sound").comment, "");
    }

    #[test]
    fn pipes_files_and_several_in_a_line() {
        let line = parse("a x|b -y <in >out.json && c; d").expect("sound");
        assert_eq!(line.pipelines.len(), 3);
        let [a, b] = &line.pipelines[0][..] else {
            panic!("{line:?}")
        };
        assert_eq!((words(a), words(b)), (vec!["a", "x"], vec!["b", "-y"]));
        assert_eq!(
            (b.from.as_deref(), b.to.as_deref()),
            (Some("in"), Some("out.json"))
        );
        assert!(parse("# only this").expect("sound").pipelines.is_empty());
    }

    #[test]
    fn what_a_shell_would_do_otherwise_is_refused() {
        for text in [
            "a $X",
            "a *.wav",
            "a &",
            "a || b",
            "a >> b",
            "a `b`",
            "a 'b",
            "a \"$b\"",
            "a |",
            "a >",
            "| a",
            "a && # b",
            "a [B]",
            "a > b > c",
        ] {
            assert!(parse(text).is_err(), "{text}: {:?}", parse(text));
        }
    }

    #[test]
    fn a_command_in_a_comment_is_seen() {
        let line = parse("a  # then: rarma connect P").expect("sound");
        assert_eq!(line.commented(), Some("rarma connect P"));
        let line = parse("a  # what rarma, and a box, do").expect("sound");
        assert_eq!(line.commented(), None);
    }
}
