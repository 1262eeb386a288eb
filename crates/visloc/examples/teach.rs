//! Teaches a place and finds another camera in it: `cargo run --release -p visloc --example teach -- [FOLDER] [OTHER FOLDER]`

use std::path::PathBuf;

use visloc::{
    GrayFrame, ImageSource, Slam, SlamConfig, Source,
    io::sequence::{Sequence, SequenceOptions, open_sequence},
    vmap::{MapLocalizer, Session, VisualMap},
};

fn open(number: usize) -> Result<Sequence, Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(number).unwrap_or_else(|| "testdata/desk-clip".to_owned());
    Ok(open_sequence(&PathBuf::from(folder), &SequenceOptions::default())?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut walk = open(1)?.images;
    let mut slam = Slam::new(walk.camera(), &SlamConfig::default(), 1)?;
    while let Some(next) = walk.next_item() {
        let frame = next?;
        slam.add_frame(frame.at, frame.image)?;
    }
    let map = VisualMap::default().after(&slam, Session::default());

    let mut later = open(2)?.images;
    let mut localizer = MapLocalizer::new(&map.map, None, later.camera(), &SlamConfig::default(), 1)?;
    while let Some(next) = later.next_item() {
        let frame = next?;
        match localizer.step(GrayFrame::new(frame.at, frame.image))? {
            Some(known) => println!(
                "{}: {:.2?}, {:.2}",
                frame.at,
                known.world_from_camera.translation().as_slice(),
                known.reliability
            ),
            None => println!("{}: no place", frame.at),
        }
    }
    Ok(())
}
