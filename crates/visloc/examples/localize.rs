//! Follows a robot through a recording: `cargo run --release -p visloc --example localize -- [BAG] [MAP]`

use visloc::{
    Map, Pipeline, Source,
    io::bag::{BagReader, BagTopics},
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let bag = args.next().unwrap_or_else(|| "testdata/R1-excerpt.mcap".to_owned());
    let map = Map::load(&args.next().unwrap_or_else(|| "robocup-spl-2010".to_owned()))?;

    let mut pipeline = Pipeline::builder(&map).build()?;
    let mut frames = BagReader::open(&bag, BagTopics::default())?;
    while let Some(next) = frames.next_item() {
        let frame = next?.frame;
        let estimate = pipeline.step(&frame)?;
        let (pose, state) = (estimate.world_from_robot, estimate.is_localized());
        println!(
            "{}: x {:.2} m, y {:.2} m, {:.2} rad, localized: {state}",
            frame.at, pose.x_m, pose.y_m, pose.yaw_rad
        );
    }
    Ok(())
}
