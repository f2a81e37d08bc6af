//! Debian packages, installed without questions where that is allowed.
//!
//! Another package manager may be at work on the same machine: its locks are waited for, and
//! the archives lie in a folder of their own, for some machines empty the common one after
//! every installation.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::{Failure, Result, process};

/// How long other package managers may take.
const PATIENCE: Duration = Duration::from_secs(600);
/// How often their locks are tried.
const TRY_AGAIN: Duration = Duration::from_secs(2);

/// Beside the folder that all package managers share.
const CACHE: &str = "/var/cache/apt";

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
/// When there is no apt-get, we are not root, another package manager does not end, or
/// apt-get fails.
pub fn install(packages: &[&str]) -> Result<()> {
    let are_here = || packages.iter().all(|package| version(package).is_some());
    if are_here() {
        return Ok(());
    }
    // One at a time in this program, and the lists of what there is are brought up to date once.
    static UP_TO_DATE: Mutex<bool> = Mutex::new(false);
    let mut up_to_date = UP_TO_DATE.lock().unwrap_or_else(PoisonError::into_inner);
    if are_here() {
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
    let archives = Archives::make(Path::new(CACHE))?;
    let apt_get = AptGet::with_archives(archives.folder());
    if !*up_to_date {
        apt_get.run(&["update"])?;
        *up_to_date = true;
    }
    let mut install = vec!["install", "--yes", "--no-install-recommends"];
    install.extend(packages);
    apt_get.run(&install)
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

/// A folder for what is downloaded, gone with this.
struct Archives(PathBuf);

impl Archives {
    fn make(beside: &Path) -> Result<Self> {
        let folder = beside.join(format!("rarma-{}", std::process::id()));
        // apt-get wants the inner one, too.
        fs::create_dir_all(folder.join("partial")).map_err(|why| {
            Failure::new(format!("cannot make {}", folder.display())).because(why)
        })?;
        Ok(Self(folder))
    }

    fn folder(&self) -> &Path {
        &self.0
    }
}

impl Drop for Archives {
    fn drop(&mut self) {
        // What cannot be removed does no harm: the next one has another name.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// How apt-get is called.
struct AptGet {
    /// Settings, as `NAME=VALUE`.
    settings: Vec<String>,
    patience: Duration,
}

impl AptGet {
    fn with_archives(folder: &Path) -> Self {
        Self {
            settings: vec![
                format!("Dir::Cache::Archives={}", folder.display()),
                // There is no such setting for the lock of the lists: all are waited for here.
                "DPkg::Lock::Timeout=0".to_owned(),
            ],
            patience: PATIENCE,
        }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new("apt-get");
        command.arg("-qq");
        for setting in &self.settings {
            command.args(["-o", setting]);
        }
        command
            .args(arguments)
            .env("DEBIAN_FRONTEND", "noninteractive")
            // A lock that is held is told from other failures by apt-get's words.
            .env("LC_ALL", "C")
            .stdin(Stdio::null());
        command
    }

    /// Runs apt-get, again and again while another package manager holds a lock.
    fn run(&self, arguments: &[&str]) -> Result<()> {
        let mut command = self.command(arguments);
        let begun = Instant::now();
        let mut told = String::new();
        loop {
            let output = command
                .output()
                .map_err(|why| process::cannot_start(&command, &why))?;
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            if output.status.success() {
                eprint!("{said}");
                return Ok(());
            }
            let failure = Failure::new(format!("`{}` failed", process::spelled(&command)))
                .because(format!("{}\n{}", output.status, said.trim_end()));
            let Some(held) = held_lock(&said) else {
                return Err(failure
                    .advise("a Debian 12 or later has these packages; see what apt-get said"));
            };
            if begun.elapsed() > self.patience {
                return Err(failure.advise("end the other package manager, then try again"));
            }
            if told != held {
                eprintln!("toolchain: waiting for another package manager: {held}");
                told = held.to_owned();
            }
            thread::sleep(TRY_AGAIN.min(self.patience));
        }
    }
}

/// The line by which apt-get says that somebody else holds a lock.
fn held_lock(said: &str) -> Option<&str> {
    said.lines()
        .find(|line| line.contains("Could not get lock"))
}

fn we_are_root() -> bool {
    process::output(Command::new("id").arg("-u")).is_ok_and(|id| id.trim() == "0")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufRead as _, BufReader};
    use std::process::Child;

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

    #[test]
    fn archives_have_a_folder_of_their_own_that_goes_with_them() {
        let archives = Archives::make(&std::env::temp_dir()).expect("a folder");
        let folder = archives.folder().to_owned();
        assert!(folder.join("partial").is_dir());
        let spelled = process::spelled(&AptGet::with_archives(&folder).command(&["install", "a"]));
        let expected = format!(
            "apt-get -qq -o Dir::Cache::Archives={} -o DPkg::Lock::Timeout=0 install a",
            folder.display()
        );
        assert_eq!(spelled, expected);
        drop(archives);
        assert!(!folder.exists());
    }

    /// Another program that holds a lock as package managers do, for some seconds.
    fn hold(lock: &Path, seconds: f32) -> Child {
        let script = "import fcntl, sys, time\n\
            f = open(sys.argv[1], 'w'); fcntl.lockf(f, fcntl.LOCK_EX)\n\
            print(flush=True); time.sleep(float(sys.argv[2]))";
        let mut child = Command::new("python3")
            .args(["-c", script])
            .arg(lock)
            .arg(seconds.to_string())
            .stdout(Stdio::piped())
            .spawn()
            .expect("python3");
        let mut line = String::new();
        let stdout = child.stdout.take().expect("its output");
        BufReader::new(stdout).read_line(&mut line).expect("a line");
        child
    }

    /// apt-get on a state of its own: the machine's is neither locked nor changed.
    fn apart(name: &str) -> Option<(PathBuf, AptGet)> {
        let needed = ["apt-get", "python3"];
        if needed
            .iter()
            .any(|name| process::find_program(name).is_none())
        {
            eprintln!("SKIPPED: waiting for locks: needs apt-get and python3");
            return None;
        }
        let folder = std::env::temp_dir().join(format!("apt-{name}-{}", std::process::id()));
        for inner in ["lists/partial", "archives/partial", "admin"] {
            fs::create_dir_all(folder.join(inner)).expect("a folder");
        }
        fs::copy("/var/lib/dpkg/status", folder.join("admin/status")).expect("a status");
        let mut apt_get = AptGet::with_archives(&folder.join("archives"));
        apt_get.patience = Duration::from_secs(60);
        let path = |inner: &str| folder.join(inner).display().to_string();
        apt_get.settings.extend([
            format!("Dir::State::Lists={}", path("lists")),
            format!("Dir::State::status={}", path("admin/status")),
            format!("Dir::Cache::pkgcache={}", path("pkgcache.bin")),
            format!("Dir::Cache::srcpkgcache={}", path("srcpkgcache.bin")),
            "Dir::Etc::SourceList=/dev/null".to_owned(),
            "Dir::Etc::SourceParts=/dev/null".to_owned(),
        ]);
        Some((folder, apt_get))
    }

    #[test]
    fn the_locks_of_another_package_manager_are_waited_for() {
        let Some((folder, mut apt_get)) = apart("waits") else {
            return;
        };
        // What every Debian has, so that there is nothing to install.
        let install = ["install", "--yes", "--no-upgrade", "dpkg"];
        for (lock, arguments) in [
            ("lists/lock", &["update"][..]),
            ("admin/lock-frontend", &install),
            ("admin/lock", &install),
        ] {
            let begun = Instant::now();
            let mut other = hold(&folder.join(lock), 3.0);
            apt_get
                .run(arguments)
                .unwrap_or_else(|why| panic!("{lock}: {why}"));
            // It did not go on beside the other, and it noticed its end.
            assert!(begun.elapsed() >= Duration::from_secs(3), "{lock}");
            assert!(other.wait().expect("an end").success());
        }
        // Not for ever: who holds it is said.
        apt_get.patience = Duration::ZERO;
        let mut other = hold(&folder.join("lists/lock"), 30.0);
        let why = apt_get.run(&["update"]).expect_err("held").to_string();
        assert!(
            why.contains(&format!("held by process {}", other.id())),
            "{why}"
        );
        other.kill().and_then(|()| other.wait()).expect("an end");
        // Other failures are told at once.
        apt_get.patience = PATIENCE;
        let why = apt_get.run(&["install", "no-package-has-this-name"]);
        assert!(why.is_err_and(|why| why.to_string().contains("no-package-has-this-name")));
        fs::remove_dir_all(&folder).expect("removed");
    }
}
