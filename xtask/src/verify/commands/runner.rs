//! Runs the blocks of the pages, line by line.

use super::lookup::Lookup;
use super::pages::Block;
use super::plan::{Known, Plan};
use super::run::{self, Server, Start};
use super::shell::{self, Pipeline, Step};
use super::tally::Tally;
use super::wanted::Wanted;
use super::yardstick::{TIMES_THE_DEMONSTRATION, Yardstick};
use super::{aliases, may_end_with_one};
use crate::inputs::Maker;
use crate::inputs::roles::{self, Input};
use crate::verify::bench::Bench;
use crate::{Failure, Result, Workspace, process};
use std::fs;
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

/// A box is listening after this long, or it does not come; an emulated one may be built first.
const LISTENING: Duration = Duration::from_secs(300);
/// Where a simulated box listens: at any port that is free.
const ANY_PORT: &str = "127.0.0.1:0";
/// Where the emulated box listens unless told otherwise.
const EMULATED_AT: &str = "127.0.0.1:7000";
/// The box at the other end where the page starts none.
const PEER: [&str; 5] = ["box", "--sim", "box-ldbb-leak", "--listen", ANY_PORT];

/// Runs blocks.
pub struct Runner<'a> {
    workspace: &'a Workspace,
    known: Known,
    rarma: PathBuf,
    scratch: PathBuf,
    maker: Maker,
    yardstick: Yardstick,
    lookup: Option<Lookup>,
    /// Commands of `rarma` that may end with 1, as README.md says.
    one: Vec<String>,
    image: Option<PathBuf>,
    long: bool,
    /// A command of this block was not run: those after it may want what it makes.
    wanting: bool,
}

/// A box that listens: the address in the page, the real one.
type Listening = (String, String, Server);

impl<'a> Runner<'a> {
    /// With this program, and the images the bench has.
    ///
    /// # Errors
    /// The program, an alias, a board or the table of exit codes is missing.
    pub fn new(bench: &Bench<'a>, rarma: &Path, scratch: PathBuf) -> Result<Self> {
        let workspace = bench.workspace;
        let rarma = fs::canonicalize(rarma)
            .map_err(|why| Failure::new(format!("no {}", rarma.display())).because(why))?;
        let yardstick = Yardstick::new(&rarma, &scratch)?;
        println!(
            "the demonstration takes {:.2} s: a command may take {:.0} s",
            yardstick.seconds,
            yardstick.limit().as_secs_f64()
        );
        Ok(Self {
            workspace,
            known: Known {
                aliases: aliases(workspace)?,
            },
            maker: Maker::new(&rarma, &scratch),
            yardstick,
            lookup: None,
            one: may_end_with_one(workspace)?,
            image: bench.image.clone(),
            long: bench.long(),
            wanting: false,
            rarma,
            scratch,
        })
    }

    /// Runs the lines of a block, one after the other, in a folder of their own.
    ///
    /// # Errors
    /// That folder cannot be made.
    pub fn block(&mut self, block: &Block, tally: &mut Tally) -> Result<()> {
        let Some((at, _)) = block.lines.first() else {
            return Ok(());
        };
        let name = format!("{}-{at}", block.page.replace(['/', '.'], "-"));
        let folder = self.scratch.join(name);
        fs::create_dir_all(&folder).map_err(|why| {
            Failure::new(format!("cannot make {}", folder.display())).because(why)
        })?;
        // Commands name what was built from the root.
        #[cfg(unix)]
        std::os::unix::fs::symlink(self.workspace.target_dir(), folder.join("target"))
            .map_err(|why| Failure::new("cannot link the build folder").because(why))?;
        self.wanting = false;
        let mut boxes: Vec<Listening> = Vec::new();
        for (number, text) in &block.lines {
            let place = format!("{}:{number}", block.page);
            let line = match shell::parse(text) {
                Ok(line) => line,
                Err(why) => {
                    tally.fail(format!("{place}: `{text}`: {why}"));
                    continue;
                }
            };
            if let Some(command) = line.commented() {
                tally.fail(format!(
                    "{place}: `{command}` stands behind a # (give it a line of its own)"
                ));
            }
            for pipeline in &line.pipelines {
                self.pipeline(&place, pipeline, block.long, &folder, &mut boxes, tally)?;
            }
        }
        Ok(())
    }

    fn pipeline(
        &mut self,
        place: &str,
        pipeline: &Pipeline,
        long: bool,
        folder: &Path,
        boxes: &mut Vec<Listening>,
        tally: &mut Tally,
    ) -> Result<()> {
        tally.found += pipeline.len();
        let said = pipeline.iter().map(Step::to_string).collect::<Vec<_>>();
        let said = format!("{place}: {}", said.join(" | "));
        let plans = pipeline.iter().map(|step| self.known.plan(step));
        let plans: Vec<Plan> = match plans.collect::<std::result::Result<_, _>>() {
            Ok(plans) => plans,
            Err(why) => {
                tally.fail(format!("{said}: {why}"));
                return Ok(());
            }
        };
        if let ([plan], [step]) = (&plans[..], &pipeline[..])
            && self.without_running(plan, step, &said, tally)?
        {
            return Ok(());
        }
        if long && !self.long {
            tally.long += pipeline.len();
            return Ok(());
        }
        if let ([Plan::EmulatedBox(words)], [_]) = (&plans[..], &pipeline[..]) {
            match self.emulated(words, folder) {
                Ok(listening) => {
                    boxes.push(listening);
                    tally.ran += 1;
                }
                Err(why) => tally.fail(format!("{said}: {why}")),
            }
            return Ok(());
        }
        let begun = Instant::now();
        match self.run(pipeline, plans, folder, boxes) {
            Err(why) => tally.fail(format!("{said}: {why}")),
            Ok(()) => tally.ran(pipeline.len(), said, begun.elapsed().as_secs_f64()),
        }
        Ok(())
    }

    /// Commands that are not run here; false for the others.
    fn without_running(
        &mut self,
        plan: &Plan,
        step: &Step,
        said: &str,
        tally: &mut Tally,
    ) -> Result<bool> {
        match plan {
            Plan::Stage(name) => tally.by(name),
            Plan::Not(why) => tally.not(said, why),
            Plan::Tests(tests) => {
                if self.lookup.is_none() {
                    self.lookup = Some(Lookup::new(self.workspace)?);
                }
                let lookup = self.lookup.as_ref();
                match lookup.map_or(Ok(()), |l| l.check(tests, &step.variables)) {
                    Err(why) => tally.fail(format!("{said}: {why}")),
                    Ok(()) if tests.ignored => tally.long += 1,
                    Ok(()) => tally.by("host tests"),
                }
            }
            Plan::Bench(name) => match Lookup::bench(self.workspace, name) {
                Err(why) => tally.fail(format!("{said}: {why}")),
                Ok(()) if !self.long => tally.long += 1,
                Ok(()) => {
                    let mut bench = process::host_cargo(self.workspace);
                    bench.args(&step.words[1..]);
                    let begun = Instant::now();
                    match process::output(&mut bench) {
                        Err(why) => tally.fail(format!("{said}: {why}")),
                        Ok(_) => tally.ran(1, said.to_owned(), begun.elapsed().as_secs_f64()),
                    }
                }
            },
            Plan::Tool(words) if process::find_program(&words[0]).is_none() => {
                tally.not(said, &format!("{} is not installed", words[0]));
            }
            plan if plan.needs_image() && self.image.is_none() => {
                tally.not(said, "no image of the emulated chip");
                self.wanting = true;
            }
            _ if self.wanting => tally.not(said, "one before it was not run"),
            Plan::Rarma(_) | Plan::Own(_) | Plan::Tool(_) | Plan::EmulatedBox(_) => {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Runs a pipeline and looks at what became of it.
    fn run(
        &mut self,
        pipeline: &Pipeline,
        plans: Vec<Plan>,
        folder: &Path,
        boxes: &mut Vec<Listening>,
    ) -> std::result::Result<(), String> {
        let told = |why: Failure| why.to_string();
        let (mut starts, mut wanted) = (Vec::new(), Vec::new());
        // A box that only this command talks to; it ends with it.
        let mut peers = Vec::new();
        for (step, plan) in pipeline.iter().zip(plans) {
            let (command, want) = match plan {
                Plan::Rarma(arguments) => {
                    let mut arguments = arguments;
                    let want = self.wanted(&arguments, folder)?;
                    for (k, input) in roles::inputs(&arguments) {
                        let place = folder.join(&arguments[k]);
                        if !place.exists() {
                            self.maker.put(input, &place).map_err(told)?;
                        }
                    }
                    if let Some(k) = roles::listens(&arguments) {
                        let address = std::mem::replace(&mut arguments[k], ANY_PORT.to_owned());
                        let (server, real) = self.simulated(&arguments, folder).map_err(told)?;
                        boxes.push((address, real, server));
                        return Ok(());
                    }
                    if let Some(k) = roles::port(&arguments) {
                        let documented = arguments[k].strip_prefix("tcp:").unwrap_or_default();
                        let there = boxes.iter().find(|(address, ..)| address == documented);
                        let real = match there {
                            Some((_, real, _)) => real.clone(),
                            None => {
                                let (server, real) = self
                                    .simulated(&PEER.map(str::to_owned), folder)
                                    .map_err(told)?;
                                peers.push(server);
                                real
                            }
                        };
                        arguments[k] = format!("tcp:{real}");
                    }
                    (self.program(&self.rarma, &arguments), want)
                }
                Plan::Own(words) => (
                    self.program(self.workspace.program(), &words),
                    Wanted::well(),
                ),
                Plan::Tool(words) => {
                    let mut command = Command::new(&words[0]);
                    command.args(&words[1..]);
                    (command, Wanted::well())
                }
                other => return Err(format!("{other:?} cannot stand in a pipeline")),
            };
            starts.push(Start {
                typed: want.typed,
                command,
                step: step.clone(),
            });
            wanted.push(want);
        }
        let mut asked = false;
        let ended = run::pipeline(starts, folder, || {
            if std::mem::replace(&mut asked, true) {
                self.yardstick.look_again()
            } else {
                Ok(self.yardstick.limit())
            }
        })
        .map_err(told)?;
        let Some(ended) = ended else {
            return Err(format!(
                "took more than {:.0} s, {TIMES_THE_DEMONSTRATION:.0} times the demonstration",
                self.yardstick.limit().as_secs_f64()
            ));
        };
        for (ended, want) in ended.iter().zip(&wanted) {
            want.judge(ended, folder)?;
        }
        Ok(())
    }

    fn program(&self, program: &Path, arguments: &[String]) -> Command {
        let mut command = Command::new(program);
        command.args(arguments);
        if let Some(image) = &self.image {
            command.env("RARMA_TARGET_ELF", image);
        }
        command
    }

    /// What must become of a command line of `rarma`.
    fn wanted(&self, arguments: &[String], folder: &Path) -> std::result::Result<Wanted, String> {
        let Some(command) = arguments.first() else {
            return Err("`rarma` without a command".to_owned());
        };
        let inputs = roles::inputs(arguments);
        // The recording that stands in for a reader's own chatters.
        let chatters = inputs
            .iter()
            .any(|(k, i)| *i == Input::Recording && !folder.join(&arguments[*k]).exists());
        let codes = match (self.one.contains(command), chatters) {
            (true, true) => vec![1],
            (true, false) => vec![0, 1],
            (false, _) => vec![0],
        };
        Ok(Wanted {
            codes,
            speaks: true,
            typed: roles::port(arguments).is_some(),
            outputs: roles::outputs(arguments),
        })
    }

    fn simulated(&self, arguments: &[String], folder: &Path) -> Result<(Server, String)> {
        let mut command = self.program(&self.rarma, arguments);
        let (server, line) = Server::start(&mut command, folder, LISTENING)?;
        let address = line.rsplit(' ').next().unwrap_or_default().to_owned();
        Ok((server, address))
    }

    fn emulated(&self, words: &[String], folder: &Path) -> Result<Listening> {
        let free = TcpListener::bind(ANY_PORT)
            .and_then(|listener| listener.local_addr())
            .map_err(|why| Failure::new("no port is free").because(why))?;
        let mut command = self.program(self.workspace.program(), words);
        command.env("RARMA_BOX_LISTEN", free.to_string());
        let (server, _) = Server::start(&mut command, folder, LISTENING)?;
        let begun = Instant::now();
        // It says so before the emulator has started.
        while TcpStream::connect(free).is_err() {
            if begun.elapsed() > LISTENING {
                return Err(Failure::new("the emulated box does not listen"));
            }
            thread::sleep(Duration::from_millis(50));
        }
        Ok((EMULATED_AT.to_owned(), free.to_string(), server))
    }
}
