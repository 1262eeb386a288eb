//! A robot that those who watch may drive.

use std::sync::Arc;

use anyhow::{Result, bail};
use visloc_core::{Clock, Source, SourceFrame};
use visloc_io::{
    sequence::SequenceRange,
    sources::{Purpose, SourceAddress, SourceOptions, UntilStopped, simulated_scenario},
};
use visloc_sim::{DrivenSimulation, LiveControls, LiveMotion, LiveSimulation};
use visloc_studio::server::{DriveLimits, DriveOrder, Wheel};

use crate::{args::DriveArgs, host::host, run::OpenSource, stopwatch::Stopwatch};

#[cfg(feature = "ros2")]
use crate::run::RosDriver as Driver;

/// Cannot be made.
#[cfg(not(feature = "ros2"))]
enum Driver {}

/// What moves the robot.
pub struct Steering {
    wheel: Arc<Wheel>,
    is_simulated: bool,
    /// Ends with the run.
    _driver: Option<Driver>,
}

impl Steering {
    /// What moves the robot of a source, if the user lets others drive.
    pub fn of(args: &DriveArgs, source: &str, options: &SourceOptions) -> Result<Option<Self>> {
        if !args.allow_drive {
            return Ok(None);
        }
        let is_simulated = source.starts_with("sim:") && SourceAddress::parse(source)?.has_robot();
        let watch = Stopwatch::start();
        let limits =
            DriveLimits { speed_m_per_s: args.max_speed, turn_rad_per_s: args.max_turn.to_radians() };
        let wheel = Arc::new(Wheel::new(limits, Clock::new(move || watch.secs())));
        if !is_simulated && !source.starts_with("ros2:") {
            bail!(
                "--allow-drive: expected a simulated robot (sim:robocup) or one on ROS 2 topics (ros2:...), found {source}, \
                 where nothing can be moved; leave it out"
            );
        }
        Ok(Some(Self {
            _driver: if is_simulated { None } else { Some(ros_driver(args, options, Arc::clone(&wheel))?) },
            is_simulated,
            wheel,
        }))
    }

    /// What those who watch turn.
    pub fn wheel(&self) -> &Arc<Wheel> {
        &self.wheel
    }

    /// Opens a simulated robot that goes where it is driven, and nowhere by itself, with the map that it walks on; `None` for others.
    pub fn simulated(&self, source: &str, options: &SourceOptions) -> Result<Option<OpenSource>> {
        if !self.is_simulated {
            return Ok(None);
        }
        let address = SourceAddress::parse(source)?;
        address.check(options, Purpose::Frames)?;
        if options.range != SequenceRange::default() {
            bail!(
                "--from, --until, --stride: a robot that is driven has no way from which a part could be taken; leave it out"
            );
        }
        let scenario = simulated_scenario(&address)?;
        let simulation = LiveSimulation::new(&scenario, options.seed.unwrap_or(1))?;
        let map = simulation.map().clone();
        let wheel = Arc::clone(&self.wheel);
        let frames: Box<dyn Source<SourceFrame>> =
            Box::new(DrivenSimulation::new(simulation, move || controls(&wheel.order())));
        Ok(Some(OpenSource {
            frames: Box::new(UntilStopped::of_kind(frames, host(), true)),
            map,
            warnings: Vec::new(),
        }))
    }
}

fn controls(order: &DriveOrder) -> LiveControls {
    let [forward_m_per_s, left_m_per_s, turn_rad_per_s] = order.speeds;
    let motion = LiveMotion::Walk { forward_m_per_s, left_m_per_s, turn_rad_per_s };
    LiveControls { motion, head: order.head, ..LiveControls::default() }
}

#[cfg(feature = "ros2")]
fn ros_driver(args: &DriveArgs, options: &SourceOptions, wheel: Arc<Wheel>) -> Result<Driver> {
    let joints = <[String; 2]>::try_from(args.head_joints.clone());
    let topics = visloc_io::ros2::DriveTopics {
        velocity: args.drive_topic.clone(),
        head: args.head_topic.clone(),
        joints: joints
            .map_err(|found| anyhow::anyhow!("--head-joints: expected two names, found {found:?}"))?,
    };
    Driver::start(options.domain_id(), &topics, move || {
        let order = wheel.order();
        (order.is_driven.then_some(order.speeds), order.head)
    })
}

#[cfg(not(feature = "ros2"))]
fn ros_driver(_: &DriveArgs, _: &SourceOptions, _: Arc<Wheel>) -> Result<Driver> {
    bail!("--allow-drive: this visloc was built without ROS 2; build with --features ros2")
}
