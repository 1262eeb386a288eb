//! The observation model as maps of the corridor. Source: 2017 section 5.3.2, figures 5.25 to 5.28.

use visloc_core::{Frame, RngTree, Source, Truth, geom::PlanarPose};
use visloc_locate::{
    ObservationModel,
    observation::office::{OfficeModelConfig, OfficeObservationModel},
    vision::office::{OfficeAnalysisConfig, OfficeAnalyzer, OfficeColors},
};
use visloc_plot::{Color, Grid, HeatMap, Picture, PoseMark, heat_map};
use visloc_sim::{Scenario, Simulation};
use visloc_world::{Map, office::Office};

use crate::ExperimentError;

const CELL_M: f64 = 0.1;
/// Headings tried at each place when any heading will do.
const NUM_HEADINGS: u32 = 72;
/// The images: the robot stands in front of a door, and it walks along the corridor.
const STANDING_FRAME: usize = 0;
const WALKING_FRAME: usize = 420;

/// What is done to an image before it is analyzed.
type Change = fn(&mut Frame);

/// All maps.
pub(super) fn pictures(seeds: &RngTree) -> Result<Vec<(String, Picture)>, ExperimentError> {
    let refused = |error: &dyn std::fmt::Display| ExperimentError::Run {
        cell: "office".to_owned(),
        run: 0,
        reason: error.to_string(),
    };
    let scenario = Scenario::load("office").map_err(|error| refused(&error))?;
    let simulation = Simulation::new(&scenario, 1).map_err(|error| refused(&error))?;
    let mut simulation = simulation.with_num_frames(WALKING_FRAME + 1);
    let Map::Office(office) = simulation.map().clone() else {
        return Err(refused(&"the scenario has no building"));
    };
    let mut frames = Vec::new();
    while let Some(next) = simulation.next_item() {
        frames.push(next.map_err(|error| refused(&error))?);
    }
    let studies: [(&str, &str, usize, bool, Change); 5] = [
        ("discrimination", "Heading known: places that explain the image", WALKING_FRAME, false, |_| {}),
        ("any-heading", "Best over all headings", WALKING_FRAME, true, |_| {}),
        ("symmetry", "One door in view: best over all headings", STANDING_FRAME, true, |_| {}),
        (
            "occlusion",
            "The right half of the image is hidden: best over all headings",
            WALKING_FRAME,
            true,
            hide_half,
        ),
        (
            "false-positive",
            "A red thing that is no door: best over all headings",
            WALKING_FRAME,
            true,
            add_red,
        ),
    ];
    let mut pictures = Vec::new();
    for (name, subtitle, index, any_heading, change) in studies {
        let Some(source) = frames.get(index) else { continue };
        let (mut frame, truth) = (source.frame.clone(), source.truth);
        change(&mut frame);
        let model = conditioned(&office, &frame, seeds).map_err(|error| refused(&error))?;
        let picture = map_of(&office, &model, truth, any_heading, subtitle);
        pictures.push((format!("likelihood-{name}"), picture));
    }
    Ok(pictures)
}

fn conditioned(
    office: &Office,
    frame: &Frame,
    seeds: &RngTree,
) -> Result<OfficeObservationModel, Box<dyn std::error::Error>> {
    let colors = OfficeColors {
        wall: office.plan().wall_color.rgb,
        floor: office.plan().floor_color.rgb,
        doors: office.door_colors().iter().map(|color| color.rgb).collect(),
    };
    let mut analyzer = OfficeAnalyzer::new(OfficeAnalysisConfig::default(), &colors)?;
    let mut model = OfficeObservationModel::new(office, &OfficeModelConfig::default())?;
    model.condition_on(analyzer.analyze(frame, &mut seeds.stream("likelihood", 0))?);
    Ok(model)
}

fn map_of(
    office: &Office,
    model: &OfficeObservationModel,
    truth: Option<Truth>,
    any_heading: bool,
    subtitle: &str,
) -> Picture {
    let [min, max] = office.free_space().bounds_m();
    let (columns, rows) = (((max.x - min.x) / CELL_M) as usize, ((max.y - min.y) / CELL_M) as usize);
    let true_pose = truth.map(|truth| truth.world_from_robot);
    let value = |i: usize| {
        let x = min.x + ((i % columns) as f64 + 0.5) * CELL_M;
        let y = min.y + ((i / columns) as f64 + 0.5) * CELL_M;
        if !office.free_space().contains(x, y) {
            return f64::NAN;
        }
        let at = |yaw: f64| model.likelihood(&PlanarPose::new(x, y, yaw));
        match (any_heading, true_pose) {
            (false, Some(pose)) => at(pose.yaw_rad),
            _ => (0..NUM_HEADINGS)
                .map(|k| at(std::f64::consts::TAU * f64::from(k) / f64::from(NUM_HEADINGS)))
                .fold(0.0, f64::max),
        }
    };
    let mark = |pose| PoseMark { label: "robot".to_owned(), color: Color::BLACK, pose };
    let input = HeatMap {
        title: "Likelihood of an image over the corridor".to_owned(),
        subtitle: subtitle.to_owned(),
        value_label: "likelihood".to_owned(),
        grid: Grid {
            origin_m: [min.x, min.y],
            cell_m: CELL_M,
            num_columns: columns,
            values: (0..columns * rows).map(value).collect(),
        },
        range: Some((0.0, 1.0)),
        marks: true_pose.map(mark).into_iter().collect(),
    };
    heat_map(&input, Some(office.into()))
}

fn hide_half(frame: &mut Frame) {
    for y in 0..frame.image.height() {
        for x in frame.image.width() / 2..frame.image.width() {
            frame.image.set(x, y, [40, 44, 46]);
        }
    }
}

fn add_red(frame: &mut Frame) {
    let (width, height) = (frame.image.width(), frame.image.height());
    for y in 0..height * 7 / 8 {
        for x in width * 3 / 8..width * 4 / 8 {
            frame.image.set(x, y, [130, 30, 24]);
        }
    }
}
