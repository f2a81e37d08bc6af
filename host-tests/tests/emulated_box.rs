//! Promise: the whole box on the emulated Cortex-M4F talks over its UART as the simulated one
//! does, and `rarma connect` hears it call and release a chatter.
//!
//! The image makes its own sound: a resonance of 900 Hz whose damping is gone from 4 to 8 s of
//! each ten ([resonance.rs](../../firmware/src/boards/mps2_an386/resonance.rs)).

use host_tests::resources::target_box_or_skip;
use serde_json::Value;
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};

const GONE_S: (f64, f64) = (4.0, 8.0);
const MODE_HZ: f64 = 900.0;
const RATE_HZ: f64 = 8000.0;

/// QEMU, ended with the test.
struct Emulated {
    child: Child,
    port: String,
}

impl Drop for Emulated {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn emulated(elf: &Path) -> Emulated {
    // A port that was free a moment ago.
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("its address").to_string();
    drop(listener);
    let child = Command::new("qemu-system-arm")
        .args(["-cpu", "cortex-m4", "-machine", "mps2-an386"])
        .args(["-nographic", "-monitor", "none", "-serial"])
        .arg(format!("tcp:{address},server=on,wait=on"))
        .args(["-semihosting-config", "enable=on,target=native,arg="])
        .arg("-kernel")
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .expect("QEMU, which built images need as well");
    // With wait=on the box starts when the host has come.
    std::thread::sleep(std::time::Duration::from_millis(500));
    Emulated {
        child,
        port: format!("tcp:{address}"),
    }
}

fn connect(port: &str, words: &[&str]) -> Vec<Value> {
    let output = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
        .args(["connect", port, "--json"])
        .args(words)
        .stdin(Stdio::null())
        .output()
        .expect("a program");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    text.lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .collect()
}

fn of<'a>(lines: &'a [Value], kind: &str) -> Vec<&'a Value> {
    let messages = lines.iter().map(|line| &line["message"][kind]);
    messages.filter(|message| !message.is_null()).collect()
}

#[test]
fn box_on_the_chip_is_asked_set_refused_and_heard() {
    let Some(elf) = target_box_or_skip("emulated_box") else {
        return;
    };
    let emulated = emulated(&elf);
    let lines = connect(
        &emulated.port,
        &[
            "--seconds",
            "13",
            "--say",
            "identify",
            "--say",
            "set monitor.threshold 0.012",
            "--say",
            "save monitor.threshold",
            "--say",
            "set monitor.threshold 9",
            "--say",
            "arm",
        ],
    );
    let answers: Vec<&Value> = of(&lines, "Reply").iter().map(|r| &r["answer"]).collect();
    assert!(
        answers
            .iter()
            .any(|a| a["Identity"]["board"] == "mps2-an386"
                && a["Identity"]["sample_rate_hz"] == RATE_HZ)
    );
    assert!(
        answers
            .iter()
            .any(|a| a["Setting"]["stored"]["Real"] == 0.012)
    );
    assert!(
        answers
            .iter()
            .any(|a| !a["Refused"]["Setting"]["Range"].is_null())
    );
    // Monitor owns no outputs, and there are none on this board.
    assert!(answers.iter().any(|a| a["Refused"]["Denied"] == "Mode"));
    assert!(of(&lines, "Status").iter().all(|s| s["energised"] == false));
    let at = |alarm: &Value| alarm["sample"].as_f64().expect("a number") / RATE_HZ;
    let alarms = of(&lines, "Alarm");
    let [called, released, ..] = alarms[..] else {
        panic!("called and released: {alarms:?}")
    };
    let f = called["frequency"].as_f64().expect("Hz");
    println!(
        "called at {:.3} s, {f:.1} Hz; released at {:.3} s",
        at(called),
        at(released)
    );
    assert!(called["on"] == true && released["on"] == false);
    let health = of(&lines, "Health");
    let last = health.last().expect("health");
    assert_eq!(last["garbage"], 0);
    // On a machine that is too busy the box falls behind and counts samples as lost, which the
    // sound does not; they come before the call as a whole.
    let lost_s = last["missing"].as_f64().expect("a number") / RATE_HZ;
    for (alarm, gone_s) in [(called, GONE_S.0), (released, GONE_S.1)] {
        let late = at(alarm) - gone_s;
        assert!(
            (0.0..0.5 + lost_s).contains(&late),
            "{alarm}, {lost_s} s lost"
        );
    }
    assert!((f - MODE_HZ).abs() < 0.03 * MODE_HZ, "{f}");
}
