//! Good inputs of every kind, small.

use std::{fs, path::Path, sync::OnceLock};

use serde_json::json;
use visloc_core::RgbImage;
use visloc_io::{
    bag::BagWriterOptions,
    camera_file::{CameraFormat, read_camera, write_camera},
    image_codec::{encode_jpeg, encode_png},
};

use crate::{
    parsers,
    support::{Workspace, write_program},
};

/// What an input is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Bag,
    BagFolder,
    BagMetadata,
    BagSqlite,
    BagRos1,
    Tum,
    TumCamera,
    TumTruth,
    Euroc,
    Kitti,
    Video,
    Images,
    Png,
    Jpeg,
    Labels,
    CameraToml,
    CameraRos,
    CameraKalibr,
    CameraOpenCv,
    MapField,
    MapOffice,
    WallList,
    Grid,
    GridPicture,
    Svg,
    Dxf,
    PosesTum,
    PosesTable,
    PosesKitti,
    PosesEuroc,
    Scenario,
    Algorithm,
    Pipeline,
    Slam,
    Topics,
    RosParameters,
    Robot,
    Urdf,
    Recording,
    Experiment,
    Benchmark,
    VisualMap,
}

/// How a kind stands damage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nature {
    /// Messages one after the other: what comes before a damage is used.
    Messages,
    /// Lines of which bad ones are left out.
    Lines,
    /// A text that is right or wrong.
    Text,
    /// A table of TOML in which every key may be missing.
    Table,
    /// A picture.
    Picture,
    /// Sections, of which some can be spared.
    Sections,
}

/// An input: what the command is told, and its files, the one that is damaged first.
#[derive(Debug, Clone)]
pub struct Input {
    /// What the command is told.
    pub name: &'static str,
    /// Names and contents.
    pub files: Vec<(&'static str, Vec<u8>)>,
}

impl Input {
    fn one(name: &'static str, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name, files: vec![(name, bytes.into())] }
    }

    /// The file that is damaged.
    pub fn main(&self) -> (&'static str, &[u8]) {
        (self.files[0].0, &self.files[0].1)
    }

    /// Whether the command is told a folder or a file beside the one that is damaged.
    pub fn is_part(&self) -> bool {
        self.files[0].0 != self.name
    }
}

const CAMERA: &str = "model = \"radial-tangential\"\nsize_px = [48, 36]\nfocal_px = [39.5, 39.5]\ncenter_px = [23.5, 17.5]\n\
                      distortion = [-0.2, 0.05, 0.0008, -0.0006, 0.0]\n";
const TUM_CAMERA: &str = "width: 48\nheight: 36\nfx: 39.5\nfy: 39.5\ncx: 23.5\ncy: 17.5\n";
const TRUTH: &str =
    "1.0 0 0 0 0 0 0 1\n1.1 0.1 0 0 0 0 0 1\n1.2 0.2 0.1 0 0 0 0 1\n1.3 0.2 0.3 0.1 0 0 0 1\n";

impl Kind {
    /// How it stands damage.
    pub fn nature(self) -> Nature {
        match self {
            Self::Bag | Self::BagFolder | Self::BagSqlite | Self::BagRos1 | Self::Recording | Self::Video => {
                Nature::Messages
            }
            Self::Tum | Self::Euroc | Self::TumTruth => Nature::Lines,
            Self::Png | Self::Jpeg | Self::Labels | Self::GridPicture | Self::Images => Nature::Picture,
            Self::Scenario | Self::Algorithm | Self::Pipeline | Self::Slam | Self::Topics | Self::Robot => {
                Nature::Table
            }
            Self::VisualMap => Nature::Sections,
            _ => Nature::Text,
        }
    }

    /// A good one, made once: some are whole recordings and maps.
    pub fn good(self) -> &'static Input {
        const NUM_KINDS: usize = Kind::VisualMap as usize + 1;
        static GOOD: [OnceLock<Input>; NUM_KINDS] = [const { OnceLock::new() }; NUM_KINDS];
        GOOD[self as usize].get_or_init(|| self.made())
    }

    fn made(self) -> Input {
        match self {
            Self::Bag => Input::one("input.mcap", bag()),
            Self::BagFolder => Input {
                name: "input",
                files: vec![("input/input_0.mcap", bag()), ("input/metadata.yaml", metadata())],
            },
            Self::BagMetadata => Input {
                name: "input",
                files: vec![("input/metadata.yaml", metadata()), ("input/input_0.mcap", bag())],
            },
            Self::BagSqlite => Input::one("input.db3", testdata("R1-first-frames.db3")),
            Self::BagRos1 => Input::one("input.bag", testdata("R1-first-frames.bag")),
            Self::Tum => tum(["input/rgb.txt", "input/camera.yaml", "input/groundtruth.txt"]),
            Self::TumCamera => tum(["input/camera.yaml", "input/rgb.txt", "input/groundtruth.txt"]),
            Self::TumTruth => tum(["input/groundtruth.txt", "input/rgb.txt", "input/camera.yaml"]),
            Self::Euroc => euroc(),
            Self::Kitti => kitti(),
            Self::Video => Input::one("input.mp4", video()),
            Self::Images => {
                Input { name: "input", files: vec![("input/1.png", encode_png(&picture(1)).unwrap())] }
            }
            Self::Png => Input::one("input.png", encode_png(&picture(0)).unwrap()),
            Self::Jpeg => Input::one("input.jpg", encode_jpeg(&picture(0), 90).unwrap()),
            Self::Labels => Input::one("input.png", encode_png(&labels()).unwrap()),
            Self::CameraToml => Input::one("input.toml", CAMERA),
            Self::CameraRos => Input::one("input.yaml", camera_as(CameraFormat::Ros)),
            Self::CameraKalibr => Input::one("input.yaml", camera_as(CameraFormat::Kalibr)),
            Self::CameraOpenCv => Input::one("input.yml", camera_as(CameraFormat::OpenCv)),
            Self::MapField => Input::one("input.toml", visloc_world::BUILT_IN_MAPS[0].1),
            Self::MapOffice => Input::one("input.toml", visloc_world::BUILT_IN_MAPS[2].1),
            Self::WallList => Input::one("input.yaml", seed("map_list", 0)),
            Self::Grid => Input {
                name: "input.yaml",
                files: vec![("input.yaml", seed("map_grid", 0)), ("grid.pgm", seed("map_grid_picture", 0))],
            },
            Self::GridPicture => Input {
                name: "input.yaml",
                files: vec![("grid.pgm", seed("map_grid_picture", 0)), ("input.yaml", seed("map_grid", 0))],
            },
            Self::Svg => Input::one("input.svg", seed("map_svg", 1)),
            Self::Dxf => Input::one("input.dxf", seed("map_dxf", 0)),
            Self::PosesTum => Input::one("input.txt", TRUTH),
            Self::PosesTable => Input::one(
                "input.csv",
                "t,x,y,yaw\n1.0,0,0,0.5\n1.1,0.1,0,0.5\n1.2,0.2,0,0.5\n1.3,0.3,0,0.5\n",
            ),
            Self::PosesKitti => Input::one("input.txt", KITTI),
            Self::PosesEuroc => Input::one("input.csv", EUROC_POSES),
            Self::Scenario => Input::one("input.toml", SCENARIO),
            Self::Algorithm => Input::one("input.toml", "num_exploiters = 40\n[explorers]\nperiod = 12\n"),
            Self::Pipeline => Input::one("input.toml", "[lift]\nmin_unloaded_secs = 0.5\n"),
            Self::Slam => {
                Input::one("input.toml", "[tracking]\nmin_matches = 20\n[mapping]\nlost_ratio = 0.5\n")
            }
            Self::Topics => Input::one(
                "input.toml",
                "image = \"/camera/image/compressed\"\nodometry = \"/odom\"\nbase_frame = \"base_footprint\"\n",
            ),
            Self::RosParameters => {
                Input::one("input.yaml", "/**:\n  ros__parameters:\n    seed: 3\n    overwrite: false\n")
            }
            Self::Robot => Input::one(
                "input.toml",
                "[camera]\npitch_down_deg = 0.5\n[odometry]\nscale = [1.01, 1.0, 1.0]\n",
            ),
            Self::Urdf => Input::one("input.urdf", seed("robot_description", 0)),
            Self::Recording => Input::one("input.mcap", recording()),
            Self::VisualMap => Input::one("input.vmap", seed("map_of_slam", 0)),
            Self::Benchmark => Input {
                name: "input",
                files: vec![(
                    "input/cells/R1.json",
                    parsers::benchmarks::result(
                        "field, tour",
                        "evolutionary",
                        101,
                        &json!({ "position_m": 0.1 }),
                    )
                    .into(),
                )],
            },
            Self::Experiment => Input {
                name: "input",
                files: vec![
                    ("input/experiment.json", parsers::experiments::manifest().into()),
                    ("input/records.jsonl", Vec::new()),
                ],
            },
        }
    }
}

const KITTI: &str = "1 0 0 0.5 0 1 0 0 0 0 1 2\n1 0 0 0.6 0 1 0 0.1 0 0 1 2\n1 0 0 0.6 0 1 0 0.3 0 0 1 3\n";
const EUROC_POSES: &str = "#t,x,y,z,qw,qx,qy,qz\n1000000000,0,0,0,1,0,0,0\n1100000000,0.1,0,0,1,0,0,0\n1200000000,0.2,0.1,0,1,0,0,0\n1300000000,0.2,0.3,0.1,1,0,0,0\n";
const SCENARIO: &str = "map = \"robocup-spl-2010\"\nduration_secs = 2.0\nframes_per_sec = 10.0\n[start]\nx_m = 0.5\ny_m = 0.2\nyaw_deg = 30.0\n";

fn seed(parser: &str, number: usize) -> Vec<u8> {
    let parser = parsers::PARSERS.iter().find(|known| known.name == parser).unwrap();
    (parser.seeds)().swap_remove(number)
}

/// Some frames of a recorded robot, without chunks so that half of the file is half of the frames.
fn bag() -> Vec<u8> {
    let workspace = Workspace::new();
    let options = BagWriterOptions { has_chunks: false, ..BagWriterOptions::default() };
    workspace.bag_with("bag.mcap", 6, options, |_, _| {});
    fs::read(workspace.path("bag.mcap")).unwrap()
}

fn testdata(name: &str) -> Vec<u8> {
    fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata").join(name)).unwrap()
}

fn metadata() -> Vec<u8> {
    b"rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  relative_file_paths:\n    - input_0.mcap\n".to_vec()
}

/// Something with corners.
pub fn picture(shift: u32) -> RgbImage {
    let mut image = RgbImage::new(48, 36);
    for y in 0..36 {
        for x in 0..48 {
            let is_light = ((x + shift) / 6 + y / 6).is_multiple_of(2);
            image.set(x, y, if is_light { [200, 190, 180] } else { [40, 60, 50] });
        }
    }
    image
}

/// All color classes in stripes.
pub fn labels() -> RgbImage {
    let colors = [[0, 255, 0], [255, 255, 255], [255, 255, 0], [0, 0, 255], [255, 128, 0], [0, 0, 0]];
    let mut image = RgbImage::new(48, 36);
    for y in 0..36 {
        for x in 0..48 {
            image.set(x, y, colors[(x / 8) as usize]);
        }
    }
    image
}

fn png(shift: u32) -> Vec<u8> {
    encode_png(&picture(shift)).unwrap()
}

fn tum(order: [&'static str; 3]) -> Input {
    let mut files = vec![
        ("input/rgb/1.png", png(0)),
        ("input/rgb/2.png", png(1)),
        ("input/rgb/3.png", png(2)),
        ("input/rgb/4.png", png(3)),
    ];
    for name in order.into_iter().rev() {
        let text = match name {
            "input/rgb.txt" => "# seconds file\n1.0 rgb/1.png\n1.1 rgb/2.png\n1.2 rgb/3.png\n1.3 rgb/4.png\n",
            "input/camera.yaml" => TUM_CAMERA,
            _ => TRUTH,
        };
        files.insert(0, (name, text.into()));
    }
    Input { name: "input", files }
}

fn euroc() -> Input {
    let camera =
        "rate_hz: 10\nresolution: [48, 36]\ncamera_model: pinhole\nintrinsics: [39.5, 39.5, 23.5, 17.5]\n";
    let list = "#timestamp [ns],filename\n1000000000,1.png\n1100000000,2.png\n1200000000,3.png\n";
    Input {
        name: "input",
        files: vec![
            ("input/mav0/cam0/data.csv", list.into()),
            ("input/mav0/cam0/sensor.yaml", camera.into()),
            ("input/mav0/cam0/data/1.png", png(0)),
            ("input/mav0/cam0/data/2.png", png(1)),
            ("input/mav0/cam0/data/3.png", png(2)),
        ],
    }
}

fn kitti() -> Input {
    Input {
        name: "input",
        files: vec![
            ("input/times.txt", "0.0\n0.1\n0.2\n".into()),
            ("input/calib.txt", "P0: 39.5 0 23.5 0 0 39.5 17.5 0 0 0 1 0\n".into()),
            ("input/poses.txt", KITTI.into()),
            ("input/image_0/000000.png", png(0)),
            ("input/image_0/000001.png", png(1)),
            ("input/image_0/000002.png", png(2)),
        ],
    }
}

/// What the program in place of ffmpeg hands on as it is.
fn video() -> Vec<u8> {
    (0..4).flat_map(|shift| [b"P6\n48 36\n255\n", picture(shift).data()].concat()).collect()
}

fn camera_as(format: CameraFormat) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("camera.toml");
    fs::write(&path, CAMERA.replace("0.0]", "0.0]\n")).unwrap();
    write_camera(&read_camera(&path).unwrap(), format, "a camera").unwrap()
}

fn recording() -> Vec<u8> {
    seed("studio_recording", 1)
}

/// The good files that commands need beside the input.
pub fn write_good_files(folder: &Path) {
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    };
    for (name, bytes) in &Kind::Tum.good().files {
        write(&name.replacen("input", "tum", 1), bytes);
    }
    write("bag.mcap", &bag());
    write("room.vmap", Kind::VisualMap.good().main().1);
    write("camera.toml", CAMERA.as_bytes());
    write("robot.tum", TRUTH.as_bytes());
    write("camera.tum", TRUTH.as_bytes());
    write("camera.kitti", KITTI.as_bytes());
    write("image.png", &png(0));
    write("labels.png", &encode_png(&labels()).unwrap());
    // Hands on its input as it is.
    let script = "#!/bin/sh\n[ \"$1\" = -version ] && echo 'ffmpeg version 5.1.9' && exit 0\n\
                  while [ \"$1\" != -i ]; do shift; done\nexec cat \"${2#file:}\"\n";
    write_program(&folder.join("ffmpeg"), script);
}
