//! The built page in the browser, and what a user does with it.

use crate::chromium::{Chromium, Microphone};
use serde_json::{Value, json};
use std::env;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use xtask::process::find_program;
use xtask::web::Server;

/// Names under which systems have Chromium.
const PROGRAMS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// The page as a user has it before them.
pub struct Page {
    pub browser: Chromium,
    /// Gone where there is no network any more.
    pub server: Option<Server>,
    address: String,
}

/// Where the built page lies, and a browser; or it is said why these tests are skipped.
fn needed(test: &str) -> Option<(PathBuf, PathBuf)> {
    let required = env::var("RARMA_REQUIRE_BROWSER").is_ok_and(|value| value == "1");
    let page = env::var_os("RARMA_WEB_PAGE").map(PathBuf::from);
    let program = PROGRAMS.into_iter().find_map(find_program);
    let why = match (&page, &program) {
        (None, _) => "RARMA_WEB_PAGE does not name the built page (cargo xtask web)",
        (_, None) => "there is no Chromium",
        _ => return page.zip(program),
    };
    assert!(!required, "{test}: {why}, and skipping is not allowed here");
    let _ = writeln!(std::io::stderr(), "SKIPPED: {test}: {why}");
    None
}

impl Page {
    /// Opens it; none where it is skipped.
    pub fn open(test: &str, microphone: Microphone<'_>) -> Option<Self> {
        let (folder, program) = needed(test)?;
        let server = Server::start(&folder, 0).unwrap_or_else(|why| panic!("{why}"));
        let address = server.address();
        let mut browser = Chromium::start(&program, microphone);
        browser.call("Page.navigate", &json!({"url": address}));
        let mut page = Self {
            browser,
            server: Some(server),
            address,
        };
        page.ready();
        Some(page)
    }

    fn ready(&mut self) {
        self.browser.wait(
            "the page is there",
            "document.readyState === 'complete' && document.getElementById('offline')?.textContent",
            20.0,
        );
    }

    /// Loads it again.
    pub fn reload(&mut self) {
        self.browser
            .call("Page.navigate", &json!({"url": "about:blank"}));
        let url = self.address.clone();
        self.browser.call("Page.navigate", &json!({"url": url}));
        self.ready();
    }

    /// Presses what has this id.
    pub fn press(&mut self, id: &str) {
        self.browser
            .value(&format!("document.getElementById('{id}').click()"));
    }

    /// Writes into a field.
    pub fn write(&mut self, id: &str, text: &str) {
        self.browser.value(&format!(
            "{{const f = document.getElementById('{id}'); f.value = '{text}'; f.dispatchEvent(new Event('change')); 0}}"
        ));
    }

    /// What stands there.
    pub fn text(&mut self, id: &str) -> String {
        let text = self
            .browser
            .value(&format!("document.getElementById('{id}').innerText"));
        text.as_str().unwrap_or_default().to_owned()
    }

    /// Gives it a file by the button.
    pub fn choose(&mut self, file: &Path) {
        let found = self.browser.call(
            "Runtime.evaluate",
            &json!({"expression": "document.getElementById('file')"}),
        );
        let object = &found["result"]["objectId"];
        self.browser.call(
            "DOM.setFileInputFiles",
            &json!({"objectId": object, "files": [file]}),
        );
    }

    /// Drops a file on it.
    pub fn drop_file(&mut self, name: &str, bytes: &[u8]) {
        let data = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, bytes);
        self.browser.value(&format!(
            "{{const bytes = Uint8Array.from(atob('{data}'), (c) => c.charCodeAt(0)); const data = new DataTransfer(); data.items.add(new File([bytes], '{name}')); document.body.dispatchEvent(new DragEvent('drop', {{dataTransfer: data, bubbles: true, cancelable: true}})); 0}}"
        ));
    }

    /// The newest listening: an expression of what the page itself keeps of it.
    pub fn newest(&mut self, what: &str) -> Value {
        self.browser.value(&format!(
            "import('./main.js').then(({{heard_so_far}}) => {{ const now = heard_so_far.at(-1); return {what}; }})"
        ))
    }

    /// Waits for the closing record of the newest listening.
    pub fn ended(&mut self, seconds: f64) -> Value {
        self.browser.wait(
            "an end",
            "import('./main.js').then(({heard_so_far}) => heard_so_far.at(-1)?.summary !== undefined)",
            seconds,
        );
        self.newest("now.summary")
    }

    /// What Save would save: `report` or `sound`.
    pub fn saved(&mut self, what: &str) -> Vec<u8> {
        let data = self.newest(&format!(
            "now.ask('{what}').then(({{blob}}) => new Promise((go) => {{ const r = new FileReader(); r.onload = () => go(r.result); r.readAsDataURL(blob); }}))"
        ));
        let data = data.as_str().expect("a text");
        let (_, data) = data.split_once("base64,").expect("base64");
        let bytes = base64::Engine::decode(&base64::engine::general_purpose::STANDARD, data);
        bytes.expect("base64")
    }

    /// Addresses that were asked for since it was opened.
    pub fn requests(&self) -> Vec<String> {
        let events = self.browser.events.iter();
        let sent = events.filter(|event| event["method"] == "Network.requestWillBeSent");
        sent.filter_map(|event| Some(event["params"]["request"]["url"].as_str()?.to_owned()))
            .collect()
    }

    /// Whether that is the page's own address, or no address at all.
    pub fn is_own(&self, url: &str) -> bool {
        url.starts_with(&self.address) || url.starts_with("blob:") || url.starts_with("data:")
    }

    /// A screen of this width, with this colour scheme.
    pub fn screen(&mut self, width: u32, scheme: &str) {
        let size =
            json!({"width": width, "height": 1600, "deviceScaleFactor": 1, "mobile": width < 600});
        self.browser
            .call("Emulation.setDeviceMetricsOverride", &size);
        let scheme = json!({"features": [{"name": "prefers-color-scheme", "value": scheme}]});
        self.browser.call("Emulation.setEmulatedMedia", &scheme);
        // The pictures are drawn anew.
        std::thread::sleep(std::time::Duration::from_millis(300));
    }

    /// A picture beside the built page, to be looked at.
    pub fn picture(&mut self, name: &str) {
        let built = env::var_os("RARMA_WEB_PAGE").map(PathBuf::from);
        let folder = built.unwrap_or_default().with_file_name("web-pictures");
        std::fs::create_dir_all(&folder).expect("a folder");
        self.browser.picture(&folder.join(format!("{name}.png")));
    }

    /// Presses a key.
    pub fn key(&mut self, key: &str) {
        let code = match key {
            "Tab" => 9,
            "Enter" => 13,
            _ => 27,
        };
        let text = if key == "Enter" { "\r" } else { "" };
        for kind in ["keyDown", "keyUp"] {
            let event = json!({"type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code, "text": text});
            self.browser.call("Input.dispatchKeyEvent", &event);
        }
    }
}
