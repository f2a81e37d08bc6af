//! The finished book: every link goes somewhere in it, and nothing is loaded from elsewhere.

use crate::links;
use anyhow::{Context, Result};
use html5ever::tendril::StrTendril;
use html5ever::tokenizer::states::RawKind;
use html5ever::tokenizer::{
    BufferQueue, Tag, TagKind, Token, TokenSink, TokenSinkResult, Tokenizer, TokenizerOpts,
};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// What was found.
#[derive(Debug, Default)]
pub struct Checked {
    /// Links and resources that were followed.
    pub links: usize,
    /// Those that lead nowhere, or out where nothing may be loaded, with their places.
    pub dead: Vec<String>,
}

/// A file of the book, as far as links go.
#[derive(Debug, Default)]
struct Document {
    ids: BTreeSet<String>,
    /// Where it goes when a reader asks for it.
    links: Vec<String>,
    /// What is loaded with it.
    resources: Vec<String>,
}

/// Follows everything in a folder.
///
/// # Errors
/// A file cannot be read.
pub fn check(book: &Path) -> Result<Checked> {
    let documents = documents(book)?;
    let mut checked = Checked::default();
    for (path, document) in &documents {
        let links = document.links.iter().filter(|to| !links::outside(to));
        for to in links.chain(&document.resources) {
            checked.links += 1;
            if let Err(why) = follow(book, &documents, path, to) {
                checked
                    .dead
                    .push(format!("{}: {to}: {why}", path.display()));
            }
        }
    }
    Ok(checked)
}

fn follow(
    book: &Path,
    documents: &BTreeMap<PathBuf, Document>,
    from: &Path,
    to: &str,
) -> Result<(), &'static str> {
    if to.starts_with("data:") {
        return Ok(());
    }
    let folder = from.parent().unwrap_or(Path::new(""));
    let (mut path, anchor) = links::inside(folder, to).ok_or("it leaves the book")?;
    if to.starts_with('#') {
        path = from.to_path_buf();
    }
    if !book.join(&path).is_file() {
        return Err("there is no such file");
    }
    let Some(anchor) = anchor.filter(|anchor| !anchor.is_empty()) else {
        return Ok(());
    };
    match documents.get(&path) {
        Some(document) if document.ids.contains(&anchor) => Ok(()),
        Some(_) => Err("there is no such place in it"),
        None => Err("a file of that kind has no places"),
    }
}

/// All pages and style sheets by their paths in the book.
fn documents(book: &Path) -> Result<BTreeMap<PathBuf, Document>> {
    let mut out = BTreeMap::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(book.join(&folder))? {
            let path = folder.join(entry?.file_name());
            let there = book.join(&path);
            if there.is_dir() {
                folders.push(path);
                continue;
            }
            let read = || {
                fs::read_to_string(&there)
                    .with_context(|| format!("cannot read {}", there.display()))
            };
            match path.extension().and_then(|e| e.to_str()) {
                Some("html") => drop(out.insert(path, Document::of_html(&read()?))),
                Some("css") => drop(out.insert(path, Document::of_css(&read()?))),
                Some("svg") => drop(out.insert(path, Document::of_html(&read()?))),
                _ => {}
            }
        }
    }
    Ok(out)
}

impl Document {
    fn of_html(text: &str) -> Self {
        let sink = Collector(RefCell::default());
        let tokenizer = Tokenizer::new(sink, TokenizerOpts::default());
        let queue = BufferQueue::default();
        queue.push_back(StrTendril::from_slice(text));
        // Nothing in a page asks the tokenizer to stop.
        let _ = tokenizer.feed(&queue);
        tokenizer.end();
        tokenizer.sink.0.into_inner()
    }

    fn of_css(text: &str) -> Self {
        let mut out = Self::default();
        out.loaded_by_css(text);
        out
    }

    fn loaded_by_css(&mut self, text: &str) {
        for rest in text.split("url(").skip(1) {
            let url = rest.split(')').next().unwrap_or_default();
            let url = url.trim_matches(|c| c == '"' || c == '\'');
            let bare = url.split(['?']).next().unwrap_or_default();
            self.resources.push(bare.to_owned());
        }
    }

    fn tag(&mut self, tag: &Tag) {
        let name: &str = &tag.name;
        for attribute in &tag.attrs {
            let value = attribute.value.to_string();
            match (name, &*attribute.name.local) {
                (_, "id") | ("a", "name") => drop(self.ids.insert(value)),
                ("a", "href") => self.links.push(value),
                ("link" | "image" | "use", "href") | (_, "src" | "srcset" | "poster" | "data") => {
                    self.resources.push(value);
                }
                (_, "style") => self.loaded_by_css(&value),
                _ => {}
            }
        }
    }
}

struct Collector(RefCell<Document>);

impl TokenSink for Collector {
    type Handle = ();

    fn process_token(&self, token: Token, _line: u64) -> TokenSinkResult<()> {
        let Token::TagToken(tag) = &token else {
            return TokenSinkResult::Continue;
        };
        if tag.kind == TagKind::EndTag {
            return TokenSinkResult::Continue;
        }
        self.0.borrow_mut().tag(tag);
        match &*tag.name {
            "script" => TokenSinkResult::RawData(RawKind::ScriptData),
            "style" => TokenSinkResult::RawData(RawKind::Rawtext),
            _ => TokenSinkResult::Continue,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::tree;

    fn dead(page: &str) -> Vec<String> {
        let book = tree(&[
            ("a/page.html", page),
            (
                "b.html",
                "<h1 id=\"here\">x</h1><script>'<a href=\"none\">'</script>",
            ),
            ("c.css", "p { background: url('b.html') }"),
        ]);
        check(book.path()).expect("readable").dead
    }

    #[test]
    fn what_leads_somewhere_is_sound() {
        let page = "<p id=\"p\"><a href=\"../b.html#here\">b</a><a href=\"#p\">p</a><a href=\"https://a.b\">far</a><link href=\"../c.css\"><img src=\"data:image/png;base64,AA\"></p>";
        assert!(dead(page).is_empty(), "{:?}", dead(page));
    }

    #[test]
    fn what_leads_nowhere_or_loads_from_elsewhere_is_dead() {
        for page in [
            "<a href=\"none.html\">",
            "<a href=\"../b.html#there\">",
            "<a href=\"#q\">",
            "<a href=\"../c.css#p\">",
            "<a href=\"../../out.html\">",
            "<img src=\"https://a.b/c.png\">",
            "<script src=\"//a.b/c.js\">",
            "<link href=\"https://a.b/c.css\">",
            "<p style=\"background: url(https://a.b/c.png)\">",
        ] {
            assert_eq!(dead(page).len(), 1, "{page}");
        }
    }
}
