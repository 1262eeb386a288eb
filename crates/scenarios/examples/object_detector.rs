//! Precision and recall of the detector of robots and balls, on robots that walk about a simulated field.
//!
//! `cargo run --release -p visloc-scenarios --example object_detector -- [SCENARIO [FIRST_SEED [GAMES]]]`, by default
//! `tour-2024 1 3`: games of 30 seconds.

use visloc_scenarios::DetectionScores;
use visloc_sim::Scenario;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let scenario = Scenario::load(&args.next().unwrap_or("tour-2024".into()))?;
    let first: u64 = args.next().map_or(Ok(1), |arg| arg.parse())?;
    let num_games: u64 = args.next().map_or(Ok(3), |arg| arg.parse())?;
    let mut scores = DetectionScores::default();
    for seed in first..first + num_games {
        scores.add_game(&scenario, seed, 60)?;
    }
    println!(
        "{:<8} {:>9} {:>9} {:>9} {:>9} {:>14}",
        "", "precision", "recall", "found", "visible", "range, median"
    );
    for (name, s) in &scores.0 {
        let error_m = s.median_error_m().unwrap_or(f64::NAN);
        println!(
            "{name:<8} {:>9.3} {:>9.3} {:>9} {:>9} {error_m:>11.3} m",
            s.precision(),
            s.recall(),
            s.num_found,
            s.num_visible
        );
    }
    Ok(())
}
