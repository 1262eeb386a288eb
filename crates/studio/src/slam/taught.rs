//! Maps that are made at the page, to find the camera in them there.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use visloc_slam::Slam;
use visloc_vmap::{VisualMap, save};

use super::SequenceSource;
use crate::{StudioError, new_file::new_file};

/// What a session of SLAM is for.
#[derive(Clone)]
pub enum Job {
    /// To make a map, or to go on in one of an earlier session.
    Teach(Option<Arc<VisualMap>>),
    /// To find the camera in a map of an earlier session, which stays as it is.
    Find(Arc<VisualMap>),
}

/// A map that was saved at the page.
#[derive(Clone)]
pub struct TaughtMap {
    /// Its file.
    pub path: PathBuf,
    /// The map.
    pub map: Arc<VisualMap>,
    /// Where its images came from.
    pub from: SequenceSource,
}

/// The maps that were saved at the page, in their order. Clones share them: sessions add to what the list of scenes shows.
#[derive(Clone, Default)]
pub struct TaughtMaps(Arc<Mutex<Vec<TaughtMap>>>);

impl TaughtMaps {
    /// All so far.
    pub fn all(&self) -> Vec<TaughtMap> {
        self.lock().clone()
    }

    /// Saves a map as a new file in a folder; its number.
    pub(super) fn save(
        &self,
        folder: &Path,
        (map, slam): (VisualMap, &Slam),
        from: &SequenceSource,
    ) -> Result<usize, StudioError> {
        let refused = |error: String| StudioError::input(folder.display(), error);
        let path = new_file(folder, &from.stem(), "vmap").map_err(|error| refused(error.to_string()))?;
        if let Err(error) = save(&path, &map, &slam.session_camera()) {
            // The name was reserved with an empty file.
            let _ = std::fs::remove_file(&path);
            return Err(refused(error.to_string()));
        }
        let mut all = self.lock();
        all.push(TaughtMap { path, map: Arc::new(map), from: from.clone() });
        Ok(all.len() - 1)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<TaughtMap>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The name of a session's program, as maps keep it.
pub(super) const PROGRAM: &str = concat!("visloc ", env!("CARGO_PKG_VERSION"));
