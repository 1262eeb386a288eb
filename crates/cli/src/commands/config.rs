//! `visloc algorithms` and `visloc config`.

use anyhow::{Result, anyhow};
use visloc_core::settings::commented_toml;
use visloc_io::bag::BagTopics;
use visloc_locate::{ALGORITHMS, Algorithm, PipelineConfig};
use visloc_slam::{PRESETS, SlamPreset};

use crate::{
    args::{ConfigArgs, ConfigCommand, ListArgs},
    report::{Listed, print_list},
    run::print_or_write,
};

/// Runs the command.
pub fn execute(args: &ConfigArgs) -> Result<()> {
    let ConfigCommand::Show { name, out } = &args.command;
    let text = match name.as_str() {
        "pipeline" => commented_toml(&PipelineConfig::default())?,
        "topics" => commented_toml(&BagTopics::default())?,
        name => match SlamPreset::find(name) {
            Ok(preset) => preset.config().commented_toml()?,
            Err(_) => {
                let algorithm = Algorithm::named(name).map_err(|_| {
                    let algorithms = ALGORITHMS.map(|algorithm| algorithm.name).join(", ");
                    let presets = PRESETS.map(|preset| preset.name).join(", ");
                    anyhow!(
                        "{name}: there are no parameters of that name; known are the algorithms {algorithms}, the presets of SLAM \
                         {presets}, pipeline and topics"
                    )
                });
                algorithm?.to_toml()?
            }
        },
    };
    print_or_write(&text, out)
}

/// Prints name and summary of every algorithm.
pub fn list_algorithms(args: &ListArgs) -> Result<()> {
    let all = ALGORITHMS.map(|algorithm| Listed::new(algorithm.name, algorithm.summary));
    print_list(&all, args)
}
