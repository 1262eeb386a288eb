//! A map of images with given poses.

use std::path::Path;

use anyhow::{Result, bail};
use visloc_core::ImageSource;
use visloc_io::camera_trajectory::read_camera_trajectory_file;
use visloc_slam::{
    SlamConfig,
    map::{Landmark, SessionCamera},
    mapping::GivenViews,
};
use visloc_vmap::{MapScale, ScaleSource, VisualMap};

use super::{POSE_TOLERANCE_SECS, map_file};
use crate::{args::SlamArgs, report::SkippedReport, run::Progress, say};

/// Makes the map of `--save` from the images that have a pose in a file.
pub fn map_given_poses(
    args: &SlamArgs,
    config: &SlamConfig,
    images: &mut dyn ImageSource,
    (poses, out): (&Path, &Path),
) -> Result<()> {
    let given = read_camera_trajectory_file(poses)?.timed(poses)?;
    let camera = *images.camera();
    let mut views = GivenViews::new(&camera, config)?;
    let progress = Progress::new(images.status().num_items);
    let (mut num_images, mut broken, mut left_out) = (0_usize, None, Vec::new());
    while let Some(next) = images.next_item() {
        let frame = match next {
            Ok(frame) => frame,
            Err(error) => {
                broken = Some(error);
                break;
            }
        };
        num_images += 1;
        progress.advance();
        let Some(pose) = given.nearest(frame.at, POSE_TOLERANCE_SECS) else { continue };
        if let Err(reason) = views.add(frame.at, frame.image, pose.world_from_camera.inverse()) {
            left_out.push((frame.at, reason));
        }
    }
    progress.clear();
    SkippedReport::new(images.status().skipped).lines().iter().for_each(|line| say::note!("{line}"));
    if let [(at, reason), ..] = &left_out[..] {
        say::note!("{} left out; the first at {at}: {reason}", say::count(left_out.len(), "image"));
    }
    let num_views = views.num_views();
    if num_views < 2 {
        bail!(
            "{}: expected poses for at least 2 images of {}, found {num_views} among {} poses; are their times those of the images?",
            poses.display(),
            args.source,
            given.poses().len()
        );
    }
    // A map of a part of the images may be meant; half of them is usual.
    if 2 * num_views + 1 < num_images {
        say::note!(
            "{}: {num_views} of {num_images} images have a pose within {POSE_TOLERANCE_SECS} s; are the times those of the images?",
            poses.display()
        );
    }
    let map = views.finish();
    let mut seen: Vec<usize> =
        map.landmarks().map(|(_, landmark): (_, &Landmark)| landmark.observations.len()).collect();
    seen.sort_unstable();
    let Some(median) = seen.get(seen.len() / 2) else {
        bail!("{}: no two images of {} show the same where these poses say so", poses.display(), args.source);
    };
    say::line!("{}: {}, {num_views} of them with a pose", args.source, say::count(num_images, "image"));
    say::line!("  {} landmarks, half of them seen by {median} images or more", seen.len());
    let map = VisualMap {
        map,
        // The unit and the frame are those of the poses.
        scales: vec![MapScale { source: ScaleSource::Aligned, relative_sigma: 0.0 }],
        levels: vec![true],
        sessions: vec![map_file::session((&args.source, args.seed.value()), num_views)],
    };
    map_file::write(out, &map, &SessionCamera::as_calibrated(&camera))?;
    match broken {
        Some(error) => bail!("{error}{}", say::before(num_images, "image", "done")),
        None => Ok(()),
    }
}
