//! A host on its wire to the broker.

use super::{Receiver, Sink, now_ms};
use crate::gateway::config::Broker;
use crate::gateway::reached;
use crate::gateway::session::{NAMESPACE, State};
use rumqttc::{AsyncClient, ClientError, Event, LastWill, MqttOptions, Packet, QoS};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Takes records from a broker until it is told to stop: `host` is this host's name, which gateways
/// wait for (`primary_host`). `tell` hears, one line each, of a broker that is lost and of a store that does
/// not take; both are tried again after half a second.
///
/// # Errors
/// The broker's certificates or password cannot be read.
pub fn receive(
    broker: &Broker,
    group: &str,
    host: &str,
    sink: &mut dyn Sink,
    stop: &AtomicBool,
    tell: &mut dyn FnMut(&str),
) -> Result<Receiver, String> {
    let (transport, credentials) = reached(broker)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let runtime = runtime.map_err(|why| format!("no connection can be made: {why}"))?;
    let mut receiver = Receiver::new(group);
    runtime.block_on(async {
        while !stop.load(Ordering::Relaxed) {
            let mut options =
                MqttOptions::new(format!("rarma-host-{host}"), &broker.host, broker.port());
            let state = format!("{NAMESPACE}/STATE/{host}");
            let ms = now_ms();
            let said = |online: bool| format!(r#"{{"online":{online},"timestamp":{ms}}}"#);
            options
                .set_clean_session(true)
                .set_keep_alive(Duration::from_secs(10))
                .set_max_packet_size(1 << 20, 1 << 20)
                .set_transport(transport.clone())
                .set_last_will(LastWill::new(&state, said(false), QoS::AtLeastOnce, true));
            if let Some((user, password)) = &credentials {
                options.set_credentials(user, password);
            }
            receiver.nodes.clear();
            let wire = Wire {
                address: format!("{}:{}", broker.host, broker.port()),
                topics: [format!("{NAMESPACE}/{group}/#"), state.clone()],
                state,
                birth: said(true),
                death: said(false),
            };
            if let Err(why) = wire.serve(options, &mut receiver, sink, stop, tell).await {
                tell(&why);
                tokio::time::sleep(Duration::from_millis(500)).await;
            }
        }
    });
    Ok(receiver)
}

/// Whether a state says that its host is not there.
fn says_offline(payload: &[u8]) -> bool {
    serde_json::from_slice::<State>(payload).is_ok_and(|state| !state.online)
}

struct Wire {
    /// For messages.
    address: String,
    topics: [String; 2],
    state: String,
    birth: String,
    death: String,
}

impl Wire {
    fn is_there(&self, client: &AsyncClient) -> Result<(), ClientError> {
        client.try_publish(&self.state, QoS::AtLeastOnce, true, self.birth.clone())
    }

    async fn serve(
        &self,
        options: MqttOptions,
        receiver: &mut Receiver,
        sink: &mut dyn Sink,
        stop: &AtomicBool,
        tell: &mut dyn FnMut(&str),
    ) -> Result<(), String> {
        let (client, mut events) = AsyncClient::new(options, 1000);
        // It says that it is there once it hears, and again when somebody says that it is not: the will of
        // a connection before this one (Sparkplug 3.0, message-flow-phid-sparkplug-subscription and
        // message-flow-hid-sparkplug-state-message-delivered).
        let mut subscribed = 0;
        loop {
            if stop.load(Ordering::Relaxed) {
                let _ = client.try_publish(&self.state, QoS::AtLeastOnce, true, self.death.clone());
                let _ = client.try_disconnect();
                // Until the wire is closed, but not for ever.
                let _ = tokio::time::timeout(Duration::from_secs(1), async {
                    while events.poll().await.is_ok() {}
                })
                .await;
                return Ok(());
            }
            let Ok(event) = tokio::time::timeout(Duration::from_millis(100), events.poll()).await
            else {
                continue;
            };
            let lost = |why: &dyn std::fmt::Display| {
                format!(
                    "broker {}: {}",
                    self.address,
                    why.to_string().replace('\n', ", ")
                )
            };
            let said = match event.map_err(|why| lost(&why))? {
                Event::Incoming(Packet::ConnAck(_)) => {
                    for topic in &self.topics {
                        let asked = client.try_subscribe(topic, QoS::AtLeastOnce);
                        asked.map_err(|why| lost(&why))?;
                    }
                    continue;
                }
                Event::Incoming(Packet::SubAck(_)) => {
                    subscribed += 1;
                    if subscribed == self.topics.len() {
                        self.is_there(&client).map_err(|why| lost(&why))?;
                    }
                    continue;
                }
                Event::Incoming(Packet::Publish(publish)) if publish.topic == self.state => {
                    if subscribed >= self.topics.len() && says_offline(&publish.payload) {
                        self.is_there(&client).map_err(|why| lost(&why))?;
                    }
                    continue;
                }
                Event::Incoming(Packet::Publish(publish)) => {
                    let said = receiver.take(&publish.topic, &publish.payload, sink);
                    receiver.notices.drain(..).for_each(|line| tell(&line));
                    said?
                }
                _ => continue,
            };
            for said in said {
                // A wire that takes no more has lost an acknowledgement: the next one says the same.
                let _ = client.try_publish(said.topic, QoS::AtMostOnce, false, said.payload);
            }
        }
    }
}
