//! How far a robot that stands can be relied upon: random places on a field, each seen for some seconds with a still head and a camera whose
//! direction is off by a constant error.
//!
//! `cargo run --release -p visloc-scenarios --example standing -- PLACES SEED [--quick] [--each] SCENARIO[@WIDTH]...`; for instance
//! `200 1 tour tour-2024@640`. The errors of pitch and roll are normal with 1.5 and 0.8 degrees. On a symmetric field the half is given.
//! Printed are the claims (reliability above 0.6) of the last images and of all, the curve of calibration, and how many of the places that a
//! search of the whole field calls unambiguous in one image are claimed (not with `--quick`); with `--each` every place.

#![allow(clippy::disallowed_methods)]

use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use visloc_core::{
    RngTree, SourceFrame, gaussian,
    geom::{CameraFrame, PlanarPose, Rigid3, nao::HeadAngles},
};
use visloc_locate::{
    LOCALIZED_RELIABILITY, Photo, Pipeline, PipelineConfig, Region, StartPrior, locate_photo,
};
use visloc_sim::{LiveControls, LiveMotion, LiveSimulation, Scenario};
use visloc_world::Map;

type Failure = Box<dyn std::error::Error>;

const SECS: f64 = 4.0;
const FRAMES_PER_SEC: f64 = 10.0;
const PITCH_DEG: f64 = 1.5;
const ROLL_DEG: f64 = 0.8;
/// A place is right within this.
const RIGHT_M: f64 = 0.3;
const RIGHT_DEG: f64 = 10.0;
/// A search calls a place unambiguous if it has this much of the probability, together with its mirror image.
const UNAMBIGUOUS: f64 = 0.9;
const BINS: usize = 10;

/// What was found at all places.
#[derive(Default)]
struct Tally {
    places: usize,
    right_at_end: usize,
    /// Claims of the last image: right and wrong.
    claims: [usize; 2],
    /// Images that claim: right and wrong.
    images: [usize; 2],
    /// Places that the search calls unambiguous: rightly, wrongly; and of the former, claimed.
    unambiguous: [usize; 2],
    unambiguous_claimed: usize,
    /// Places that are claimed wrongly in some image.
    ever_wrong: usize,
    /// Right ones and all by reliability of the last image.
    bins: [(usize, usize); BINS],
}

fn main() -> Result<(), Failure> {
    let mut args = std::env::args().skip(1);
    let places: u64 = args.next().ok_or("PLACES")?.parse()?;
    let seed: u64 = args.next().ok_or("SEED")?.parse()?;
    let args: Vec<_> = args.collect();
    let has = |flag: &str| args.iter().any(|arg| arg == flag);
    let (is_quick, is_told) = (has("--quick"), has("--each"));
    for scenario in args.iter().filter(|arg| !arg.starts_with("--")) {
        let mut tally = Tally::default();
        for place in 0..places {
            stand(scenario, (seed, place), (is_quick, is_told), &mut tally)?;
        }
        tally.print(scenario);
    }
    Ok(())
}

fn load(name: &str) -> Result<Scenario, Failure> {
    let (name, width) = name.split_once('@').unwrap_or((name, "320"));
    let mut scenario = Scenario::load(name)?;
    let scale = width.parse::<f64>()? / f64::from(scenario.camera.size_px[0]);
    let camera = &mut scenario.camera;
    camera.size_px = camera.size_px.map(|px| (f64::from(px) * scale).round() as u32);
    camera.focal_px = camera.focal_px.map(|px| px * scale);
    camera.center_px = camera.center_px.map(|px| (px + 0.5) * scale - 0.5);
    scenario.frames_per_sec = FRAMES_PER_SEC;
    Ok(scenario)
}

/// The images of a robot that stands somewhere.
fn images(scenario: &Scenario, rng: RngTree) -> Result<(Map, Vec<SourceFrame>), Failure> {
    let mut draws = rng.stream("standing", 0);
    let mut simulation = LiveSimulation::new(scenario, draws.random_range(0..1 << 40))?;
    let at = simulation.random_pose(0).ok_or("no free place")?;
    let head =
        HeadAngles { yaw_rad: draws.random_range(-0.8..0.8), pitch_rad: draws.random_range(0.12..0.33) };
    let error = Vector3::new(gaussian(&mut draws, PITCH_DEG), 0.0, gaussian(&mut draws, ROLL_DEG));
    let turn = Rotation3::from_scaled_axis(error.map(f64::to_radians));
    let turn = Rigid3::<CameraFrame, CameraFrame>::new(turn, Vector3::zeros());
    let put = LiveMotion::Held { world_from_robot: at, height_m: 0.0, is_felt: false };
    let controls = LiveControls { head: Some(head), ..LiveControls::default() };
    simulation.step(&LiveControls { motion: put, ..controls });
    let mut frames: Vec<_> =
        (0..(SECS * FRAMES_PER_SEC) as usize).map(|_| simulation.step(&controls)).collect();
    for frame in &mut frames {
        frame.frame.robot_from_camera = frame.frame.robot_from_camera * turn;
    }
    Ok((simulation.map().clone(), frames))
}

fn stand(
    name: &str,
    (seed, place): (u64, u64),
    (is_quick, is_told): (bool, bool),
    tally: &mut Tally,
) -> Result<(), Failure> {
    let rng = RngTree::new(seed).subtree("place", place);
    let (map, frames) = images(&load(name)?, rng)?;
    let truth = frames[0].truth.ok_or("no truth")?.world_from_robot;
    let mut pipeline = Pipeline::builder(&map).seed(seed + place).build()?;
    if let Map::Field(field) = &map
        && field.is_point_symmetric()
    {
        let (half_x, half_y) = field.half_carpet_m();
        let (min_x_m, max_x_m) = if truth.x_m > 0.0 { (0.0, half_x) } else { (-half_x, 0.0) };
        let region = Region { min_x_m, max_x_m, min_y_m: -half_y, max_y_m: half_y };
        pipeline.reset_to(&StartPrior::Region { region, heading: None });
    }
    let mut first = None;
    let (mut wrong, mut last) = (0, (false, 0.0));
    for (i, frame) in frames.iter().enumerate() {
        let estimate = pipeline.step(&frame.frame)?;
        let is_right = is_right(&estimate.world_from_robot, &truth);
        last = (is_right, estimate.reliability);
        if estimate.reliability > LOCALIZED_RELIABILITY {
            first.get_or_insert(i);
            tally.images[usize::from(!is_right)] += 1;
            wrong += usize::from(!is_right);
        }
    }
    let is_claimed = last.1 > LOCALIZED_RELIABILITY;
    let (probability, is_found) =
        if is_quick { (0.0, false) } else { search(&map, &frames[frames.len() / 2], &truth)? };
    tally.places += 1;
    tally.right_at_end += usize::from(last.0);
    tally.ever_wrong += usize::from(wrong > 0);
    if is_claimed {
        tally.claims[usize::from(!last.0)] += 1;
    }
    let bin = &mut tally.bins[((last.1 * BINS as f64) as usize).min(BINS - 1)];
    *bin = (bin.0 + usize::from(last.0), bin.1 + 1);
    if probability > UNAMBIGUOUS {
        tally.unambiguous[usize::from(!is_found)] += 1;
        tally.unambiguous_claimed += usize::from(is_found && is_claimed);
    }
    if is_told {
        println!(
            "{place:4} ({:5.2} {:5.2} {:4.0}) {} {:.2} first {first:?} wrong {wrong}, search {probability:.3} {is_found}",
            truth.x_m,
            truth.y_m,
            truth.yaw_rad.to_degrees(),
            if last.0 { "right" } else { "WRONG" },
            last.1
        );
    }
    Ok(())
}

/// What a search of the whole field finds in one image: probability of the best place together with its mirror image, and whether it is right.
fn search(map: &Map, frame: &SourceFrame, truth: &PlanarPose) -> Result<(f64, bool), Failure> {
    let reported = &frame.frame.robot_from_camera;
    let photo = Photo {
        image: frame.frame.image.clone(),
        camera: frame.frame.camera,
        pitch_down_rad: Some((-reported.rotate(&Vector3::z()).z).asin()),
        height_m: Some(reported.translation().z),
    };
    let answer = locate_photo(map, &PipelineConfig::default(), &photo, RngTree::new(1))?;
    let Some(best) = answer.poses.first() else { return Ok((0.0, false)) };
    let (eye, ahead) = (reported.translation(), reported.rotate(&Vector3::z()));
    let view = PlanarPose::new(eye.x, eye.y, ahead.y.atan2(ahead.x));
    let at = truth.compose(&view);
    let is_same = |a: &PlanarPose| is_right(a, &at);
    let mirrored = |a: &PlanarPose| PlanarPose::new(-a.x_m, -a.y_m, a.yaw_rad + std::f64::consts::PI);
    let is_symmetric = matches!(map, Map::Field(field) if field.is_point_symmetric());
    let best = best.world_from_view;
    let together: f64 = answer
        .poses
        .iter()
        .filter(|pose| {
            let found = &pose.world_from_view;
            is_right(found, &best) || is_symmetric && is_right(&mirrored(found), &best)
        })
        .map(|pose| pose.probability)
        .sum();
    Ok((together, is_same(&best) || is_symmetric && is_same(&mirrored(&best))))
}

fn is_right(found: &PlanarPose, truth: &PlanarPose) -> bool {
    found.distance_m(truth) < RIGHT_M && found.heading_difference_rad(truth).to_degrees() < RIGHT_DEG
}

impl Tally {
    fn print(&self, scenario: &str) {
        println!(
            "{scenario}: {} places, right at the end {}, claims {} right {} wrong, claimed wrongly in some image {}, images {} right {} wrong",
            self.places,
            self.right_at_end,
            self.claims[0],
            self.claims[1],
            self.ever_wrong,
            self.images[0],
            self.images[1]
        );
        println!(
            "  unambiguous by search {} (and {} wrongly), of them claimed {} ({:.0} %)",
            self.unambiguous[0],
            self.unambiguous[1],
            self.unambiguous_claimed,
            100.0 * self.unambiguous_claimed as f64 / self.unambiguous[0].max(1) as f64
        );
        for (i, (right, all)) in self.bins.iter().enumerate().filter(|(_, bin)| bin.1 > 0) {
            println!(
                "  reliability {:.1} to {:.1}: {right} of {all} right ({:.0} %)",
                i as f64 / BINS as f64,
                (i + 1) as f64 / BINS as f64,
                100.0 * *right as f64 / *all as f64
            );
        }
    }
}
