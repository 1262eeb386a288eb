//! One page at its socket.

use std::{sync::Arc, time::Duration};

use axum::extract::ws::{Message, WebSocket};
use tokio::time::{MissedTickBehavior, interval, sleep};

use super::{
    hub::Hub,
    link::Link,
    pulse::{PULSE_EVERY, Pulse},
    refusal::Refused,
    seat::Visitor,
};
use crate::Command;

/// Whoever takes nothing for so long is gone.
const SEND_TIMEOUT: Duration = Duration::from_secs(20);
/// What a page says when it has drawn an update.
const DRAWN: &str = "drawn";

/// Attends to a page until it leaves.
pub(super) async fn attend(mut socket: WebSocket, hub: Arc<Hub>, visitor: Visitor) {
    serve(&mut socket, &hub, &visitor).await;
    hub.leave(&visitor);
}

async fn serve(socket: &mut WebSocket, hub: &Hub, visitor: &Visitor) {
    let mut updates = hub.subscribe();
    hub.take(Command::Hello {});
    let mut link = Link::default();
    let mut pulse_due = interval(PULSE_EVERY);
    pulse_due.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut has_begun = false;
    loop {
        tokio::select! {
            incoming = socket.recv() => match incoming {
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(message)) => if let Err(reason) = take(&message, &mut link, hub, visitor) {
                    let refused = Refused { reason }.text();
                    if !send_one(socket, Message::Text(refused.into())).await {
                        return;
                    }
                },
            },
            changed = updates.changed(), if link.is_ready() => {
                if changed.is_err() {
                    return;
                }
                let update = updates.borrow_and_update().clone();
                let Some(update) = update else { continue };
                has_begun = true;
                let messages = link.messages(&update, hub.clock().secs());
                if !send(socket, messages).await {
                    return;
                }
            }
            () = sleep(link.still_after()), if link.owes_rest() => {
                let Some(update) = updates.borrow().clone() else { continue };
                let messages = link.rest(&update, hub.clock().secs());
                if !send(socket, messages).await {
                    return;
                }
            }
            _ = pulse_due.tick(), if has_begun => {
                let pulse = Pulse { busy_secs: hub.busy_secs() };
                if !send_one(socket, Message::Text(pulse.text().into())).await {
                    return;
                }
            }
        }
    }
}

/// Takes in what a page says; an error is for the person there.
fn take(message: &Message, link: &mut Link, hub: &Hub, visitor: &Visitor) -> Result<(), String> {
    match message {
        Message::Text(text) if text.as_str() == DRAWN => link.drawn(hub.clock().secs()),
        Message::Text(text) => hub.take_text_of(visitor, text)?,
        Message::Binary(bytes) => {
            hub.count_malformed(&format!("expected text, found {} bytes", bytes.len()));
        }
        Message::Ping(_) | Message::Pong(_) | Message::Close(_) => {}
    }
    Ok(())
}

/// Whether the page took them.
async fn send(socket: &mut WebSocket, messages: Vec<Arc<[u8]>>) -> bool {
    for message in messages {
        let bytes = axum::body::Bytes::from_owner(message);
        if !send_one(socket, Message::Binary(bytes)).await {
            return false;
        }
    }
    true
}

async fn send_one(socket: &mut WebSocket, message: Message) -> bool {
    matches!(tokio::time::timeout(SEND_TIMEOUT, socket.send(message)).await, Ok(Ok(())))
}
