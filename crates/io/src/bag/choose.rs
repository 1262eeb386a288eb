//! Which topics are meant where nobody named them.

use std::path::Path;

use crate::bag::{BagError, BagTopics, TopicInfo, TopicRole, topics::camera_info_beside};

/// The topics that are read. Where a topic has its default name and the recording has none of that name, the only one of a
/// fitting type is taken, for the calibration the one beside the images.
pub(super) fn choose_topics(available: &[TopicInfo], topics: &BagTopics) -> BagTopics {
    let mut chosen = topics.clone();
    let only = |role| match &candidates(available, topics, role)[..] {
        [only] => Some(only.topic.clone()),
        _ => None,
    };
    if let Some(image) = only(TopicRole::Image) {
        chosen.image = image;
    }
    let beside = beside(&chosen.image, &candidates(available, topics, TopicRole::CameraInfo));
    if let Some(camera_info) = beside.or_else(|| only(TopicRole::CameraInfo)) {
        chosen.camera_info = camera_info;
    }
    if let Some(odometry) = only(TopicRole::Odometry) {
        chosen.odometry = odometry;
    }
    for (role, name) in [
        (TopicRole::JointStates, &mut chosen.joint_states),
        (TopicRole::RobotDescription, &mut chosen.robot_description),
    ] {
        if let Some(topic) = only(role) {
            *name = topic;
        } else if *name == BagTopics::default().name(role)
            && available.iter().any(|info| info.topic == *name && !info.fits(role))
        {
            // Something else happens to have the usual name.
            name.clear();
        }
    }
    chosen
}

/// The topics of a further camera: all but pictures, calibration and frame are those of the first one.
pub(super) fn further_camera(available: &[TopicInfo], first: &BagTopics, image: &str) -> BagTopics {
    let is_calibration =
        |info: &&TopicInfo| TopicRole::CameraInfo.type_names().contains(&info.type_name.as_str());
    let calibrations: Vec<_> = available.iter().filter(is_calibration).collect();
    BagTopics {
        image: image.to_owned(),
        camera_info: beside(image, &calibrations).unwrap_or_else(|| camera_info_beside(image)),
        camera_frame: None,
        more_images: Vec::new(),
        ..first.clone()
    }
}

/// That it is clear which odometry is meant: without a word a run would do without any.
pub(super) fn check_odometry(
    path: &Path,
    available: &[TopicInfo],
    topics: &BagTopics,
) -> Result<(), BagError> {
    let candidates = candidates(available, topics, TopicRole::Odometry);
    if candidates.len() < 2 {
        return Ok(());
    }
    Err(BagError::SeveralOdometries {
        path: path.to_path_buf(),
        topics: candidates.into_iter().cloned().collect(),
    })
}

/// Topics that can be meant by a default name that the recording does not have. Those without messages count if there are no others.
fn candidates<'a>(available: &'a [TopicInfo], topics: &BagTopics, role: TopicRole) -> Vec<&'a TopicInfo> {
    let name = topics.name(role);
    if name != BagTopics::default().name(role) || available.iter().any(|info| info.topic == name) {
        return Vec::new();
    }
    let all: Vec<_> = available.iter().filter(|info| info.fits(role)).collect();
    let used: Vec<_> = all.iter().copied().filter(|info| info.num_messages > 0).collect();
    if used.is_empty() { all } else { used }
}

/// The one that is nearest above the images: `/eye/camera_info` for `/eye/image_raw/compressed`.
fn beside(image: &str, candidates: &[&TopicInfo]) -> Option<String> {
    let mut space = image;
    while let Some((above, _)) = space.rsplit_once('/') {
        space = above;
        let is_there =
            |info: &&&TopicInfo| info.topic.rsplit_once('/').is_some_and(|(above, _)| above == space);
        let mut found = candidates.iter().filter(is_there);
        if let Some(first) = found.next() {
            return found.next().is_none().then(|| first.topic.clone());
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(topic: &str, type_name: &str) -> TopicInfo {
        TopicInfo {
            topic: topic.into(),
            type_name: type_name.into(),
            message_encoding: "cdr".into(),
            num_messages: 1,
        }
    }

    #[test]
    fn the_only_images_and_what_stands_beside_them() {
        let camera_info = |topic| info(topic, "sensor_msgs/msg/CameraInfo");
        let mut available = vec![
            info("/eye/left/image_raw", "sensor_msgs/msg/Image"),
            camera_info("/eye/left/camera_info"),
            camera_info("/eye/right/camera_info"),
            info("/wheels", "nav_msgs/msg/Odometry"),
        ];
        let chosen = choose_topics(&available, &BagTopics::default());
        assert_eq!(chosen.image, "/eye/left/image_raw");
        assert_eq!(chosen.camera_info, "/eye/left/camera_info");
        assert_eq!(chosen.odometry, "/wheels");
        assert!(check_odometry(Path::new("x"), &available, &BagTopics::default()).is_ok());

        available.push(info("/eye/right/image_raw", "sensor_msgs/msg/Image"));
        available.push(info("/fused", "nav_msgs/msg/Odometry"));
        let chosen = choose_topics(&available, &BagTopics::default());
        assert_eq!(
            (chosen.image, chosen.odometry),
            (BagTopics::default().image, BagTopics::default().odometry)
        );
        let error =
            check_odometry(Path::new("x"), &available, &BagTopics::default()).unwrap_err().to_string();
        assert!(error.contains("/wheels") && error.contains("--odometry-topic"), "{error}");
        let named = BagTopics {
            image: "/eye/right/image_raw".into(),
            odometry: String::new(),
            ..BagTopics::default()
        };
        assert_eq!(choose_topics(&available, &named).camera_info, "/eye/right/camera_info");
        let further = further_camera(&available, &named, "/eye/left/image_raw");
        assert_eq!(further.camera_info, "/eye/left/camera_info");
        assert_eq!(further_camera(&available, &named, "/mouth/image").camera_info, "/mouth/camera_info");
        assert!(check_odometry(Path::new("x"), &available, &named).is_ok());
    }

    #[test]
    fn joints_and_description_of_a_robot_with_a_name() {
        let mut available = vec![
            info("/nao/joint_states", "sensor_msgs/msg/JointState"),
            info("/nao/robot_description", "std_msgs/msg/String"),
            info("/nao/chatter", "std_msgs/msg/String"),
        ];
        let chosen = choose_topics(&available, &BagTopics::default());
        assert_eq!(chosen.joint_states, "/nao/joint_states");
        assert_eq!(chosen.robot_description, "/nao/robot_description");
        available.push(info("/joint_states", "my_msgs/msg/Joints"));
        assert_eq!(choose_topics(&available, &BagTopics::default()).joint_states, "");
        let none = BagTopics { joint_states: String::new(), ..BagTopics::default() };
        assert_eq!(choose_topics(&available, &none).joint_states, "");
    }

    #[test]
    fn what_is_there_under_its_name_is_taken() {
        let available = [
            info("/camera/image/compressed", "sensor_msgs/msg/CompressedImage"),
            info("/camera/other", "sensor_msgs/msg/Image"),
            info("/odom", "nav_msgs/msg/Odometry"),
            info("/odom2", "nav_msgs/msg/Odometry"),
        ];
        assert_eq!(choose_topics(&available, &BagTopics::default()), BagTopics::default());
        assert!(check_odometry(Path::new("x"), &available, &BagTopics::default()).is_ok());
    }
}
