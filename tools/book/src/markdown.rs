//! A page as far as its links go: headings with their anchors, and links with their places.

use mdbook_markdown::pulldown_cmark::{Event, HeadingLevel, LinkType, Tag, TagEnd};
use mdbook_markdown::{MarkdownOptions, new_cmark_parser};
use std::collections::BTreeSet;
use std::ops::Range;

/// A link of a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Link {
    /// Where it goes, as written.
    pub to: String,
    /// The bytes of the page in which that stands; none where the link has no place of its own.
    pub place: Option<Range<usize>>,
    /// Number of its line.
    pub line: usize,
}

/// A page.
#[derive(Debug, Clone, Default)]
pub struct Page {
    /// Its text.
    pub text: String,
    /// Its first heading.
    pub title: String,
    /// What a link to it may name after `#`.
    pub anchors: BTreeSet<String>,
    /// Its links and pictures.
    pub links: Vec<Link>,
    /// Headings of the second level, and where each begins.
    parts: Vec<(String, usize)>,
}

impl Page {
    /// Reads a page.
    pub fn new(text: &str) -> Self {
        let mut page = Self {
            text: text.to_owned(),
            ..Self::default()
        };
        let mut options = MarkdownOptions::default();
        options.smart_punctuation = false;
        options.definition_lists = false;
        options.admonitions = false;
        let mut heading: Option<String> = None;
        for (event, range) in new_cmark_parser(text, &options).into_offset_iter() {
            match event {
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::Text(words) | Event::Code(words) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&words);
                    }
                }
                Event::End(TagEnd::Heading(level)) => {
                    page.headed(level, &heading.take().unwrap_or_default(), range.start);
                }
                Event::Start(
                    Tag::Link {
                        link_type,
                        dest_url,
                        ..
                    }
                    | Tag::Image {
                        link_type,
                        dest_url,
                        ..
                    },
                ) => page.linked(link_type, &dest_url, &range),
                _ => {}
            }
        }
        page
    }

    fn headed(&mut self, level: HeadingLevel, words: &str, at: usize) {
        let anchor = anchor(words);
        let free = std::iter::once(anchor.clone())
            .chain((1..).map(|k| format!("{anchor}-{k}")))
            .find(|name| !self.anchors.contains(name));
        self.anchors.extend(free);
        match level {
            HeadingLevel::H1 if self.title.is_empty() => self.title = words.to_owned(),
            HeadingLevel::H2 => self.parts.push((words.to_owned(), at)),
            _ => {}
        }
    }

    fn linked(&mut self, kind: LinkType, to: &str, range: &Range<usize>) {
        let written = &self.text[range.clone()];
        let place = match kind {
            LinkType::Inline => written.rfind(&format!("]({to}")).map(|at| {
                let from = range.start + at + 2;
                from..from + to.len()
            }),
            _ => None,
        };
        self.links.push(Link {
            to: to.to_owned(),
            place,
            line: 1 + self.text[..range.start].matches('\n').count(),
        });
    }

    /// Headings of the second level, each with the links below it.
    pub fn parts(&self) -> impl Iterator<Item = (String, Vec<&Link>)> {
        self.parts.iter().enumerate().map(|(k, (title, from))| {
            let to = self.parts.get(k + 1).map_or(self.text.len(), |p| p.1);
            let below = self.links.iter().filter(move |link| {
                let at = link.place.as_ref();
                at.is_some_and(|place| (*from..to).contains(&place.start))
            });
            (title.clone(), below.collect())
        })
    }

    /// The text with other places for its links, where `other` names one.
    pub fn relinked(&self, mut other: impl FnMut(&Link) -> Option<String>) -> String {
        let mut out = String::with_capacity(self.text.len());
        let mut done = 0;
        // A picture in a link stands before the place of the link, and comes after it.
        let mut links: Vec<&Link> = self.links.iter().collect();
        links.sort_by_key(|link| link.place.as_ref().map(|place| place.start));
        for link in links {
            let (Some(place), Some(to)) = (&link.place, other(link)) else {
                continue;
            };
            out.push_str(&self.text[done..place.start]);
            out.push_str(&to);
            done = place.end;
        }
        out.push_str(&self.text[done..]);
        out
    }
}

/// What a heading is called in a link, as code hosts and mdBook have it: small letters, digits,
/// `-` and `_`; a blank becomes `-`, everything else goes.
fn anchor(words: &str) -> String {
    words
        .trim()
        .to_lowercase()
        .chars()
        .filter_map(|c| match c {
            c if c.is_alphanumeric() || c == '_' || c == '-' => Some(c),
            c if c.is_whitespace() => Some('-'),
            _ => None,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn anchors_are_those_of_code_hosts() {
        let page = Page::new("# A `b` (c), d_e: f-g\n## Über ζ\n## x\n### x\n");
        let want = ["a-b-c-d_e-f-g", "x", "x-1", "über-ζ"];
        assert_eq!(page.title, "A b (c), d_e: f-g");
        assert!(page.anchors.iter().eq(want), "{:?}", page.anchors);
    }

    #[test]
    fn links_are_found_with_their_places_and_not_in_code() {
        let text = "# T\n[a](b.md) `[c](d.md)` ![p](p.svg \"t\")\n\n```sh\n[e](f.md)\n```\n<https://a.b>\n[r][s] [[i](in.md)](out.md)\n\n[s]: g.md\n";
        let page = Page::new(text);
        let found: Vec<(&str, usize, bool)> = page
            .links
            .iter()
            .map(|link| (link.to.as_str(), link.line, link.place.is_some()))
            .collect();
        let want = [
            ("b.md", 2, true),
            ("p.svg", 2, true),
            ("https://a.b", 7, false),
            ("g.md", 8, false),
            ("in.md", 8, true),
        ];
        assert_eq!(found, want);
        let both = Page::new("[![w](p.svg)](b.md)\n");
        let moved = both.relinked(|link| Some(format!("x/{}", link.to)));
        assert_eq!(moved, "[![w](x/p.svg)](x/b.md)\n");
        let moved = page.relinked(|link| (link.to == "b.md").then(|| "c/d.html#e".to_owned()));
        assert_eq!(moved, text.replacen("b.md", "c/d.html#e", 1));
    }
}
