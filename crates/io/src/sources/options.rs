//! How a source is opened, and which kind of source honors what.

use std::{
    f64::consts::PI,
    path::{Path, PathBuf},
};

use visloc_core::geom::{Camera, Mount};

use super::source_option::{FORWARD_M, HEIGHTS_M, PATIENCES_SECS, RATES_HZ, SourceOption};
use crate::{
    bag::{BagTopics, ImageQos, TopicRole},
    sequence::{SCALES, SequenceRange},
    sources::SourcesError,
};

/// How a source is opened. What is `None`, or a range of everything, was not asked for. What was asked for is honored, or
/// the source refuses to be opened: see [`SourceOption`].
#[derive(Debug, Clone, Default)]
pub struct SourceOptions {
    /// Topics and frames of bags and of live topics.
    pub topics: TopicOptions,
    /// Calibration of the camera, over what the source itself says.
    pub camera: Option<PathBuf>,
    /// Where the camera is on the robot, over what the source itself says.
    pub mount: Option<Mount>,
    /// Description of the robot (URDF), over what the source itself says.
    pub urdf: Option<PathBuf>,
    /// Which images are used.
    pub range: SequenceRange,
    /// Size of gray images as a factor; the camera is adapted.
    pub scale: Option<f64>,
    /// Images a second: of folders without times, of videos in place of theirs, and what cameras are asked for.
    pub rate_hz: Option<f64>,
    /// Seed of a simulation; 1 if absent.
    pub seed: Option<u64>,
    /// Threads of a simulation; [`Usual::num_threads`] if absent.
    pub num_threads: Option<usize>,
    /// A live source from which nothing comes for so long ends, seconds; without it is waited on.
    pub patience_secs: Option<f64>,
    /// The program that decodes video; `ffmpeg` if absent.
    pub ffmpeg: Option<PathBuf>,
    /// How images of live topics are asked for; best effort if absent.
    pub image_qos: Option<ImageQos>,
    /// Domain of live topics; [`Usual::domain_id`] if absent.
    pub domain_id: Option<u16>,
    /// What is taken where nothing was asked for.
    pub usual: Usual,
    /// What whoever opens the source honors itself, so that a source without use for it need not refuse it: a seed that
    /// an algorithm takes too, names of topics that are written.
    pub honored_elsewhere: Vec<SourceOption>,
}

visloc_core::with_defaults! {
    /// What is taken where nothing was asked for. A source that has no use for it passes over it.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Usual {
        /// Threads of a simulation.
        pub num_threads: usize = 1,
        /// Most frames that will be taken from a simulation; it prepares no more.
        pub max_frames: Option<usize> = None,
        /// Longer side of gray images that are handed out as they are, pixels: larger ones are shrunk by a whole number.
        pub most_side_px: Option<u32> = None,
        /// Camera of gray images that come without a word about theirs.
        pub camera: Option<Camera> = None,
        /// Domain of live topics, for instance `ROS_DOMAIN_ID` of the environment.
        pub domain_id: u16 = 0,
        /// How long a gray image of a live source may wait while those before it are worked on, seconds: then only the newest
        /// counts, as it does from the start with 0.
        pub backlog_secs: f64 = 0.0,
    }
}

/// Names of topics and frames that were asked for. An empty name of a topic means: do not read it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TopicOptions {
    /// All names at once.
    pub all: Option<BagTopics>,
    /// Images; as the following, over `all`.
    pub image: Option<String>,
    /// Images of the robot's further cameras.
    pub more_images: Vec<String>,
    /// Calibration.
    pub camera_info: Option<String>,
    /// Odometry.
    pub odometry: Option<String>,
    /// Where the robot really is.
    pub ground_truth: Option<String>,
    /// Frame of the robot on the ground.
    pub base_frame: Option<String>,
    /// Optical frame of the camera.
    pub camera_frame: Option<String>,
}

impl TopicOptions {
    /// All names: the usual ones where nothing was asked for.
    pub fn names(&self) -> BagTopics {
        let mut names = self.all.clone().unwrap_or_default();
        let Self {
            all: _,
            image,
            more_images,
            camera_info,
            odometry,
            ground_truth,
            base_frame,
            camera_frame,
        } = self;
        if image.is_some() {
            names.more_images.clone_from(more_images);
        }
        for (given, name) in [
            (image, &mut names.image),
            (camera_info, &mut names.camera_info),
            (odometry, &mut names.odometry),
            (ground_truth, &mut names.ground_truth),
            (base_frame, &mut names.base_frame),
        ] {
            if let Some(given) = given {
                name.clone_from(given);
            }
        }
        if camera_frame.is_some() {
            names.camera_frame.clone_from(camera_frame);
        }
        names
    }

    /// What was asked for one by one.
    pub fn named(&self) -> Vec<TopicRole> {
        let all = [
            (&self.image, TopicRole::Image),
            (&self.camera_info, TopicRole::CameraInfo),
            (&self.odometry, TopicRole::Odometry),
            (&self.ground_truth, TopicRole::GroundTruth),
        ];
        all.into_iter().filter_map(|(name, role)| name.as_ref().map(|_| role)).collect()
    }
}

/// What a source is opened for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// All that a robot senses.
    Frames,
    /// Gray images of a calibrated camera.
    Images,
    /// Pictures of any camera.
    Pictures,
}

impl Purpose {
    /// Every purpose.
    pub const ALL: [Self; 3] = [Self::Frames, Self::Images, Self::Pictures];
}

impl SourceOptions {
    /// What was asked for.
    pub fn given(&self) -> impl Iterator<Item = SourceOption> {
        // A new option has to be named here.
        let Self {
            topics:
                TopicOptions {
                    all,
                    image,
                    more_images: _,
                    camera_info,
                    odometry,
                    ground_truth,
                    base_frame,
                    camera_frame,
                },
            camera,
            mount,
            urdf,
            range: SequenceRange { start, end, stride, most },
            scale,
            rate_hz,
            seed,
            num_threads,
            patience_secs,
            image_qos,
            ffmpeg,
            domain_id,
            usual: _,
            honored_elsewhere: _,
        } = self;
        let whole = SequenceRange::default();
        let is_given = [
            (SourceOption::Camera, camera.is_some()),
            (SourceOption::Mount, mount.is_some()),
            (SourceOption::Urdf, urdf.is_some()),
            (SourceOption::Topics, all.is_some()),
            (SourceOption::ImageTopic, image.is_some()),
            (SourceOption::CameraInfoTopic, camera_info.is_some()),
            (SourceOption::OdometryTopic, odometry.is_some()),
            (SourceOption::TruthTopic, ground_truth.is_some()),
            (SourceOption::BaseFrame, base_frame.is_some()),
            (SourceOption::CameraFrame, camera_frame.is_some()),
            (SourceOption::Start, *start != whole.start),
            (SourceOption::End, end.is_some()),
            (SourceOption::Stride, *stride != whole.stride),
            (SourceOption::Frames, most.is_some()),
            (SourceOption::Scale, scale.is_some()),
            (SourceOption::Fps, rate_hz.is_some()),
            (SourceOption::Seed, seed.is_some()),
            (SourceOption::Threads, num_threads.is_some()),
            (SourceOption::Patience, patience_secs.is_some()),
            (SourceOption::ImageQos, image_qos.is_some()),
            (SourceOption::Ffmpeg, ffmpeg.is_some()),
            (SourceOption::RosDomain, domain_id.is_some()),
        ];
        is_given.into_iter().filter(|(_, is_given)| *is_given).map(|(option, _)| option)
    }

    /// Refuses options that the source has no use for, that contradict each other or that have senseless values.
    pub(crate) fn check(
        &self,
        source: &str,
        kind: &str,
        purpose: Purpose,
        honored: &[SourceOption],
    ) -> Result<(), SourcesError> {
        let refuse = |option: SourceOption, reason: &str| {
            let (flag, reason) = (option.flag(), format!("{source} ({kind}): {reason}"));
            Err(SourcesError::Refused { flag, reason })
        };
        let is_elsewhere = |option: &SourceOption| self.honored_elsewhere.contains(option);
        for option in self.given().filter(|option| !is_elsewhere(option)) {
            if !honored.contains(&option) {
                return refuse(option, option.reason(purpose));
            }
            if let Some(winner) = self.loses_to(option) {
                return refuse(option, &format!("{winner} is used in place of it; leave one of the two out"));
            }
        }
        if honored.contains(&SourceOption::ImageTopic) {
            self.check_cameras(purpose).or_else(|reason| refuse(SourceOption::ImageTopic, &reason))?;
        }
        self.check_numbers()
    }

    /// Whether several cameras can be used, if they are asked for; otherwise why not.
    fn check_cameras(&self, purpose: Purpose) -> Result<(), String> {
        let names = self.topics.names();
        let num_cameras = 1 + names.more_images.len();
        if num_cameras == 1 {
            return Ok(());
        }
        if let Some(twice) = names.more_images.iter().enumerate().find_map(|(i, topic)| {
            (*topic == names.image || names.more_images[..i].contains(topic)).then_some(topic)
        }) {
            return Err(format!("expected one topic for each camera, found '{twice}' twice"));
        }
        if purpose != Purpose::Frames {
            return Err(format!(
                "expected one topic, found {num_cameras}: this takes the images of one camera"
            ));
        }
        let of_one = [
            (SourceOption::Camera, self.camera.is_some()),
            (SourceOption::Mount, self.mount.is_some()),
            (SourceOption::CameraInfoTopic, self.topics.camera_info.is_some()),
            (SourceOption::CameraFrame, self.topics.camera_frame.is_some()),
        ];
        match of_one.into_iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) => Err(format!(
                "{num_cameras} topics, but {} is of one camera; leave it out: each camera is read with the calibration beside its images, in the \
                 frame that they name",
                option.flag()
            )),
            None => Ok(()),
        }
    }

    /// The option that makes another one of no use.
    fn loses_to(&self, option: SourceOption) -> Option<&'static str> {
        let names_calibration = self.topics.camera_info.as_ref().is_some_and(|name| !name.is_empty());
        match option {
            SourceOption::CameraInfoTopic if names_calibration && self.camera.is_some() => {
                Some(SourceOption::Camera.flag())
            }
            SourceOption::BaseFrame | SourceOption::CameraFrame | SourceOption::Urdf
                if self.mount.is_some() =>
            {
                Some(SourceOption::Mount.flag())
            }
            _ => None,
        }
    }

    fn check_numbers(&self) -> Result<(), SourcesError> {
        let in_range = |option: SourceOption, value: Option<f64>, (least, most): (f64, f64)| match value {
            Some(value) if !(least..=most).contains(&value) => Err(SourcesError::Refused {
                flag: option.flag(),
                reason: format!("expected a number from {least} to {most}, found {value:?}"),
            }),
            _ => Ok(()),
        };
        if self.range.is_empty() {
            let reason = "expected a place behind that of --from".to_owned();
            return Err(SourcesError::Refused { flag: SourceOption::End.flag(), reason });
        }
        in_range(SourceOption::Scale, self.scale, SCALES)?;
        in_range(SourceOption::Fps, self.rate_hz, RATES_HZ)?;
        in_range(SourceOption::Patience, self.patience_secs, PATIENCES_SECS)?;
        if let Some(Mount { height_m, forward_m, tilt_rad, pan_rad, roll_rad }) = self.mount {
            in_range(SourceOption::Mount, Some(height_m), HEIGHTS_M)?;
            in_range(SourceOption::Mount, Some(forward_m), FORWARD_M)?;
            for angle_rad in [tilt_rad, pan_rad, roll_rad] {
                in_range(SourceOption::Mount, Some(angle_rad), (-PI, PI))?;
            }
        }
        Ok(())
    }

    /// Size of gray images as a factor.
    pub(crate) fn scale(&self) -> f64 {
        self.scale.unwrap_or(1.0)
    }

    /// Seed of a simulation.
    pub(crate) fn seed(&self) -> u64 {
        self.seed.unwrap_or(1)
    }

    /// Threads of a simulation.
    pub(crate) fn num_threads(&self) -> usize {
        self.num_threads.unwrap_or(self.usual.num_threads)
    }

    /// The program that decodes video.
    pub(crate) fn ffmpeg(&self) -> &Path {
        self.ffmpeg.as_deref().unwrap_or(Path::new("ffmpeg"))
    }

    /// Domain of live topics.
    pub fn domain_id(&self) -> u16 {
        self.domain_id.unwrap_or(self.usual.domain_id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{sequence::Bound, sources::KINDS};

    #[test]
    fn every_option_is_listed_once_and_honored_somewhere() {
        let mut flags: Vec<&str> = SourceOption::ALL.iter().map(|option| option.flag()).collect();
        flags.sort_unstable();
        flags.dedup();
        assert_eq!(flags.len(), SourceOption::ALL.len());
        for option in SourceOption::ALL {
            let honors = |purpose| KINDS.iter().any(|kind| kind.honors(purpose, "").contains(&option));
            assert!(Purpose::ALL.into_iter().any(honors), "{option:?}");
        }
    }

    #[test]
    fn what_cannot_be_honored_is_refused_with_its_name() {
        let check = |options: &SourceOptions| {
            let honored = [SourceOption::Scale, SourceOption::CameraInfoTopic, SourceOption::Camera];
            options.check("x", "kind", Purpose::Images, &honored).map_err(|error| error.to_string())
        };
        let seeded = SourceOptions { seed: Some(2), ..SourceOptions::default() };
        assert_eq!(check(&seeded).unwrap_err(), "--seed: x (kind): nothing in it is random; leave it out");
        let ends = [SourceOption::Start, SourceOption::End];
        for (start, end) in [
            (Bound::Secs(1.0), Bound::Secs(0.5)),
            (Bound::Secs(1.0), Bound::Secs(1.0)),
            (Bound::Frame(5), Bound::Frame(5)),
        ] {
            let range = SequenceRange { start, end: Some(end), ..SequenceRange::default() };
            let empty = SourceOptions { range, ..SourceOptions::default() };
            let error = empty.check("x", "kind", Purpose::Images, &ends).unwrap_err().to_string();
            assert!(error.starts_with("--until: expected a place behind that of --from"), "{error}");
        }
        let elsewhere = vec![SourceOption::Seed];
        assert!(check(&SourceOptions { honored_elsewhere: elsewhere, ..seeded }).is_ok());
        let twice = |name: &str| SourceOptions {
            camera: Some("c.toml".into()),
            topics: TopicOptions { camera_info: Some(name.into()), ..TopicOptions::default() },
            ..SourceOptions::default()
        };
        assert!(check(&twice("/info")).unwrap_err().contains("--camera is used in place of it"));
        assert!(check(&twice("")).is_ok(), "not to read it is no contradiction");
        for scale in [0.0, -1.0, 1e9, 1e300, f64::NAN, f64::INFINITY] {
            let error = check(&SourceOptions { scale: Some(scale), ..SourceOptions::default() }).unwrap_err();
            assert!(error.starts_with("--scale: expected a number from 0.05 to 4"), "{error}");
            assert!(error.len() < 80, "{error}");
        }
    }
}
