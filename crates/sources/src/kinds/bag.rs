//! Recordings of ROS 2.

use std::path::Path;

use visloc_base::files;
use visloc_data::{
    bag::{BagPictures, BagReader},
    sequence::Calibration,
};

use super::{SourceKind, always_usable, has_extension};
use crate::{OpenFrames, OpenImages, OpenPictures, SourcesError, adapt::images_of_pictures, open::Request};

pub(super) const KIND: SourceKind = SourceKind {
    name: "ROS 2 bag",
    schemes: &["bag"],
    form: "FILE.mcap",
    example: "testdata/R1-excerpt.mcap",
    summary: "a recording in MCAP, a file or a folder of rosbag2; also bag:PATH",
    is_live: false,
    is_robot: |_| true,
    problem: always_usable,
    claims,
    frames,
    images,
    pictures,
};

fn claims(path: &Path) -> bool {
    if path.is_file() {
        return has_extension(path, &["mcap"]);
    }
    let has_bag = |entry: std::fs::DirEntry| has_extension(&entry.path(), &["mcap"]);
    let is_bag = |mut entries: std::fs::ReadDir| entries.any(|entry| entry.is_ok_and(has_bag));
    path.is_dir() && (is_rosbag_metadata(path) || std::fs::read_dir(path).is_ok_and(is_bag))
}

fn is_rosbag_metadata(folder: &Path) -> bool {
    let text = files::read_text(&folder.join("metadata.yaml"));
    text.is_ok_and(|text| text.contains("rosbag2_bagfile_information"))
}

fn frames(request: &Request<'_>) -> Result<OpenFrames, SourcesError> {
    let bag = BagReader::open(request.address.rest(), request.options.topics.clone())?;
    Ok(OpenFrames { frames: Box::new(bag), map: None, warnings: Vec::new() })
}

fn images(request: &Request<'_>) -> Result<OpenImages, SourcesError> {
    images_of_pictures(request, pictures(request)?)
}

fn pictures(request: &Request<'_>) -> Result<OpenPictures, SourcesError> {
    let path = request.address.rest();
    let pictures = BagPictures::open(path, &request.options.topics)?;
    let calibration = pictures.camera().map(|camera| (Calibration::of(camera), path.into()));
    Ok(OpenPictures { pictures: Box::new(pictures), calibration, warnings: Vec::new() })
}
