//! A gateway inside the test, where it need not be killed.

use super::link::Sockets;
use rarma_fleet::gateway::config::Config;
use rarma_fleet::gateway::{Gateway, GatewayStatus};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// Waits for something, half a minute at most.
pub fn until(what: &str, mut is: impl FnMut() -> bool) {
    let until = Instant::now() + Duration::from_secs(30);
    while !is() {
        assert!(Instant::now() < until, "waited for: {what}");
        thread::sleep(Duration::from_millis(50));
    }
}

pub struct Here {
    gateway: Gateway,
    said: Arc<Mutex<Vec<String>>>,
}

impl Here {
    /// `records.db` in the folder, boxes at these ports, and `broker` for the rest of what the file says of
    /// the broker.
    pub fn start(folder: &Path, port: u16, broker: &str, boxes: &[u16]) -> Self {
        let mut text = format!(
            "group = \"plant\"\nnode = \"gw\"\njournal = \"records.db\"\nstretch_s = 5\n[broker]\nhost = \"localhost\"\nport = {port}\nuser = \"gateway\"\npassword_file = \"broker/gateway.password\"\n{broker}"
        );
        for (k, port) in boxes.iter().enumerate() {
            text.push_str(&format!(
                "[[box]]\nname = \"box-{k}\"\nmachine = \"M{k}\"\nport = \"tcp:127.0.0.1:{port}\"\nstarted = \"2026-01-05T00:00:00Z\"\n"
            ));
        }
        Self::of(folder, &text)
    }

    /// What a file says, whose paths are beside the folder.
    pub fn of(folder: &Path, text: &str) -> Self {
        let config = Config::parse(text, folder).unwrap();
        let said: Arc<Mutex<Vec<String>>> = Arc::default();
        let kept = Arc::clone(&said);
        let tell = move |_, line: &str| kept.lock().unwrap().push(line.to_owned());
        Self {
            gateway: Gateway::start(&config, Arc::new(Sockets), Arc::new(tell)).unwrap(),
            said,
        }
    }

    pub fn standing(&self) -> GatewayStatus {
        self.gateway.standing()
    }

    /// All records that there are, of which there are some, are where they belong.
    pub fn is_done(&self) -> bool {
        let s = self.standing();
        s.last > 0 && s.acknowledged == s.last
    }

    pub fn said(&self) -> String {
        self.said.lock().unwrap().join("\n")
    }

    pub fn stop(self) {
        self.gateway.stop();
    }
}
