//! Saving what a run found.

use std::path::Path;

use anyhow::{Error, Result, anyhow};

use crate::{
    args::STANDARD_OUTPUT,
    say::{self, one_line},
};

/// Saves one result after the other: one that fails does not keep the others from being saved, and all failures are told.
#[derive(Default)]
pub struct Saving {
    failures: Vec<Error>,
}

impl Saving {
    /// Takes in what came of saving a result.
    pub fn save(&mut self, result: Result<(), impl Into<Error>>) {
        self.failures.extend(result.map_err(Into::into).err());
    }

    /// Takes in what came of saving a result if that was wanted.
    pub fn save_if<T>(&mut self, wanted: Option<T>, save: impl FnOnce(T) -> Result<()>) {
        if let Some(wanted) = wanted {
            self.save(save(wanted));
        }
    }

    /// Writes a file if it was wanted, and says where it is.
    pub fn write(&mut self, what: &str, wanted: Option<&Path>, write: impl FnOnce(&Path) -> Result<()>) {
        self.save_if(wanted, |path| {
            write(path)?;
            if path != Path::new(STANDARD_OUTPUT) {
                say::line!("{what}: {}", path.display());
            }
            Ok(())
        });
    }

    /// Whether all that came until now could be saved.
    pub fn is_complete(&self) -> bool {
        self.failures.is_empty()
    }

    /// Whether all could be saved.
    pub fn end(mut self) -> Result<()> {
        match self.failures.len() {
            0 => Ok(()),
            1 => Err(self.failures.remove(0)),
            _ => Err(anyhow!("{}", self.failures.iter().map(one_line).collect::<Vec<_>>().join("; "))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_failures_are_told() {
        let mut saving = Saving::default();
        saving.save(Err(anyhow!("no space").context("a.json: cannot write it")));
        saving.save(Ok::<(), Error>(()));
        saving.save_if(Some("plots"), |folder| Err(anyhow!("{folder}: no such folder")));
        saving.save_if(None::<()>, |()| Err(anyhow!("not wanted")));
        assert_eq!(
            saving.end().unwrap_err().to_string(),
            "a.json: cannot write it: no space; plots: no such folder"
        );
        assert!(Saving::default().end().is_ok());
    }
}
