//! Live topics of ROS 2: a robot, or a simulator of one.

use super::{SourceKind, claims_nothing};
use crate::{OpenFrames, OpenImages, OpenPictures, SourceOptions, SourcesError, open::Request};

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
    frames,
    images,
    pictures,
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
    use visloc_data::{bag::BagTopics, sequence::Calibration};
    use visloc_ros2::{LiveFrames, LivePictures, LiveSettings, NodeSettings};

    use super::*;
    use crate::adapt::{frames_of_pictures, images_of_pictures};

    pub(super) fn problem(_: &SourceOptions) -> Option<String> {
        None
    }

    /// The topic behind the colon wins over the one in the settings.
    fn settings(request: &Request<'_>) -> Result<LiveSettings, SourcesError> {
        let SourceOptions { topics, domain_id, patience_secs, .. } = request.options;
        let mut topics: BagTopics = topics.clone();
        let image = request.address.rest();
        if !image.is_empty() {
            if !image.starts_with('/') {
                return request
                    .cannot(format!("expected a topic such as /camera/image_raw, found '{image}'"));
            }
            image.clone_into(&mut topics.image);
        }
        let node =
            NodeSettings { domain_id: *domain_id, name: format!("visloc_input_{}", std::process::id()) };
        Ok(LiveSettings { node, topics, patience_secs: *patience_secs })
    }

    /// With a mount there is no need for tf.
    pub(super) fn frames(request: &Request<'_>) -> Result<OpenFrames, SourcesError> {
        if request.options.mount.is_some() {
            return frames_of_pictures(request, pictures(request)?);
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
            Some(_) => None,
            None => pictures.wait_for_camera()?,
        };
        let topic = &request.options.topics.camera_info;
        let calibration = calibration.map(|camera| (Calibration::of(&camera), topic.into()));
        Ok(OpenPictures { pictures: Box::new(pictures), calibration, warnings: Vec::new() })
    }
}

use live::{frames, images, pictures, problem};
