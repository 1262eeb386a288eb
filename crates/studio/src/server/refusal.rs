//! What one page is told that asked for what it may not do.

use serde::{Deserialize, Serialize};

/// A command was not obeyed, as JSON in a text: `{"type": "refused", "reason": "..."}`. Only who asked gets it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "type", rename = "refused")]
pub(super) struct Refused {
    /// Why, as a sentence.
    pub reason: String,
}

impl Refused {
    pub fn text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    pub fn read(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }
}
