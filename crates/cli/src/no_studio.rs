//! Stands in for the studio where it was left out of the program.

use anyhow::{Result, bail};
use visloc_core::{CameraTrajectory, GrayFrame, geom::Camera};
use visloc_io::sources::SourceOptions;
use visloc_slam::{Slam, SlamConfig, SlamFrame};
use visloc_vmap::{MapLocalizer, VisualMap};

use crate::{
    args::{BroadcastArgs, DriveArgs},
    run::{FrameView, OpenSource, Spectator},
    slam::SlamAudience,
};

fn check(args: &BroadcastArgs) -> Result<()> {
    for (name, is_given) in [("--record", args.record.is_some()), ("--publish", args.publish.is_some())] {
        if is_given {
            bail!("{name}: this visloc was built without the studio; build with --features studio");
        }
    }
    Ok(())
}

/// Cannot be made.
pub enum Steering {}

impl Steering {
    /// Nothing is driven.
    pub fn of(args: &DriveArgs, _: &str, _: &SourceOptions) -> Result<Option<Self>> {
        if args.allow_drive {
            bail!("--allow-drive: this visloc was built without the studio; build with --features studio");
        }
        Ok(None)
    }

    /// Never called.
    pub fn simulated(&self, _: &str, _: &SourceOptions) -> Result<Option<OpenSource>> {
        match *self {}
    }
}

/// Shows nothing.
pub struct Show;

impl Show {
    /// Shows a run to nobody.
    pub fn open(args: &BroadcastArgs, _: Option<&Steering>, _: &str) -> Result<Self> {
        check(args).map(|()| Self)
    }

    /// There is nothing to complete.
    pub fn finish(self) -> Result<()> {
        Ok(())
    }
}

impl Spectator for Show {
    fn after_frame(&mut self, _: &FrameView<'_>) {}
}

/// Cannot be made.
pub enum MapShow {}

impl MapShow {
    /// Says what is missing.
    pub fn open(
        args: &BroadcastArgs,
        _: Option<&Steering>,
        _: &str,
        _: &SlamConfig,
        _: u64,
    ) -> Result<Option<Self>> {
        check(args).map(|()| None)
    }

    /// Never called.
    pub fn obey(&mut self) -> Option<(SlamConfig, u64)> {
        match *self {}
    }

    /// Never called.
    pub fn look(
        &mut self,
        _: (&VisualMap, Option<&CameraTrajectory>),
        _: &MapLocalizer,
        _: &GrayFrame,
        _: &Camera,
    ) {
        match *self {}
    }

    /// Never called.
    pub fn finish(self) -> Result<()> {
        match self {}
    }
}

/// What is shown of a run.
#[allow(dead_code)]
pub struct Shown<'a> {
    /// Name of the source.
    pub title: &'a str,
    /// The camera.
    pub camera: &'a Camera,
    /// Where the camera was, if that is known.
    pub truth: Option<&'a CameraTrajectory>,
    /// Parameters.
    pub config: &'a SlamConfig,
    /// Seed of everything random.
    pub seed: u64,
}

/// Cannot be made.
pub enum SlamShow {}

impl SlamShow {
    /// Says what is missing.
    pub fn open(args: &BroadcastArgs, _: Option<&Steering>, _: &Shown<'_>) -> Result<Option<Self>> {
        check(args).map(|()| None)
    }

    /// Never called.
    pub fn finish(self) -> Result<()> {
        match self {}
    }
}

impl SlamAudience for SlamShow {
    fn obey(&mut self, _: &Slam) -> Option<(SlamConfig, u64)> {
        match *self {}
    }

    fn look(&mut self, _: &Slam, _: &SlamFrame<'_>) {
        match *self {}
    }
}
