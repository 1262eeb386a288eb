//! Watches a robot elsewhere: takes its updates to the pages here, and commands back.

use std::{
    sync::{Arc, mpsc::Receiver},
    time::Duration,
};

use futures_util::{SinkExt as _, StreamExt as _};
use tokio::{
    runtime::Builder,
    time::{interval, sleep},
};
use tokio_tungstenite::{
    MaybeTlsStream, WebSocketStream, connect_async_with_config,
    tungstenite::{self, Message as Frame, protocol::WebSocketConfig},
};

use super::{
    hub::Hub,
    pulse::{PULSE_EVERY, Pulse, Silence},
    refusal::Refused,
};
use crate::{Command, Message, MessageKind, StudioError, Update};

/// Longest message that is taken, bytes.
const MAX_MESSAGE_BYTES: usize = 64 << 20;
/// How often commands of pages are looked for.
const COMMANDS_EVERY: Duration = Duration::from_millis(10);
/// Waits between attempts to connect.
const FIRST_WAIT: Duration = Duration::from_millis(500);
const MAX_WAIT: Duration = Duration::from_secs(5);
/// A robot that says nothing for so long is asked whether it is still there.
const PING_EVERY: Duration = Duration::from_secs(5);
/// What the robot refuses is part of all states for so long: a page that is busy leaves states out.
const REFUSED_FOR: Duration = Duration::from_secs(1);
/// So many questions without an answer, and the link is broken.
const MAX_PINGS: u32 = 2;

type Socket = WebSocketStream<MaybeTlsStream<tokio::net::TcpStream>>;

/// Where a robot publishes.
#[derive(Debug, Clone)]
pub struct Remote {
    /// Host and port.
    pub address: String,
    /// What must be known there.
    pub token: Option<String>,
}

impl Remote {
    fn url(&self) -> String {
        let token = self.token.as_ref().map(|token| format!("?token={token}")).unwrap_or_default();
        format!("ws://{}/socket{token}", self.address)
    }

    /// Shows the pages of a hub that a link is about to be opened.
    pub(super) fn announce(&self, hub: &Hub) -> Result<(), StudioError> {
        Picture::new(&self.address)?.tell(hub, &format!("connecting to {}", self.address));
        Ok(())
    }

    /// Watches until the hub is closed. A link that breaks is opened again.
    ///
    /// # Errors
    /// If there is no event loop.
    pub fn watch(&self, hub: &Arc<Hub>, commands: &Receiver<Command>) -> Result<(), StudioError> {
        let runtime = Builder::new_current_thread().enable_io().enable_time().build();
        let runtime = runtime.map_err(|error| StudioError::input("event loop", error))?;
        runtime.block_on(async {
            let mut wait = FIRST_WAIT;
            let mut picture = Picture::new(&self.address)?;
            while !hub.is_closed() {
                picture.tell(hub, &format!("connecting to {}", self.address));
                let config = WebSocketConfig::default().max_message_size(Some(MAX_MESSAGE_BYTES));
                match connect_async_with_config(self.url(), Some(config), true).await {
                    Ok((socket, _)) => {
                        wait = FIRST_WAIT;
                        relay(socket, hub, commands, &mut picture).await;
                        picture
                            .tell(hub, &format!("the link to {} is broken; connecting again", self.address));
                    }
                    Err(error) => picture.tell(hub, &format!("{}: {}", self.address, reason(&error))),
                }
                // What was asked for while there was no link is out of date when there is one.
                commands.try_iter().for_each(drop);
                sleep(wait).await;
                wait = (2 * wait).min(MAX_WAIT);
            }
            Ok(())
        })
    }
}

fn reason(error: &tungstenite::Error) -> String {
    match error {
        tungstenite::Error::Http(answer) if answer.status() == 403 => {
            "the token is missing or wrong (--token)".to_owned()
        }
        tungstenite::Error::Io(error) if error.kind() == std::io::ErrorKind::ConnectionRefused => {
            "no program publishes there now; trying again".to_owned()
        }
        // What the look-up of a name says has no kind.
        tungstenite::Error::Io(error) => format!("{error}; trying again"),
        error => format!("{error}; trying again"),
    }
}

/// Until the link breaks.
async fn relay(mut socket: Socket, hub: &Hub, commands: &Receiver<Command>, picture: &mut Picture) {
    let mut num_pings = 0;
    let mut silent = Duration::ZERO;
    let mut silence = Silence::default();
    let (mut is_stale, mut since_told) = (false, Duration::ZERO);
    let mut commands_due = interval(COMMANDS_EVERY);
    loop {
        tokio::select! {
            incoming = socket.next() => {
                let Some(Ok(frame)) = incoming else { return };
                (num_pings, silent) = (0, Duration::ZERO);
                silence.ends();
                if let Frame::Text(text) = &frame {
                    if let Some(pulse) = Pulse::read(text) {
                        silence.take(pulse);
                    } else if let Some(Refused { reason }) = Refused::read(text) {
                        picture.refused = Some((reason, REFUSED_FOR));
                        picture.show(hub, Arc::clone(&picture.state));
                    }
                }
                let Frame::Binary(bytes) = frame else { continue };
                match picture.take(&bytes, hub) {
                    Ok(false) => {}
                    // The robot may send the next one: the pages here have their own flow.
                    Ok(true) => if socket.send(Frame::text("drawn")).await.is_err() { return },
                    Err(error) => hub.complain(&error.to_string()),
                }
            }
            _ = commands_due.tick() => {
                if hub.is_closed() {
                    return;
                }
                silent += COMMANDS_EVERY;
                since_told += COMMANDS_EVERY;
                silence.pass(COMMANDS_EVERY.as_secs_f64());
                picture.pass(COMMANDS_EVERY);
                match silence.stale_secs() {
                    Some(secs) if !is_stale || since_told >= PULSE_EVERY => {
                        (is_stale, since_told) = (true, Duration::ZERO);
                        picture.tell_stale(hub, secs);
                    }
                    Some(_) => {}
                    None if is_stale => {
                        is_stale = false;
                        picture.show(hub, Arc::clone(&picture.state));
                    }
                    None => {}
                }
                if silent >= PING_EVERY {
                    silent = Duration::ZERO;
                    num_pings += 1;
                    if num_pings > MAX_PINGS || socket.send(Frame::Ping(Vec::new().into())).await.is_err() {
                        return;
                    }
                }
                for command in commands.try_iter().filter(|command| *command != Command::Hello {}) {
                    let Ok(text) = serde_json::to_string(&command) else { continue };
                    if socket.send(Frame::text(text)).await.is_err() {
                        return;
                    }
                }
            }
        }
    }
}

/// The robot's latest messages.
struct Picture {
    scene: Arc<[u8]>,
    image: Option<Arc<[u8]>>,
    state: Arc<[u8]>,
    /// What the robot does not do for whoever is here, and how long that is still to be told.
    refused: Option<(String, Duration)>,
}

impl Picture {
    /// Before the first message: an empty space.
    fn new(address: &str) -> Result<Self, StudioError> {
        let scene = serde_json::json!({
            "mode": "watch",
            "scene": "remote",
            "scenes": [{ "id": "remote", "group": "Robot", "label": address }],
            "world": { "kind": "space", "name": address, "bounds_m": [-3, -2, 3, 2], "floor_m": 0 },
            "plots": [],
        });
        let state = serde_json::json!({ "number": 0, "secs": 0.0, "is_playing": true });
        let bytes = |kind, header: &serde_json::Value| -> Result<Arc<[u8]>, StudioError> {
            Ok(crate::MessageBuilder::new(kind, header)?.finish().into())
        };
        Ok(Self {
            scene: bytes(MessageKind::Scene, &scene)?,
            image: None,
            refused: None,
            state: bytes(MessageKind::State, &state)?,
        })
    }

    /// Takes in a message; with a state the picture is whole and goes to the pages.
    fn take(&mut self, bytes: &[u8], hub: &Hub) -> Result<bool, StudioError> {
        match Message::read(bytes)?.kind {
            MessageKind::Scene => self.scene = bytes.into(),
            MessageKind::Image => self.image = Some(bytes.into()),
            MessageKind::Input => {}
            MessageKind::State => {
                self.state = bytes.into();
                self.show(hub, Arc::clone(&self.state));
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn pass(&mut self, time: Duration) {
        self.refused.take_if(|(_, left)| {
            *left = left.saturating_sub(time);
            left.is_zero()
        });
    }

    fn show(&self, hub: &Hub, mut state: Arc<[u8]>) {
        if let Some((reason, _)) = &self.refused
            && let Ok(mut told) = Message::read(&state)
        {
            told.header.insert("notice".to_owned(), reason.as_str().into());
            state = told.write().into();
        }
        hub.publish(Update { scene: Arc::clone(&self.scene), state, image: self.image.clone() });
    }

    /// Tells the people at the pages something while there is no link; what is shown stays.
    fn tell(&self, hub: &Hub, notice: &str) {
        self.show_with(hub, &[("notice", notice.into()), ("is_stale", true.into())]);
    }

    /// The robot has not answered for so long, seconds; what is shown stays.
    fn tell_stale(&self, hub: &Hub, secs: f64) {
        self.show_with(hub, &[("is_stale", true.into()), ("stale_secs", secs.into())]);
    }

    fn show_with(&self, hub: &Hub, more: &[(&str, serde_json::Value)]) {
        let Ok(mut state) = Message::read(&self.state) else { return };
        state.header.extend(more.iter().map(|(key, value)| ((*key).to_owned(), value.clone())));
        self.show(hub, state.write().into());
    }
}
