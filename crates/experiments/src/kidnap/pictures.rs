//! Picture: the share of the individuals at the true place over time.

use visloc_core::RngTree;
use visloc_plot::{Color, Mark, Panel, Picture, Series, TimeSeriesPicture, ValueAxis, time_series};

use super::{
    KidnapExperiment,
    experiment::{FLOOR, KIDNAP_AFTER, NUM_ITERATIONS_AFTER, scenario},
};
use crate::{
    Experiment, ExperimentError,
    positions::{Census, Session},
};

/// The first run of all contenders.
pub(super) fn all(
    experiment: &KidnapExperiment,
    seed: u64,
) -> Result<Vec<(String, Picture)>, ExperimentError> {
    let seeds = RngTree::new(seed);
    let mut series = Vec::new();
    for (i, contender) in experiment.settings().contenders.iter().enumerate() {
        let mut session = Session::new(contender, scenario(0, &seeds), FLOOR)?;
        let mut rng = seeds.stream(&contender.label, 0);
        let mut census = Census::default();
        let mut points = Vec::new();
        for iteration in 1..=KIDNAP_AFTER + NUM_ITERATIONS_AFTER {
            session.step(&mut rng);
            session.count(&mut census);
            let share = 100.0 * f64::from(census.counts()[0]) / contender.num_individuals as f64;
            points.push((iteration as f64, share));
        }
        series.push(Series::new(&contender.label, Color::series(i), points));
    }
    let kidnap = KIDNAP_AFTER as f64;
    let picture = time_series(&TimeSeriesPicture {
        title: "Kidnap: individuals at the true place".to_owned(),
        subtitle: format!(
            "Within 2 m, in % of all individuals, explorers included; one run with seed {seed}"
        ),
        x_label: "iteration".to_owned(),
        panels: vec![Panel {
            label: "individuals [%]".to_owned(),
            axis: ValueAxis::Linear { min: 0.0, max: 100.0 },
            series,
            ..Panel::default()
        }],
        marks: vec![Mark { at_secs: kidnap, label: "kidnap".to_owned() }],
        range_secs: Some((kidnap - 20.0, kidnap + 80.0)),
        ..TimeSeriesPicture::default()
    });
    Ok(vec![("kidnap-over-time".to_owned(), picture)])
}
