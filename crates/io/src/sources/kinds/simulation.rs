//! The simulator: robots on known maps, and cameras that are carried through rooms.

use std::path::PathBuf;

use visloc_core::{ImageSource, Picture, Source};
use visloc_sim::{BUILT_IN_SCENARIOS, CameraTour, Scenario, Simulation, TEAM, TOURS};

use super::{SourceKind, Way, always_usable, claims_nothing};
use crate::{
    sequence::{Bound, Calibration},
    sources::{
        OpenFrames, OpenImages, OpenPictures, SourceAddress,
        SourceOption::{End, Frames, Scale, Seed, Start, Stride, Threads},
        SourcesError,
        adapt::{
            CameraFrames, frames_in_range, gray_of_frames, images_of_gray, pictures_in_range,
            pictures_of_frames, pictures_of_images,
        },
        address::nearest,
        open::Request,
    },
};

pub(super) const KIND: SourceKind = SourceKind {
    name: "simulator",
    schemes: &["sim"],
    form: "sim:NAME",
    example: "sim:robocup",
    summary: "a simulated robot (sim:robocup, sim:office, any scenario or its TOML file) or camera tour (sim:room, ...)",
    is_live: false,
    is_robot: |name| !is_tour(name),
    problem: always_usable,
    claims: claims_nothing,
    frames: Way {
        honors: |_| vec![Start, End, Stride, Frames, Seed, Threads],
        open: |request| frames_in_range(request, frames(request)?),
    },
    images: Way { honors: |_| vec![Start, End, Stride, Frames, Scale, Seed, Threads], open: images },
    pictures: Way {
        honors: |name| {
            let scale: &[_] = if is_tour(name) { &[Scale] } else { &[] };
            [&[Start, End, Stride, Frames, Seed, Threads][..], scale].concat()
        },
        open: |request| {
            let open = pictures(request)?;
            if is_tour(request.address.rest()) { Ok(open) } else { pictures_in_range(request, open) }
        },
    },
};

/// Other names of scenarios.
const ALIASES: [(&str, &str); 1] = [("robocup", "tour")];

/// Everything that may stand behind the colon, without files.
pub(crate) fn simulated_names() -> Vec<String> {
    let aliases = ALIASES.iter().map(|alias| alias.0);
    let scenarios = BUILT_IN_SCENARIOS.iter().map(|scenario| scenario.0);
    aliases.chain(scenarios).chain(TOURS.iter().map(|tour| tour.0)).map(str::to_owned).collect()
}

/// Refuses a name that is neither known nor a file.
fn check_name(request: &Request<'_>) -> Result<(), SourcesError> {
    let (rest, known) = (request.address.rest(), simulated_names());
    // The scenario itself says which factors there are.
    let name = rest.split('+').next().unwrap_or(rest);
    let exists = |name: &str| known.iter().any(|known| known == name) || std::path::Path::new(name).is_file();
    if exists(rest) || exists(name) {
        return Ok(());
    }
    if name == TEAM {
        return request.cannot(
            "this is a team of robots, each with a camera of its own; expected one robot, such as sim:tour-2024 on the same field \
             (for the team: visloc studio sim:team, or visloc experiment team)",
        );
    }
    let nearest = nearest(name, known.iter().map(String::as_str));
    let hint = nearest.map(|nearest| format!("; did you mean '{nearest}'?")).unwrap_or_default();
    request.cannot(format!("expected the file of a scenario or one of: {}{hint}", known.join(", ")))
}

fn is_tour(name: &str) -> bool {
    TOURS.iter().any(|tour| tour.0 == name)
}

fn frames(request: &Request<'_>) -> Result<OpenFrames, SourcesError> {
    check_name(request)?;
    if is_tour(request.address.rest()) {
        return request.cannot(
            "this is a camera in a room without a map; expected a robot on a map, such as sim:robocup or sim:office \
             (for the room: visloc slam)",
        );
    }
    let simulation = simulation(request)?;
    let map = Some(simulation.map().clone());
    Ok(OpenFrames { frames: Box::new(simulation), map, warnings: Vec::new() })
}

/// The scenario of a simulated robot.
///
/// # Errors
/// If there is none of this name, or it makes no sense.
pub fn simulated_scenario(address: &SourceAddress<'_>) -> Result<Scenario, SourcesError> {
    let name = address.rest();
    let resolved = ALIASES.iter().find_map(|(alias, resolved)| {
        let factors = name.strip_prefix(alias).filter(|rest| rest.is_empty() || rest.starts_with('+'))?;
        Some(format!("{resolved}{factors}"))
    });
    Ok(Scenario::load(resolved.as_deref().unwrap_or(name))?)
}

fn simulation(request: &Request<'_>) -> Result<Simulation, SourcesError> {
    let scenario = simulated_scenario(&request.address)?;
    let options = request.options;
    // Those before the range have to be drawn, too.
    let max_frames = match (options.usual.max_frames, options.range.start) {
        (Some(number), Bound::Frame(start)) => Some(number.saturating_add(start)),
        _ => None,
    };
    let simulation = Simulation::new(&scenario, options.seed())?.with_threads(options.num_threads());
    Ok(simulation.with_num_frames(max_frames.unwrap_or(usize::MAX)))
}

fn images(request: &Request<'_>) -> Result<OpenImages, SourcesError> {
    check_name(request)?;
    if is_tour(request.address.rest()) {
        return tour(request);
    }
    let (robot, calibration) = robot(request)?;
    images_of_gray(request, gray_of_frames(robot.frames), Some(calibration), Vec::new())
}

/// The simulated robot, and the calibration of its camera.
fn robot(request: &Request<'_>) -> Result<(CameraFrames, (Calibration, PathBuf)), SourcesError> {
    let simulation = simulation(request)?;
    if !simulation.scenario().more_cameras.is_empty() {
        return request
            .cannot("expected a robot with one camera here, found a scenario with [[more_cameras]]");
    }
    let opened = CameraFrames::new(Box::new(simulation));
    let robot = opened.ok_or_else(|| request.empty(String::new()))??;
    let calibration = Calibration::of(&robot.camera);
    Ok((robot, (calibration, request.argument().into())))
}

fn tour(request: &Request<'_>) -> Result<OpenImages, SourcesError> {
    let options = request.options;
    if !(0.15..=4.0).contains(&options.scale()) {
        return request
            .cannot(format!("--scale: expected a factor from 0.15 to 4, found {}", options.scale()));
    }
    let tour = CameraTour::new(request.address.rest(), options.seed())?;
    let (width, height) = tour.camera().size_px();
    let side = |px: u32| (f64::from(px) * options.scale()).round() as u32;
    let rate = tour.frames_per_sec();
    let frame = |bound: Bound| match bound {
        Bound::Frame(frame) => frame,
        Bound::Secs(secs) => (secs * rate).ceil() as usize,
    };
    let range = options.range;
    let start = frame(range.start);
    let behind = range.most.map(|most| start.saturating_add(most.saturating_mul(range.stride.max(1))));
    let end = range.end.map_or(usize::MAX, frame).min(behind.unwrap_or(usize::MAX));
    let tour = tour
        .with_size((side(width), side(height)))?
        .with_frames(start, end, range.stride)
        .with_threads(options.num_threads());
    Ok(OpenImages { truth: Some(tour.truth()), images: Box::new(tour), warnings: Vec::new() })
}

fn pictures(request: &Request<'_>) -> Result<OpenPictures, SourcesError> {
    check_name(request)?;
    let (pictures, calibration): (Box<dyn Source<Picture>>, _) = if is_tour(request.address.rest()) {
        let images = tour(request)?.images;
        let calibration = (Calibration::of(images.camera()), request.argument().into());
        (pictures_of_images(images), calibration)
    } else {
        let (robot, calibration) = robot(request)?;
        (pictures_of_frames(robot.frames), calibration)
    };
    Ok(OpenPictures { pictures, calibration: Some(calibration), warnings: Vec::new() })
}
