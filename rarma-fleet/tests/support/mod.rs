//! Databases for tests: PostgreSQL in a folder of its own, ClickHouse's engine behind HTTP.
//!
//! Where one is not installed the test says so and goes on without it; with
//! `RARMA_ALL_STORES=1` (`cargo verify` sets it) it fails.

#![allow(dead_code, reason = "each test uses a part")]

use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// Without it: loudly.
fn missing<T>(what: &str) -> Option<T> {
    assert!(
        std::env::var_os("RARMA_ALL_STORES").is_none(),
        "{what} is not installed"
    );
    eprintln!("SKIPPED: {what} is not installed: its part of this test did not run");
    None
}

/// A server that ends with the test.
pub struct Server {
    child: Child,
    pub port: u16,
    folder: tempfile::TempDir,
}

impl Server {
    /// Where it keeps everything.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }
}

/// Bytes of all files in a folder and those below it.
pub fn bytes(folder: &Path) -> u64 {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return 0;
    };
    (entries.flatten())
        .map(|entry| match entry.metadata() {
            Ok(of) if of.is_dir() => bytes(&entry.path()),
            Ok(of) => of.len(),
            Err(_) => 0,
        })
        .sum()
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = Command::new("kill")
            .args(["-INT", &self.child.id().to_string()])
            .status();
        // An orderly end, or none: a server that does not go holds up nothing.
        for _ in 0..100 {
            if matches!(self.child.try_wait(), Ok(Some(_)) | Err(_)) {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn root() -> bool {
    Command::new("id")
        .arg("-u")
        .output()
        .is_ok_and(|o| o.stdout == b"0\n")
}

/// A program of PostgreSQL, as a user that it accepts: it refuses to run as root.
fn as_postgres(program: &Path) -> Command {
    if root() {
        let mut command = Command::new("setpriv");
        command
            .args(["--reuid=postgres", "--regid=postgres", "--clear-groups"])
            .arg(program);
        command
    } else {
        Command::new(program)
    }
}

fn give_to_postgres(path: &Path) {
    if root() {
        let owned = Command::new("chown").arg("postgres").arg(path).status();
        assert!(owned.unwrap().success());
    }
}

fn postgres_programs() -> Option<PathBuf> {
    let versions = std::fs::read_dir("/usr/lib/postgresql").ok()?;
    let mut found: Vec<PathBuf> = versions.flatten().map(|v| v.path().join("bin")).collect();
    found.retain(|bin| bin.join("initdb").exists());
    found.sort();
    found.pop()
}

/// A certificate of a server, and of who signed it.
pub struct Certificates {
    pub folder: tempfile::TempDir,
}

impl Certificates {
    /// Made by openssl; `None` where it is not installed. The server is called `DNS:localhost`.
    pub fn signed_by(signer: &str) -> Option<Self> {
        if Command::new("openssl").arg("version").output().is_err() {
            return missing("openssl (apt-get install openssl)");
        }
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(
            folder.path().join("names"),
            "subjectAltName=DNS:localhost\nbasicConstraints=CA:FALSE\n",
        )
        .unwrap();
        let key = "-newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes";
        for words in [
            format!("req -x509 {key} -days 2 -keyout ca.key -out ca.pem -subj /CN={signer}"),
            format!("req {key} -keyout server.key -out server.csr -subj /CN=server"),
            "x509 -req -in server.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile names -out server.pem"
                .to_owned(),
        ] {
            let made = Command::new("openssl")
                .args(words.split(' '))
                .current_dir(folder.path())
                .output()
                .unwrap();
            let said = String::from_utf8_lossy(&made.stderr);
            assert!(made.status.success(), "openssl {words}: {said}");
        }
        Some(Self { folder })
    }

    /// A file of it: `ca.pem`, `server.pem`, `server.key`.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

/// PostgreSQL on a free port of this machine; `None` where it is not installed.
pub fn postgres() -> Option<Server> {
    postgres_with(None)
}

/// The same. With certificates it speaks to nobody without TLS, and all databases but `postgres` ask the user `rarma` for
/// the password `word`.
pub fn postgres_with(certificates: Option<&Certificates>) -> Option<Server> {
    let Some(bin) = postgres_programs() else {
        return missing("PostgreSQL (apt-get install postgresql)");
    };
    let folder = tempfile::tempdir().unwrap();
    give_to_postgres(folder.path());
    let data = folder.path().join("data");
    let word = folder.path().join("word");
    std::fs::write(&word, "word\n").unwrap();
    let made = as_postgres(&bin.join("initdb"))
        .args([
            "--username=rarma",
            "--auth=trust",
            "--no-sync",
            "--encoding=UTF8",
            "-D",
        ])
        .arg(&data)
        .arg("--pwfile")
        .arg(&word)
        .output()
        .unwrap();
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    let mut tls = Vec::new();
    if let Some(certificates) = certificates {
        for name in ["server.pem", "server.key"] {
            let copy = data.join(name);
            std::fs::copy(certificates.file(name), &copy).unwrap();
            // It refuses a key that others may read.
            std::fs::set_permissions(&copy, std::fs::Permissions::from_mode(0o600)).unwrap();
            give_to_postgres(&copy);
        }
        let rules = "hostssl postgres all all trust\nhostssl all all all scram-sha-256\n";
        std::fs::write(data.join("pg_hba.conf"), rules).unwrap();
        tls = [
            "ssl=on",
            "ssl_cert_file=server.pem",
            "ssl_key_file=server.key",
        ]
        .map(|setting| ["-c", setting])
        .concat();
    }
    let port = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap()
        .port();
    let child = as_postgres(&bin.join("postgres"))
        .args([
            "-c",
            "listen_addresses=127.0.0.1",
            "-c",
            "fsync=off",
            "-c",
            "jit=off",
            "-p",
            &port.to_string(),
        ])
        .args(tls)
        .args([
            "-c",
            &format!("unix_socket_directories={}", folder.path().display()),
            "-D",
        ])
        .arg(&data)
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let server = Server {
        child,
        port,
        folder,
    };
    for _ in 0..600 {
        // One that speaks TLS only refuses this question, and so is there.
        let answer = sql(&server, "SELECT 1");
        if answer.is_ok()
            || answer.is_err_and(|why| {
                why.as_db_error()
                    .is_some_and(|e| e.message().contains("pg_hba"))
            })
        {
            return Some(server);
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    panic!("PostgreSQL does not answer after half a minute");
}

fn sql(server: &Server, what: &str) -> Result<(), postgres::Error> {
    let place = format!("postgres://rarma@127.0.0.1:{}/postgres", server.port);
    postgres::Client::connect(&place, postgres::NoTls)?.batch_execute(what)
}

/// A new database of that name; its address.
pub fn postgres_database(server: &Server, name: &str) -> String {
    sql(server, &format!("CREATE DATABASE {name}")).unwrap();
    format!("postgres://rarma@127.0.0.1:{}/{name}", server.port)
}

/// Ends all connections to a database from the server's side, and waits until they have.
pub fn postgres_ends_connections(server: &Server, name: &str) {
    let end = format!(
        "SELECT pg_terminate_backend(pid, 10000) FROM pg_stat_activity WHERE datname = '{name}'"
    );
    sql(server, &end).unwrap();
}

/// A Python that has chdb: `RARMA_CHDB_PYTHON`, or `python3`.
fn chdb_python() -> Option<String> {
    let python = std::env::var("RARMA_CHDB_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let found = Command::new(&python)
        .args(["-c", "import chdb"])
        .stderr(Stdio::null())
        .status();
    found.is_ok_and(|s| s.success()).then_some(python)
}

/// ClickHouse's engine on a free port; `None` where it is not installed.
pub fn clickhouse() -> Option<Server> {
    clickhouse_with(None)
}

/// The same; with certificates behind TLS.
pub fn clickhouse_with(certificates: Option<&Certificates>) -> Option<Server> {
    let Some(python) = chdb_python() else {
        return missing("ClickHouse's engine (pip install chdb)");
    };
    let folder = tempfile::tempdir().unwrap();
    let tls = certificates.map(|of| [of.file("server.pem"), of.file("server.key")]);
    let (child, port) = chdb(&python, folder.path(), 0, tls.as_ref().map_or(&[], |of| of));
    Some(Server {
        child,
        port,
        folder,
    })
}

/// The engine is killed, and there again: the same folder and port.
pub fn clickhouse_again(mut server: Server) -> Server {
    server.child.kill().unwrap();
    server.child.wait().unwrap();
    let python = chdb_python().expect("as before");
    (server.child, _) = chdb(&python, server.folder.path(), server.port, &[]);
    server
}

/// The engine and its port: that one, or a free one if it is 0.
fn chdb(python: &str, folder: &Path, port: u16, tls: &[PathBuf]) -> (Child, u16) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/support/chdb_server.py");
    let mut child = Command::new(python)
        .arg(script)
        .args([folder, Path::new(&port.to_string())])
        .args(tls)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    (child, line.trim().parse().expect("a port"))
}

/// The address of a database in it.
pub fn clickhouse_database(server: &Server, name: &str) -> String {
    format!("clickhouse://127.0.0.1:{}/{name}", server.port)
}
