//! What is known of a camera in a map, for other programs.

use nalgebra::{Isometry3, Matrix3, Matrix6};
use visloc_core::geom::{CameraFrame, Rigid3, Robot, World};
use visloc_io::bag::{ResultSample, in_space, on_ground};
use visloc_vmap::{CameraEstimate, Hypothesis};

use crate::slam::MapFrame;

/// What is known after a frame. On a robot the poses are those of the robot, for a camera alone those of the camera.
pub fn result_sample(
    frame: &MapFrame,
    estimate: Option<&CameraEstimate>,
    hypotheses: &[Hypothesis],
    num_dropped: usize,
) -> ResultSample {
    let robot = frame.robot.as_ref().map(|(frame, _)| frame);
    let robot_from_camera = robot.map_or(Rigid3::identity(), |frame| frame.robot_from_camera);
    let world_from_robot = |world_from_camera: &Rigid3<World, CameraFrame>| {
        in_space(&(*world_from_camera * robot_from_camera.inverse()))
    };
    let pose = estimate.map(|estimate| world_from_robot(&estimate.world_from_camera));
    ResultSample {
        at: frame.gray.at,
        world_from_robot: pose.unwrap_or_else(Isometry3::identity),
        covariance: estimate.map_or(Matrix6::identity(), |estimate| covariance(estimate, &robot_from_camera)),
        reliability: estimate.map_or(0.0, |estimate| estimate.reliability),
        is_localized: estimate.is_some_and(CameraEstimate::is_localized),
        likelihood: None,
        hypotheses: hypotheses.iter().map(|place| world_from_robot(&place.world_from_camera)).collect(),
        odometry: robot.and_then(|frame| frame.odometry.as_ref()).map(on_ground),
        num_dropped,
    }
}

/// Covariance of the pose of the robot along and about the axes of the map. What turns the camera moves the robot that hangs on it.
fn covariance(estimate: &CameraEstimate, robot_from_camera: &Rigid3<Robot, CameraFrame>) -> Matrix6<f64> {
    let turn = estimate.world_from_camera.rotation();
    let camera_to_robot = turn * robot_from_camera.inverse().translation();
    let mut jacobian = Matrix6::zeros();
    jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(turn);
    jacobian.fixed_view_mut::<3, 3>(3, 3).copy_from(turn);
    let lever: Matrix3<f64> = -camera_to_robot.cross_matrix() * turn;
    jacobian.fixed_view_mut::<3, 3>(0, 3).copy_from(&lever);
    jacobian * estimate.covariance * jacobian.transpose()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};
    use visloc_core::{GrayFrame, GrayImage, RgbImage, Timestamp, geom::Camera};
    use visloc_vmap::Support;

    use super::*;

    fn frame(robot_from_camera: Option<Rigid3<Robot, CameraFrame>>) -> MapFrame {
        let at = Timestamp::from_secs(1.0);
        let gray = GrayFrame::new(at, GrayImage::new(4, 4));
        let camera = Camera::default();
        let robot = robot_from_camera
            .map(|pose| (visloc_core::Frame::new(at, RgbImage::default(), camera, pose), None));
        MapFrame { gray, camera, robot }
    }

    fn estimate(covariance: Matrix6<f64>) -> CameraEstimate {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
        CameraEstimate {
            at: Timestamp::from_secs(1.0),
            map: visloc_slam::map::MapId::default(),
            world_from_camera: Rigid3::new(turn, Vector3::new(1.0, 2.0, 3.0)),
            covariance,
            reliability: 0.9,
            support: Support::Map,
            is_found: false,
        }
    }

    #[test]
    fn a_robot_stands_below_its_camera() {
        let pose = Rigid3::new(Rotation3::identity(), Vector3::new(0.5, 0.0, 1.0));
        let estimate = estimate(Matrix6::identity());
        let CameraEstimate { map, world_from_camera, .. } = estimate;
        let places = [Hypothesis { map, world_from_camera, probability: 0.9 }];
        let sample = result_sample(&frame(Some(pose)), Some(&estimate), &places, 0);
        // The camera is half a meter ahead of the robot, which is turned by a quarter to the left.
        let place = sample.world_from_robot.translation.vector;
        assert!((place - Vector3::new(1.0, 1.5, 2.0)).norm() < 1e-12, "{place}");
        assert!(sample.is_localized && sample.hypotheses.len() == 1);
    }

    #[test]
    fn doubts_are_along_the_axes_of_the_map_and_longer_where_the_robot_is_far_from_its_camera() {
        let along_x = Matrix6::from_diagonal(&nalgebra::Vector6::new(4.0, 1.0, 1.0, 0.0, 0.0, 0.0));
        let alone = result_sample(&frame(None), Some(&estimate(along_x)), &[], 0).covariance;
        assert!((alone[(1, 1)] - 4.0).abs() < 1e-12 && (alone[(0, 0)] - 1.0).abs() < 1e-12, "{alone}");
        let turns = Matrix6::from_diagonal(&nalgebra::Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.01));
        let pose = Rigid3::new(Rotation3::identity(), Vector3::new(2.0, 0.0, 0.0));
        let swung = result_sample(&frame(Some(pose)), Some(&estimate(turns)), &[], 0).covariance;
        assert!((swung[(0, 0)] - 0.04).abs() < 1e-12 && swung[(1, 1)].abs() < 1e-12, "{swung}");
        assert!((swung[(5, 5)] - 0.01).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_localized_without_an_estimate() {
        let sample = result_sample(&frame(None), None, &[], 3);
        assert!(!sample.is_localized && sample.hypotheses.is_empty() && sample.num_dropped == 3);
    }
}
