//! What a camera that is bolted on wrong costs: the same frames with a constant error of the reported camera pose.
//!
//! `cargo run --release -p visloc-scenarios --example bolted -- PITCH,ROLL,YAW SEEDS RUN...`; the error in degrees (the real camera looks so much
//! farther down, is so much more rolled clockwise, looks so much farther to the left than reported), with `known:` before them for tracks that take the reported one for right; SEEDS for instance 3. RUN is
//! `SCENARIO[:FRAMES]` or `RECORDING.mcap=MAP`, with `@IMAGE` behind it for a robot that sees this image again and again for
//! 120 images. On a symmetric field the half is given.

#![allow(clippy::disallowed_methods)]

use std::time::Instant;

use nalgebra::{Rotation3, Vector3};
use visloc_core::{
    Source, SourceFrame,
    geom::{CameraFrame, PlanarPose, Rigid3},
};
use visloc_io::bag::{BagReader, BagTopics};
use visloc_locate::{Pipeline, PipelineConfig, Region, StartPrior};
use visloc_scenarios::collect;
use visloc_sim::{Scenario, Simulation};
use visloc_world::Map;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let mut args = std::env::args().skip(1);
    let error = args.next().ok_or("PITCH,ROLL,YAW")?;
    let (error, is_known) =
        error.strip_prefix("known:").map_or((error.as_str(), false), |error| (error, true));
    let error: Vec<f64> = error.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let [pitch, roll, yaw] = error[..] else { return Err("three angles".into()) };
    let tilt = Vector3::new(-pitch, -yaw, roll).map(f64::to_radians);
    let seeds: u64 = args.next().ok_or("SEEDS")?.parse()?;
    for run in args {
        for seed in 1..=seeds {
            let (map, mut frames) = load(&run, seed)?;
            for frame in &mut frames {
                // Reported is where the real one would be without its error.
                let turn = Rigid3::<CameraFrame, CameraFrame>::new(
                    Rotation3::from_scaled_axis(-tilt),
                    Vector3::zeros(),
                );
                frame.frame.robot_from_camera = frame.frame.robot_from_camera * turn;
            }
            follow((&run, seed, is_known), &map, &frames)?;
        }
    }
    Ok(())
}

/// The map and all frames of a scenario or a recording.
fn load(run: &str, seed: u64) -> Result<(Map, Vec<SourceFrame>), Failure> {
    let (run, standing) = run.split_once('@').map_or((run, None), |(run, image)| (run, Some(image)));
    let (map, mut frames) = if let Some((recording, map)) = run.split_once('=') {
        let mut bag = BagReader::open(recording, BagTopics::default())?;
        (Map::load(map)?, std::iter::from_fn(|| bag.next_item()).collect::<Result<Vec<_>, _>>()?)
    } else {
        let (name, frames) = run.split_once(':').unwrap_or((run, "1000000"));
        let scenario = Scenario::load(name)?;
        let simulation = Simulation::new(&scenario, seed)?.with_threads(2);
        let map = simulation.map().clone();
        (map, collect(&mut simulation.with_num_frames(frames.parse()?))?)
    };
    if let Some(image) = standing {
        let seen = frames.get(image.parse::<usize>()?).ok_or("no such image")?.clone();
        frames.truncate(120);
        for frame in &mut frames {
            let at = frame.frame.at;
            *frame = seen.clone();
            frame.frame.at = at;
        }
    }
    Ok((map, frames))
}

fn follow(
    (run, seed, is_known): (&str, u64, bool),
    map: &Map,
    frames: &[SourceFrame],
) -> Result<(), Failure> {
    let mut config = PipelineConfig::default();
    if is_known {
        let tracks = &mut config.refinement;
        [tracks.mount_pitch_rad, tracks.mount_roll_rad, tracks.mount_yaw_rad] = [0.0; 3];
    }
    let mut pipeline = Pipeline::builder(map).config(config).seed(seed).build()?;
    let start = frames.iter().find_map(|frame| frame.truth).ok_or("no truth")?.world_from_robot;
    if let Map::Field(field) = map
        && field.is_point_symmetric()
    {
        let (half_x, half_y) = field.half_carpet_m();
        let (min_x_m, max_x_m) = if start.x_m > 0.0 { (0.0, half_x) } else { (-half_x, 0.0) };
        let region = Region { min_x_m, max_x_m, min_y_m: -half_y, max_y_m: half_y };
        pipeline.reset_to(&StartPrior::Region { region, heading: None });
    }
    let (mut errors, mut turns) = (Vec::new(), Vec::new());
    let (mut claimed, mut wrong, mut first) = (0, 0, None);
    let began = Instant::now();
    for (i, frame) in frames.iter().enumerate() {
        let estimate = pipeline.step(&frame.frame)?;
        let Some(truth) = frame.truth.filter(|truth| truth.height_m < 0.01) else { continue };
        let (off_m, off_deg) = off(&estimate.world_from_robot, &truth.world_from_robot);
        errors.push(off_m);
        turns.push(off_deg);
        if estimate.is_localized() {
            first.get_or_insert(i);
            claimed += 1;
            wrong += usize::from(off_m > 0.3 || off_deg > 10.0);
        }
    }
    let ms = began.elapsed().as_secs_f64() * 1e3 / frames.len() as f64;
    let last = (errors.last().copied().unwrap_or(9.9), turns.last().copied().unwrap_or(9.9));
    let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
    let num = errors.len();
    errors.sort_by(f64::total_cmp);
    turns.sort_by(f64::total_cmp);
    let camera = pipeline.localizer().camera_error();
    let name = run.rsplit('/').next().unwrap_or(run);
    println!(
        "{name:<32} {seed} median {:.3} mean {mean:.3} m {:.2} deg, last {:.2} m {:.1} deg, localized {:3.0} % from {first:?}, wrong {wrong}, {ms:.2} ms {}",
        errors[num / 2],
        turns[num / 2],
        last.0,
        last.1,
        100.0 * f64::from(claimed) / num as f64,
        camera.map_or(String::new(), |e| format!(
            "camera {:.2}+-{:.2} {:.2}+-{:.2} {:.2}+-{:.2}",
            e.pitch_down_deg.mean,
            e.pitch_down_deg.sigma,
            e.roll_clockwise_deg.mean,
            e.roll_clockwise_deg.sigma,
            e.yaw_left_deg.mean,
            e.yaw_left_deg.sigma
        )),
    );
    Ok(())
}

fn off(found: &PlanarPose, truth: &PlanarPose) -> (f64, f64) {
    (found.distance_m(truth), found.heading_difference_rad(truth).to_degrees())
}
