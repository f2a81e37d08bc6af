//! `rarma store`.

use super::{Opened, ask, failed, lines, name, receive, tell, values};
use crate::args::{StoreAddArgs, StoreCommand, StoreExportArgs, StoreShowArgs, StoreThinArgs};
use crate::failure::Failure;
use crate::output::{self, NewFile};
use rarma_fleet::convert::{self, ConvertError, Head};
use rarma_fleet::record::{RecordError, Utc, from_line};
use rarma_fleet::store::{Taken, is_journal};
use serde_json::json;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;

/// Lines that are taken together.
const TOGETHER: usize = 4096;
/// Lines of a file that are told one by one as being none.
const TOLD: usize = 5;

pub(in crate::commands) fn main(command: &StoreCommand) -> Result<u8, Failure> {
    match command {
        StoreCommand::Add(args) => add(args),
        StoreCommand::Receive(args) => receive::main(args),
        StoreCommand::Show(args) => show(args),
        StoreCommand::Ask(args) => ask::main(args),
        StoreCommand::Export(args) => export(args),
        StoreCommand::Thin(args) => thin(args),
    }
}

/// What became of all files.
#[derive(Default)]
struct Sum {
    taken: Taken,
    refused: u64,
}

fn add(args: &StoreAddArgs) -> Result<u8, Failure> {
    let mut opened = Opened::new(&args.store)?;
    let mut sum = Sum::default();
    for file in &args.files {
        add_file(&mut opened, args, file, &mut sum)?;
    }
    for id in sum.taken.different.iter().take(TOLD) {
        output::trouble(format_args!(
            "{} {} {}: another record of this name was there first, and stays",
            id.sender, id.session, id.seq
        ));
    }
    tell(&sum.taken, sum.refused, args.json);
    let clean = sum.refused == 0 && sum.taken.different_count == 0;
    Ok(if clean { 0 } else { 3 })
}

fn add_file(
    opened: &mut Opened,
    args: &StoreAddArgs,
    path: &Path,
    sum: &mut Sum,
) -> Result<(), Failure> {
    if is_journal(path) {
        return add_journal(opened, path, sum);
    }
    let named = path.display();
    let cannot =
        |why: &std::io::Error| Failure::Input(format!("{named}: read: {why} (check the file)"));
    let mut reader: Box<dyn BufRead> = if path == Path::new("-") {
        Box::new(BufReader::new(std::io::stdin()))
    } else {
        Box::new(BufReader::new(
            File::open(path).map_err(|why| cannot(&why))?,
        ))
    };
    let mut first = String::new();
    let mut number = 0;
    let mut block: Vec<String> = Vec::new();
    // The first line tells which of the two it is.
    read_line(&mut reader, &mut first).map_err(|why| cannot(&why))?;
    if !matches!(
        from_line(first.trim_end()),
        Ok(_) | Err(RecordError::Future { .. } | RecordError::Value { .. })
    ) && !first.contains("\"schema\"")
    {
        let mut text = first;
        reader
            .read_to_string(&mut text)
            .map_err(|why| cannot(&why))?;
        return add_converted(opened, args, path, &text, sum);
    }
    let mut told = 0;
    loop {
        if !first.trim().is_empty() {
            block.push(std::mem::take(&mut first));
        }
        let more = read_line(&mut reader, &mut first).map_err(|why| cannot(&why))?;
        if block.len() == TOGETHER || (!more && !block.is_empty()) {
            let from = number;
            let taken = opened
                .store
                .add_lines(block.iter().map(String::as_str), |place, why| {
                    sum.refused += 1;
                    told += 1;
                    if told <= TOLD {
                        output::trouble(format_args!("{named}: line {}: {why}", from + place + 1));
                    }
                });
            sum.taken
                .add(taken.map_err(|why| failed(&opened.place, "add", &why))?);
            number += block.len();
            block.clear();
        }
        if !more {
            break;
        }
    }
    if told > TOLD {
        output::trouble(format_args!(
            "{named}: {} more lines are no records",
            told - TOLD
        ));
    }
    Ok(())
}

/// The journal of a gateway that does not run.
fn add_journal(opened: &mut Opened, path: &Path, sum: &mut Sum) -> Result<(), Failure> {
    let named = path.display();
    let mut told = 0;
    let taken = opened.store.add_journal(path, |number, why| {
        told += 1;
        if told <= TOLD {
            output::trouble(format_args!("{named}: entry {number}: {why}"));
        }
    });
    sum.taken
        .add(taken.map_err(|why| failed(&format!("{named} to {}", opened.place), "add", &why))?);
    sum.refused += told as u64;
    if told > TOLD {
        output::trouble(format_args!(
            "{named}: {} more entries are no records",
            told - TOLD
        ));
    }
    Ok(())
}

/// A line, with what is not UTF-8 replaced: it is refused as a line, not as a file. `false` at the end.
fn read_line(reader: &mut dyn BufRead, line: &mut String) -> std::io::Result<bool> {
    let mut bytes = Vec::new();
    let read = reader.read_until(b'\n', &mut bytes)?;
    *line = String::from_utf8_lossy(&bytes).into_owned();
    Ok(read > 0)
}

/// What another command printed.
fn add_converted(
    opened: &mut Opened,
    args: &StoreAddArgs,
    path: &Path,
    text: &str,
    sum: &mut Sum,
) -> Result<(), Failure> {
    let named = path.display();
    let wrong = |why: &dyn std::fmt::Display| {
        Failure::whole(
            named.to_string(),
            why,
            "give records, one a line, a gateway's journal, a log of `rarma act`, or what one of these commands printed with --json",
        )
    };
    let needs = || {
        Failure::Usage(format!(
            "{named} holds no records; what another command printed needs --machine and --time (a log of `rarma act` the machine only)"
        ))
    };
    let machine = args.machine.as_ref().ok_or_else(needs)?;
    let time = args.time.as_deref().map(str::parse::<Utc>).transpose();
    let time = time.map_err(|why| Failure::Usage(format!("--time: {why}")))?;
    let head = Head {
        machine: name("--machine", machine)?,
        time,
        sender: name("--sender", &args.sender)?,
        tool: args
            .tool
            .as_deref()
            .map(|t| name("--tool", t))
            .transpose()?,
        operator: args
            .operator
            .as_deref()
            .map(|o| name("--operator", o))
            .transpose()?,
    };
    let records = convert::records(text, &head).map_err(|why| match why {
        ConvertError::NoTime => needs(),
        why => wrong(&why),
    })?;
    let taken = opened
        .store
        .add(&records)
        .map_err(|why| failed(&opened.place, "add", &why))?;
    sum.taken.add(taken);
    Ok(())
}

fn show(args: &StoreShowArgs) -> Result<u8, Failure> {
    let mut opened = Opened::that_is_there(&args.store)?;
    let contents = opened.store.contents();
    let contents = values(&opened.asked(contents)?);
    let machines = opened.store.machines();
    let machines = values(&opened.asked(machines)?);
    if args.json {
        say!("{}", json!({"kinds": contents, "machines": machines}));
    } else {
        for line in lines(&contents) {
            say!("{line}");
        }
        say!("");
        for line in lines(&machines) {
            say!("{line}");
        }
    }
    Ok(0)
}

fn export(args: &StoreExportArgs) -> Result<u8, Failure> {
    let mut opened = Opened::that_is_there(&args.store)?;
    let machine = args
        .machine
        .as_deref()
        .map(|m| name("--machine", m))
        .transpose()?;
    let mut file = args.out.as_deref().map(NewFile::create).transpose()?;
    let mut after = None;
    loop {
        let page = opened
            .store
            .lines(machine.as_ref(), None, after.as_ref(), TOGETHER);
        let page = opened.asked(page)?;
        let Some(last) = page.last() else { break };
        let record =
            from_line(last).map_err(|why| Failure::System(format!("{}: {why}", opened.place)))?;
        after = Some((record.time, record.id));
        for line in &page {
            match &mut file {
                Some(file) => writeln!(file, "{line}")
                    .map_err(|why| output::failed(file.path(), "write", &why))?,
                None => say!("{line}"),
            }
        }
        output::stdout::check()?;
    }
    if let Some(file) = file {
        file.done()?.keep()?;
    }
    Ok(0)
}

fn thin(args: &StoreThinArgs) -> Result<u8, Failure> {
    let day = start_of("--before", &args.before)?.day();
    let mut opened = Opened::that_is_there(&args.store)?;
    let thinned = opened
        .store
        .thin(day)
        .map_err(|why| failed(&opened.place, "thin", &why))?;
    if args.json {
        say!(
            "{}",
            json!({"verdicts": thinned.verdicts, "days": thinned.days})
        );
    } else {
        say!(
            "{} verdicts before {} are now {} rows of days",
            thinned.verdicts,
            args.before,
            thinned.days
        );
    }
    Ok(0)
}

/// The beginning of a day, UTC.
pub(super) fn start_of(option: &str, day: &str) -> Result<Utc, Failure> {
    let text = format!("{day}T00:00:00Z");
    text.parse()
        .map_err(|_| Failure::Usage(format!("{option}: {day:?} is no day (write 2026-03-01)")))
}
