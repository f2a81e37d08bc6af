//! Which files a command reads and writes, for [`crate::output::check`].

use super::{CersCommand, Command, ElsCommand, LdbbCommand, OutArgs, ReadingArgs, StoreCommand};
use crate::output::Files;
use std::path::{Path, PathBuf};

const PAGE: &[&str] = &["index.html"];

impl Command {
    /// Files it is told to read and write. A name that may be that of a shipped scenario, or
    /// of a port, is taken for that of a file.
    pub fn files(&self) -> Files {
        let files = Files::default();
        match self {
            Self::Monitor(a) | Self::Target(a) => files
                .read([&a.input.input])
                .read(&a.more)
                .read(&a.structure)
                .folder("--report", a.report.as_ref(), PAGE),
            Self::Listen(a) => files
                .read(&a.monitor.structure)
                .read(&a.monitor.speed_from)
                .record("--record", a.record.as_ref())
                .folder("--report", a.monitor.report.as_ref(), PAGE),
            Self::Advise(a) => files
                .read([&a.monitor.input.input])
                .read(&a.monitor.structure)
                .read(&a.known)
                .read(&a.machine.machine)
                .folder("--report", a.monitor.report.as_ref(), PAGE),
            Self::Act(a) => files
                .read([&a.monitor.input.input])
                .read(&a.monitor.structure)
                .read(&a.log)
                .read(&a.machine.machine)
                .folder("--report", a.monitor.report.as_ref(), PAGE),
            Self::Identify(a) => {
                files
                    .read([&a.input.input])
                    .folder("--report", a.report.as_ref(), PAGE)
            }
            Self::Order(a) => {
                files
                    .read([&a.input.input])
                    .folder("--report", a.report.as_ref(), PAGE)
            }
            Self::Psd(a) => files.read([&a.input.input]).file("--out", a.out.as_ref()),
            Self::Convert(a) => files.read([&a.input.input]).file("--out", Some(&a.out)),
            Self::Lobes(a) => files
                .read(&a.scenarios)
                .folder("--report", a.report.as_ref(), PAGE),
            Self::Simulate(a) => files
                .read(&a.scenario)
                .file("--out", a.out.as_ref())
                .file("--truth", a.truth.as_ref()),
            Self::ChooseOrder(a) => files
                .read([&a.scenario])
                .file("--settings", a.settings.as_ref()),
            Self::Sweep(a) => files
                .read(&a.scenarios)
                .folder("--report", a.report.as_ref(), PAGE),
            Self::Population(a) => files
                .folder("--out", a.out.as_ref(), &["labels.json"])
                .folder("--report", a.report.as_ref(), PAGE),
            Self::Els(command) => els(command, files),
            Self::Ldbb(command) => ldbb(command, files),
            Self::Cers(command) => cers(command, files),
            Self::Box(a) => files.read(&a.sim).record("--record", a.record.as_ref()),
            Self::Decode(a) => files.read([&a.input]).file("--wav", a.wav.as_ref()),
            Self::Connect(a) => files.read([&a.port]).record("--record", a.record.as_ref()),
            Self::Gateway(a) => files.read([&a.file]),
            Self::Store(command) => store(command, files),
            Self::Trends(a) => files
                .read([&a.store.store])
                .file("--csv", a.table.csv.as_ref())
                .file("--parquet", a.table.parquet.as_ref())
                .folder("--report", a.report.as_ref(), PAGE),
            Self::Plant(a) => files.folder("--out", Some(&a.out), &["records.jsonl", "truth.json"]),
            Self::Completions(_) => files,
            Self::Man(a) => files.folder("--out", Some(&a.out), &["rarma.1"]),
            Self::Demo(a) => files.folder("--out", Some(&a.out), &["telemetry.bin", "index.html"]),
        }
    }
}

fn page(files: Files, out: &OutArgs) -> Files {
    files.folder("--report", out.report.as_ref(), PAGE)
}

/// A store is read and written in its own way; no table may be written onto it.
fn store(command: &StoreCommand, files: Files) -> Files {
    match command {
        StoreCommand::Add(a) => files.read(&a.files),
        StoreCommand::Receive(a) => files.read([&a.file]),
        StoreCommand::Ask(a) => files
            .read([&a.store.store])
            .file("--csv", a.table.csv.as_ref())
            .file("--parquet", a.table.parquet.as_ref()),
        StoreCommand::Export(a) => files.read([&a.store.store]).file("--out", a.out.as_ref()),
        StoreCommand::Show(_) | StoreCommand::Thin(_) => files,
    }
}

fn els(command: &ElsCommand, files: Files) -> Files {
    match command {
        ElsCommand::Model(a) => page(
            files.read(&a.scenario).file("--uff", a.uff.as_ref()),
            &a.out,
        ),
        ElsCommand::Limit(a) => {
            let parts = [&a.input, &a.uu, &a.uv, &a.vu, &a.vv];
            let files = files.read(parts.into_iter().flatten());
            page(files.file("--uff", a.uff.as_ref()), &a.out)
        }
        ElsCommand::Hammer(a) => page(
            files
                .read([&a.force, &a.response])
                .file("--uff", a.uff.as_ref()),
            &a.out,
        ),
        ElsCommand::Fit(a) => files.read([&a.scenario]).read(&a.loads).read(&a.receptance),
    }
}

fn ldbb(command: &LdbbCommand, files: Files) -> Files {
    match command {
        LdbbCommand::Run(a) => page(
            files.read(&a.scenario).folder(
                "--out",
                a.out.as_ref(),
                &["static.csv", "analysis.json"],
            ),
            &a.show,
        ),
        LdbbCommand::Analyse(a) => {
            let tables = a.files.iter().flat_map(|path| tables(path));
            page(files.read(tables).file("--save", a.save.as_ref()), &a.show)
        }
        LdbbCommand::Compare(a) => {
            let folders = a.tests.iter().map(|test| test.join("analysis.json"));
            page(files.read(&a.tests).read(folders), &a.show)
        }
    }
}

/// The tables of a folder, or the one table.
fn tables(path: &Path) -> Vec<PathBuf> {
    match std::fs::read_dir(path) {
        Ok(entries) => entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path.extension().is_some_and(|e| e == "csv"))
            .collect(),
        Err(_) => vec![path.to_path_buf()],
    }
}

fn cers(command: &CersCommand, files: Files) -> Files {
    let record = &["signals.wav", "record.toml"];
    let reading = |files: Files, a: &ReadingArgs| {
        files
            .file("--csv", a.csv.as_ref())
            .file("--uff", a.uff.as_ref())
            .folder(
                "--structure",
                a.structure.as_ref(),
                &["structure-x.json", "structure-y.json"],
            )
    };
    match command {
        CersCommand::Run(a) => page(
            reading(
                files
                    .read(&a.scenario)
                    .folder("--out", a.out.as_ref(), record),
                &a.reading,
            ),
            &a.show,
        ),
        CersCommand::Analyse(a) => page(
            reading(
                files.read(record.iter().map(|name| a.record.join(name))),
                &a.reading,
            ),
            &a.show,
        ),
    }
}
