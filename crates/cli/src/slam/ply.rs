//! The landmarks as a file that 3-D viewers open.

use std::{io::Write, path::Path};

use anyhow::{Context, Result};
use visloc_base::files::NewFile;
use visloc_slam::map::Map;

/// Writes converged landmarks as points, with the number of keyframes that see each.
///
/// # Errors
/// If the file cannot be written.
pub fn write_ply(path: &Path, map: &Map) -> Result<()> {
    let landmarks: Vec<_> = map.landmarks().filter(|(_, landmark)| landmark.is_converged()).collect();
    let write = || -> std::io::Result<()> {
        let mut out = NewFile::create(path)?;
        writeln!(out, "ply\nformat ascii 1.0\ncomment map units\nelement vertex {}", landmarks.len())?;
        writeln!(
            out,
            "property float x\nproperty float y\nproperty float z\nproperty int observations\nend_header"
        )?;
        for (_, landmark) in &landmarks {
            let p = landmark.point_in_world;
            writeln!(out, "{:.6} {:.6} {:.6} {}", p.x, p.y, p.z, landmark.observations.len())?;
        }
        out.finish()
    };
    write().with_context(|| path.display().to_string())
}
