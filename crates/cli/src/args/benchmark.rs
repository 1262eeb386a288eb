//! `visloc benchmark`.

use clap::Args;

use super::{InputPath, OutputFolder, number::whole};

/// Arguments of `visloc benchmark`.
#[derive(Debug, Args)]
#[command(
    long_about = "Measures everything that is claimed and writes one table: published figures, the best other program on the same \
                  recordings, and what this program does here, as median and range over recordings and seeds.\n\n\
                  Recordings are found below --data by what they are: bags, videos and folders of images that visloc reads, with \
                  their truth in them or beside them (groundtruth.txt, .tum, .csv). A bag with a map beside it (map.toml, \
                  field.toml, map.yaml, field.yaml) is one of a robot that knows its map, all others are for SLAM. What cannot be \
                  used is listed with the reason. The simulator's scenarios are run as well, with --data or without.\n\n\
                  First all runs for accuracy, as many at the same time as there are cores, then some of them again for times and \
                  memory, one program at a time. Every run is a file in DIR/cells: the same command goes on after an interruption. \
                  Results of another build, recording or option are not taken. Written are report.html with pictures, report.md and \
                  report.csv.\n\n\
                  --quick takes excerpts of one recording of each class, one seed and the first settings: for a first look and for \
                  comparing two versions, not for quoting.",
    after_long_help = "Examples:\n  \
                       visloc benchmark --quick --out out/quick                          the simulator alone, a minute or two\n  \
                       visloc benchmark --data recordings --out out/now                  run again to go on after an interruption\n  \
                       visloc benchmark --data recordings --out out/new --baseline out/now    what got better, what got worse\n  \
                       visloc benchmark --only R2 --data recordings --out out/r2"
)]
pub struct BenchmarkArgs {
    /// Search this folder for recordings; can be given several times [default: the simulator's scenarios alone]
    #[arg(long, value_name = "DIR")]
    pub data: Vec<InputPath>,
    /// Keep every run and the report in this folder; runs that are there are not done again
    #[arg(long, value_name = "DIR", default_value = "out/benchmark")]
    pub out: OutputFolder,
    /// Compare with an earlier benchmark: its --out
    #[arg(long, value_name = "DIR")]
    pub baseline: Option<InputPath>,
    /// A minute or two, with --data three: excerpts, one seed, one recording of each class
    #[arg(long)]
    pub quick: bool,
    /// Only recordings whose name or class contains this; can be given several times
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Runs of each recording and setting, with seeds from 101 on [default: 1 to 5; 1 with --quick]
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..=1000))]
    pub seeds: Option<u64>,
    /// Images of each recording at most [default: all]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..))]
    pub frames: Option<u32>,
    /// Runs that are done at the same time; changes the speed, never the accuracy [default: all cores]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=1024))]
    pub threads: Option<u16>,
}
