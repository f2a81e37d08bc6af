//! Running a pipeline: what it says kept in files, the time it may take, its end.

use super::shell::Step;
use crate::{Failure, Result, process};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

const LOOK: Duration = Duration::from_millis(10);
/// A program that shows what comes until it is told to stop is told so after this.
const WATCHED: Duration = Duration::from_millis(1500);

/// A program to start, and the name of its files.
#[derive(Debug)]
pub struct Start {
    /// The program.
    pub command: Command,
    /// As it was written.
    pub step: Step,
    /// Ended as its user ends it: `quit` is typed.
    pub typed: bool,
}

/// How a program ended.
#[derive(Debug)]
pub struct Ended {
    /// Exit code; none: a signal.
    pub code: Option<i32>,
    /// Whether it wrote anything to its standard output.
    pub spoke: bool,
    /// The last of what it said on standard error, or else on standard output.
    pub last_words: String,
}

/// A program that runs until it is stopped, for others to talk to.
#[derive(Debug)]
pub struct Server {
    child: Child,
    output: PathBuf,
}

/// Runs a pipeline in a folder; none where it was ended because `limit` was over. `limit` is
/// asked when the time it gave before is over.
///
/// # Errors
/// A program cannot be started.
pub fn pipeline(
    starts: Vec<Start>,
    folder: &Path,
    mut limit: impl FnMut() -> Result<Duration>,
) -> Result<Option<Vec<Ended>>> {
    let begun = Instant::now();
    let count = starts.len();
    let mut children = Vec::new();
    let mut before = None;
    for (k, mut start) in starts.into_iter().enumerate() {
        let output = kept(folder, k, "out");
        let stdin = match (before.take(), &start.step.from) {
            (Some(pipe), _) => Stdio::from(pipe),
            (None, Some(file)) => Stdio::from(open(&folder.join(file))?),
            (None, None) if start.typed => Stdio::piped(),
            (None, None) => Stdio::null(),
        };
        let stdout = match &start.step.to {
            Some(file) => Stdio::from(create(&folder.join(file))?),
            None if k + 1 < count => Stdio::piped(),
            None => Stdio::from(create(&output)?),
        };
        start
            .command
            .current_dir(folder)
            .envs(start.step.variables.iter().map(|(n, v)| (n, v)))
            .stdin(stdin)
            .stdout(stdout)
            .stderr(create(&kept(folder, k, "err"))?);
        let mut child = spawn(&mut start.command)?;
        before = child.stdout.take();
        children.push((child, start.typed, k + 1 < count || start.step.to.is_some()));
    }
    let mut given = limit()?;
    let mut out = Vec::new();
    for (k, (child, typed, elsewhere)) in children.iter_mut().enumerate() {
        let cannot = |why| Failure::new("cannot wait for a program").because(why);
        let mut spoken = None;
        let status = loop {
            if let Some(status) = child.try_wait().map_err(cannot)? {
                break Some(status);
            }
            if begun.elapsed() > given {
                given = limit()?;
                if begun.elapsed() > given {
                    break None;
                }
            }
            if *typed && size(&kept(folder, k, "out")) > 0 {
                let since = *spoken.get_or_insert_with(Instant::now);
                if since.elapsed() > WATCHED {
                    // Gone already where it ended in between.
                    if let Some(mut stdin) = child.stdin.take() {
                        let _ = stdin.write_all(b"quit\n");
                    }
                }
            }
            thread::sleep(LOOK);
        };
        let Some(status) = status else {
            for (child, ..) in &mut children {
                end(child);
            }
            return Ok(None);
        };
        let (said, erred) = (kept(folder, k, "out"), kept(folder, k, "err"));
        out.push(Ended {
            code: status.code(),
            spoke: *elsewhere || size(&said) > 0,
            last_words: last_words(if size(&erred) > 0 { &erred } else { &said }),
        });
    }
    Ok(Some(out))
}

impl Server {
    /// Starts a program and waits until it says where it listens; returns that line.
    ///
    /// # Errors
    /// It cannot be started, or ends or says nothing before `limit`.
    pub fn start(command: &mut Command, folder: &Path, limit: Duration) -> Result<(Self, String)> {
        let output = kept(folder, 0, "box");
        let both = create(&output)?;
        let again = both
            .try_clone()
            .map_err(|why| Failure::new("cannot keep a box's words").because(why))?;
        command
            .current_dir(folder)
            .stdin(Stdio::null())
            .stdout(both)
            .stderr(again);
        let mut server = Self {
            child: spawn(command)?,
            output,
        };
        let begun = Instant::now();
        loop {
            let text = fs::read_to_string(&server.output).unwrap_or_default();
            if let Some(line) = text.lines().find(|line| line.contains("listen")) {
                return Ok((server, line.to_owned()));
            }
            let gone = server.child.try_wait().is_ok_and(|status| status.is_some());
            if gone || begun.elapsed() > limit {
                return Err(
                    Failure::new("the box does not listen").because(last_words(&server.output))
                );
            }
            thread::sleep(LOOK);
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        end(&mut self.child);
    }
}

fn kept(folder: &Path, k: usize, what: &str) -> PathBuf {
    folder.join(format!(".said-{k}.{what}"))
}

fn size(path: &Path) -> u64 {
    path.metadata().map_or(0, |meta| meta.len())
}

fn last_words(path: &Path) -> String {
    let text = fs::read(path).unwrap_or_default();
    let text = String::from_utf8_lossy(&text).into_owned();
    let lines: Vec<&str> = text
        .lines()
        .filter(|line| !line.trim().is_empty())
        .collect();
    lines[lines.len().saturating_sub(3)..].join(" / ")
}

fn create(path: &Path) -> Result<File> {
    let file = File::create(path);
    file.map_err(|why| Failure::new(format!("cannot write {}", path.display())).because(why))
}

fn open(path: &Path) -> Result<File> {
    let file = File::open(path);
    file.map_err(|why| Failure::new(format!("cannot read {}", path.display())).because(why))
}

/// Starts it as the first of a group of its own: what it starts ends with it.
fn spawn(command: &mut Command) -> Result<Child> {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    command
        .spawn()
        .map_err(|why| process::cannot_start(command, &why))
}

/// Ends a program and what it started.
fn end(child: &mut Child) {
    if child.try_wait().is_ok_and(|status| status.is_some()) {
        return;
    }
    #[cfg(unix)]
    {
        let group = format!("-{}", child.id());
        let _ = Command::new("kill").args(["-KILL", "--", &group]).status();
    }
    // Gone already where the group was ended.
    let _ = child.kill();
    let _ = child.wait();
}

#[cfg(all(test, unix))]
mod tests {
    use super::super::shell;
    use super::*;

    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let name = format!("xtask-run-{name}-{}", std::process::id());
            let path = std::env::temp_dir().join(name);
            fs::create_dir_all(&path).expect("a folder");
            Self(path)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn run(folder: &Folder, text: &str, limit: Duration) -> Option<Vec<Ended>> {
        let line = shell::parse(text).expect("sound");
        let starts = line.pipelines[0].iter().map(|step| {
            let mut command = Command::new(&step.words[0]);
            command.args(&step.words[1..]);
            Start {
                command,
                step: step.clone(),
                typed: false,
            }
        });
        pipeline(starts.collect(), &folder.0, || Ok(limit)).expect("they start")
    }

    #[test]
    fn a_pipeline_with_files_and_codes() {
        let folder = Folder::new("pipe");
        fs::write(folder.0.join("in"), "b\na\n").expect("a file");
        let ended = run(
            &folder,
            "sort <in | grep -v a >out",
            Duration::from_secs(20),
        );
        let codes: Vec<_> = ended.expect("in time").iter().map(|e| e.code).collect();
        assert_eq!(codes, [Some(0), Some(0)]);
        let out = fs::read_to_string(folder.0.join("out")).expect("written");
        assert_eq!(out, "b\n");
        let ended = run(&folder, "sort no-such-file", Duration::from_secs(20)).expect("in time");
        assert!(ended[0].code != Some(0) && ended[0].last_words.contains("no-such-file"));
    }

    #[test]
    fn what_takes_too_long_is_ended() {
        let folder = Folder::new("long");
        let begun = Instant::now();
        assert!(run(&folder, "sleep 60", Duration::from_millis(100)).is_none());
        assert!(begun.elapsed() < Duration::from_secs(30));
    }
}
