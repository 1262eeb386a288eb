//! The board in all pictures.

use anyhow::{Result, bail};
use rayon::prelude::*;
use visloc_calib::{Board, ViewInput, detect};

use super::NamedImage;
use crate::host::host;

/// What was found in the pictures.
#[derive(Debug, Clone, Default)]
pub struct Detected {
    /// Width and height of the pictures, pixels.
    pub size_px: (u32, u32),
    /// Pictures with the board.
    pub views: Vec<ViewInput>,
    /// Name and reason of the others.
    pub rejected: Vec<(String, String)>,
}

/// Looks for the board in every picture. Pictures of another size than most are left out.
pub fn find_boards(board: &Board, images: &[NamedImage]) -> Result<Detected> {
    type Outcome = Result<((usize, usize), Result<ViewInput, String>), String>;
    let look = |image: &NamedImage| -> Outcome {
        // Who ends a live source wants to have the pictures that it gave.
        if image.is_file() && host().is_stopped() {
            host().note_interruption();
            return Err("not looked at: interrupted".to_owned());
        }
        let pixels = image.read().map_err(|error| format!("{error:#}"))?;
        let found = detect(board, &pixels).map_err(|why| why.to_string());
        let view = found.map(|found| ViewInput { name: image.name.clone(), corners: found.corners });
        Ok(((pixels.width(), pixels.height()), view))
    };
    let outcomes: Vec<Outcome> = images.par_iter().map(look).collect();
    let Some(size) = usual_size(outcomes.iter().flatten().map(|(size, _)| *size)) else {
        let first = images.iter().zip(outcomes).find_map(|(image, outcome)| Some((image, outcome.err()?)));
        let first = first.map(|(image, reason)| format!("; {}: {reason}", image.origin()));
        bail!("expected images, found none that can be read{}", first.unwrap_or_default());
    };
    let side = |v: usize| u32::try_from(v).unwrap_or(u32::MAX);
    let mut detected = Detected { size_px: (side(size.0), side(size.1)), ..Detected::default() };
    for (image, outcome) in images.iter().zip(outcomes) {
        let view = outcome.and_then(|(found, view)| {
            if found == size {
                return view;
            }
            Err(format!("expected {} x {} px as most, found {} x {}", size.0, size.1, found.0, found.1))
        });
        match view {
            Ok(view) => detected.views.push(view),
            Err(reason) => detected.rejected.push((image.name.clone(), reason)),
        }
    }
    Ok(detected)
}

/// The size that most have.
fn usual_size(sizes: impl Iterator<Item = (usize, usize)>) -> Option<(usize, usize)> {
    let mut counts = std::collections::BTreeMap::new();
    for size in sizes {
        *counts.entry(size).or_insert(0_usize) += 1;
    }
    counts.into_iter().max_by_key(|(_, count)| *count).map(|(size, _)| size)
}
