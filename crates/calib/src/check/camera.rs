//! Findings.

use std::fmt;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// As it should be.
    Fine,
    /// Unusual; look at it.
    Warning,
    /// The calibration cannot be right for these images.
    Wrong,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fine => "fine",
            Self::Warning => "warning",
            Self::Wrong => "wrong",
        })
    }
}

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What was looked at, in one word or two.
    pub subject: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What was found, what is usual, and what to do.
    pub message: String,
}

/// All findings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CameraCheck {
    /// In the order in which they were looked at.
    pub findings: Vec<Finding>,
}

impl CameraCheck {
    /// The worst of all findings.
    pub fn severity(&self) -> Severity {
        self.findings.iter().map(|finding| finding.severity).max().unwrap_or(Severity::Fine)
    }

    pub(super) fn add(&mut self, subject: &'static str, severity: Severity, message: String) {
        self.findings.push(Finding { subject, severity, message });
    }
}
