//! Datasets and plain folders of images.

use std::path::Path;

use super::{SourceKind, Way, always_usable};
use crate::{
    FileError,
    sequence::{
        FilePictures, Listing, Sequence, SequenceOptions, SequenceRange, list_sequence, open_sequence,
        sequence_layouts,
    },
    sources::{
        OpenFrames, OpenImages, OpenPictures,
        SourceOption::{Camera, End, Fps, Frames, Mount, Scale, Start, Stride},
        SourcesError,
        adapt::frames_of_pictures,
        open::Request,
    },
};

pub(super) const KIND: SourceKind = SourceKind {
    name: "images",
    schemes: &["images", "tum", "euroc", "kitti", "icl", "zurich"],
    form: "DIR",
    example: "tum:rgbd_dataset_freiburg2_desk",
    summary: "a folder of JPEG or PNG images with a calibration, or a dataset; the layout is recognized, or said: \
              images:DIR, tum:DIR, euroc:DIR, kitti:DIR, icl:DIR, zurich:DIR",
    is_live: false,
    is_robot: |_| false,
    problem: always_usable,
    claims: Path::is_dir,
    frames: Way { honors: |_| vec![Camera, Mount, Start, End, Stride, Frames, Fps], open: frames },
    images: Way { honors: |_| vec![Camera, Start, End, Stride, Frames, Scale, Fps], open: images },
    pictures: Way { honors: |_| vec![Camera, Start, End, Stride, Frames, Fps], open: pictures },
};

fn sequence_options(request: &Request<'_>) -> SequenceOptions {
    let options = request.options;
    let scheme = request.address.scheme();
    SequenceOptions {
        range: options.range,
        scale: options.scale,
        most_side_px: options.usual.most_side_px,
        calibration: options.camera.clone(),
        camera: options.usual.camera,
        rate_hz: options.rate_hz,
        layout: sequence_layouts().map(|(key, _)| key).find(|key| *key == scheme),
    }
}

fn images(request: &Request<'_>) -> Result<OpenImages, SourcesError> {
    let folder = Path::new(request.address.rest());
    let Sequence { images, truth, warnings, .. } = open_sequence(folder, &sequence_options(request))?;
    Ok(OpenImages { images: Box::new(images), truth, warnings })
}

fn pictures(request: &Request<'_>) -> Result<OpenPictures, SourcesError> {
    let folder = Path::new(request.address.rest());
    let mut listing = list_sequence(folder, &sequence_options(request))?;
    let size_px = listing.begin_with_usual_size(folder)?;
    Ok(pictures_of(listing, |pictures| pictures.of_size(size_px)))
}

fn pictures_of(listing: Listing, chosen: impl FnOnce(FilePictures) -> FilePictures) -> OpenPictures {
    let Listing { images, calibration, skipped, mut warnings, .. } = listing;
    // Pictures need no calibration; a broken one is worth a word.
    if let Err(error) = &calibration
        && !matches!(error, FileError::NoCamera { .. })
    {
        warnings.push(format!("no calibration: {error}"));
    }
    let pictures = Box::new(chosen(FilePictures::new(images, skipped)));
    OpenPictures { pictures, calibration: calibration.ok(), warnings }
}

fn frames(request: &Request<'_>) -> Result<OpenFrames, SourcesError> {
    // The range is that of the frames, which follow.
    let options = SequenceOptions { range: SequenceRange::default(), ..sequence_options(request) };
    let folder = Path::new(request.address.rest());
    let mut listing = list_sequence(folder, &options)?;
    listing.begin_with_usual_size(folder)?;
    // A size that others have for good ends them.
    frames_of_pictures(request, pictures_of(listing, |pictures| pictures))
}
