//! The wire to the broker: one connection after the other, births, live values, records.
//!
//! A connection that is lost is left with all that was on its way: what counts is in the journal, and
//! everything else is born again. Records go in order and by number; the store (or the broker,
//! see [`Acknowledge`]) says up to which it has them: `flow`.

mod flow;

use super::boxes::{RECORDING, Shared};
use super::config::{Acknowledge, Broker, Config};
use super::journal::Journal;
use super::metrics::{OfNode, data, node_alias};
use super::notices::Notices;
use super::session::{HostSays, Outgoing, Session, Wanted};
use super::told::Told;
use super::value::Value;
use super::writing::lock;
use crate::record::{Name, Utc};
use flow::Flow;
use rumqttc::{
    AsyncClient, ClientError, Event, LastWill, MqttOptions, Packet, Publish, QoS, Transport,
};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tokio::sync::{Notify, mpsc};

/// The gateway's own metrics are sent this often.
const NODE: Duration = Duration::from_secs(10);
/// A broker that cannot be reached is tried again after so long; doubled up to the most.
const AGAIN: Duration = Duration::from_millis(500);
const AGAIN_MOST: Duration = Duration::from_secs(15);
/// Messages waiting for the wire, beyond which nothing more is made.
const OUTBOX: usize = 256;
/// Largest message that is taken, bytes.
const LARGEST: usize = 256 * 1024;

/// One box, as the uplink sees it.
pub(super) struct Ward {
    pub name: Name,
    pub shared: Arc<Shared>,
}

/// The connection to the broker.
pub(super) struct Uplink {
    broker: Broker,
    transport: Transport,
    credentials: Option<(String, String)>,
    client: String,
    mark: String,
    live: Duration,
    session: Session,
    journal: Arc<Mutex<Journal>>,
    wards: Vec<Ward>,
    wake: Arc<Notify>,
    notices: Notices,
    stop: Arc<AtomicBool>,
    flow: Flow,
    /// Births that stand, and when live values went last.
    born: Vec<(bool, Instant)>,
    node: Instant,
    outbox: VecDeque<Outgoing>,
}

enum News {
    Here,
    Subscribed,
    Came(Publish),
    Left(u16),
    Acknowledged(u16),
    Lost(String),
}

impl Uplink {
    pub fn new(
        config: &Config,
        broker: &Broker,
        transport: Transport,
        credentials: Option<(String, String)>,
        journal: Arc<Mutex<Journal>>,
        wards: Vec<Ward>,
        (wake, notices, stop): (Arc<Notify>, Notices, Arc<AtomicBool>),
    ) -> Self {
        let (group, node) = (config.group.as_str(), config.node.as_str());
        let devices = wards.iter().map(|w| w.name.to_string()).collect();
        let primary = broker.primary_host.as_ref().map(Name::to_string);
        Self {
            broker: broker.clone(),
            transport,
            credentials,
            client: format!("rarma-{group}-{node}"),
            mark: format!("rarma/1/{group}/{node}/sent"),
            live: Duration::from_secs_f64(config.live_s),
            session: Session::new(group, node, devices, primary),
            journal,
            born: wards.iter().map(|_| (false, Instant::now())).collect(),
            wards,
            wake,
            notices,
            stop,
            flow: Flow::new(),
            node: Instant::now(),
            outbox: VecDeque::new(),
        }
    }

    /// Until it is told to stop.
    pub async fn run(mut self) {
        let mut again = AGAIN / 2;
        while !self.stop.load(Ordering::Relaxed) {
            let ended = self.connection().await;
            if let Err(why) = ended {
                let Broker { host, .. } = &self.broker;
                self.notices
                    .say(format!("broker {host}:{}: {why}", self.broker.port()));
            }
            // One that was good is tried again at once.
            again = if self.session.is_born() {
                AGAIN
            } else {
                (2 * again).min(AGAIN_MOST)
            };
            self.session.leaves();
            let until = Instant::now() + again;
            while Instant::now() < until && !self.stop.load(Ordering::Relaxed) {
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
        }
    }

    fn options(&self, will: Outgoing) -> MqttOptions {
        let mut options = MqttOptions::new(&self.client, &self.broker.host, self.broker.port());
        options
            .set_clean_session(true)
            .set_keep_alive(Duration::from_secs(10))
            .set_max_packet_size(LARGEST, LARGEST)
            .set_transport(self.transport.clone())
            .set_last_will(LastWill::new(
                will.topic,
                will.payload,
                QoS::AtLeastOnce,
                false,
            ));
        if let Some((user, password)) = &self.credentials {
            options.set_credentials(user, password);
        }
        options
    }

    async fn connection(&mut self) -> Result<(), String> {
        let birth = lock(&self.journal)
            .next_birth()
            .map_err(|why| why.to_string())?;
        let will = self.session.connects(birth, now_ms());
        let (client, mut events) = AsyncClient::new(self.options(will), 1000);
        let (tell, mut news) = mpsc::unbounded_channel();
        // Polled apart, so that nothing here holds up the wire.
        let poller = tokio::spawn(async move {
            loop {
                let told = match events.poll().await {
                    Ok(Event::Incoming(Packet::ConnAck(_))) => News::Here,
                    Ok(Event::Incoming(Packet::SubAck(_))) => News::Subscribed,
                    Ok(Event::Incoming(Packet::Publish(publish))) => News::Came(publish),
                    Ok(Event::Incoming(Packet::PubAck(ack))) => News::Acknowledged(ack.pkid),
                    Ok(Event::Outgoing(rumqttc::Outgoing::Publish(id))) if id != 0 => {
                        News::Left(id)
                    }
                    Ok(_) => continue,
                    Err(why) => News::Lost(why.to_string().replace('\n', ", ")),
                };
                let lost = matches!(told, News::Lost(_));
                if tell.send(told).is_err() || lost {
                    break;
                }
            }
        });
        self.outbox.clear();
        let result = self.serve(&client, &mut news).await;
        poller.abort();
        result
    }

    async fn serve(
        &mut self,
        client: &AsyncClient,
        news: &mut mpsc::UnboundedReceiver<News>,
    ) -> Result<(), String> {
        let mut subscribed = 0;
        let filters = self.session.filters();
        loop {
            if self.stop.load(Ordering::Relaxed) {
                return self.leave(client, news).await;
            }
            let busy = self.pump(client)?;
            let tick = Duration::from_millis(if busy { 2 } else { 50 });
            let wake = Arc::clone(&self.wake);
            let told = tokio::select! {
                told = news.recv() => told,
                () = wake.notified() => None,
                () = tokio::time::sleep(tick) => None,
            };
            for told in told
                .into_iter()
                .chain(std::iter::from_fn(|| news.try_recv().ok()).take(1000))
            {
                match told {
                    News::Here => {
                        for filter in &filters {
                            let asked = client.try_subscribe(filter, QoS::AtLeastOnce);
                            asked.map_err(|why| why.to_string())?;
                        }
                    }
                    News::Subscribed => subscribed += 1,
                    News::Lost(why) => return Err(why),
                    News::Left(id) => self.flow.left(id),
                    News::Acknowledged(id) => self.marked(id),
                    News::Came(publish) => {
                        if self.came(&publish) == HostSays::Offline {
                            self.outbox.clear();
                            let _ = self.leave(client, news).await;
                            return Err("the primary host is offline; records wait in the journal"
                                .to_owned());
                        }
                    }
                }
            }
            if subscribed >= filters.len() && !self.session.is_born() && self.session.may_be_born()
            {
                self.give_birth();
            }
            if self.session.is_born() {
                self.beat();
            }
        }
    }

    /// Puts messages on the wire as long as it takes them; true if some are left.
    fn pump(&mut self, client: &AsyncClient) -> Result<bool, String> {
        while let Some(out) = self.outbox.pop_front() {
            let quality = if out.at_least_once {
                QoS::AtLeastOnce
            } else {
                QoS::AtMostOnce
            };
            match client.try_publish(&out.topic, quality, false, out.payload.clone()) {
                Ok(()) => {}
                Err(ClientError::TryRequest(_)) => {
                    self.outbox.push_front(out);
                    return Ok(true);
                }
                Err(why) => return Err(why.to_string()),
            }
        }
        Ok(false)
    }

    /// Says its own death and goes.
    async fn leave(
        &mut self,
        client: &AsyncClient,
        news: &mut mpsc::UnboundedReceiver<News>,
    ) -> Result<(), String> {
        if self.session.is_born() {
            let death = self.session.death();
            let said = client
                .publish(death.topic, QoS::AtLeastOnce, false, death.payload)
                .await;
            said.map_err(|why| why.to_string())?;
            // Until the broker has it, but not for ever.
            let _ = tokio::time::timeout(Duration::from_secs(2), async {
                while let Some(told) = news.recv().await {
                    if matches!(told, News::Acknowledged(_) | News::Lost(_)) {
                        break;
                    }
                }
            })
            .await;
        }
        let _ = client.disconnect().await;
        tokio::time::sleep(Duration::from_millis(20)).await;
        self.session.leaves();
        Ok(())
    }

    fn give_birth(&mut self) {
        let ms = now_ms();
        let mut values = self.own_values();
        let (last, identity) = {
            let journal = lock(&self.journal);
            (journal.last(), journal.identity())
        };
        values.push((
            OfNode::Version,
            Value::Text(env!("CARGO_PKG_VERSION").to_owned()),
        ));
        values.push((OfNode::Identity, Value::Text(identity.to_string())));
        self.outbox.push_back(self.session.birth(&values, ms));
        for born in &mut self.born {
            born.0 = false;
        }
        self.node = Instant::now();
        self.flow = Flow {
            agreed: self.broker.acknowledge == Acknowledge::Broker,
            history: last,
            sent: lock(&self.journal).acknowledged(),
            ..Flow::new()
        };
    }

    fn own_values(&self) -> Vec<(OfNode, Value)> {
        let journal = lock(&self.journal);
        let mut values = vec![
            (OfNode::Acknowledged, Value::Count(journal.acknowledged())),
            (
                OfNode::Waiting,
                Value::Count(journal.last() - journal.acknowledged()),
            ),
            (OfNode::Dropped, Value::Count(journal.dropped())),
        ];
        values.extend(
            self.notices
                .last()
                .map(|line| (OfNode::Notice, Value::Text(line))),
        );
        values
    }

    /// What is due: births and deaths of boxes, live values, own values, records.
    fn beat(&mut self) {
        let ms = now_ms();
        for (k, ward) in self.wards.iter().enumerate() {
            if self.outbox.len() > OUTBOX {
                return;
            }
            let mut live = ward.shared.live();
            let (born, last) = &mut self.born[k];
            let out = match (live.here, *born) {
                (true, false) => self.session.device_birth(k, live.births(k, ms), ms),
                (false, true) => self.session.device_death(k, ms),
                (true, true) if last.elapsed() >= self.live => {
                    let changes = live.changes(k, ms);
                    if changes.is_empty() {
                        continue;
                    }
                    self.session.device_data(k, changes, ms)
                }
                _ => continue,
            };
            (*born, *last) = (live.here, Instant::now());
            self.outbox.extend(out);
        }
        if self.node.elapsed() >= NODE {
            self.node = Instant::now();
            let values = self.own_values();
            let metrics = values
                .into_iter()
                .map(|(m, v)| data(node_alias(m), Some(v), ms, false))
                .collect();
            self.outbox.extend(self.session.data(metrics, ms));
            if !self.flow.agreed {
                self.notices
                    .note("no store has answered yet: records wait in the journal".to_owned());
            }
        }
        if self.flow.agreed {
            self.records(ms);
        }
    }

    fn came(&mut self, publish: &Publish) -> HostSays {
        if publish.topic.contains("/STATE/") {
            return self.session.hears_state(&publish.topic, &publish.payload);
        }
        for wanted in self.session.hears_command(&publish.topic, &publish.payload) {
            match wanted {
                Wanted::Rebirth => self.give_birth(),
                Wanted::Acknowledged {
                    identity,
                    number,
                    come,
                } => self.store_has(&identity, number, come),
                Wanted::Write {
                    device,
                    metric,
                    value,
                } => match Told::of(&metric, &value) {
                    Ok(told) => {
                        let ward = self.wards.iter().find(|w| w.name.as_str() == device);
                        if let Some(ward) = ward
                            && !ward.shared.told().put(told, Instant::now())
                        {
                            self.notices.say(format!("{device}: {RECORDING}"));
                        }
                    }
                    Err(why) => self.notices.say(format!("{device}: refused: {why}")),
                },
                Wanted::Foreign(why) => self.notices.say(format!("refused: {why}")),
            }
        }
        HostSays::Nothing
    }
}

fn now_ms() -> u64 {
    Utc::now().map_or(0, |now| now.micros().unsigned_abs() / 1000)
}
