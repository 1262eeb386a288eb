//! Where commands read something.

use super::kinds::Kind::{self, *};

/// An argument of a command that names something to read.
#[derive(Debug)]
pub struct Slot {
    /// The command, with the one below it.
    pub command: &'static str,
    /// The option, or the name of the value.
    pub argument: &'static str,
    /// The other words; `{}` is the input, `@NAME` a good file.
    pub words: &'static str,
    /// What it takes.
    pub kinds: &'static [Kind],
    /// What becomes of a good input.
    pub good: Good,
}

/// What a command does with a good input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Good {
    /// It comes to its end.
    Done,
    /// It comes to its end, and needs nothing but the beginning.
    Beginning,
    /// It comes to its end, and needs no camera for that.
    NoCamera,
    /// It refuses it, because the good inputs here are too small for it.
    TooSmall,
    /// It goes on until it is interrupted, so only inputs that are refused are tried.
    Endless,
}

const CAMERA_FILES: &[Kind] = &[CameraToml, CameraRos, CameraKalibr, CameraOpenCv];
const PLANS: &[Kind] = &[WallList, Grid, GridPicture, Svg, Dxf];
const MAPS: &[Kind] = &[MapField, MapOffice, WallList, Grid, GridPicture, Svg, Dxf];
const ROBOT_SOURCES: &[Kind] = &[Bag, BagFolder, BagMetadata, BagSqlite, BagRos1];
const CAMERA_SOURCES: &[Kind] = &[Tum, TumCamera, TumTruth, Euroc, Kitti, Bag, BagSqlite, BagRos1];

const fn slot(
    command: &'static str,
    argument: &'static str,
    words: &'static str,
    kinds: &'static [Kind],
) -> Slot {
    Slot { command, argument, words, kinds, good: Good::Done }
}

const fn small(
    command: &'static str,
    argument: &'static str,
    words: &'static str,
    kinds: &'static [Kind],
) -> Slot {
    Slot { command, argument, words, kinds, good: Good::TooSmall }
}

const fn beginning(
    command: &'static str,
    argument: &'static str,
    words: &'static str,
    kinds: &'static [Kind],
) -> Slot {
    Slot { command, argument, words, kinds, good: Good::Beginning }
}

const fn without_camera(
    command: &'static str,
    argument: &'static str,
    words: &'static str,
    kinds: &'static [Kind],
) -> Slot {
    Slot { command, argument, words, kinds, good: Good::NoCamera }
}

const fn endless(
    command: &'static str,
    argument: &'static str,
    words: &'static str,
    kinds: &'static [Kind],
) -> Slot {
    Slot { command, argument, words, kinds, good: Good::Endless }
}

/// All of them.
pub const SLOTS: &[Slot] = &[
    slot(
        "localize",
        "SOURCE",
        "{} --map robocup-spl-2010 --trajectory out/t.tum --json out/r.json",
        ROBOT_SOURCES,
    ),
    slot(
        "localize",
        "--map",
        "@bag.mcap --map {} --frames 1 --json out/r.json",
        &[MapField, MapOffice, WallList],
    ),
    slot("localize", "--map", "@tum --map {} --trajectory out/t.tum --json out/r.json", &[VisualMap]),
    slot(
        "localize",
        "--config",
        "@bag.mcap --map robocup-spl-2010 --frames 1 --config {} --json out/r.json",
        &[Algorithm],
    ),
    slot("localize", "--pipeline", "@bag.mcap --map robocup-spl-2010 --frames 1 --pipeline {}", &[Pipeline]),
    slot("localize", "--robot", "@bag.mcap --map robocup-spl-2010 --frames 1 --robot {}", &[Robot]),
    slot(
        "localize",
        "--params-file",
        "@bag.mcap --map robocup-spl-2010 --frames 1 --params-file {} --json out/r.json",
        &[RosParameters],
    ),
    slot("localize", "--topics", "@bag.mcap --map robocup-spl-2010 --frames 1 --topics {}", &[Topics]),
    slot(
        "localize",
        "--camera",
        "@bag.mcap --map robocup-spl-2010 --frames 1 --camera {}",
        &[CameraToml, CameraRos],
    ),
    slot(
        "localize",
        "--urdf",
        "@bag.mcap --map robocup-spl-2010 --frames 1 --urdf {} --json out/r.json",
        &[Urdf],
    ),
    slot(
        "slam",
        "SOURCE",
        "{} --camera @camera.toml --ffmpeg @ffmpeg --json out/r.json --trajectory out/t.tum",
        &[Video],
    ),
    slot("slam", "SOURCE", "{} --camera @camera.toml --json out/r.json --trajectory out/t.tum", &[Bag]),
    slot(
        "slam",
        "SOURCE",
        "{} --json out/r.json --trajectory out/t.tum --points out/m.ply",
        &[Tum, TumCamera, TumTruth, Euroc, Kitti],
    ),
    slot("slam", "--config", "@tum --config {} --json out/r.json", &[Slam]),
    slot("slam", "--camera", "@tum --camera {} --json out/r.json", CAMERA_FILES),
    slot("slam", "--load", "@tum --load {} --save out/later.vmap --json out/r.json", &[VisualMap]),
    small("slam", "--poses", "@tum --poses {} --save out/given.vmap", &[PosesTum, PosesEuroc]),
    slot("slam", "--params-file", "@tum --params-file {} --json out/r.json", &[RosParameters]),
    slot("slam", "--urdf", "@bag.mcap --urdf {} --until 1", &[Urdf]),
    slot("slam", "--topics", "@bag.mcap --topics {} --until 1", &[Topics]),
    slot("extract", "SOURCE", "{} --ffmpeg @ffmpeg --out out/images", &[Video]),
    without_camera("extract", "SOURCE", "{} --out out/images", CAMERA_SOURCES),
    slot("extract", "--camera", "@tum --camera {} --out out/images", &[CameraToml, CameraKalibr]),
    // Images alone do not depend on it, so it is refused before it is read.
    slot("extract", "--urdf", "@bag.mcap --urdf {} --out out/images", &[]),
    slot("extract", "--topics", "@bag.mcap --topics {} --frames 1 --out out/images", &[Topics]),
    slot("record", "SOURCE", "{} --ffmpeg @ffmpeg --out out/copy.mcap", &[Video]),
    without_camera("record", "SOURCE", "{} --out out/copy.mcap", CAMERA_SOURCES),
    slot("record", "--camera", "@tum --camera {} --out out/copy.mcap", &[CameraToml, CameraKalibr]),
    slot("record", "--urdf", "@bag.mcap --urdf {} --frames 1 --out out/copy.mcap", &[Urdf]),
    slot("record", "--topics", "@bag.mcap --topics {} --frames 1 --out out/copy.mcap", &[Topics]),
    beginning(
        "likelihood",
        "SOURCE",
        "{} --at 0.1 --map robocup-spl-2010 --step 0.5 --out out",
        &[Bag, BagFolder],
    ),
    slot("likelihood", "--map", "@bag.mcap --at 0.1 --map {} --step 0.5 --out out", &[MapField]),
    slot(
        "likelihood",
        "--pipeline",
        "@bag.mcap --at 0.1 --map robocup-spl-2010 --step 0.5 --out out --pipeline {}",
        &[Pipeline],
    ),
    slot(
        "likelihood",
        "--camera",
        "@bag.mcap --at 0.1 --map robocup-spl-2010 --step 0.5 --out out --camera {}",
        &[CameraToml],
    ),
    slot(
        "likelihood",
        "--urdf",
        "@bag.mcap --at 0.1 --map robocup-spl-2010 --step 0.5 --out out --urdf {}",
        &[Urdf],
    ),
    slot(
        "likelihood",
        "--topics",
        "@bag.mcap --at 0.1 --map robocup-spl-2010 --step 0.5 --out out --topics {}",
        &[Topics],
    ),
    slot("evaluate", "TRUTH", "{} @robot.tum --as robot --json out/e.json", &[PosesTum, PosesTable]),
    slot("evaluate", "ESTIMATE", "@camera.tum {} --as camera --json out/e.json", &[PosesTum, PosesEuroc]),
    slot("evaluate", "ESTIMATE", "@camera.kitti {} --as camera --json out/e.json", &[PosesKitti]),
    slot("evaluate", "--map", "@robot.tum @robot.tum --map {} --plots out", &[MapField]),
    slot("map check", "NAME|FILE", "{} --plots out", MAPS),
    slot("map import", "FILE", "{}", PLANS),
    slot("map info", "FILE", "{} --plots out --json out/m.json", &[VisualMap]),
    slot("map show", "NAME|FILE", "{} --plots out", &[VisualMap]),
    small("map merge", "FILE", "{} @room.vmap --out out/both.vmap", &[VisualMap]),
    small("map merge", "OTHER", "@room.vmap {} --out out/both.vmap", &[VisualMap]),
    slot("map trim", "FILE", "{} --keyframes 2 --out out/small.vmap", &[VisualMap]),
    slot("map export", "FILE", "{} --points out/m.ply --colmap out/c --nerfstudio out/n", &[VisualMap]),
    small("map export", "FILE", "{} --floor out/f", &[VisualMap]),
    slot("map align", "FILE", "{} --between 0 1 --distance 0.5 --out out/aligned.vmap", &[VisualMap]),
    small("map align", "--to", "@room.vmap --to {} --out out/aligned.vmap", &[PosesTum, PosesEuroc]),
    slot("camera convert", "IN", "{} out/camera.toml", CAMERA_FILES),
    slot("camera render", "CAMERA", "{} --size 9x6 --square 0.03 --count 1 --out out", &[CameraToml]),
    slot("camera by-hand", "IMAGE", "{} --map robocup-spl-2010 --out out/page.html", &[Png, Jpeg]),
    slot("camera by-hand", "--map", "@image.png --map {} --out out/page.html", &[MapField]),
    slot(
        "camera by-hand",
        "--camera",
        "@image.png --map robocup-spl-2010 --camera {} --out out/page.html",
        &[CameraToml],
    ),
    slot(
        "locate",
        "PHOTO",
        "{} --map robocup-spl-2010 --camera @camera.toml --pitch 10 --height 0.5",
        &[Png, Jpeg],
    ),
    slot("locate", "--map", "@image.png --map {} --camera @camera.toml --pitch 10 --height 0.5", &[MapField]),
    slot("locate", "--map", "@image.png --map {} --camera @camera.toml", &[VisualMap]),
    slot(
        "locate",
        "--camera",
        "@image.png --map robocup-spl-2010 --camera {} --pitch 10 --height 0.5",
        &[CameraToml],
    ),
    slot(
        "locate",
        "--pipeline",
        "@image.png --map robocup-spl-2010 --camera @camera.toml --pitch 10 --height 0.5 --pipeline {}",
        &[Pipeline],
    ),
    slot("check-camera", "CAMERA", "{}", CAMERA_FILES),
    slot("check-camera", "SOURCE", "@camera.toml {}", &[Images]),
    slot("check-camera", "SOURCE", "@camera.toml {} --ffmpeg @ffmpeg", &[Video]),
    slot("colors", "IMAGE", "{} --labels @labels.png --out out/colors.toml", &[Png]),
    slot("colors", "--labels", "@image.png --labels {} --out out/colors.toml", &[Labels]),
    small("calibrate", "SOURCE", "{} --size 9x6 --square 0.03 --out out/camera.toml", &[Images]),
    small("calibrate-robot", "SOURCE", "{} --map robocup-spl-2010 --out out/robot.toml", &[Bag, BagFolder]),
    small("calibrate-robot", "--map", "@bag.mcap --map {} --out out/robot.toml", &[MapField]),
    small(
        "calibrate-robot",
        "--robot",
        "@bag.mcap --map robocup-spl-2010 --robot {} --out out/robot.toml",
        &[Robot],
    ),
    small(
        "calibrate-robot",
        "--camera",
        "@bag.mcap --map robocup-spl-2010 --camera {} --out out/robot.toml",
        &[CameraToml],
    ),
    small(
        "calibrate-robot",
        "--urdf",
        "@bag.mcap --map robocup-spl-2010 --urdf {} --out out/robot.toml",
        &[Urdf],
    ),
    small(
        "calibrate-robot",
        "--topics",
        "@bag.mcap --map robocup-spl-2010 --topics {} --out out/robot.toml",
        &[Topics],
    ),
    slot("simulate", "SCENARIO", "{} --frames 1 --out out/bag.mcap", &[Scenario]),
    slot("demo", "--scenario", "--scenario {} --frames 2 --out out", &[Scenario]),
    slot("studio", "--replay", "--replay {} --export out/copy.mcap", &[Recording]),
    endless("studio", "SOURCE", "{} --port 0 --no-open --map robocup-spl-2010", &[Bag]),
    endless("studio", "--map", "@bag.mcap --port 0 --no-open --map {}", &[MapField]),
    endless("studio", "--sequence", "--sequence {} --port 0 --no-open", &[Tum]),
    endless("studio", "--camera", "@tum --camera {} --port 0 --no-open", &[CameraToml]),
    endless("studio", "--urdf", "@bag.mcap --map robocup-spl-2010 --urdf {} --port 0 --no-open", &[Urdf]),
    endless(
        "studio",
        "--topics",
        "@bag.mcap --map robocup-spl-2010 --topics {} --port 0 --no-open",
        &[Topics],
    ),
    small("benchmark", "--data", "--data {} --only no-such-recording --out out", ROBOT_SOURCES),
    slot("benchmark", "--baseline", "--baseline {} --quick --only room --frames 2 --out out", &[Benchmark]),
    slot("experiment merge", "DIR", "{}", &[Experiment]),
    small("experiment markov", "--recording", "--recording {} --runs 1 --shard 900000000/1000000000", &[Bag]),
    slot("experiment slam-compare", "SEQUENCE", "{} --runs 1 --frames 2", &[Tum]),
    slot("experiment slam-configs", "SEQUENCE", "{} --runs 1 --frames 2", &[Tum]),
    slot("experiment slam-dynamic", "SEQUENCE", "{} --runs 1 --frames 2", &[Tum]),
    slot("experiment slam-lost-points", "SEQUENCE", "{} --runs 1 --frames 2", &[Tum]),
    slot("experiment slam-kidnap", "SEQUENCE", "{} --runs 1 --frames 2", &[Tum]),
];

/// Arguments that name what is written.
pub const OUTPUTS: &[&str] = &[
    "--out",
    "--robot-out",
    "--json",
    "--plots",
    "--trajectory",
    "--estimates",
    "--keyframes",
    "--log",
    "--points",
    "--save",
    "--colmap",
    "--nerfstudio",
    "--floor",
    "--bag-out",
    "--record",
    "--recordings",
    "--export",
    "--report",
    "--ros",
];
