//! Writes frames of a scenario as PNG files: `render_frames SCENARIO DIRECTORY [FIRST STEP COUNT [SEED [THREADS]]]`.

use std::{env, error::Error, path::Path};

use visloc_core::Source;
use visloc_sim::{Scenario, Simulation};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [name, directory, numbers @ ..] = arguments.as_slice() else {
        return Err("expected a scenario and a directory".into());
    };
    let number = |i: usize, default: usize| numbers.get(i).map_or(Ok(default), |text| text.parse());
    let (first, step, count) = (number(0, 0)?, number(1, 90)?, number(2, 8)?);
    let scenario = Scenario::load(name)?;
    let mut simulation = Simulation::new(&scenario, number(3, 1)? as u64)?.with_threads(number(4, 2)?);
    let mut index = 0;
    while let Some(frame) = simulation.next_item() {
        let image = frame?.frame.image;
        if index >= first && (index - first) % step == 0 {
            let path = Path::new(directory).join(format!("{name}-{index:05}.png"));
            let (width, height) = (image.width(), image.height());
            image::save_buffer(path, image.data(), width, height, image::ColorType::Rgb8)?;
        }
        index += 1;
        if index >= first + step * count {
            break;
        }
    }
    Ok(())
}
