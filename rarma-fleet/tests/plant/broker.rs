//! A real broker (Debian's mosquitto) in a folder of its own, with users, access lists and TLS; and a wire to it
//! that can be cut.

use std::fs;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Users with their passwords, and what each may do.
pub const USERS: [(&str, &str); 4] = [
    ("gateway", "gateway-word"),
    ("store", "store-word"),
    ("controller", "controller-word"),
    ("screen", "screen-word"),
];

/// What docs/plant.md tells to write.
fn access() -> &'static str {
    let page = include_str!("../../../docs/plant.md");
    let part = page.split("### Who may write what").nth(1);
    let text = part.and_then(|part| part.split("```").nth(1));
    text.and_then(|text| text.strip_prefix("text\n"))
        .expect("the lines of the page")
}

pub struct Broker {
    folder: PathBuf,
    pub port: u16,
    child: Option<Child>,
}

/// Whether mosquitto and openssl are there; says loudly if not.
pub fn is_there() -> bool {
    let found = |name: &str| {
        let paths = [
            "/usr/sbin",
            "/usr/bin",
            "/usr/local/sbin",
            "/usr/local/bin",
            "/opt/homebrew/sbin",
        ];
        paths.iter().any(|path| Path::new(path).join(name).exists())
    };
    let there = found("mosquitto") && found("openssl");
    if !there {
        assert!(
            std::env::var_os("RARMA_REQUIRE_BROKER").is_none(),
            "mosquitto or openssl is missing (apt-get install mosquitto openssl)"
        );
        eprintln!("SKIPPED: no broker; `apt-get install mosquitto openssl`");
    }
    there
}

fn run(program: &str, arguments: &[&str], folder: &Path) {
    let output = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .output();
    let output = output.unwrap_or_else(|why| panic!("{program}: {why}"));
    assert!(
        output.status.success(),
        "{program} {arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}

pub fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap()
        .port()
}

const KEY: [&str; 5] = [
    "-newkey",
    "ec",
    "-pkeyopt",
    "ec_paramgen_curve:P-256",
    "-nodes",
];

/// `ca.pem` and `ca.key`: somebody who signs under a name.
pub fn authority(folder: &Path, name: &str) {
    let mut words = vec!["req", "-x509", "-days", "2"];
    words.extend(KEY);
    let subject = format!("/CN={name}");
    words.extend(["-keyout", "ca.key", "-out", "ca.pem", "-subj", &subject]);
    run("openssl", &words, folder);
}

/// `FILE.pem` and `FILE.key`: somebody of a name whom the authority of the folder has signed.
pub fn signed(folder: &Path, file: &str, name: &str, more: &str) {
    let [key, pem, request] = ["key", "pem", "csr"].map(|kind| format!("{file}.{kind}"));
    let mut words = vec!["req"];
    words.extend(KEY);
    let subject = format!("/CN={name}");
    words.extend(["-keyout", &key, "-out", &request, "-subj", &subject]);
    run("openssl", &words, folder);
    let text = format!("basicConstraints=CA:FALSE\n{more}");
    fs::write(folder.join("names"), text).unwrap();
    let words = format!(
        "x509 -req -in {request} -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile names -out {pem}"
    );
    let words: Vec<&str> = words.split(' ').collect();
    run("openssl", &words, folder);
}

impl Broker {
    pub fn start(folder: &Path) -> Self {
        Self::start_with(folder, "")
    }

    /// With more lines in its file.
    pub fn start_with(folder: &Path, more: &str) -> Self {
        fs::create_dir_all(folder).unwrap();
        authority(folder, "plant");
        signed(
            folder,
            "broker",
            "localhost",
            "subjectAltName=DNS:localhost\n",
        );
        fs::write(folder.join("passwords"), "").unwrap();
        for (user, word) in USERS {
            run("mosquitto_passwd", &["-b", "passwords", user, word], folder);
            fs::write(folder.join(format!("{user}.password")), format!("{word}\n")).unwrap();
        }
        fs::write(folder.join("access"), access()).unwrap();
        let port = free_port();
        let text = |file: &str| folder.join(file).display().to_string();
        let user = if is_root() { "user root\n" } else { "" };
        let conf = format!(
            "listener {port} 127.0.0.1\n{user}cafile {}\ncertfile {}\nkeyfile {}\npassword_file {}\nacl_file {}\nallow_anonymous false\nmax_queued_messages 10000\nlog_type error\n{more}",
            text("ca.pem"),
            text("broker.pem"),
            text("broker.key"),
            text("passwords"),
            text("access"),
        );
        fs::write(folder.join("broker.conf"), conf).unwrap();
        let mut broker = Self {
            folder: folder.to_owned(),
            port,
            child: None,
        };
        broker.again();
        broker
    }

    /// Starts it (again) and waits until it answers.
    pub fn again(&mut self) {
        let log = fs::File::create(self.folder.join("broker.log")).unwrap();
        let child = Command::new("mosquitto")
            .args(["-c", "broker.conf"])
            .current_dir(&self.folder)
            .env(
                "PATH",
                "/usr/local/sbin:/usr/sbin:/usr/local/bin:/usr/bin:/bin:/opt/homebrew/sbin",
            )
            .stdout(Stdio::null())
            .stderr(log)
            .spawn();
        self.child = Some(child.unwrap_or_else(|why| panic!("mosquitto: {why}")));
        let until = Instant::now() + Duration::from_secs(10);
        while TcpStream::connect(("127.0.0.1", self.port)).is_err() {
            assert!(Instant::now() < until, "mosquitto does not answer");
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Kills it, with all that it had.
    pub fn kill(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        self.kill();
    }
}

fn is_root() -> bool {
    fs::metadata("/proc/self").is_ok_and(|m| {
        use std::os::unix::fs::MetadataExt as _;
        m.uid() == 0
    })
}

/// A wire between the gateway and the broker. While it is cut nothing passes and nobody is told, as when a
/// switch fails; connections of before are dead afterwards.
pub struct Wire {
    pub port: u16,
    cut: Arc<AtomicBool>,
}

impl Wire {
    pub fn to(port: u16) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let wire = Self {
            port: listener.local_addr().unwrap().port(),
            cut: Arc::new(AtomicBool::new(false)),
        };
        let cut = Arc::clone(&wire.cut);
        thread::spawn(move || {
            for near in listener.incoming().flatten() {
                let Ok(far) = TcpStream::connect(("127.0.0.1", port)) else {
                    continue;
                };
                for (from, to) in [
                    (near.try_clone().unwrap(), far.try_clone().unwrap()),
                    (far, near),
                ] {
                    let cut = Arc::clone(&cut);
                    thread::spawn(move || pass(from, to, &cut));
                }
            }
        });
        wire
    }

    pub fn cut(&self, cut: bool) {
        self.cut.store(cut, Ordering::Relaxed);
    }
}

fn pass(mut from: TcpStream, mut to: TcpStream, cut: &AtomicBool) {
    let mut bytes = [0; 16 * 1024];
    while let Ok(n) = from.read(&mut bytes) {
        if cut.load(Ordering::Relaxed) {
            // What was on its way is lost, and with it the connection.
            while cut.load(Ordering::Relaxed) {
                thread::sleep(Duration::from_millis(10));
            }
            break;
        }
        if n == 0 || to.write_all(&bytes[..n]).is_err() {
            break;
        }
    }
    let _ = from.shutdown(Shutdown::Both);
    let _ = to.shutdown(Shutdown::Both);
}
