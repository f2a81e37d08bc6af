//! The code blocks of a page, and the command lines in those for a shell.

/// Words after the fence that make a block one for a shell.
const SHELLS: [&str; 4] = ["sh", "bash", "shell", "console"];

/// Beside one of these: too long for every run of the checks.
const LONG: &str = "long";

/// First words of commands of this project, which stand in blocks for a shell only.
const OURS: [&str; 3] = ["rarma", "cargo", "$"];

/// A block for a shell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// The page, from the root of the workspace.
    pub page: String,
    /// Whether it is marked as long.
    pub long: bool,
    /// Command lines with the number of their first line; continued lines are one.
    pub lines: Vec<(usize, String)>,
}

/// The blocks for a shell of a page.
///
/// # Errors
/// Place and text of a command that stands in a block of another kind, where nobody would run it.
pub fn blocks(page: &str, text: &str) -> Result<Vec<Block>, String> {
    let mut out = Vec::new();
    let mut open: Option<(String, Option<Block>)> = None;
    let mut begun: Option<(usize, String)> = None;
    for (number, line) in (1..).zip(text.lines()) {
        let bare = line.trim();
        let Some((fence, block)) = &mut open else {
            open = opened(page, bare);
            continue;
        };
        if bare.starts_with(fence.as_str()) && bare.trim_start_matches(['`', '~']).is_empty() {
            out.extend(block.take());
            open = None;
            continue;
        }
        let Some(block) = block else {
            let first = bare.split_whitespace().next().unwrap_or_default();
            if OURS.contains(&first) {
                return Err(format!(
                    "{page}:{number}: `{bare}` stands in a block that is not for a shell (open it with ```sh)"
                ));
            }
            continue;
        };
        let (at, mut whole) = begun.take().unwrap_or((number, String::new()));
        let prompted = bare.strip_prefix("$ ").unwrap_or(bare);
        match prompted.strip_suffix('\\') {
            Some(part) => {
                whole += part;
                begun = Some((at, whole));
            }
            None => {
                whole += prompted;
                if !whole.is_empty() {
                    block.lines.push((at, whole));
                }
            }
        }
    }
    match open {
        None => Ok(out),
        Some(_) => Err(format!("{page}: a code block is not closed")),
    }
}

/// What a line opens: the fence that closes it, and the block where it is one for a shell.
fn opened(page: &str, line: &str) -> Option<(String, Option<Block>)> {
    let mark = ["```", "~~~"].into_iter().find(|m| line.starts_with(m))?;
    let info = line.trim_start_matches(&mark[..1]);
    let fence = line[..line.len() - info.len()].to_owned();
    let mut words = info.split([' ', ',']).filter(|w| !w.is_empty());
    let shell = words.next().is_some_and(|first| SHELLS.contains(&first));
    let block = shell.then(|| Block {
        page: page.to_owned(),
        long: words.any(|word| word == LONG),
        lines: Vec::new(),
    });
    Some((fence, block))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_shells_only_with_their_places() {
        let page = "# A\n```sh\nrarma a   # b\n\nrarma c \\\n  --d\n```\n\n```text\nout of rarma\n```\n~~~sh long\n$ e\n~~~\n";
        let found = blocks("p.md", page).expect("a sound page");
        assert_eq!(found.len(), 2, "{found:?}");
        assert_eq!(
            found[0].lines,
            [
                (3, "rarma a   # b".to_owned()),
                (5, "rarma c --d".to_owned())
            ]
        );
        assert_eq!(found[1].lines, [(13, "e".to_owned())]);
        assert_eq!([found[0].long, found[1].long], [false, true]);
    }

    #[test]
    fn a_command_where_nobody_runs_it_is_refused() {
        for page in ["```text\nrarma a\n```", "```\n$ ls\n```", "```sh\nrarma a"] {
            assert!(blocks("p.md", page).is_err(), "{page}");
        }
    }
}
