//! Recordings of ROS 2 and ROS 1.

use std::path::Path;

use visloc_base::files;
use visloc_data::{
    bag::{BagPictures, BagReader, BagTopics},
    sequence::Calibration,
};

use super::{SourceKind, always_usable, has_extension};
use crate::{OpenFrames, OpenImages, OpenPictures, SourcesError, adapt::images_of_pictures, open::Request};

pub(super) const KIND: SourceKind = SourceKind {
    name: "ROS bag",
    schemes: &["bag"],
    form: "FILE.mcap|db3|bag",
    example: "testdata/R1-excerpt.mcap",
    summary: "a recording of ROS 2 in MCAP or SQLite (.db3), a file or a folder of rosbag2, or one of ROS 1 (.bag); also bag:PATH",
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
        return has_extension(path, &["mcap", "db3", "bag"]);
    }
    let has_bag = |entry: std::fs::DirEntry| has_extension(&entry.path(), &["mcap", "db3"]);
    let is_bag = |mut entries: std::fs::ReadDir| entries.any(|entry| entry.is_ok_and(has_bag));
    path.is_dir() && (is_rosbag_metadata(path) || std::fs::read_dir(path).is_ok_and(is_bag))
}

fn is_rosbag_metadata(folder: &Path) -> bool {
    let text = files::read_text(&folder.join("metadata.yaml"));
    text.is_ok_and(|text| text.contains("rosbag2_bagfile_information"))
}

fn frames(request: &Request<'_>) -> Result<OpenFrames, SourcesError> {
    let bag = BagReader::open(request.address.rest(), request.options.topics.clone())?;
    let warnings = chosen(request, bag.topics());
    Ok(OpenFrames { frames: Box::new(bag), map: None, warnings })
}

fn images(request: &Request<'_>) -> Result<OpenImages, SourcesError> {
    images_of_pictures(request, pictures(request)?)
}

fn pictures(request: &Request<'_>) -> Result<OpenPictures, SourcesError> {
    let path = request.address.rest();
    let pictures = BagPictures::open(path, &request.options.topics)?;
    let calibration = pictures.camera().map(|camera| (Calibration::of(camera), path.into()));
    let found = BagTopics { image: pictures.topic().into(), ..request.options.topics.clone() };
    let warnings = chosen(request, &found);
    Ok(OpenPictures { pictures: Box::new(pictures), calibration, warnings })
}

/// What was taken for topics that nobody named and that the recording does not have.
fn chosen(request: &Request<'_>, found: &BagTopics) -> Vec<String> {
    let asked = &request.options.topics;
    let roles = [
        ("images", &asked.image, &found.image),
        ("calibration", &asked.camera_info, &found.camera_info),
        ("odometry", &asked.odometry, &found.odometry),
    ];
    let changed = roles.into_iter().filter(|(_, asked, found)| asked != found && !found.is_empty());
    changed
        .map(|(what, asked, found)| format!("{what}: from '{found}', since there is no '{asked}'"))
        .collect()
}
