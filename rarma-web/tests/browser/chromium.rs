//! A real Chromium, driven through its own protocol over two pipes: no port, no other program.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// No answer takes longer, unless the browser hangs.
const PATIENCE: Duration = Duration::from_secs(60);

/// What the browser gives a page that asks for the microphone.
#[derive(Debug, Clone, Copy)]
pub enum Microphone<'a> {
    /// This file, once; then its usual beeps' place is silent.
    Hears(&'a Path),
    /// No permission.
    Forbidden,
}

/// The browser, and one page in it.
pub struct Chromium {
    process: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    session: String,
    number: u64,
    /// What happened meanwhile.
    pub events: Vec<Value>,
    _profile: TempDir,
}

impl Chromium {
    /// Starts it with an empty page.
    pub fn start(program: &Path, microphone: Microphone<'_>) -> Self {
        let profile = tempfile::tempdir().expect("a folder");
        let mut options = vec![
            "--headless=new".to_owned(),
            // Tests run as root in containers, where there is no other sandbox to be had.
            "--no-sandbox".to_owned(),
            "--disable-gpu".to_owned(),
            "--no-first-run".to_owned(),
            "--autoplay-policy=no-user-gesture-required".to_owned(),
            "--use-fake-device-for-media-stream".to_owned(),
            "--remote-debugging-pipe".to_owned(),
            format!("--user-data-dir={}", profile.path().display()),
        ];
        match microphone {
            Microphone::Hears(file) => options.extend([
                "--use-fake-ui-for-media-stream".to_owned(),
                format!(
                    "--use-file-for-fake-audio-capture={}%noloop",
                    file.display()
                ),
            ]),
            Microphone::Forbidden => {
                options.push("--use-fake-ui-for-media-stream=deny".to_owned());
            }
        }
        // The browser's pipes are 3 and 4.
        let mut process = Command::new("sh")
            .args(["-c", r#"exec "$0" "$@" 3<&0 4>&1 0</dev/null 1>&2"#])
            .arg(program)
            .args(options)
            .arg("about:blank")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("a shell");
        let to = process.stdin.take().expect("a pipe");
        let out = process.stdout.take().expect("a pipe");
        let (tell, from) = channel();
        thread::spawn(move || {
            for message in BufReader::new(out).split(0) {
                let message = message.ok().and_then(|m| serde_json::from_slice(&m).ok());
                if message.is_none_or(|message: Value| tell.send(message).is_err()) {
                    return;
                }
            }
        });
        let mut browser = Self {
            process,
            to,
            from,
            session: String::new(),
            number: 0,
            events: Vec::new(),
            _profile: profile,
        };
        let targets = browser.call("Target.getTargets", &json!({}));
        let is_page = |t: &&Value| t["type"] == "page";
        let targets = targets["targetInfos"].as_array().expect("a list");
        let page = targets.iter().find(is_page).expect("a page")["targetId"].clone();
        let attached = browser.call(
            "Target.attachToTarget",
            &json!({"targetId": page, "flatten": true}),
        );
        attached["sessionId"]
            .as_str()
            .expect("a name")
            .clone_into(&mut browser.session);
        for domain in ["Page", "Runtime", "Network", "Log"] {
            browser.call(&format!("{domain}.enable"), &json!({}));
        }
        browser
    }

    /// The process that all others of this browser belong to.
    pub fn process(&self) -> u32 {
        self.process.id()
    }

    /// A command of the protocol, and its answer.
    pub fn call(&mut self, method: &str, parameters: &Value) -> Value {
        self.number += 1;
        let mut message = json!({"id": self.number, "method": method, "params": parameters});
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        let mut bytes = message.to_string().into_bytes();
        bytes.push(0);
        self.to.write_all(&bytes).expect("the browser listens");
        let begun = Instant::now();
        loop {
            let answer = match self.from.recv_timeout(PATIENCE) {
                Ok(answer) => answer,
                Err(RecvTimeoutError::Timeout) => panic!("{method}: no answer in {PATIENCE:?}"),
                Err(RecvTimeoutError::Disconnected) => panic!("{method}: the browser has ended"),
            };
            if answer["id"] == self.number {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.events.push(answer);
            assert!(begun.elapsed() < PATIENCE, "{method}: no answer");
        }
    }

    /// The value of a JavaScript expression; promises are waited for.
    pub fn value(&mut self, expression: &str) -> Value {
        let result = self.call(
            "Runtime.evaluate",
            &json!({"expression": expression, "awaitPromise": true, "returnByValue": true, "userGesture": true}),
        );
        let thrown = &result["exceptionDetails"];
        assert!(thrown.is_null(), "{expression}: {thrown}");
        result["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    pub fn wait(&mut self, what: &str, expression: &str, seconds: f64) {
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        while self.value(&format!("Promise.resolve({expression}).then(Boolean)")) != json!(true) {
            if Instant::now() > until {
                let page = self.value("document.body.innerText");
                let page = page.as_str().unwrap_or_default();
                let complaints = self.complaints().join("\n");
                panic!("{what}: not within {seconds} s; the page says:\n{page}\n{complaints}");
            }
            thread::sleep(Duration::from_millis(50));
        }
    }

    /// What went wrong in the page: exceptions, and what the browser itself complains of.
    pub fn complaints(&self) -> Vec<String> {
        let is = |event: &&Value| {
            let method = event["method"].as_str().unwrap_or_default();
            let level = &event["params"]["entry"]["level"];
            method == "Runtime.exceptionThrown" || (method == "Log.entryAdded" && level == "error")
        };
        let complaints = self.events.iter().filter(is);
        complaints
            .map(|event| event["params"].to_string())
            .collect()
    }

    /// A picture of the page as a PNG, as wide and high as the window.
    pub fn picture(&mut self, path: &Path) {
        let png = self.call(
            "Page.captureScreenshot",
            &json!({"captureBeyondViewport": true}),
        );
        let png = png["data"].as_str().expect("a picture");
        let bytes = base64::Engine::decode(&base64::engine::general_purpose::STANDARD, png);
        std::fs::write(path, bytes.expect("base64")).expect("written");
    }
}

impl Drop for Chromium {
    fn drop(&mut self) {
        let message = json!({"id": 0, "method": "Browser.close"}).to_string() + "\0";
        // One that is gone already needs no word.
        let _ = self.to.write_all(message.as_bytes());
        let until = Instant::now() + Duration::from_secs(5);
        while Instant::now() < until {
            if matches!(self.process.try_wait(), Ok(Some(_))) {
                return;
            }
            thread::sleep(Duration::from_millis(50));
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
