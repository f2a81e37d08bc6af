//! Debian packages, installed without questions where that is allowed.

use std::process::{Command, Stdio};

use crate::{Failure, Result, process};

/// Seconds to wait for another package manager to finish.
const LOCK_TIMEOUT_S: u32 = 300;

/// The line a user would type.
pub fn install_line(packages: &[&str]) -> String {
    format!(
        "`apt-get update && apt-get install --no-install-recommends {}`",
        packages.join(" ")
    )
}

/// Installs packages, unless they are installed already.
///
/// # Errors
/// When there is no apt-get, we are not root, or apt-get fails.
pub fn install(packages: &[&str]) -> Result<()> {
    if packages.iter().all(|package| version(package).is_some()) {
        return Ok(());
    }
    let what = || Failure::new(format!("cannot install {}", packages.join(" ")));
    if process::find_program("apt-get").is_none() {
        return Err(what().because("this machine has no apt-get"));
    }
    if !we_are_root() {
        return Err(what()
            .because("only root may install packages")
            .advise(format!("as root: {}", install_line(packages))));
    }
    eprintln!("toolchain: installing {}", packages.join(" "));
    apt_get(&["update"])?;
    let mut install = vec!["install", "--yes", "--no-install-recommends"];
    install.extend(packages);
    apt_get(&install)
}

/// The installed version of a package.
pub fn version(package: &str) -> Option<String> {
    let mut query = Command::new("dpkg-query");
    query.args([
        "--show",
        "--showformat",
        "${db:Status-Status} ${Version}",
        package,
    ]);
    let answer = process::output(&mut query).ok()?;
    answer.trim().strip_prefix("installed ").map(str::to_owned)
}

fn apt_get(arguments: &[&str]) -> Result<()> {
    let mut command = Command::new("apt-get");
    command
        .args([
            "-qq",
            "-o",
            &format!("DPkg::Lock::Timeout={LOCK_TIMEOUT_S}"),
        ])
        .args(arguments)
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdin(Stdio::null())
        // Our stdout may be read by a program; apt-get's progress is for people.
        .stdout(Stdio::null());
    process::run(&mut command).map_err(|failure| {
        failure.advise("look at apt-get's lines above; a Debian 12 or later has these packages")
    })
}

fn we_are_root() -> bool {
    process::output(Command::new("id").arg("-u")).is_ok_and(|id| id.trim() == "0")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_to_type_names_every_package() {
        assert_eq!(
            install_line(&["a", "b"]),
            "`apt-get update && apt-get install --no-install-recommends a b`"
        );
    }

    #[test]
    fn an_unknown_package_has_no_version() {
        assert_eq!(version("no-package-has-this-name"), None);
    }
}
