//! What a page is shown.

use std::sync::Arc;

/// Everything that a page needs to show one moment, as messages. Cheap to copy.
#[derive(Debug, Clone)]
pub struct Update {
    /// What stays. The same allocation as long as nothing in it changes.
    pub scene: Arc<[u8]>,
    /// What is true now.
    pub state: Arc<[u8]>,
    /// The camera image, if there is one.
    pub image: Option<Arc<[u8]>>,
}
