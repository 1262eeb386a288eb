//! Live topics of ROS 2: a robot, or a simulator of one.

use super::{SourceKind, Way, claims_nothing};
use crate::sources::{
    OpenFrames, OpenImages, OpenPictures, SourceOption,
    SourceOption::{
        Camera, CameraInfoTopic, End, Frames, ImageQos, ImageTopic, Mount, Patience, RosDomain, Scale, Start,
        Stride, Topics, Urdf,
    },
    SourceOptions, SourcesError,
    adapt::{frames_in_range, pictures_in_range},
    open::Request,
};

pub(super) const KIND: SourceKind = SourceKind {
    name: "ROS 2 topics",
    schemes: &["ros2"],
    form: "ros2:TOPIC",
    example: "ros2:/camera/image_raw",
    summary: "live topics of a robot or simulator: images there, the rest as in --topics; no ROS installation needed",
    is_live: true,
    is_robot: |_| true,
    problem,
    claims: claims_nothing,
    frames: Way {
        honors: |_| {
            let robot = [Camera, Mount, Urdf, Start, End, Stride, Frames];
            [&robot[..], &SourceOption::TOPICS, &[Patience, ImageQos, RosDomain]].concat()
        },
        open: |request| frames_in_range(request, frames(request)?),
    },
    images: Way {
        honors: |_| {
            let topics = [Camera, Topics, ImageTopic, CameraInfoTopic];
            [&topics[..], &[Start, End, Stride, Frames, Scale], &[Patience, ImageQos, RosDomain]].concat()
        },
        open: images,
    },
    pictures: Way {
        honors: |_| {
            let topics = [Camera, Topics, ImageTopic, CameraInfoTopic];
            [&topics[..], &[Start, End, Stride, Frames], &[Patience, ImageQos, RosDomain]].concat()
        },
        open: |request| pictures_in_range(request, pictures(request)?),
    },
};

#[cfg(not(feature = "ros2"))]
mod live {
    use super::*;

    pub(super) fn problem(_: &SourceOptions) -> Option<String> {
        Some("this visloc was built without the feature ros2".into())
    }

    fn not_built<T>(request: &Request<'_>) -> Result<T, SourcesError> {
        Err(SourcesError::NotBuilt { argument: request.argument(), feature: "ros2" })
    }

    pub(super) fn frames(request: &Request<'_>) -> Result<OpenFrames, SourcesError> {
        not_built(request)
    }

    pub(super) fn images(request: &Request<'_>) -> Result<OpenImages, SourcesError> {
        not_built(request)
    }

    pub(super) fn pictures(request: &Request<'_>) -> Result<OpenPictures, SourcesError> {
        not_built(request)
    }
}

#[cfg(feature = "ros2")]
mod live {
    use super::*;
    use crate::{
        ros2::{LiveFrames, LivePictures, LiveSettings, NodeSettings},
        sequence::{Calibration, read_calibration},
        sources::adapt::images_of_pictures,
        urdf::read_robot_description,
    };
    use std::sync::Arc;

    pub(super) fn problem(_: &SourceOptions) -> Option<String> {
        None
    }

    /// The topic behind the colon wins over the one in the settings.
    fn settings(request: &Request<'_>) -> Result<LiveSettings, SourcesError> {
        let SourceOptions { topics, camera, mount, urdf, patience_secs, image_qos, usual, .. } =
            request.options;
        let is_named_twice = topics.image.is_some();
        let mut topics = request.topics();
        if !topics.more_images.is_empty() {
            return request.cannot(
                "--image-topic: expected one topic: live images are taken of one camera; record a bag of all (visloc record), which visloc \
                 localize reads with several",
            );
        }
        let image = request.address.rest();
        if !image.is_empty() {
            if !image.starts_with('/') {
                return request
                    .cannot(format!("expected a topic such as /camera/image_raw, found '{image}'"));
            }
            if is_named_twice {
                return request.cannot(
                    "--image-topic: the images' topic stands behind the colon already; leave one out",
                );
            }
            image.clone_into(&mut topics.image);
        }
        let node = NodeSettings {
            domain_id: request.options.domain_id(),
            name: format!("visloc_input_{}", std::process::id()),
        };
        Ok(LiveSettings {
            topics,
            patience_secs: *patience_secs,
            image_qos: image_qos.unwrap_or_default(),
            backlog_secs: usual.backlog_secs,
            calibration: camera
                .as_ref()
                .map(|path| Ok::<_, SourcesError>((read_calibration(path)?, path.clone())))
                .transpose()?,
            robot_from_camera: mount.map(|mount| mount.robot_from_camera()),
            robot: urdf.as_deref().map(read_robot_description).transpose()?.map(Arc::new),
            ..LiveSettings::new(node)
        })
    }

    pub(super) fn frames(request: &Request<'_>) -> Result<OpenFrames, SourcesError> {
        let (topics, SourceOptions { camera, mount, urdf, .. }) = (request.topics(), request.options);
        if topics.camera_info.is_empty() && camera.is_none() {
            return Err(SourcesError::NoCamera { argument: request.argument() });
        }
        let has_poses =
            [&topics.tf, &topics.tf_static, &topics.robot_description].iter().any(|name| !name.is_empty());
        if !has_poses && mount.is_none() && urdf.is_none() {
            return Err(SourcesError::NoMount { argument: request.argument() });
        }
        let frames = LiveFrames::open(&settings(request)?, request.host)?;
        Ok(OpenFrames { frames: Box::new(frames), map: None, warnings: Vec::new() })
    }

    pub(super) fn images(request: &Request<'_>) -> Result<OpenImages, SourcesError> {
        let open = pictures(request)?;
        images_of_pictures(request, open)
    }

    pub(super) fn pictures(request: &Request<'_>) -> Result<OpenPictures, SourcesError> {
        let mut pictures = LivePictures::open(&settings(request)?, request.host)?;
        let calibration = match &request.options.camera {
            None if !request.topics().camera_info.is_empty() => pictures.wait_for_camera()?,
            _ => None,
        };
        let topic = request.topics().camera_info;
        let calibration = calibration.map(|camera| (Calibration::of(&camera), topic.into()));
        Ok(OpenPictures { pictures: Box::new(pictures), calibration, warnings: Vec::new() })
    }
}

use live::{frames, images, pictures, problem};
