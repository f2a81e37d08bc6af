//! Pages of figures and tables.

use super::text::escape;

/// The style sheet of every page: dark, light and in print.
pub const STYLE: &str = include_str!("style.css");

/// A page of headed figures and tables, in the same dress as a run's report.
///
/// `body` is HTML.
pub fn sheet(title: &str, headline: &str, body: &str, version: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<header>\n<p class=\"job\">{title}</p>\n<h1>{headline}</h1>\n</header>\n<main>\n{body}</main>\n<footer><p>rarma {version}</p></footer>\n</body>\n</html>\n",
        title = escape(title),
        headline = escape(headline),
        style = STYLE,
        version = escape(version),
    )
}

/// A table; cells are plain text.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut html = String::from("<div class=\"scroll\"><table>\n<thead><tr>");
    for h in head {
        put!(html, "<th scope=\"col\">{}</th>", escape(h));
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in rows {
        html.push_str("<tr>");
        for cell in row {
            put!(html, "<td>{}</td>", escape(cell));
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table></div>\n");
    html
}
