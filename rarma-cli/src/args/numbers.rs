//! The numbers of the verdict, by name.

use crate::failure::Failure;
use clap::Args;
use rarma_core::verdict::VerdictConfig;

/// Numbers that are not the usual ones.
#[derive(Debug, Clone, Args)]
pub struct NumbersArgs {
    /// Another value for a number of the verdict; may be repeated.
    #[arg(long, value_name = "NAME=VALUE", value_parser = number)]
    pub set: Vec<(String, f64)>,
}

impl NumbersArgs {
    /// All of them.
    ///
    /// # Errors
    /// One that does not exist or is out of range.
    pub fn numbers(&self) -> Result<VerdictConfig, Failure> {
        let mut numbers = VerdictConfig::default();
        for (name, value) in &self.set {
            let refused = |why| Failure::Usage(format!("--set {name}={value}: {why}"));
            numbers.set(name, *value).map_err(refused)?;
        }
        Ok(numbers)
    }
}

fn number(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("must be NAME=VALUE")?;
    let value = value
        .parse()
        .map_err(|_| format!("{value}: not a number"))?;
    Ok((name.to_owned(), value))
}
