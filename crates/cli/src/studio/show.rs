//! Shows a run to a recording and to pages, and does what people there ask for.

use anyhow::{Context, Result};
use visloc_core::StampedPose;
use visloc_io::trajectory::{write_tum_header, write_tum_pose};
use visloc_studio::{Command, StudioError, recording::Input, tuning, view::RunViewer};

use super::{
    broadcast::{Broadcast, new_saved_file},
    steering::Steering,
};
use crate::{
    args::LocalizeArgs,
    run::{FrameView, Runner, Spectator, write_text},
};

/// A spectator that shows what it sees to others.
struct Show {
    broadcast: Broadcast,
    viewer: RunViewer,
}

/// Shows a run to whom the user asks for; `None` if to nobody.
pub fn open_show(args: &LocalizeArgs, steering: Option<&Steering>) -> Result<Option<Box<dyn Spectator>>> {
    let Some(broadcast) = Broadcast::open(&args.broadcast, steering)? else { return Ok(None) };
    Ok(Some(Box::new(Show { broadcast, viewer: RunViewer::new(&args.source) })))
}

impl Show {
    /// The notice that answers a command.
    fn obey(&self, command: &Command, runner: &mut Runner) -> Result<Option<String>> {
        if matches!(command, Command::Save {}) {
            let path = new_saved_file("trajectory", "tum")?;
            let mut text = Vec::new();
            write_tum_header(&mut text)?;
            for record in runner.records().iter() {
                let world_from_robot = record.world_from_robot;
                write_tum_pose(&mut text, &StampedPose { at: record.at, world_from_robot, height_m: 0.0 })?;
            }
            write_text(&path, std::str::from_utf8(&text).context("trajectory")?)?;
            return Ok(Some(format!("saved on the robot: {}", path.display())));
        }
        match command {
            Command::Reset { seed } => runner.lineup_mut().reset(*seed)?,
            Command::Algorithms { names } if names.len() != 1 => {
                let expected = "one: this run writes the results of one";
                return Err(StudioError::command("algorithms", expected, names.len()).into());
            }
            command if tuning::obey(runner.lineup_mut(), command)? => {}
            Command::Drive { .. } | Command::Head { .. } => {
                let expected = "a robot that others may drive: it runs with --allow-drive";
                return Err(StudioError::command("driving", expected, "one that moves by itself").into());
            }
            command => {
                let expected = "one for a run: parameters, reset, forget, save, pause";
                return Err(StudioError::command("command", expected, command.name()).into());
            }
        }
        let is_reset = matches!(command, Command::Reset { .. } | Command::Forget {});
        Ok(is_reset.then(|| "the robot's pose is forgotten".to_owned()))
    }
}

impl Spectator for Show {
    fn before_frame(&mut self, runners: &mut [Runner]) {
        let Some(runner) = runners.first_mut() else { return };
        for command in self.broadcast.commands() {
            match self.obey(&command, runner) {
                Ok(Some(notice)) => self.broadcast.tell(&notice),
                Ok(None) => {}
                Err(error) => self.broadcast.tell(&format!("{error:#}")),
            }
        }
    }

    fn after_frame(&mut self, view: &FrameView<'_>) {
        self.broadcast.rest();
        self.broadcast.wait_for(view.secs);
        let Some(runner) = view.runners.first() else { return };
        if self.broadcast.is_wanted() {
            let aside = self.broadcast.aside();
            let input = Input::Robot { frame: view.frame, truth: view.truth.as_ref() };
            match self.viewer.moment(view.frame, view.truth, runner.lineup(), &aside) {
                Ok(moment) => self.broadcast.send(moment.secs(), || moment.update(None), &input),
                Err(error) => self.broadcast.fail(error.into()),
            }
        }
        self.viewer.next_frame();
    }

    fn finish(self: Box<Self>) -> Result<()> {
        self.broadcast.finish()
    }
}
