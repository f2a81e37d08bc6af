//! The gateway's file: which boxes, which broker, which journal.

use crate::record::{Name, Utc};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// The whole file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Group of the plant, second part of every topic.
    pub group: Name,
    /// Name of this gateway in the group.
    pub node: Name,
    /// File of the journal; relative to the gateway's file.
    pub journal: PathBuf,
    /// Most bytes of the journal's records; default 1 GiB.
    #[serde(default = "default_journal_bytes")]
    pub journal_bytes: u64,
    /// A stretch of one state is ended after so long, s; default 60.
    #[serde(default = "default_stretch_s")]
    pub stretch_s: f64,
    /// What is under way of a box is brought to disk this often, s, beside whole records, which are at once;
    /// default 5. A gateway that is killed has not heard for at most this long.
    #[serde(default = "default_keep_s")]
    pub keep_s: f64,
    /// Changed values of a box are sent at most this often, s; default 1.
    #[serde(default = "default_live_s")]
    pub live_s: f64,
    /// The broker.
    pub broker: Option<Broker>,
    /// Address on which SHDR is spoken to agents of MTConnect, such as `127.0.0.1:7878`.
    pub shdr: Option<String>,
    /// The boxes, in the order of their aliases: add new ones at the end.
    #[serde(rename = "box")]
    pub boxes: Vec<BoxConfig>,
}

/// The broker.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Broker {
    /// Its name, as its certificate has it.
    pub host: String,
    /// Its port; default 8883 with TLS, 1883 without.
    pub port: Option<u16>,
    /// Certificates of who signs the broker's certificate (PEM): with it TLS is spoken, and no other
    /// certificate is taken.
    pub ca: Option<PathBuf>,
    /// The gateway's own certificate (PEM), where the broker asks for one.
    pub certificate: Option<PathBuf>,
    /// Its key (PEM).
    pub certificate_key: Option<PathBuf>,
    /// Without TLS user and password go over the network in clear. Set it to true where that is meant.
    #[serde(default)]
    pub in_clear: bool,
    /// User.
    pub user: Option<String>,
    /// File with the password, one line.
    pub password_file: Option<PathBuf>,
    /// Name of the primary host: nothing is born and sent while it is away.
    pub primary_host: Option<Name>,
    /// Who says that a record has arrived.
    #[serde(default)]
    pub acknowledge: Acknowledge,
}

/// Who says that a record has arrived.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Acknowledge {
    /// The store, after it has written it: nothing is lost whatever breaks in between.
    #[default]
    Store,
    /// The broker, after it has taken it: what the broker loses is lost.
    Broker,
}

/// One box.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxConfig {
    /// Its name: `box` of its records, device of its topics.
    pub name: Name,
    /// The machine it listens to.
    pub machine: Name,
    /// Where it is: a serial port, `tcp:HOST:PORT`, or a recording.
    pub port: String,
    /// Baud rate of a serial port.
    #[serde(default = "default_baud")]
    pub baud: u32,
    /// File with the key of its link: without one a box on a network is told no speed.
    pub key: Option<PathBuf>,
    /// Of a recording: when its box was started.
    pub started: Option<Utc>,
}

fn default_journal_bytes() -> u64 {
    1 << 30
}

fn default_stretch_s() -> f64 {
    60.0
}

fn default_keep_s() -> f64 {
    5.0
}

fn default_live_s() -> f64 {
    1.0
}

fn default_baud() -> u32 {
    2_000_000
}

/// Least room for a journal, bytes.
const LEAST_JOURNAL: u64 = 1 << 20;
/// Most boxes of a gateway.
pub const MOST_BOXES: usize = 1000;

impl Config {
    /// Reads a file. Paths in it are relative to it.
    ///
    /// # Errors
    /// One line: file, place, what, remedy.
    pub fn read(path: &Path) -> Result<Self, String> {
        let file = path.display();
        Self::parse(&text_of(path)?, path.parent().unwrap_or(Path::new("")))
            .map_err(|why| format!("{file}: {why}"))
    }

    /// Reads a text; paths in it are relative to `folder`.
    ///
    /// # Errors
    /// Place, what, remedy.
    pub fn parse(text: &str, folder: &Path) -> Result<Self, String> {
        let mut config: Self = parsed(text)?;
        config.check()?;
        config.journal = folder.join(&config.journal);
        if let Some(broker) = &mut config.broker {
            broker.beside(folder);
        }
        for key in config.boxes.iter_mut().filter_map(|b| b.key.as_mut()) {
            *key = folder.join(&*key);
        }
        Ok(config)
    }

    fn check(&self) -> Result<(), String> {
        if self.boxes.is_empty() || self.boxes.len() > MOST_BOXES {
            return wrong(
                "box",
                "1 to 1000 boxes are needed",
                "write [[box]] with name, machine and port for each",
            );
        }
        for (k, one) in self.boxes.iter().enumerate() {
            let twice =
                |of: fn(&BoxConfig) -> &str| self.boxes[..k].iter().any(|b| of(b) == of(one));
            if twice(|b| b.name.as_str()) {
                return wrong(
                    "box",
                    &format!("the name {} comes twice", one.name),
                    "a box has its own name",
                );
            }
            if twice(|b| &b.port) {
                return wrong(
                    "box",
                    &format!("the port {} comes twice", one.port),
                    "a box has its own port",
                );
            }
        }
        if !(1.0..=86_400.0).contains(&self.stretch_s) {
            return wrong("stretch_s", "not in 1 to 86400", "60 suits a plant");
        }
        if !(0.05..=60.0).contains(&self.keep_s) {
            return wrong("keep_s", "not in 0.05 to 60", "5 suits a disk");
        }
        if !(0.05..=3600.0).contains(&self.live_s) {
            return wrong("live_s", "not in 0.05 to 3600", "1 suits a screen");
        }
        if self.journal_bytes < LEAST_JOURNAL {
            return wrong(
                "journal_bytes",
                "less than 1048576",
                "a record takes some 400 bytes",
            );
        }
        self.broker.as_ref().map_or(Ok(()), Broker::check)
    }
}

impl Broker {
    fn check(&self) -> Result<(), String> {
        if self.ca.is_none() && !self.in_clear {
            return wrong(
                "broker",
                "neither `ca` nor `in_clear`",
                "name the file of the plant's certificates, or write in_clear = true",
            );
        }
        if self.ca.is_some() && self.in_clear {
            return wrong("broker", "`ca` and `in_clear`", "leave one of them out");
        }
        if self.certificate.is_some() != self.certificate_key.is_some() {
            return wrong(
                "broker",
                "`certificate` and `certificate_key` belong together",
                "name both",
            );
        }
        if self.user.is_some() != self.password_file.is_some() {
            return wrong(
                "broker",
                "`user` and `password_file` belong together",
                "name both",
            );
        }
        Ok(())
    }

    /// Paths are relative to this folder.
    fn beside(&mut self, folder: &Path) {
        let Self {
            ca,
            certificate,
            certificate_key,
            password_file,
            ..
        } = self;
        for path in [ca, certificate, certificate_key, password_file]
            .into_iter()
            .flatten()
        {
            *path = folder.join(&*path);
        }
    }

    /// Its port.
    #[must_use]
    pub fn port(&self) -> u16 {
        self.port
            .unwrap_or(if self.ca.is_some() { 8883 } else { 1883 })
    }
}

/// The file of a host that takes records off the broker.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HostConfig {
    /// Group of the plant.
    pub group: Name,
    /// This host's name: what gateways call `primary_host`.
    pub host: Name,
    /// The broker.
    pub broker: Broker,
}

impl HostConfig {
    /// Reads a file. Paths in it are relative to it.
    ///
    /// # Errors
    /// One line: file, place, what, remedy.
    pub fn read(path: &Path) -> Result<Self, String> {
        Self::parse(&text_of(path)?, path.parent().unwrap_or(Path::new("")))
            .map_err(|why| format!("{}: {why}", path.display()))
    }

    /// Reads a text; paths in it are relative to `folder`.
    ///
    /// # Errors
    /// Place, what, remedy.
    pub fn parse(text: &str, folder: &Path) -> Result<Self, String> {
        let mut config: Self = parsed(text)?;
        config.broker.check()?;
        if config.broker.primary_host.is_some() {
            return wrong(
                "broker.primary_host",
                "is for a gateway's file",
                "a host has its own name in `host`",
            );
        }
        config.broker.beside(folder);
        Ok(config)
    }
}

fn wrong<T>(place: &str, what: &str, remedy: &str) -> Result<T, String> {
    Err(format!("{place}: {what} ({remedy})"))
}

fn text_of(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|why| {
        format!(
            "{}: open: {} (check the spelling and the directory)",
            path.display(),
            why.kind()
        )
    })
}

fn parsed<T: for<'a> Deserialize<'a>>(text: &str) -> Result<T, String> {
    toml::from_str(text).map_err(|why| {
        let line = why
            .span()
            .map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        let what = why.message().replace('\n', ", ");
        format!("line {line}: {what} (docs/plant.md has an example)")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAST: &str = "group = \"plant\"\nnode = \"gw\"\njournal = \"j.db\"\n[[box]]\nname = \"b1\"\nmachine = \"M1\"\nport = \"tcp:b1:4711\"\n";

    #[test]
    fn the_least_file_is_enough_and_paths_are_beside_it() {
        let config = Config::parse(LEAST, Path::new("/etc/rarma")).unwrap();
        assert_eq!(config.journal, Path::new("/etc/rarma/j.db"));
        assert_eq!((config.stretch_s, config.boxes[0].baud), (60.0, 2_000_000));
    }

    #[test]
    fn a_hosts_file_is_read_and_its_faults_are_named() {
        const FILE: &str =
            "group = \"plant\"\nhost = \"store\"\n[broker]\nhost = \"h\"\nca = \"ca.pem\"\n";
        let config = HostConfig::parse(FILE, Path::new("/etc/rarma")).unwrap();
        assert_eq!(
            config.broker.ca.as_deref(),
            Some(Path::new("/etc/rarma/ca.pem"))
        );
        for (text, says) in [
            (FILE.replace("\"store\"", "\"s/t\""), "line 2"),
            (FILE.replace("ca = \"ca.pem\"\n", ""), "in_clear"),
            (format!("{FILE}primary_host = \"store\"\n"), "primary_host"),
            (format!("{FILE}node = \"gw\"\n"), "node"),
            (FILE[..FILE.find('[').unwrap()].to_owned(), "broker"),
        ] {
            let why = HostConfig::parse(&text, Path::new("")).unwrap_err();
            assert!(
                why.contains(says) && why.ends_with(')') && !why.contains('\n'),
                "{why}"
            );
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place_and_remedy() {
        for (text, says) in [
            (LEAST.replace("\"gw\"", "\"g/w\""), "line 2"),
            (LEAST.replace("port", "prot"), "prot"),
            (
                format!("{LEAST}{}", &LEAST[LEAST.find("[[").unwrap()..]),
                "comes twice",
            ),
            (LEAST[..LEAST.find("[[").unwrap()].to_owned(), "box"),
            (LEAST.replace("[[", "stretch_s = 0.1\n[["), "stretch_s"),
            (
                LEAST.replace("[[", "[broker]\nhost = \"h\"\n[["),
                "in_clear",
            ),
            (
                LEAST.replace("[[", "[broker]\nhost = \"h\"\nca = \"c\"\nuser = \"u\"\n[["),
                "password_file",
            ),
        ] {
            let why = Config::parse(&text, Path::new("")).unwrap_err();
            assert!(
                why.contains(says) && why.ends_with(')') && !why.contains('\n'),
                "{why}"
            );
        }
    }
}
