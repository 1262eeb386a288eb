//! One frame of a robot that is looked for, as messages.

use nalgebra::Vector3;
use serde_json::{Value, json};
use visloc_core::{
    Frame, Truth,
    geom::{Horizon, PlanarPose},
};
use visloc_io::{camera_file::CameraToml, image_codec::encode_jpeg};
use visloc_locate::{
    Estimate, Individual, LOCALIZED_RELIABILITY, Pipeline, StepTimes,
    lineup::Lineup,
    vision::{DropReason, FeatureKind, Percept},
};
use visloc_world::Map;

use super::theory::theoretical_image;
use crate::{MessageBuilder, MessageKind, StudioError};

/// Hypotheses that a page is shown.
const MAX_HYPOTHESES: usize = 40;
/// Particles or exploiters that a page is shown.
const MAX_INDIVIDUALS: usize = 4000;
/// Dropped pixels that a page is shown.
const MAX_DROPPED: usize = 3000;
/// Quality of the images that are sent.
const JPEG_QUALITY: u8 = 85;

/// What is shown of an algorithm after a frame. A copy, so that the algorithm can go on while it is shown.
#[derive(Debug, Clone)]
pub struct ContenderView {
    /// Its name.
    pub name: String,
    /// What it believes.
    pub estimate: Estimate,
    /// What it made of the image.
    pub percept: Percept,
    /// Particles or exploiters, at most `MAX_INDIVIDUALS`.
    pub individuals: Vec<Individual>,
    /// How many of them it weighed.
    pub num_individuals: usize,
    /// Time for the image, milliseconds.
    pub analysis_ms: f64,
    /// Time for the pose, milliseconds.
    pub localizer_ms: f64,
}

impl ContenderView {
    /// Copies what is shown of an algorithm.
    pub fn new(name: &str, pipeline: &Pipeline) -> Self {
        let StepTimes { analysis_ms, localizer_ms } = pipeline.times();
        let localizer = pipeline.localizer();
        let mut individuals = Vec::new();
        localizer.individuals(&mut individuals);
        let every = individuals.len().div_ceil(MAX_INDIVIDUALS).max(1);
        if every > 1 {
            individuals = individuals.into_iter().step_by(every).collect();
        }
        Self {
            name: name.to_owned(),
            estimate: localizer.estimate().clone(),
            percept: pipeline.analyzer().percept().clone(),
            individuals,
            num_individuals: localizer.num_weighed(),
            analysis_ms,
            localizer_ms,
        }
    }

    /// What a state says of it.
    pub(crate) fn fields(&self, truth: Option<Truth>) -> Value {
        let Self { estimate, percept, .. } = self;
        let error = truth.filter(|truth| truth.height_m <= 0.0).map(|truth| {
            let pose = &estimate.world_from_robot;
            let turn = pose.heading_difference_rad(&truth.world_from_robot).abs();
            [pose.distance_m(&truth.world_from_robot), turn.to_degrees()]
        });
        let sigma = [0, 1, 2].map(|i| estimate.covariance[(i, i)].max(0.0).sqrt());
        json!({
            "name": self.name,
            "pose": triple(&estimate.world_from_robot),
            "sigma": sigma,
            "reliability": estimate.reliability,
            "reliability_up_to_symmetry": estimate.reliability_up_to_symmetry,
            "is_localized": estimate.reliability > LOCALIZED_RELIABILITY,
            "likelihood": estimate.likelihood,
            "hypotheses": hypotheses(estimate),
            "error": error,
            "quality": percept.quality,
            "num_kept": percept.pixels.len(),
            "num_dropped": percept.dropped.len(),
            "num_individuals": self.num_individuals,
            "ms": { "image": self.analysis_ms, "pose": self.localizer_ms },
        })
    }
}

/// Everything about one frame.
pub struct LocalizationView<'a> {
    /// The map.
    pub map: &'a Map,
    /// Number of the frame, from 0.
    pub number: u64,
    /// Since the first frame.
    pub secs: f64,
    /// What the robot sensed.
    pub frame: &'a Frame,
    /// Where it was.
    pub truth: Option<Truth>,
    /// The algorithms.
    pub contenders: &'a [ContenderView],
}

impl LocalizationView<'_> {
    /// The state message; `more` is a table that is laid over the header, `likelihood` a grid of likelihoods, if there is one.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn state(&self, more: Value, likelihood: Option<Vec<f64>>) -> Result<Vec<u8>, StudioError> {
        let mut header = json!({
            "number": self.number,
            "secs": self.secs,
            "camera": self.camera_direction(),
            "lens": CameraToml::from(&self.frame.camera),
            "mount": self.mount(),
            "truth": self.truth.map(|truth| json!({
                "pose": triple(&truth.world_from_robot),
                "height_m": truth.height_m,
            })),
            "contenders": self.contenders.iter().map(|it| it.fields(self.truth)).collect::<Vec<_>>(),
        });
        if let (Some(header), Value::Object(more)) = (header.as_object_mut(), more) {
            header.extend(more);
        }
        let mut message = MessageBuilder::new(MessageKind::State, &header)?;
        for (i, contender) in self.contenders.iter().enumerate() {
            message.floats(&format!("individuals{i}"), flat(&contender.individuals));
        }
        if let Some(values) = likelihood {
            message.floats("likelihood", values);
        }
        Ok(message.finish())
    }

    /// The image message, with what belongs on the image: pixels of the first algorithm's analysis, and the map as each
    /// algorithm expects it.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn image(&self) -> Result<Vec<u8>, StudioError> {
        let image = &self.frame.image;
        let header = json!({
            "number": self.number,
            "size_px": [image.width(), image.height()],
            "horizon": self.horizon(),
        });
        let mut message = MessageBuilder::new(MessageKind::Image, &header)?;
        message.bytes("jpeg", &encode_jpeg(image, JPEG_QUALITY)?);
        if let Some(first) = self.contenders.first() {
            message.floats("kept", kept(&first.percept));
            message.floats("dropped", dropped(&first.percept));
        }
        self.add_theories(&mut message);
        Ok(message.finish())
    }

    /// The image message without the image: only what each algorithm expects to see.
    pub(crate) fn theories(&self) -> Result<Vec<u8>, StudioError> {
        let mut message = MessageBuilder::new(MessageKind::Image, &json!({ "number": self.number }))?;
        self.add_theories(&mut message);
        Ok(message.finish())
    }

    fn add_theories(&self, message: &mut MessageBuilder) {
        for (i, contender) in self.contenders.iter().enumerate() {
            let estimate = &contender.estimate;
            if estimate.reliability_up_to_symmetry > 0.0 {
                let pose = &estimate.world_from_robot;
                let (camera, mount) = (&self.frame.camera, &self.frame.robot_from_camera);
                message.floats(&format!("theory{i}"), theoretical_image(self.map, camera, pose, mount));
            }
        }
    }

    /// Where the camera looks, seen from the robot, and how wide, radians: heading, and angle between left and right border.
    fn camera_direction(&self) -> [f64; 2] {
        let ahead = self.frame.robot_from_camera.rotate(&Vector3::z());
        let (width, _) = self.frame.camera.size_px();
        let width = 2.0 * (f64::from(width) / 2.0).atan2(self.frame.camera.focal_px().0);
        [ahead.y.atan2(ahead.x), width]
    }

    /// Pose of the camera on the robot: ahead, left, height in meters; heading, pitch down, roll clockwise in degrees.
    fn mount(&self) -> [f64; 6] {
        let mount = &self.frame.robot_from_camera;
        let (ahead, right) = (mount.rotate(&Vector3::z()), mount.rotate(&Vector3::x()));
        let down = mount.rotate(&Vector3::y());
        let [heading, pitch, roll] =
            [ahead.y.atan2(ahead.x), (-ahead.z).clamp(-1.0, 1.0).asin(), (-right.z).atan2(-down.z)];
        let at = mount.translation();
        [at.x, at.y, at.z, heading.to_degrees(), pitch.to_degrees(), roll.to_degrees()]
    }

    /// Rows of the horizon at the left and the right border.
    fn horizon(&self) -> [Option<f64>; 2] {
        let horizon = Horizon::new(&self.frame.camera, &self.frame.robot_from_camera);
        [0.0, f64::from(self.frame.image.width()) - 1.0].map(|column| horizon.row_px(column))
    }
}

pub(crate) fn triple(pose: &PlanarPose) -> [f64; 3] {
    [pose.x_m, pose.y_m, pose.yaw_rad]
}

/// x, y, heading and probability of each hypothesis.
fn hypotheses(estimate: &Estimate) -> Vec<[f64; 4]> {
    let quadruple = |hypothesis: &visloc_locate::Hypothesis| {
        let [x, y, yaw] = triple(&hypothesis.world_from_robot);
        [x, y, yaw, hypothesis.probability]
    };
    estimate.hypotheses.iter().take(MAX_HYPOTHESES).map(quadruple).collect()
}

/// x, y, heading, likelihood and population of each individual.
fn flat(individuals: &[Individual]) -> impl Iterator<Item = f64> + '_ {
    let five = |individual: &Individual| {
        let [x, y, yaw] = triple(&individual.world_from_robot);
        [x, y, yaw, individual.likelihood, individual.population as f64]
    };
    individuals.iter().flat_map(five)
}

/// x, y and kind of each pixel: 0 for what lies on the floor, 1 for what stands on it.
fn kept(percept: &Percept) -> impl Iterator<Item = f64> + '_ {
    percept.pixels.iter().flat_map(|pixel| {
        let stands =
            pixel.kind.is_goal() || pixel.kind.is_door_edge() || pixel.kind == FeatureKind::UnknownLine;
        [pixel.px.x, pixel.px.y, f64::from(u8::from(stands))]
    })
}

/// x, y and the number of the reason among all reasons.
fn dropped(percept: &Percept) -> impl Iterator<Item = f64> + '_ {
    let every = percept.dropped.len().div_ceil(MAX_DROPPED).max(1);
    percept.dropped.iter().step_by(every).flat_map(|pixel| {
        let reason = DropReason::ALL.iter().position(|reason| *reason == pixel.reason).unwrap_or(0);
        [pixel.px.x, pixel.px.y, reason as f64]
    })
}

/// What pages are shown of each algorithm.
pub fn views(lineup: &Lineup) -> Vec<ContenderView> {
    lineup.contenders().iter().map(|it| ContenderView::new(it.name(), it.pipeline())).collect()
}
