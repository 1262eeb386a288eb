//! Boards, cameras and pictures.

use visloc_calib::{
    AprilGrid, Board, CameraFromBoard, Checkerboard,
    render::{RenderSettings, random_pose, render},
};
use visloc_core::{
    GrayImage, RngTree,
    geom::{Camera, Distortion},
};

pub const CHECKERS: Board = Board::Checkerboard(Checkerboard { columns: 9, rows: 6, square_m: 0.03 });
pub const TAGS: Board = Board::AprilGrid(AprilGrid {
    columns: 6,
    rows: 4,
    tag_m: 0.05,
    spacing: 0.3,
    first_id: 0,
    border_cells: 2,
});

pub fn webcam() -> Camera {
    let lens = Distortion::RadialTangential([-0.25, 0.09, 8e-4, -6e-4, -0.01]);
    Camera::new((640, 480), (521.3, 523.1), (323.8, 236.4), lens).unwrap()
}

pub fn fisheye() -> Camera {
    let lens = Distortion::KannalaBrandt([0.03, -0.012, 0.006, -0.002]);
    Camera::new((640, 480), (252.7, 251.9), (317.1, 243.2), lens).unwrap()
}

/// A picture and where the board is in it.
pub fn picture(
    board: &Board,
    camera: &Camera,
    seed: u64,
    index: u64,
    settings: &RenderSettings,
) -> (GrayImage, CameraFromBoard) {
    let mut rng = RngTree::new(seed).stream("board", index);
    let pose = random_pose(board, camera, &mut rng).expect("the board can be seen");
    (render(board, camera, &pose, settings, &mut rng), pose)
}
