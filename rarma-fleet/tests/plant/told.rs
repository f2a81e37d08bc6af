//! The whole firmware on a socket, with a key, and a controller that tells it a speed and teeth through broker and
//! gateway.

use super::broker::{Broker, is_there};
use super::here::{Here, until};
use hal_sim::rig::{RigSetUp, SimBox, SimRig};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_box::settings::{LINK_KEY, MONITOR_TEETH, SettingValue};
use rarma_box::wire::{Answer, Command, Deframer, LinkKey, NOBODY, Telemetry};
use rarma_core::monitor::SpeedSource;
use rumqttc::{Client, MqttOptions, QoS, Transport};
use srad_types::payload::{DataType, Message, Metric, Payload, metric};
use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

const KEY: [u8; 32] = [0x5a; 32];

/// What the box has said.
#[derive(Debug, Default, Clone)]
struct Said {
    told_hz: Option<f32>,
    started: u32,
    verdicts_since: u32,
    teeth: Option<SettingValue>,
    holder: Option<u32>,
}

impl Said {
    fn hears(&mut self, message: &Telemetry) {
        match message {
            Telemetry::Started { .. } => {
                (self.started, self.verdicts_since) = (self.started + 1, 0)
            }
            Telemetry::Verdict(v) => {
                self.verdicts_since += 1;
                let told = v
                    .spindle
                    .hz
                    .filter(|_| v.spindle.source == SpeedSource::Told);
                self.told_hz = told.or(self.told_hz);
            }
            Telemetry::Status(status) => self.holder = Some(status.control.by),
            Telemetry::Reply(reply) => {
                if let Answer::Setting(s) = &reply.answer
                    && s.setting == MONITOR_TEETH.number()
                {
                    self.teeth = Some(s.value);
                }
            }
            _ => {}
        }
    }
}

/// A box in real time for one host at a time; somebody at its own port asks for its teeth ten times a second.
fn box_on(listener: &TcpListener, said: &Mutex<Said>, stop: &AtomicBool) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let sound = std::iter::repeat_with(move || rng.random_range(-0.02..0.02_f32));
    let mut all = SimBox::new(SimRig::new(RigSetUp::default(), sound));
    all.send(&Command::Set {
        setting: LINK_KEY.number(),
        value: SettingValue::Key(LinkKey(KEY)),
    });
    all.host.speaker.set_key(Some(LinkKey(KEY)));
    all.send(&Command::Release);
    (all.host.takes_control, all.host.heartbeat_us) = (false, None);
    all.host.keep_all = false;
    listener.set_nonblocking(true).unwrap();
    let mut deframer = Deframer::default();
    let mut host: Option<TcpStream> = None;
    let (begun, from_us) = (Instant::now(), all.rig.world_us());
    let mut asked_us = 0;
    while !stop.load(Ordering::Relaxed) {
        if host.is_none()
            && let Ok((socket, _)) = listener.accept()
        {
            socket.set_nonblocking(true).unwrap();
            host = Some(socket);
        }
        let until_us = all.rig.world_us() + 5000;
        while all.rig.world_us() < until_us {
            let bytes = all.step_and_take();
            for &byte in &bytes {
                if let Some(Ok((_, message))) = deframer.push::<Telemetry>(byte) {
                    said.lock().unwrap().hears(&message);
                }
            }
            if host
                .as_mut()
                .is_some_and(|host| host.write_all(&bytes).is_err())
            {
                host = None;
            }
        }
        let mut bytes = [0; 4096];
        if let Some(Ok(n)) = host.as_mut().map(|host| host.read(&mut bytes)) {
            all.rig.link.host_sends(&bytes[..n]);
        }
        if all.rig.world_us() > asked_us + 100_000 {
            asked_us = all.rig.world_us();
            let setting = MONITOR_TEETH.number();
            all.send(&Command::Read { setting });
        }
        let ahead = Duration::from_micros(all.rig.world_us() - from_us);
        thread::sleep(ahead.saturating_sub(begun.elapsed()));
    }
}

fn payload(name: &str, value: f64) -> Vec<u8> {
    let mut metric = Metric::new();
    metric.set_name(name.to_owned());
    metric.set_datatype(DataType::Double);
    metric.set_value(metric::Value::DoubleValue(value));
    let metrics = vec![metric];
    Payload {
        metrics,
        ..Payload::default()
    }
    .encode_to_vec()
}

#[test]
fn a_controller_tells_the_whole_firmware_its_speed_and_teeth() {
    if !is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("broker");
    let broker = Broker::start(&at);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let (said, stop): (Arc<Mutex<Said>>, Arc<AtomicBool>) = Default::default();
    let (says, stops) = (Arc::clone(&said), Arc::clone(&stop));
    let the_box = thread::spawn(move || box_on(&listener, &says, &stops));
    fs::write(folder.path().join("box.key"), KEY).unwrap();
    let text = |key: &str| {
        format!(
            "group = \"plant\"\nnode = \"gw\"\njournal = \"records.db\"\nstretch_s = 1\n[broker]\nhost = \"localhost\"\nport = {}\nca = \"broker/ca.pem\"\nuser = \"gateway\"\npassword_file = \"broker/gateway.password\"\nacknowledge = \"broker\"\n[[box]]\nname = \"box-1\"\nmachine = \"M1\"\nport = \"tcp:127.0.0.1:{port}\"\n{key}",
            broker.port
        )
    };
    let ca = fs::read(at.join("ca.pem")).unwrap();
    let mut options = MqttOptions::new("plc", "localhost", broker.port);
    options
        .set_credentials("controller", "controller-word")
        .set_transport(Transport::tls(ca, None, None));
    let (controller, mut connection) = Client::new(options, 10);
    thread::spawn(move || while connection.recv().is_ok_and(|event| event.is_ok()) {});
    let tell = |name: &str, value| {
        let topic = "spBv1.0/plant/DCMD/gw/box-1";
        let sent = controller.publish(topic, QoS::AtMostOnce, false, payload(name, value));
        sent.unwrap();
        Instant::now()
    };
    let now = || said.lock().unwrap().clone();

    // A gateway without the key tells nothing, and says so.
    let gateway = Here::of(folder.path(), &text(""));
    until("the broker's first acknowledgement", || {
        gateway.standing().acknowledged > 0
    });
    tell("Spindle/Speed", 6000.0);
    until("the refusal", || {
        gateway.said().contains("the key is missing")
    });
    gateway.stop();
    assert_eq!(now().told_hz, None);

    let gateway = Here::of(folder.path(), &text("key = \"box.key\"\n"));
    let before = gateway.standing().last;
    until("the broker's acknowledgement", || {
        let standing = gateway.standing();
        standing.last > before && standing.acknowledged == standing.last
    });
    for rpm in [6120.0, 9000.0] {
        let told = tell("Spindle/Speed", rpm);
        until("the speed in a verdict", || {
            now().told_hz.map(f64::from) == Some(rpm / 60.0)
        });
        println!("a speed counts after {:.2} s", told.elapsed().as_secs_f64());
    }
    let before = now();
    assert_eq!(before.teeth, Some(SettingValue::Whole(0)));
    let told = tell("Spindle/Teeth", 6.0);
    until("a verdict of a monitor that was started anew", || {
        let now = now();
        now.started > before.started && now.verdicts_since > 0
    });
    println!("teeth count after {:.2} s", told.elapsed().as_secs_f64());
    until("the teeth, and nobody in control", || {
        let now = now();
        now.teeth == Some(SettingValue::Whole(6)) && now.holder == Some(NOBODY)
    });
    assert!(!gateway.said().contains("not told"), "{}", gateway.said());
    gateway.stop();
    stop.store(true, Ordering::Relaxed);
    the_box.join().unwrap();
}
