//! Pictures: individuals near each position over time, and where they end.

use std::sync::Arc;

use visloc_core::RngTree;
use visloc_plot::{
    Color, Panel, Picture, ScatterPicture, ScatterSeries, Series, TimeSeriesPicture, scatter, time_series,
};

use super::{
    contenders::{self, FILTERS},
    experiment::{NUM_ITERATIONS, NUM_LONG_ITERATIONS, scenario},
};
use crate::{
    ExperimentError,
    positions::{Census, Contender, Movement, NEAR_M, Scenario, ScenarioShape, Session},
};

type Pictures = Vec<(String, Picture)>;

/// The runs that the document shows, and their opponents. Source: 2017 figures 5.2 to 5.4.
pub(super) fn published(seed: u64) -> Result<Pictures, ExperimentError> {
    let mut pictures = Vec::new();
    let rows = [
        ("mc-200", contenders::filter(&FILTERS[0], 200)),
        ("mca-200", contenders::filter(&FILTERS[1], 200)),
        ("mce-1000", contenders::filter(&FILTERS[2], 1000)),
        ("systematic-1000", contenders::filter(&FILTERS[4], 1000)),
        ("evolutionary-10", contenders::evolutionary(10)),
    ];
    for (name, contender) in rows {
        for (kind, movement) in [("static", Movement::Static), ("moving", Movement::Straight(0.01))] {
            let shape = ScenarioShape { num_positions: 2, movement, num_iterations: NUM_ITERATIONS };
            pictures.extend(pair(&format!("{name}-{kind}"), &contender, &shape, seed)?);
        }
    }
    Ok(pictures)
}

/// A run with eight moving positions.
pub(super) fn long(seed: u64) -> Result<Pictures, ExperimentError> {
    let movement = Movement::Wandering(0.05);
    let shape = ScenarioShape { num_positions: 8, movement, num_iterations: NUM_LONG_ITERATIONS };
    pair("evolutionary-long", &contenders::evolutionary_long(), &shape, seed)
}

/// Counts over time and the final distribution of the first run.
fn pair(
    name: &str,
    contender: &Contender,
    shape: &ScenarioShape,
    seed: u64,
) -> Result<Pictures, ExperimentError> {
    let seeds = RngTree::new(seed);
    let scenario = scenario(shape, 0, &seeds);
    let mut session = Session::new(contender, Arc::clone(&scenario), 0.0)?;
    let mut rng = seeds.stream("picture", 0);
    let mut census = Census::default();
    let mut points = vec![Vec::new(); shape.num_positions];
    for iteration in 1..=shape.num_iterations {
        session.step(&mut rng);
        session.count(&mut census);
        for (points, count) in points.iter_mut().zip(census.counts()) {
            points.push((iteration as f64, f64::from(*count)));
        }
    }
    let name_of_all = contender.label.split(',').next().unwrap_or_default();
    let title = format!("{name_of_all}, {} individuals", contender.num_individuals);
    let over_time = time_series(&TimeSeriesPicture {
        title: title.clone(),
        subtitle: format!("Individuals within {NEAR_M} m of each position, one run with seed {seed}"),
        x_label: "iteration".to_owned(),
        panels: vec![Panel {
            label: "individuals".to_owned(),
            series: points
                .into_iter()
                .enumerate()
                .map(|(i, points)| Series::new(&format!("position {}", i + 1), Color::series(i), points))
                .collect(),
            ..Panel::default()
        }],
        ..TimeSeriesPicture::default()
    });
    let end = distribution(&title, &scenario, &mut session, shape);
    Ok(vec![(format!("{name}-over-time"), over_time), (format!("{name}-end"), end)])
}

fn distribution(title: &str, scenario: &Scenario, session: &mut Session, shape: &ScenarioShape) -> Picture {
    let positions = scenario.positions(shape.num_iterations - 1).iter().map(|p| (p[0], p[1])).collect();
    let individuals = session.individuals().iter().map(|i| (i.world_from_robot.x_m, i.world_from_robot.y_m));
    scatter(&ScatterPicture {
        title: title.to_owned(),
        subtitle: format!("After {} iterations", shape.num_iterations),
        x_m: (-10.0, 10.0),
        y_m: (-10.0, 10.0),
        series: vec![
            ScatterSeries {
                label: "positions, 2 m around".to_owned(),
                color: Color::VERMILION,
                radius_m: Some(NEAR_M),
                points: positions,
                ..ScatterSeries::default()
            },
            ScatterSeries {
                label: "individuals".to_owned(),
                color: Color::BLUE,
                points: individuals.collect(),
                ..ScatterSeries::default()
            },
        ],
        ..ScatterPicture::default()
    })
}
