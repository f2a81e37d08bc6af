//! `cargo xtask book [--pictures] [--serve [PORT]]`: the pages of docs as a book, its links checked.
//!
//! mdBook renders it; the program that calls it is `tools/book`, a workspace of its own, so that
//! nobody builds it who does not want the book.

use std::path::PathBuf;
use std::process::Command;

use crate::web::Server;
use crate::{Failure, Result, Workspace, gallery, process};

/// The manifest of the program that makes the book.
pub const MANIFEST: &str = "tools/book/Cargo.toml";
const TOOL: &str = "book";

/// The book, made.
#[derive(Debug, Clone)]
pub struct Book {
    /// Where it is.
    pub folder: PathBuf,
    /// What is in it, for people.
    pub description: String,
}

/// Makes the book in `target/book`; with pictures, the gallery is made first and is in it.
///
/// # Errors
/// The program does not build, a link is dead, or the folder cannot be written.
pub fn make(workspace: &Workspace, pictures: bool) -> Result<Book> {
    let program = process::build_tool(workspace, TOOL)?.join(TOOL);
    let folder = workspace.target_dir().join("book");
    let mut book = Command::new(program);
    book.arg(workspace.root())
        .arg(workspace.target_dir().join("book-pages"))
        .arg(&folder);
    if pictures {
        let to = gallery::usual_folder(workspace);
        gallery::make(workspace, &to, None)?;
        book.arg(to);
    }
    let description = process::output(&mut book)?.trim().to_owned();
    Ok(Book {
        folder,
        description,
    })
}

/// The command `book`.
///
/// # Errors
/// Wrong arguments, or as [`make`].
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let (pictures, port) = parse(arguments)?;
    let book = make(workspace, pictures)?;
    println!(
        "{}: {}",
        book.folder.join("index.html").display(),
        book.description
    );
    if let Some(port) = port {
        let server = Server::start(&book.folder, port)?;
        println!("{} (Ctrl-C ends)", server.address());
        server.wait();
    }
    Ok(0)
}

/// Whether with pictures, and the port to serve at.
fn parse(arguments: &[String]) -> Result<(bool, Option<u16>)> {
    let usage = |what: String| {
        Failure::usage(what).advise("cargo xtask book [--pictures] [--serve [PORT]]")
    };
    let (mut pictures, mut port) = (false, None);
    let mut words = arguments.iter().peekable();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--pictures" => pictures = true,
            "--serve" => {
                let named = words.next_if(|word| !word.starts_with('-'));
                port = Some(named.map_or(Ok(8080), |port| {
                    port.parse()
                        .map_err(|_| usage(format!("`{port}` is no port")))
                })?);
            }
            other => return Err(usage(format!("`book` knows no `{other}`"))),
        }
    }
    Ok((pictures, port))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments() {
        let parsed = |text: &str| {
            let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
            parse(&words)
        };
        assert_eq!(parsed(""), Ok((false, None)));
        assert_eq!(parsed("--serve --pictures"), Ok((true, Some(8080))));
        assert_eq!(parsed("--pictures --serve 9000"), Ok((true, Some(9000))));
        for wrong in ["--serve x", "--frob", "out"] {
            assert!(parsed(wrong).is_err(), "{wrong}");
        }
    }
}
