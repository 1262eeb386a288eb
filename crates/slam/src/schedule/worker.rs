//! The mapping side on a thread of its own.

use std::{
    io,
    sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel},
    thread::{self, JoinHandle},
};

use super::{BackEnd, Order, Update};

/// Orders that may wait. More would only make the map learn late.
const MAX_WAITING: usize = 4;

/// A thread that does orders one after the other.
#[derive(Debug)]
pub(crate) struct Worker {
    orders: Option<SyncSender<Order>>,
    updates: Receiver<Update>,
    thread: Option<JoinHandle<()>>,
    num_under_way: usize,
}

impl Worker {
    /// Starts the thread.
    ///
    /// # Errors
    /// If the system has no thread left.
    pub fn start(mut back_end: BackEnd) -> io::Result<Self> {
        let (orders, incoming) = sync_channel::<Order>(MAX_WAITING);
        // There is room for the answers of all waiting orders and of the one being done: sending never blocks.
        let (outgoing, updates) = sync_channel(MAX_WAITING + 1);
        let thread = thread::Builder::new().name("mapping".to_owned()).spawn(move || {
            for order in incoming {
                if outgoing.send(back_end.process(order)).is_err() {
                    break;
                }
            }
        })?;
        Ok(Self { orders: Some(orders), updates, thread: Some(thread), num_under_way: 0 })
    }

    /// Hands an order over without waiting; gives it back if too many are waiting.
    ///
    /// # Panics
    /// If the mapper has panicked: passes its panic on.
    pub fn submit(&mut self, order: Order) -> Result<(), Box<Order>> {
        let Some(orders) = self.orders.as_ref().filter(|_| self.num_under_way <= MAX_WAITING) else {
            return Err(Box::new(order));
        };
        match orders.try_send(order) {
            Ok(()) => {
                self.num_under_way += 1;
                Ok(())
            }
            Err(TrySendError::Full(order)) => Err(Box::new(order)),
            Err(TrySendError::Disconnected(order)) => {
                self.pass_panic_on();
                Err(Box::new(order))
            }
        }
    }

    /// What has been finished since the last call, without waiting.
    pub fn collect(&mut self) -> Vec<Update> {
        let updates: Vec<Update> = self.updates.try_iter().collect();
        self.num_under_way -= updates.len();
        updates
    }

    /// Waits until everything is finished.
    ///
    /// # Panics
    /// If the mapper has panicked: passes its panic on.
    pub fn finish(&mut self) -> Vec<Update> {
        let mut updates = Vec::new();
        while self.num_under_way > 0 {
            match self.updates.recv() {
                Ok(update) => updates.push(update),
                Err(_) => {
                    self.pass_panic_on();
                    break;
                }
            }
            self.num_under_way -= 1;
        }
        updates
    }

    fn pass_panic_on(&mut self) {
        self.orders = None;
        self.num_under_way = 0;
        if let Some(Err(panic)) = self.thread.take().map(JoinHandle::join) {
            std::panic::resume_unwind(panic);
        }
    }
}

impl Drop for Worker {
    /// Lets the thread finish what it is doing.
    fn drop(&mut self) {
        self.orders = None;
        if let Some(thread) = self.thread.take() {
            // Answers may be waiting: there is room for all of them, so the thread ends.
            let _ = thread.join();
        }
    }
}
