//! `visloc studio`.

use std::{net::IpAddr, path::Path};

use clap::Args;

use super::{
    InputName, InputPath, OutputFolder, OutputRecording, OverwriteArg, SeedArg, SourceArgs, TopicArgs,
    number::whole, shared::token,
};

/// Arguments of `visloc studio`.
#[derive(Debug, Args)]
#[command(
    long_about = "Opens a page in the browser: watch a simulated robot on the field or in an office, drive it, kidnap it, and see \
                  how several algorithms find it again. Every parameter can be changed while it runs.\n\n\
                  Only this computer can open the page, unless --listen is given; then a token is needed, which is in the \
                  address that is printed.",
    after_long_help = "Examples:\n  \
                       visloc studio\n  \
                       visloc studio --scene office --seed 7\n  \
                       visloc studio sim:team\n  \
                       visloc localize sim:kidnaps --record out/kidnaps.mcap\n  \
                       visloc studio --replay out/kidnaps.mcap\n  \
                       visloc studio --scene sim:room\n  \
                       visloc studio recording.mcap --map robocup-spl-2010\n  \
                       visloc studio clip.mp4 --camera camera.toml\n  \
                       visloc studio clip.mp4 --camera camera.toml --map room.vmap\n  \
                       visloc studio ros2:/camera/image_raw --map my-field.toml\n  \
                       visloc studio --listen 0.0.0.0 --no-open"
)]
pub struct StudioArgs {
    /// Follow a robot or a camera through any source (see: visloc sources): with --map, or with sim:SCENARIO, on a known map, else
    /// without one; sim:team is a team of robots
    #[arg(value_name = "SOURCE")]
    pub source: Option<InputName>,
    /// The map that SOURCE moves on: a name (visloc maps) or a file, also one of visloc slam (.vmap)
    #[arg(long, value_name = "NAME|FILE", requires = "source")]
    pub map: Option<InputName>,
    /// What to show first: robocup-2010, robocup-2024, office, office-large, sim:team for a team of robots, or
    /// sim:room, sim:hall, sim:walking, sim:kidnap for SLAM [default: robocup-2010]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["source", "replay"])]
    pub scene: Option<String>,
    /// Play a recording that was made with --record; can be given several times
    #[arg(long, value_name = "FILE")]
    pub replay: Vec<InputPath>,
    /// Write the recording of --replay as another file instead of opening the page: .rrd for the Rerun viewer
    #[arg(long, value_name = "FILE", requires = "replay", conflicts_with_all = ["source", "sequence", "scene", "connect", "recordings", "port", "listen", "no_open"])]
    pub export: Option<OutputRecording>,
    #[command(flatten)]
    pub overwrite: OverwriteArg,
    /// Follow a camera without a map (as visloc slam SOURCE); can be given several times
    #[arg(long, value_name = "SOURCE")]
    pub sequence: Vec<InputName>,
    /// Watch a robot elsewhere, where visloc localize or slam runs with --publish
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "scene", value_parser = host_and_port)]
    pub connect: Option<String>,
    /// What the robot elsewhere asks for; it printed it
    #[arg(long, value_name = "TOKEN", requires = "connect", conflicts_with = "scene", value_parser = token)]
    pub token: Option<String>,
    /// Where the page's button puts recordings [default: out/studio]
    #[arg(long, value_name = "DIR")]
    pub recordings: Option<OutputFolder>,
    /// Port of the page; 0 for any free one
    #[arg(long, default_value_t = 7878, value_parser = whole::<u16>(0..))]
    pub port: u16,
    /// Address to listen at instead of this computer's own; then a token is needed
    #[arg(long, value_name = "ADDRESS", value_parser = address)]
    pub listen: Option<IpAddr>,
    /// Do not open the browser
    #[arg(long)]
    pub no_open: bool,
    #[command(flatten)]
    pub seed: SeedArg,
    #[command(flatten)]
    pub options: SourceArgs,
    #[command(flatten)]
    pub topics: TopicArgs,
}

/// The address of another computer with a port.
fn host_and_port(text: &str) -> Result<String, String> {
    let port = text
        .rsplit_once(':')
        .filter(|(host, _)| !host.is_empty())
        .and_then(|(_, port)| port.parse::<u16>().ok());
    port.map(|_| text.to_owned())
        .ok_or_else(|| "expected a computer and a port, such as robot.local:7979".to_owned())
}

/// An address of this computer, without the port.
fn address(text: &str) -> Result<IpAddr, String> {
    text.parse().map_err(|_| match text.parse::<std::net::SocketAddr>() {
        Ok(both) => format!("expected an address alone: --listen {} --port {}", both.ip(), both.port()),
        Err(_) => "expected an address such as 0.0.0.0".to_owned(),
    })
}

impl StudioArgs {
    /// Where the page's button puts recordings.
    pub fn recordings(&self) -> &Path {
        self.recordings.as_deref().unwrap_or(Path::new("out/studio"))
    }
}
