//! Stands in for the studio where it was left out of the program: says what is missing.

use anyhow::{Result, bail};
use visloc_core::{CameraTrajectory, geom::Camera};
use visloc_io::sources::SourceOptions;
use visloc_slam::SlamConfig;

use crate::{
    args::{BroadcastArgs, DriveArgs, LocalizeArgs, SlamArgs},
    run::{OpenSource, Spectator},
    slam::{MapWatcher, SlamAudience},
};

/// Cannot be made.
pub enum Steering {}

impl Steering {
    pub fn of(args: &DriveArgs, _: &str, _: &SourceOptions) -> Result<Option<Self>> {
        refuse(&[("--allow-drive", args.allow_drive)])
    }

    pub fn simulated(&self, _: &str, _: &SourceOptions) -> Result<Option<OpenSource>> {
        match *self {}
    }
}

pub fn open_show(args: &LocalizeArgs, _: Option<&Steering>) -> Result<Option<Box<dyn Spectator>>> {
    refuse_broadcast(&args.broadcast)
}

pub fn open_map_show(
    args: &LocalizeArgs,
    _: Option<&Steering>,
    _: &SlamConfig,
) -> Result<Option<Box<dyn MapWatcher>>> {
    refuse_broadcast(&args.broadcast)
}

pub fn open_slam_show(
    args: &SlamArgs,
    _: Option<&Steering>,
    _: &SlamConfig,
    _: &Camera,
    _: Option<&CameraTrajectory>,
) -> Result<Option<Box<dyn SlamAudience>>> {
    refuse_broadcast(&args.broadcast)
}

fn refuse_broadcast<T>(args: &BroadcastArgs) -> Result<Option<T>> {
    refuse(&[("--record", args.record.is_some()), ("--publish", args.publish.is_some())])
}

fn refuse<T>(options: &[(&str, bool)]) -> Result<Option<T>> {
    match options.iter().find(|(_, is_given)| *is_given) {
        Some((name, _)) => {
            bail!("{name}: this visloc was built without the studio; build with --features studio")
        }
        None => Ok(None),
    }
}
