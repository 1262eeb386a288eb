//! `visloc study`: what one image tells about the pose.

use anyhow::Result;

use crate::{
    args::StudyArgs,
    report::save_json,
    run::{Progress, Saving},
    say,
};

/// Runs the command.
pub fn execute(args: &StudyArgs) -> Result<()> {
    let progress = Progress::message("looks from many poses; some studies take a minute or two");
    let outcome = args.study.conduct(args.seed.value());
    progress.clear();
    let outcome = outcome?;
    say::text(format_args!("{}", outcome.report.text()));
    let mut saving = Saving::default();
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, &outcome.report.json));
    saving.save_if(args.out.as_deref(), |folder| {
        outcome.save(folder)?;
        say::line!("\ntables and pictures: {}", folder.display());
        Ok(())
    });
    saving.end()
}
