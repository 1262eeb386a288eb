//! Recordings of ROS 2 and ROS 1.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use visloc_core::{Source, SourceFrame, files, geom::Camera as CameraModel};

use super::{SourceKind, Way, always_usable, has_extension, video::is_video};
use crate::{
    bag::{
        BagPictures, BagReader, BagTopics, GivenInputs, TopicRole, files_without_metadata, recorded_topics,
    },
    sequence::{Calibration, fit_calibration, is_image, read_calibration},
    sources::{
        OpenFrames, OpenImages, OpenPictures, SourceOption,
        SourceOption::{
            Camera, CameraInfoTopic, End, Frames, ImageTopic, Mount, Scale, Start, Stride, Topics, Urdf,
        },
        SourcesError, TopicOptions,
        adapt::{
            CameraFrames, ManyCameras, frames_in_range, gray_of_frames, images_of_gray, images_of_pictures,
            pictures_in_range,
        },
        open::Request,
    },
    urdf::{RobotDescription, read_robot_description},
};

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
    frames: Way {
        honors: |_| {
            [&[Camera, Mount, Urdf][..], &SourceOption::TOPICS, &[Start, End, Stride, Frames]].concat()
        },
        open: |request| frames_in_range(request, frames(request)?),
    },
    images: Way {
        honors: |_| {
            [&[Camera, Mount, Urdf][..], &SourceOption::TOPICS, &[Start, End, Stride, Frames, Scale]].concat()
        },
        open: images,
    },
    pictures: Way {
        honors: |_| vec![Camera, Topics, ImageTopic, CameraInfoTopic, Start, End, Stride, Frames],
        open: |request| pictures_in_range(request, pictures(request)?),
    },
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
    let topics = request.topics();
    if !topics.more_images.is_empty() {
        let given = GivenInputs {
            robot: given_robot(request)?,
            named: request.options.topics.named(),
            ..GivenInputs::default()
        };
        let readers = BagReader::open_cameras(request.address.rest(), &topics, &given)?;
        let warnings = chosen(request, readers[0].topics());
        let of_camera = [TopicRole::Image, TopicRole::CameraInfo];
        let in_common = TopicRole::ALL.into_iter().filter(|role| !of_camera.contains(role));
        let mut in_common: Vec<_> = in_common.map(|role| topics.name(role).to_owned()).collect();
        in_common.push(TopicRole::RobotDescription.meaning().to_owned());
        let sources =
            readers.into_iter().map(|reader| Box::new(reader) as Box<dyn Source<SourceFrame>>).collect();
        return Ok(OpenFrames {
            frames: Box::new(ManyCameras::new(sources, in_common)),
            map: None,
            warnings,
        });
    }
    let mut warnings = Vec::new();
    let bag = reader(request, &mut warnings)?;
    Ok(OpenFrames { frames: Box::new(bag), map: None, warnings })
}

fn reader(request: &Request<'_>, warnings: &mut Vec<String>) -> Result<BagReader, SourcesError> {
    let given = GivenInputs {
        camera: given_camera(request, warnings)?,
        robot_from_camera: request.options.mount.map(|mount| mount.robot_from_camera()),
        robot: given_robot(request)?,
        named: request.options.topics.named(),
    };
    let bag = BagReader::open_with(request.address.rest(), &request.topics(), given)?;
    warnings.extend(chosen(request, bag.topics()));
    let has =
        |name: &str| bag.available_topics().iter().any(|topic| topic.topic == name && topic.num_messages > 0);
    if request.options.urdf.is_some() && has(&bag.topics().tf) && !has(&bag.topics().joint_states) {
        warnings.push(
            "--urdf: transforms come and no positions of joints, so the description tells fixed frames only, and of these what no transform tells"
                .to_owned(),
        );
    }
    Ok(bag)
}

/// The user's description of the robot.
fn given_robot(request: &Request<'_>) -> Result<Option<Arc<RobotDescription>>, SourcesError> {
    Ok(request.options.urdf.as_deref().map(read_robot_description).transpose()?.map(Arc::new))
}

/// The user's calibration for the size of the first image.
fn given_camera(
    request: &Request<'_>,
    warnings: &mut Vec<String>,
) -> Result<Option<CameraModel>, SourcesError> {
    let Some(path) = &request.options.camera else { return Ok(None) };
    let calibration = read_calibration(path)?;
    let topics = BagTopics { camera_info: String::new(), ..request.topics() };
    let mut pictures = BagPictures::open(request.address.rest(), &topics)?;
    let first = pictures.next_item().ok_or_else(|| request.empty(String::new()))??;
    let size_px = (first.image.width(), first.image.height());
    Ok(Some(fit_calibration(&calibration, size_px, path, warnings)?))
}

fn images(request: &Request<'_>) -> Result<OpenImages, SourcesError> {
    // A file that cannot be read is told here: what stands in the way of a robot that nobody asked for only means that there is none.
    given_robot(request)?;
    let fault = match robot(request) {
        Ok(Some((CameraFrames { camera, frames }, warnings))) => {
            let calibration = (Calibration::of(&camera), request.address.rest().into());
            return images_of_gray(request, gray_of_frames(frames), Some(calibration), warnings);
        }
        Ok(None) => None,
        Err(error) => Some(error),
    };
    match (fault, asked_of_robot(request)) {
        (Some(fault), Some(_)) => Err(fault),
        (None, Some(option)) => request.cannot(format!(
            "{} and the like: expected odometry and a camera whose place on the robot matters, found no odometry",
            option.flag()
        )),
        (fault, None) => {
            let mut open = images_of_pictures(request, pictures(request)?)?;
            open.warnings.extend(fault.map(|fault| format!("its odometry is not used: {fault}")));
            Ok(open)
        }
    }
}

/// An option that only a robot with odometry has a use for. An empty name asks for nothing.
fn asked_of_robot(request: &Request<'_>) -> Option<SourceOption> {
    let TopicOptions { odometry, ground_truth, .. } = &request.options.topics;
    request.options.given().find(|option| match option {
        SourceOption::OdometryTopic => odometry.as_deref() != Some(""),
        SourceOption::TruthTopic => ground_truth.as_deref() != Some(""),
        option => [Mount, Urdf, SourceOption::BaseFrame, SourceOption::CameraFrame].contains(option),
    })
}

/// The camera of a robot with odometry, and its frames. `None` if the recording has no odometry: its images are those of any camera.
fn robot(request: &Request<'_>) -> Result<Option<(CameraFrames, Vec<String>)>, SourcesError> {
    let mut warnings = Vec::new();
    let bag = match reader(request, &mut warnings) {
        Err(_) if request.topics().odometry.is_empty() || !has_odometry(request)? => return Ok(None),
        bag => bag?,
    };
    if !bag.available_topics().iter().any(|topic| topic.topic == bag.topics().odometry) {
        return Ok(None);
    }
    let frames = CameraFrames::new(Box::new(bag)).transpose()?;
    Ok(frames.map(|frames| (frames, warnings)))
}

fn has_odometry(request: &Request<'_>) -> Result<bool, SourcesError> {
    let topics = recorded_topics(request.address.rest())?;
    Ok(topics.iter().any(|topic| topic.fits(TopicRole::Odometry)))
}

fn pictures(request: &Request<'_>) -> Result<OpenPictures, SourcesError> {
    let path = request.address.rest();
    let pictures = BagPictures::open(path, &request.topics())?;
    let calibration = pictures.camera().map(|camera| (Calibration::of(camera), path.into()));
    let found = BagTopics { image: pictures.topic().into(), ..request.topics() };
    let warnings = chosen(request, &found);
    Ok(OpenPictures { pictures: Box::new(pictures), calibration, warnings })
}

/// What a folder was taken for, and what was taken for topics that nobody named and that the recording does not have.
fn chosen(request: &Request<'_>, found: &BagTopics) -> Vec<String> {
    let asked = &request.topics();
    let roles = [
        ("images", &asked.image, &found.image),
        ("calibration", &asked.camera_info, &found.camera_info),
        ("odometry", &asked.odometry, &found.odometry),
        ("positions of joints", &asked.joint_states, &found.joint_states),
        ("the robot's description", &asked.robot_description, &found.robot_description),
    ];
    let changed = roles.into_iter().filter(|(_, asked, found)| asked != found && !found.is_empty());
    let changed =
        changed.map(|(what, asked, found)| format!("{what}: from '{found}', since there is no '{asked}'"));
    notes_on_folder(Path::new(request.address.rest())).into_iter().chain(changed).collect()
}

/// What is read as one recording of a folder in which no `metadata.yaml` says what belongs to it, and what is left out.
pub fn notes_on_folder(folder: &Path) -> Vec<String> {
    let Some(read) = files_without_metadata(folder) else { return Vec::new() };
    let mut notes = Vec::new();
    if read.len() > 1 {
        notes.push(format!(
            "{}: no metadata.yaml says what belongs together; read as one recording, in this order: {}",
            folder.display(),
            listed(&read)
        ));
    }
    let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    let could_be_read =
        |path: &PathBuf| has_extension(path, &["mcap", "db3", "bag"]) || is_video(path) || is_image(path);
    let mut left_out: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(could_be_read).collect();
    left_out.retain(|path| !read.contains(path));
    left_out.sort();
    if !left_out.is_empty() {
        notes.push(format!("{}: left out: {}", folder.display(), listed(&left_out)));
    }
    notes
}

/// Names of files without their folder.
fn listed(paths: &[PathBuf]) -> String {
    const MAX_LISTED: usize = 6;
    let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut names: Vec<String> = paths.iter().take(MAX_LISTED).map(name).collect();
    if paths.len() > MAX_LISTED {
        names.push(format!("... ({} files)", paths.len()));
    }
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_says_what_is_read_together_and_what_is_left_out() {
        let cases: [(&[&str], &[&str]); 5] = [
            (&["a.mcap"], &[]),
            (&["a.mcap", "notes.txt"], &[]),
            (&["b.mcap", "a.mcap"], &["read as one recording, in this order: a.mcap, b.mcap"]),
            (&["a.mcap", "a.db3", "clip.mp4", "x.png"], &["left out: a.db3, clip.mp4, x.png"]),
            (&["a.mcap", "b.mcap", "metadata.yaml"], &[]),
        ];
        for (names, expected) in cases {
            let folder = tempfile::tempdir().unwrap();
            names.iter().for_each(|name| std::fs::write(folder.path().join(name), "").unwrap());
            let notes = notes_on_folder(folder.path());
            let is_same = notes.len() == expected.len()
                && notes.iter().zip(expected).all(|(note, expected)| note.ends_with(expected));
            assert!(is_same, "{names:?}: {notes:?}");
        }
        assert_eq!(listed(&vec![PathBuf::from("d/a.mcap"); 9]).matches("a.mcap").count(), 6);
    }
}
