//! Taking the pictures out of a page of `rarma`, each as a file of its own.

use std::collections::BTreeSet;

/// A picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Its title.
    pub title: String,
    /// What is to be seen, in words.
    pub words: String,
    /// How to read it.
    pub caption: String,
    /// The file.
    pub svg: String,
}

/// All pictures of a page.
///
/// # Errors
/// A figure lacks something; what.
pub fn of_page(html: &str) -> Result<Vec<Picture>, String> {
    let style = between(html, "<style>", "</style>").unwrap_or_default();
    let rules = rules(style);
    html.split("<figure>")
        .skip(1)
        .enumerate()
        .map(|(k, figure)| {
            picture(figure, &rules).ok_or_else(|| {
                format!("figure {} lacks its title, its words or its caption", k + 1)
            })
        })
        .collect()
}

fn picture(figure: &str, rules: &[Rule]) -> Option<Picture> {
    let at = figure.find("<svg ")?;
    let end = figure.find("</svg>")?;
    let svg = &figure[at + "<svg ".len()..end];
    let view = between(svg, "viewBox=\"", "\"")?;
    let mut sides = view.split(' ').skip(2);
    let (width, height) = (sides.next()?, sides.next()?);
    let titled = svg.find("class=\"title\"")?;
    let title = between(&svg[titled..], ">", "</text>")?;
    let (attributes, content) = svg.split_once('>')?;
    Some(Picture {
        title: plain(title),
        words: plain(between(attributes, "aria-label=\"", "\"")?),
        caption: plain(between(figure, "<figcaption>", "</figcaption>")?),
        svg: format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" {attributes}>\n<style>\n{}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"var(--paper)\"/>\n{content}\n</svg>\n",
            style(rules, content),
        ),
    })
}

/// A rule of a style sheet.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Rule {
    selector: String,
    block: String,
}

/// The rules of a style sheet, those in an `@media` as one.
fn rules(style: &str) -> Vec<Rule> {
    let style: String = style
        .split("/*")
        .enumerate()
        .filter_map(|(k, piece)| match k {
            0 => Some(piece),
            _ => Some(piece.split_once("*/")?.1),
        })
        .collect();
    let mut out = Vec::new();
    let (mut depth, mut from, mut opened) = (0, 0, 0);
    for (at, c) in style.char_indices() {
        match c {
            '{' => {
                if depth == 0 {
                    opened = at;
                }
                depth += 1;
            }
            '}' => {
                depth -= 1;
                if depth == 0 {
                    out.push(Rule {
                        selector: style[from..opened].trim().to_owned(),
                        block: style[opened + 1..at].trim().to_owned(),
                    });
                    from = at + 1;
                }
            }
            _ => {}
        }
    }
    out
}

/// What of a page's style a picture needs that stands alone: colours, the font, and the rules
/// for what is in it.
fn style(rules: &[Rule], content: &str) -> String {
    let used: BTreeSet<&str> = content
        .split("class=\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .flat_map(str::split_whitespace)
        .collect();
    let mut out = String::new();
    for rule in rules {
        let dark = rule.selector.contains("prefers-color-scheme: dark");
        if rule.selector == "body" {
            let font = rule
                .block
                .split(';')
                .find(|part| part.trim().starts_with("font:"));
            if let Some(font) = font {
                out.push_str(&format!("svg {{ {}; }}\n", font.trim()));
            }
        } else if rule.selector == ":root"
            || dark
            || rule.selector.split(',').any(|s| drawn(s, &used))
        {
            out.push_str(&format!("{} {{ {} }}\n", rule.selector, rule.block));
        }
    }
    out
}

/// Whether a selector is for something in a picture with these classes.
fn drawn(selector: &str, used: &BTreeSet<&str>) -> bool {
    let selector = selector.trim();
    let inner = selector.strip_prefix("svg ").unwrap_or(selector);
    let mut classes = inner.split(['.', ' ', ':']).filter(|part| !part.is_empty());
    if inner.starts_with('.') {
        classes.all(|class| used.contains(class))
    } else {
        inner != selector && !inner.contains(['.', ':'])
    }
}

fn between<'a>(text: &'a str, before: &str, after: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(before)?;
    Some(rest.split_once(after)?.0)
}

/// Text of a page without its marks.
fn plain(html: &str) -> String {
    html.replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&quot;", "\"")
        .replace("&#39;", "'")
        .replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "<style>\n:root { --a: 1; /* x */ }\n/* dark { */\n@media (prefers-color-scheme: dark) {\n  :root { --a: 2; }\n}\nbody { margin: 0; font: 16px/1.5 Arial, sans-serif; }\nsvg { width: 100%; }\nsvg text { fill: red; }\nsvg .number, svg .none { fill: blue; }\n.c0 { --tone: 1; }\n.forced.arrow { fill: pink; }\n.forced { fill: green; }\nh1 { x: y; }\n@media print { svg text { a: b; } }\n</style><figure><div><svg viewBox=\"0 0 10 20\" role=\"img\" aria-label=\"W &quot;1&quot;\"><text x=\"1\" class=\"title\">T &lt; U</text><path class=\"number forced\"/></svg></div><figcaption>C</figcaption></figure>";

    #[test]
    fn a_picture_stands_alone_with_the_style_it_needs() {
        let found = of_page(PAGE).expect("one picture");
        assert_eq!(found.len(), 1);
        let picture = &found[0];
        assert_eq!(
            (&picture.title[..], &picture.words[..], &picture.caption[..]),
            ("T < U", "W \"1\"", "C")
        );
        let svg = &picture.svg;
        assert!(
            svg.starts_with(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"10\" height=\"20\" viewBox"
            ),
            "{svg}"
        );
        for kept in [
            ":root { --a: 1;",
            "--a: 2;",
            "svg { font: 16px/1.5 Arial, sans-serif; }",
            "svg text { fill: red; }",
            "svg .number, svg .none { fill: blue; }",
            ".forced { fill: green; }",
        ] {
            assert!(svg.contains(kept), "{kept}: {svg}");
        }
        for left in ["width: 100%;", "--tone", "pink", "h1", "a: b", "margin"] {
            assert!(!svg.contains(left), "{left}: {svg}");
        }
        assert!(of_page("<figure><svg viewBox=\"0 0 1 1\"></svg></figure>").is_err());
        assert_eq!(of_page("no pictures"), Ok(Vec::new()));
    }
}
