//! Trajectories and the lists of datasets.

use std::fs;

use visloc_core::RgbImage;
use visloc_io::{
    camera_trajectory::read_camera_trajectory_file,
    image_codec::save_png,
    sequence::{SequenceOptions, list_sequence},
    trajectory::read_trajectory,
};

use super::{as_file, choice, chosen, in_folder};

const TUM: &str = "# t x y z qx qy qz qw\n1700000000.03 1 2 0.25 0 0 0.7071067811865476 0.7071067811865476\n1700000000.1 0 0 0 0 0 0 1\n";

pub fn trajectory_seeds() -> Vec<Vec<u8>> {
    let all = [
        TUM,
        "t,x,y,z,yaw,carried\n1.5,1,2,0.1,-0.5,0\n1.6, 1,2,0.1,-0.5,0\n",
        "t,x,y,z,yaw,reliability\n1.5,1,2,0.1,-0.5,0.9\n1.6, 1,2,0.1,-0.5,0\n",
        "t,x,y,z,qx,qy,qz,qw,map,reliability,sigma_x,sigma_y,sigma_z,sigma_angle,localized,carried,found\n\
         1.5,1,2,0.1,0,0,0,1,0,0.2,0.5,0.5,0.5,0.1,0,0,0\n1.6,1,2,0.1,0,0.6,0,0.8,0,0.9,0.1,0.1,0.1,0.02,1,0,1\n",
        "1 0 0 0.5 0 1 0 0 0 0 1 2\n1 0 0 0.6 0 1 0 0 0 0 1 2\n",
        "#t,x,y,z,qw,qx,qy,qz,vx\n1403636579763555584,4.6,-1.7,0.6,0.5,-0.1,-0.8,-0.03,0\n1403636579863555584,4.6,-1.7,0.6,1,0,0,0,0\n",
    ];
    all.map(|text| text.as_bytes().to_vec()).into()
}

pub fn trajectory(bytes: &[u8]) {
    as_file("poses.txt", bytes, |path| {
        if let Ok(poses) = read_trajectory(path) {
            assert!(poses.poses().iter().all(|pose| pose.world_from_robot.is_finite()));
        }
        let _ = visloc_cli::reliabilities_in(path);
        if let Ok(file) = read_camera_trajectory_file(path) {
            assert!(file.trajectory.poses().windows(2).all(|pair| pair[0].at < pair[1].at));
        }
    });
}

/// A layout: its folder here, and its files with good contents. The file that the input stands for comes first.
struct Layout {
    folder: &'static str,
    files: &'static [(&'static str, &'static str)],
    images: &'static [&'static str],
}

const CAMERA: &str = "width: 8\nheight: 6\nfx: 5\nfy: 5\ncx: 3.5\ncy: 2.5\n";
const RGB: &str = "1.0 rgb/1.png\n1.1 rgb/2.png\n";
const CALIB: &str = "P0: 707 0 601 0 0 708 183 0 0 0 1 0\n";
const CAM0: &str = "rate_hz: 20\nresolution: [752, 480]\nintrinsics: [458, 457, 367, 248]\n";
const DATA: &str = "#timestamp [ns],filename\n1403636579763555584,1.png\n1403636579863555584,2.png\n";
const KITTI: &str = "1 0 0 0.5 0 1 0 0 0 0 1 2\n1 0 0 0.6 0 1 0 0 0 0 1 2\n";

const LAYOUTS: [Layout; 10] = [
    Layout {
        folder: "tum",
        files: &[("rgb.txt", RGB), ("camera.yaml", CAMERA)],
        images: &["rgb/1.png", "rgb/2.png"],
    },
    Layout {
        folder: "tum-truth",
        files: &[("groundtruth.txt", TUM), ("rgb.txt", RGB), ("camera.yaml", CAMERA)],
        images: &["rgb/1.png"],
    },
    Layout {
        folder: "euroc",
        files: &[("mav0/cam0/data.csv", DATA), ("mav0/cam0/sensor.yaml", CAM0)],
        images: &["mav0/cam0/data/1.png", "mav0/cam0/data/2.png"],
    },
    Layout {
        folder: "euroc-truth",
        files: &[
            (
                "mav0/state_groundtruth_estimate0/data.csv",
                "#t\n1403636579763555584,4.6,-1.7,0.6,0.5,-0.1,-0.8,-0.03,0\n",
            ),
            ("mav0/cam0/data.csv", DATA),
            ("mav0/cam0/sensor.yaml", CAM0),
        ],
        images: &["mav0/cam0/data/1.png"],
    },
    Layout {
        folder: "kitti-times",
        files: &[("times.txt", "0.0\n0.1\n"), ("calib.txt", CALIB), ("poses.txt", KITTI)],
        images: &["image_0/000000.png", "image_0/000001.png"],
    },
    Layout {
        folder: "kitti-poses",
        files: &[("poses.txt", KITTI), ("calib.txt", CALIB), ("times.txt", "0.0\n0.1\n")],
        images: &["image_0/000000.png", "image_0/000001.png"],
    },
    Layout {
        folder: "kitti-calib",
        files: &[("calib.txt", CALIB), ("poses.txt", KITTI)],
        images: &["image_0/000000.png"],
    },
    Layout {
        folder: "icl",
        files: &[
            ("associations.txt", "1 depth/1.png 1 rgb/1.png\n2 depth/2.png 2 rgb/2.png\n"),
            ("livingRoom0.gt.freiburg", "1 0 0 -2.25 0 0 0 1\n2 0 0 -2.25 0 0 0 1\n"),
        ],
        images: &["rgb/1.png", "rgb/2.png"],
    },
    Layout {
        folder: "zurich",
        files: &[(
            "Log Files/GroundTruthAGL.csv",
            "imgid, x_gps, y_gps, z_gps, omega, phi, kappa\n1, 465691.1, 5247933.0, 471.0, 80.0, 1.0, 2.0\n",
        )],
        images: &["MAV Images/00001.jpg", "MAV Images/00031.jpg"],
    },
    Layout {
        folder: "images",
        files: &[("camera.yaml", CAMERA), ("groundtruth.txt", TUM)],
        images: &["1.png", "2.png"],
    },
];

pub fn dataset_seeds() -> Vec<Vec<u8>> {
    LAYOUTS.iter().enumerate().map(|(form, layout)| chosen(form, layout.files[0].1)).collect()
}

pub fn dataset(bytes: &[u8]) {
    let Some((form, rest)) = choice(bytes, LAYOUTS.len()) else { return };
    let Layout { folder, files, images } = &LAYOUTS[form];
    in_folder(|root| {
        let folder = root.join(folder);
        if !folder.exists() {
            for (name, content) in *files {
                let path = folder.join(name);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(path, content).unwrap();
            }
            for name in *images {
                let path = folder.join(name);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                save_png(&RgbImage::new(8, 6), &path).unwrap();
            }
        }
        fs::write(folder.join(files[0].0), rest).unwrap();
        if let Ok(listing) = list_sequence(&folder, &SequenceOptions::default()) {
            assert!(listing.images.windows(2).all(|pair| pair[0].at < pair[1].at), "time increases");
        }
    });
}
