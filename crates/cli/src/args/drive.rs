//! Whether others may move the robot.

use clap::Args;

use super::number::within;

/// Driving over the link.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "For the studio")]
pub struct DriveArgs {
    /// Let those who watch drive: a simulated robot, or one on ROS 2 topics (/cmd_vel). They need a token then, on this computer too
    #[arg(long, requires = "publish")]
    pub allow_drive: bool,
    /// Fastest that they may drive, meters per second; half of it to the sides
    #[arg(long, value_name = "M_PER_S", default_value_t = 0.3, value_parser = within(0.01, 10.0), requires = "allow_drive")]
    pub max_speed: f64,
    /// Fastest that they may turn, degrees per second
    #[arg(long, value_name = "DEG_PER_S", default_value_t = 50.0, value_parser = within(1.0, 360.0), requires = "allow_drive")]
    pub max_turn: f64,
    /// Where a robot on ROS 2 takes speeds, geometry_msgs/Twist
    #[arg(long, value_name = "TOPIC", default_value = "/cmd_vel", requires = "allow_drive")]
    pub drive_topic: String,
    /// Where its head takes trajectory_msgs/JointTrajectory
    #[arg(
        long,
        value_name = "TOPIC",
        default_value = "/head_controller/joint_trajectory",
        requires = "allow_drive"
    )]
    pub head_topic: String,
    /// Joints of its head: to the left, and down
    #[arg(
        long,
        value_name = "NAME",
        num_args = 2,
        default_values = ["head_pan_joint", "head_tilt_joint"],
        requires = "allow_drive"
    )]
    pub head_joints: Vec<String>,
}
