//! The same figures as `evo` 1.38 on a trajectory that is made here, for several settings.
//!
//! Made with its Python interface: `sync.associate_trajectories(truth, estimate, max_diff=0.01)`, `align`, then `APE` and
//! `RPE` for the translation and for the rotation in degrees.

#![allow(clippy::unwrap_used, clippy::unreadable_literal)] // a test may stop; figures as they were printed

use nalgebra::{Rotation3, Vector3};
use visloc_core::{
    CameraPose, CameraTrajectory, Timestamp,
    eval::camera::{Alignment, Motions, Statistics, Step, absolute_error, associate, relative_errors},
    geom::Rigid3,
};

/// A loop of 10 s with a truth at 20 Hz; the estimate is moved, smaller, noisy, late or early by 3 ms, and has a gap.
fn trajectories() -> (CameraTrajectory, CameraTrajectory) {
    let (mut truth, mut estimate) = (CameraTrajectory::new(), CameraTrajectory::new());
    let moved = Rotation3::from_scaled_axis(Vector3::new(0.4, -0.3, 1.1));
    for i in 0..200 {
        let n = f64::from(i);
        let s = 0.05 * n;
        let position = Vector3::new(2.0 * (0.6 * s).cos(), 1.5 * (0.6 * s).sin(), 0.3 * (1.7 * s).sin());
        let turn = Vector3::new(0.2 * (0.5 * s).sin(), 0.3 * (0.4 * s).cos(), 0.6 * s);
        let rotation = Rotation3::from_scaled_axis(turn);
        let pose = |at, rotation, position| CameraPose {
            at: Timestamp::from_secs(at),
            world_from_camera: Rigid3::new(rotation, position),
        };
        truth.push(pose(10.0 + s, rotation, position)).unwrap();
        if (60..80).contains(&i) || i % 3 == 2 {
            continue;
        }
        let noise = Vector3::new((12.9 * n).sin(), (78.2 * n).sin(), (37.7 * n).sin()) * 0.01;
        let shaken = Vector3::new((1.3 * n).sin(), (2.1 * n).cos(), (3.7 * n).sin()) * 0.01;
        let seen = moved * position * 0.4 + Vector3::new(1.0, -2.0, 0.5) + noise;
        let rotation = moved * rotation * Rotation3::from_scaled_axis(shaken);
        estimate.push(pose(10.0 + s + 0.003 * n.sin(), rotation, seen)).unwrap();
    }
    (truth, estimate)
}

/// RMSE, mean, median, standard deviation, least, largest, sum of squares.
type Figures = [f64; 7];

fn assert_equal(errors: &[f64], expected: &Figures, what: &str) {
    let s = Statistics::of(errors).unwrap();
    let found = [s.rmse, s.mean, s.median, s.std, s.min, s.max, s.sse];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-6 * expected.max(1.0), "{what}: {found} instead of {expected}");
    }
}

fn degrees(angles_rad: &[f64]) -> Vec<f64> {
    angles_rad.iter().map(|angle| angle.to_degrees()).collect()
}

#[test]
fn absolute_errors_are_those_of_evo() {
    let cases: [(Alignment, f64, Figures, Figures); 3] = [
        (
            Alignment::None,
            1.0000000000,
            [
                2.7271748122,
                2.5516954807,
                2.6703748575,
                0.9624617550,
                0.9203591376,
                3.8948061455,
                892.4978947331,
            ],
            [
                69.2216685192,
                69.2204480006,
                69.2311948049,
                0.4110610400,
                68.4657981888,
                69.9821738593,
                574996.7271104007,
            ],
        ),
        (
            Alignment::Rigid,
            1.0000000000,
            [
                1.0665721996,
                1.0591544927,
                1.0743412062,
                0.1255707673,
                0.8128818784,
                1.2367248142,
                136.5091508384,
            ],
            [
                0.7450704475,
                0.7347163384,
                0.7463627313,
                0.1237815570,
                0.3462154362,
                0.9588778038,
                66.6155966091,
            ],
        ),
        (
            Alignment::Similarity,
            2.4988907331,
            [
                0.0247651486,
                0.0233244128,
                0.0248379272,
                0.0083237224,
                0.0020587891,
                0.0362796066,
                0.0735975104,
            ],
            [
                0.7450704475,
                0.7347163384,
                0.7463627313,
                0.1237815570,
                0.3462154362,
                0.9588778038,
                66.6155966091,
            ],
        ),
    ];
    let (truth, estimate) = trajectories();
    let pairs = associate(&truth, &estimate, 0.01);
    assert_eq!(pairs.len(), 120);
    for (alignment, scale, translation, rotation) in cases {
        let error = absolute_error(&pairs, alignment).unwrap();
        assert!((error.similarity.scale - scale).abs() < 1e-6, "{alignment:?}");
        assert_equal(&error.each, &translation, &format!("{alignment:?}, translation"));
        assert_equal(&degrees(&error.each_rotation_rad), &rotation, &format!("{alignment:?}, rotation"));
    }
}

/// Alignment, what a motion is, number of motions, then the figures of translation (m) and rotation (degrees).
const RELATIVE: [(Alignment, Step, Motions, usize, Figures, Figures); 8] = [
    (
        Alignment::None,
        Step::Frames(1),
        Motions::Consecutive,
        119,
        [0.0931555965, 0.0573073511, 0.0529716712, 0.0734427169, 0.0199212991, 0.8306945263, 1.0326778531],
        [1.3041894602, 1.2921176061, 1.3037254370, 0.1770373972, 0.9833381658, 1.5957318261, 202.4083076084],
    ),
    (
        Alignment::None,
        Step::Frames(10),
        Motions::All,
        110,
        [0.5991029683, 0.5612569279, 0.5093979032, 0.2095591265, 0.4010469647, 1.2295633336, 39.4816803271],
        [0.5997094778, 0.5586750817, 0.5603520752, 0.2180220420, 0.1438374091, 1.6035213384, 39.5616603489],
    ),
    (
        Alignment::None,
        Step::Meters(0.5),
        Motions::Consecutive,
        8,
        [0.8035620755, 0.7852376162, 0.7349264677, 0.1706279438, 0.6609107020, 1.2295633336, 5.1656960728],
        [0.9118354731, 0.8507655917, 0.7138839745, 0.3280881557, 0.5254402518, 1.6035213384, 6.6515514402],
    ),
    (
        Alignment::None,
        Step::Meters(0.5),
        Motions::All,
        95,
        [0.6951937105, 0.6943074298, 0.6962228917, 0.0350925650, 0.6200974752, 0.8306945263, 45.9129580425],
        [1.0815607367, 1.0375915156, 1.0906574412, 0.3052498552, 0.3692476935, 1.6851371352, 111.1284945905],
    ),
    (
        Alignment::Similarity,
        Step::Frames(1),
        Motions::Consecutive,
        119,
        [0.0277137573, 0.0240763895, 0.0193814240, 0.0137251526, 0.0009470948, 0.0499133755, 0.0913982289],
        [1.3041894602, 1.2921176061, 1.3037254370, 0.1770373972, 0.9833381658, 1.5957318261, 202.4083076084],
    ),
    (
        Alignment::Similarity,
        Step::Frames(10),
        Motions::All,
        110,
        [0.0358826758, 0.0343184771, 0.0348532903, 0.0104789575, 0.0050185242, 0.0523002979, 0.1416323064],
        [0.5997094778, 0.5586750817, 0.5603520752, 0.2180220420, 0.1438374091, 1.6035213384, 39.5616603489],
    ),
    (
        Alignment::Similarity,
        Step::Meters(0.5),
        Motions::Consecutive,
        19,
        [0.0264545124, 0.0239393200, 0.0251301762, 0.0112583384, 0.0061444128, 0.0492025970, 0.0132969833],
        [0.9692914161, 0.9265907708, 0.9321468956, 0.2845266115, 0.3847972481, 1.6100386342, 17.8509911365],
    ),
    (
        Alignment::Similarity,
        Step::Meters(0.5),
        Motions::All,
        95,
        [0.0397876466, 0.0359911487, 0.0374474534, 0.0169615460, 0.0023388735, 0.0681479020, 0.1503903983],
        [1.0464948389, 0.9876286130, 0.9822393981, 0.3460363718, 0.1324342488, 1.5869852962, 104.0393875505],
    ),
];

#[test]
fn relative_errors_are_those_of_evo() {
    let (truth, estimate) = trajectories();
    let pairs = associate(&truth, &estimate, 0.01);
    for (alignment, step, motions, count, translation, rotation) in RELATIVE {
        let similarity = match alignment {
            Alignment::None => visloc_core::geom::Similarity::identity(),
            other => absolute_error(&pairs, other).unwrap().similarity,
        };
        let errors = relative_errors(&pairs, step, motions, &similarity);
        let what = format!("{alignment:?}, {step:?}, {motions:?}");
        assert_eq!(errors.motions.len(), count, "{what}");
        assert_equal(&errors.translation_m, &translation, &what);
        assert_equal(&degrees(&errors.rotation_rad), &rotation, &what);
    }
}
