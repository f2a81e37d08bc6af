//! `book ROOT STAGE OUT [GALLERY]`: the pages of docs as an mdBook, its links checked before and after.
//!
//! Pages come from the workspace at ROOT, are laid out as mdBook wants them in STAGE and rendered
//! into OUT. GALLERY is a folder of pictures that becomes one more chapter.

mod contents;
mod gallery;
mod links;
mod markdown;
mod rendered;
mod source;
mod stage;
#[cfg(test)]
mod testing;

use anyhow::{Result, bail};
use mdbook_driver::MDBook;
use mdbook_driver::config::{Config, HtmlConfig};
use stage::Stage;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let made = match &arguments[..] {
        [root, stage, out] => book(root, stage, out, None),
        [root, stage, out, gallery] => book(root, stage, out, Some(gallery)),
        _ => Err(anyhow::anyhow!("usage: book ROOT STAGE OUT [GALLERY]")),
    };
    match made {
        Ok(told) => {
            println!("{told}");
            ExitCode::SUCCESS
        }
        Err(why) => {
            eprintln!("error: {why:#}");
            ExitCode::FAILURE
        }
    }
}

/// Makes the book and says what is in it.
fn book(root: &Path, stage: &Path, out: &Path, gallery: Option<&Path>) -> Result<String> {
    let staged = Stage::new(root, gallery)?;
    staged.write(stage)?;
    MDBook::load_with_config(stage, config(out)?)?.build()?;
    for page in &staged.sources {
        page.write(root, out)?;
    }
    let checked = rendered::check(out)?;
    if !checked.dead.is_empty() {
        bail!(
            "{} dead links in the book:\n  {}",
            checked.dead.len(),
            checked.dead.join("\n  ")
        );
    }
    Ok(format!(
        "{} chapters, {} source files shown, {} links followed in the pages and {} in the book",
        staged.chapters(),
        staged.sources.len(),
        staged.links,
        checked.links
    ))
}

/// How mdBook is to render. The destination is absolute, because mdBook takes others from the
/// stage's folder.
fn config(out: &Path) -> Result<Config> {
    let mut config = Config::default();
    config.book.title = Some("rarma".to_owned());
    config.book.description = Some("Open firmware for listening to machine tools".to_owned());
    config.book.language = Some("en".to_owned());
    config.build.build_dir = std::path::absolute(out)?;
    config.build.create_missing = false;
    // Pages are laid out already, and `{{` in them is text.
    config.build.use_default_preprocessors = false;
    config.set("output.html", html())?;
    Ok(config)
}

fn html() -> HtmlConfig {
    let mut html = HtmlConfig::default();
    // The pages are read on code hosts, too, which have none of these.
    html.smart_punctuation = false;
    html.definition_lists = false;
    html.admonitions = false;
    // There is no server that would show it.
    html.input_404 = Some(String::new());
    html.no_section_label = true;
    html.print.enable = false;
    html
}
