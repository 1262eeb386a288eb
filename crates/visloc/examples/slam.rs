//! Follows one camera without a map: `cargo run --release -p visloc --example slam -- [FOLDER OF IMAGES]`

use std::path::PathBuf;

use visloc::{
    ImageSource, Slam, SlamConfig, Source,
    io::sequence::{SequenceOptions, open_sequence},
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "testdata/desk-clip".to_owned());
    let mut images = open_sequence(&PathBuf::from(folder), &SequenceOptions::default())?.images;

    let mut slam = Slam::new(images.camera(), &SlamConfig::default(), 1)?;
    while let Some(next) = images.next_item() {
        let frame = next?;
        let outcome = slam.add_frame(frame.at, frame.image)?;
        println!("{}: {:?}", frame.at, outcome.state);
    }
    slam.complete();
    for pose in slam.trajectory() {
        println!("{}: {:.3?}", pose.at, pose.world_from_camera.translation().as_slice());
    }
    println!("{} keyframes, {} landmarks", slam.map().keyframes().count(), slam.map().landmarks().count());
    Ok(())
}
