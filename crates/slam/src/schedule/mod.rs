//! When tracking and mapping run: one after the other, or each on a thread of its own. Both exchange the same orders and
//! updates; the mapper is the only writer of the map, and tracking reads a copy that shares what has not changed.

mod at_hand;
mod back_end;
mod order;
mod worker;

pub(crate) use back_end::BackEnd;
pub(crate) use order::{FrameJob, Job, Order, Update};
pub(crate) use worker::Worker;

/// When tracking and mapping run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Schedule {
    /// Mapping is done with a frame before the next one is tracked: the same frames give the same bits.
    #[default]
    Sequential,
    /// Mapping has a thread of its own, and tracking never waits for it. What the mapper has no time for is left out, except
    /// keyframes; results depend on the speed of the machine.
    Threaded,
}
