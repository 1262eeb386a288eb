//! A map in code, and a simulated robot that finds itself in it: `cargo run --release -p visloc --features sim --example own_map`

use visloc::{
    Map, Pipeline, Source,
    sim::{Scenario, Simulation},
    world::office::{CorridorPlan, DoorPlan, Office, OfficePlan, SurfaceColor},
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut plan = OfficePlan::named("my corridor");
    plan.corridors.push(CorridorPlan::closed(vec![[0.0, 0.0], [14.0, 0.0], [14.0, 2.0], [0.0, 2.0]]));
    for x in [1.0, 2.5, 5.5, 10.0] {
        let (height_m, color, is_open) = (2.05, SurfaceColor::RED, false);
        plan.doors.push(DoorPlan { from: [x, 0.0], to: [x + 0.9, 0.0], height_m, color, is_open });
    }
    let map = Map::Office(Office::new("my corridor", plan)?);
    let file = std::env::temp_dir().join("my-corridor.toml");
    std::fs::write(&file, map.to_toml()?)?;

    let scenario = format!("map = {file:?}\nduration_secs = 20.0\n[[motion]]\nwander.secs = 20.0\n");
    let mut frames = Simulation::new(&Scenario::parse("my corridor", &scenario)?, 1)?;
    let mut pipeline = Pipeline::builder(&map).build()?;
    while let Some(next) = frames.next_item() {
        let next = next?;
        let estimate = pipeline.step(&next.frame)?;
        let error_m = next.truth.map(|truth| truth.world_from_robot.distance_m(&estimate.world_from_robot));
        println!("{}: reliability {:.2}, error {error_m:.2?} m", next.frame.at, estimate.reliability);
    }
    Ok(())
}
