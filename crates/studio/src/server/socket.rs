//! One page at its socket.

use std::{sync::Arc, time::Duration};

use axum::extract::ws::{Message, WebSocket};

use super::{hub::Hub, link::Link};
use crate::{Command, Update};

/// Whoever takes nothing for so long is gone.
const SEND_TIMEOUT: Duration = Duration::from_secs(20);
/// Longest wait for an image that was left out, seconds.
const MAX_SLEEP_SECS: f64 = 60.0;
/// What a page says when it has drawn an update.
const DRAWN: &str = "drawn";

/// Attends to a page until it leaves.
pub(super) async fn attend(mut socket: WebSocket, hub: Arc<Hub>) {
    let mut updates = hub.subscribe();
    hub.take(Command::Hello {});
    let mut link = Link::default();
    loop {
        tokio::select! {
            incoming = socket.recv() => match incoming {
                Some(Ok(message)) => if !take(&message, &mut link, &hub) { return },
                Some(Err(_)) | None => return,
            },
            changed = updates.changed(), if link.is_ready() => {
                if changed.is_err() {
                    return;
                }
                let update = updates.borrow_and_update().clone();
                let Some(update) = update else { continue };
                if !send(&mut socket, &mut link, &update, &hub).await {
                    return;
                }
            }
            // Nothing newer came: the page gets the image that was left out.
            () = sleep_until(link.image_due_secs(), &hub) => {
                let update = updates.borrow_and_update().clone();
                let Some(update) = update else { continue };
                if !send(&mut socket, &mut link, &update, &hub).await {
                    return;
                }
            }
        }
    }
}

/// Until a time of the hub's clock; for ever if there is none.
async fn sleep_until(due_secs: Option<f64>, hub: &Hub) {
    match due_secs {
        Some(due_secs) => {
            let wait_secs = (due_secs - hub.clock().secs()).clamp(0.0, MAX_SLEEP_SECS);
            tokio::time::sleep(Duration::from_secs_f64(wait_secs)).await;
        }
        None => std::future::pending().await,
    }
}

/// Whether the page stays.
fn take(message: &Message, link: &mut Link, hub: &Hub) -> bool {
    match message {
        Message::Text(text) if text.as_str() == DRAWN => link.drawn(hub.clock().secs()),
        Message::Text(text) => hub.take_text(text),
        Message::Binary(bytes) => {
            hub.count_malformed(&format!("expected text, found {} bytes", bytes.len()));
        }
        Message::Ping(_) | Message::Pong(_) => {}
        Message::Close(_) => return false,
    }
    true
}

/// Whether the page took it.
async fn send(socket: &mut WebSocket, link: &mut Link, update: &Update, hub: &Hub) -> bool {
    for message in link.messages(update, hub.clock().secs()) {
        let bytes = axum::body::Bytes::from_owner(message);
        let sending = socket.send(Message::Binary(bytes));
        if !matches!(tokio::time::timeout(SEND_TIMEOUT, sending).await, Ok(Ok(()))) {
            return false;
        }
    }
    true
}
