//! Small grids by hand, the examples of the source, and statistics over lists of seeds.

use rand::RngExt;
use visloc_core::{
    RngTree,
    geom::{Camera, PlanarPose},
};
use visloc_world::Map;

use super::*;
use crate::{
    Half, Localizer, Region, SideLines, StartPrior, StepInput,
    observation::field::{FieldModelConfig, FieldObservationModel},
    vision::Percept,
};

fn region(length_m: f64, width_m: f64) -> Region {
    let (x, y) = (length_m / 2.0, width_m / 2.0);
    Region { min_x_m: -x, max_x_m: x, min_y_m: -y, max_y_m: y }
}

/// The grid of the source: 12 x 8 tiles, 4 headings.
fn published_grid() -> Grid {
    Grid::new(&region(6.0, 4.0), 0.5, 4, Direction::MinusX)
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-12
}

/// Where an action leads if it happens exactly once.
fn after(grid: Grid, state: usize, action: Action) -> usize {
    let mut belief = Belief::known(grid, state, 1.0);
    belief.predict(action, &Outcomes::exact());
    let (best, probability) = belief.best();
    assert!(close(probability, 1.0), "{probability}");
    best
}

/// Table 1 of the source, and the ways of its goalkeeper.
#[test]
fn states_are_numbered_as_published() {
    let grid = published_grid();
    assert_eq!(grid.num_states(), 384);
    for (state, advanced, right, left) in [(0, 32, 1, 3), (1, 1, 2, 0), (2, 2, 3, 1), (3, 7, 0, 2)] {
        assert_eq!(after(grid, state, Action::ADVANCE), advanced);
        assert_eq!(after(grid, state, Action::TURN_RIGHT), right);
        assert_eq!(after(grid, state, Action::TURN_LEFT), left);
    }
    assert_eq!(after(grid, 352, Action::TURN_LEFT), 355);
    assert_eq!((0..4).fold(355, |state, _| after(grid, state, Action::ADVANCE)), 371);
    assert_eq!(after(grid, 371, Action::TURN_LEFT), 370);
    for index in 0..grid.num_states() {
        assert_eq!(grid.index(grid.state(index)), index);
        assert_eq!(grid.nearest(&grid.pose(index)), index);
    }
}

/// State 0 is the corner to the right of a robot that looks at the goal at the far end.
#[test]
fn states_have_their_place_on_the_field() {
    let place = |direction, state| {
        let pose = Grid::new(&region(6.0, 4.0), 0.5, 4, direction).pose(state);
        [pose.x_m, pose.y_m, pose.yaw_rad.to_degrees()].map(|v| (v * 1e6).round() / 1e6)
    };
    assert_eq!(place(Direction::PlusX, 0), [-2.75, -1.75, 0.0]);
    assert_eq!(place(Direction::PlusX, 3), [-2.75, -1.75, 90.0]);
    assert_eq!(place(Direction::PlusX, 370), [2.75, 0.25, 180.0]);
    assert_eq!(place(Direction::MinusX, 0), [2.75, 1.75, 180.0]);
    assert_eq!(place(Direction::MinusX, 370), [-2.75, -0.25, 0.0]);
    let grid = published_grid();
    let beside = PlanarPose::new(-2.99, -0.01, 1.0);
    assert!(grid.is_in_tile(370, &beside) && !grid.is_in_tile(366, &beside));
    assert!(grid.is_in_tile(369, &beside), "whatever the heading");
}

#[test]
fn prediction_by_hand_with_a_wall() {
    // four tiles in a row, one heading
    let grid = Grid::new(&region(4.0, 1.0), 1.0, 1, Direction::PlusX);
    let mut belief = Belief::known(grid, 1, 0.7); // 0.1 0.7 0.1 0.1
    belief.predict(Action::ADVANCE, &Outcomes::published());
    // 5 % stay, 80 % one, 10 % two, 5 % three tiles; nobody passes the wall
    let expected = [
        0.1 * 0.05,
        0.1 * 0.80 + 0.7 * 0.05,
        0.1 * 0.10 + 0.7 * 0.80 + 0.1 * 0.05,
        0.1 * 0.05 + 0.7 * 0.15 + 0.1 * 0.95 + 0.1,
    ];
    for (found, expected) in belief.probabilities().iter().zip(expected) {
        assert!(close(*found, expected), "{found} {expected}");
    }
}

#[test]
fn turns_by_hand() {
    let grid = Grid::new(&region(1.0, 1.0), 1.0, 4, Direction::PlusX);
    let mut belief = Belief::known(grid, 0, 1.0);
    belief.predict(Action::TURN_RIGHT, &Outcomes::published());
    for (state, expected) in [0.02, 0.90, 0.08, 0.0].into_iter().enumerate() {
        assert!(close(belief.probabilities()[state], expected));
    }
    let mut belief = Belief::known(grid, 0, 1.0);
    belief.predict(Action::TURN_LEFT, &Outcomes::published());
    for (state, expected) in [0.02, 0.0, 0.05, 0.93].into_iter().enumerate() {
        assert!(close(belief.probabilities()[state], expected));
    }
}

#[test]
fn bayes_by_hand() {
    let grid = Grid::new(&region(3.0, 1.0), 1.0, 1, Direction::PlusX);
    let mut belief = Belief::known(grid, 0, 0.5); // 0.5 0.25 0.25
    assert!(belief.weigh(|state| [0.1, 0.6, 0.2][state]));
    // 0.05 0.15 0.05
    assert!(close(belief.probabilities()[0], 0.2) && close(belief.probabilities()[1], 0.6));
    let before = belief.clone();
    assert!(!belief.weigh(|_| 0.0), "impossible");
    assert!(!belief.weigh(|_| f64::NAN));
    assert_eq!(belief.probabilities(), before.probabilities());
    assert!(belief.weigh(|state| if state == 2 { f64::INFINITY } else { -1.0 }));
    assert!(close(belief.probabilities()[2], 1.0));
    let mut tiny = Belief::uniform(grid);
    assert!(tiny.weigh(|state| if state == 1 { 1e-320 } else { 0.0 }), "no underflow");
    assert!(close(tiny.probabilities()[1], 1.0));
}

#[test]
fn known_and_unknown_start() {
    let grid = published_grid();
    let unknown = MarkovFilter::new(Belief::uniform(grid), Outcomes::published(), Remedy::none());
    assert!(unknown.belief().probabilities().iter().all(|p| close(*p, 1.0 / 384.0)));
    assert_eq!(unknown.localized(), None, "not localized");
    let known = MarkovFilter::new(Belief::known(grid, 7, 0.8), Outcomes::published(), Remedy::none());
    assert!(close(known.belief().probabilities()[8], 0.2 / 383.0));
    assert_eq!(known.localized(), Some(7));
}

/// Random actions and observations on coarse and fine grids, also with headings of 45 and 10 degrees: the belief stays a
/// distribution, and the same seed gives the same bits.
#[test]
fn probability_is_conserved_and_runs_repeat() {
    for (tile_m, num_headings) in [(0.5, 4), (0.5, 8), (0.25, 8), (1.0, 36)] {
        for seed in 1..=3 {
            let run = || {
                let mut rng = RngTree::new(seed).stream("belief", 0);
                let grid = Grid::new(&region(6.0, 4.0), tile_m, num_headings, Direction::PlusX);
                let mut filter =
                    MarkovFilter::new(Belief::uniform(grid), Outcomes::published(), Remedy::default());
                for _ in 0..15 {
                    filter.act(match rng.random_range(0..3) {
                        0 => Action::Turn(rng.random_range(-3..=3)),
                        _ => Action::Walk { ahead: rng.random_range(-2..=2), left: rng.random_range(-1..=1) },
                    });
                    filter.diffuse(0.02, 0.03);
                    let likelihoods: Vec<f64> = (0..grid.num_states()).map(|_| rng.random()).collect();
                    filter.observe(&likelihoods, rng.random());
                    let total: f64 = filter.belief().probabilities().iter().sum();
                    assert!((total - 1.0).abs() < 1e-9, "{total}");
                    assert!(filter.belief().probabilities().iter().all(|p| *p >= 0.0));
                }
                filter.belief().probabilities().to_vec()
            };
            assert_eq!(run(), run());
        }
    }
}

#[test]
fn headings_of_45_degrees_and_finer_tiles() {
    let grid = Grid::new(&region(6.0, 4.0), 0.25, 8, Direction::PlusX);
    assert_eq!(grid.num_states(), 24 * 16 * 8);
    let start = grid.nearest(&PlanarPose::new(0.1, 0.1, -45_f64.to_radians()));
    assert!((grid.pose(start).yaw_rad.to_degrees() + 45.0).abs() < 1e-9);
    // Two steps of 45 degrees are a quarter turn.
    let quarter = after(grid, start, Action::Turn(2));
    assert!((grid.pose(quarter).yaw_rad.to_degrees() + 135.0).abs() < 1e-9);
    // A diagonal walk of ten tiles ends at the right place on average.
    let mut belief = Belief::known(grid, start, 1.0);
    belief.predict(Action::Walk { ahead: 4, left: 0 }, &Outcomes::exact());
    let mean = |part: fn(&PlanarPose) -> f64| -> f64 {
        belief.probabilities().iter().enumerate().map(|(i, p)| p * part(&grid.pose(i))).sum()
    };
    let diagonal_m = 1.0 / 2_f64.sqrt();
    assert!((mean(|p| p.x_m) - grid.pose(start).x_m - diagonal_m).abs() < 1e-9);
    assert!((mean(|p| p.y_m) - grid.pose(start).y_m + diagonal_m).abs() < 1e-9);
}

/// A random walk, cut into actions: the actions lead from the start to the end, up to the residual.
#[test]
fn odometry_is_cut_without_loss() {
    for num_headings in [4, 8] {
        let grid = Grid::new(&region(60.0, 60.0), 0.5, num_headings, Direction::PlusX);
        let mut rng = RngTree::new(4).stream("walk", 0);
        let mut cutter = OdometryCutter::new(&grid);
        let (mut truth, mut state, mut actions) = (PlanarPose::default(), PlanarPose::default(), Vec::new());
        for _ in 0..2000 {
            let step = PlanarPose::new(
                rng.random_range(-0.01..0.03),
                rng.random_range(-0.02..0.02),
                rng.random_range(-0.05..0.05),
            );
            truth = truth.compose(&step);
            actions.clear();
            cutter.add(&step, &mut actions);
            for action in &actions {
                state = state.compose(&match *action {
                    Action::Turn(steps) => {
                        PlanarPose::new(0.0, 0.0, -f64::from(steps) * grid.heading_step_rad())
                    }
                    Action::Walk { ahead, left } => {
                        PlanarPose::new(f64::from(ahead) * 0.5, f64::from(left) * 0.5, 0.0)
                    }
                });
            }
            let found = state.compose(&cutter.residual());
            assert!(found.distance_m(&truth) < 1e-9 && found.heading_difference_rad(&truth) < 1e-9);
            let residual = cutter.residual();
            assert!(residual.x_m.abs() <= 0.31 && residual.y_m.abs() <= 0.31);
        }
        assert!(state.distance_m(&PlanarPose::default()) > 1.0, "the walk went somewhere");
    }
}

#[test]
fn cases_of_the_source() {
    let limits = CaseLimits::default();
    let view = |area_px, bearing_deg: f64| BlobView { area_px, bearing_rad: bearing_deg.to_radians() };
    assert_eq!((limits.size_case(None), limits.centroid_case(None)), (0, 0));
    for (area_px, case) in [(50.0, 0), (200.0, 1), (399.0, 1), (650.0, 2), (1999.0, 7), (2000.0, 8)] {
        assert_eq!(limits.size_case(Some(&view(area_px, 0.0))), case, "{area_px}");
    }
    for (bearing_deg, case) in [(31.0, 1), (60.0, 1), (9.0, 3), (1.0, 4), (-1.0, 5), (-31.0, 8), (-90.0, 8)] {
        assert_eq!(limits.centroid_case(Some(&view(500.0, bearing_deg))), case, "{bearing_deg}");
    }
}

#[test]
fn tables_are_shares_of_captures() {
    let view = |area_px, bearing_rad| Some(BlobView { area_px, bearing_rad });
    let captures =
        [(0, view(300.0, 0.05)), (0, view(500.0, 0.05)), (0, None), (0, view(300.0, 0.05)), (7, None)];
    let tables = learn_tables(CaseLimits::default(), 2, captures.into_iter());
    assert_eq!(tables.size(0)[..3], [0.25, 0.5, 0.25]);
    assert_eq!((tables.centroid(0)[0], tables.centroid(0)[4]), (0.25, 0.75));
    assert!(close(tables.size(1)[8], 1.0 / 9.0), "no captures: everything alike");
    let mut likelihoods = Vec::new();
    tables.likelihoods(view(300.0, 0.05).as_ref(), &mut likelihoods);
    assert!(close(likelihoods[0], 0.5 * 0.75));
    let again = CaseTables::from_csv(CaseLimits::default(), &tables.to_csv()).unwrap();
    assert!(again.size(0).iter().zip(tables.size(0)).all(|(a, b)| (a - b).abs() < 1e-4));
    let error = CaseTables::from_csv(CaseLimits::default(), "state\n0,1,2\n").unwrap_err().to_string();
    assert!(error.contains("line 2") && error.contains("18 shares"), "{error}");
    let soft = tables.softened(0.09);
    assert!(close(soft.size(0)[0], 0.25 * 0.91 + 0.01) && close(soft.centroid(0)[8], 0.01));
}

/// An observation without a landmark, from states of which half see one.
fn half_blind(grid: &Grid) -> Vec<f64> {
    (0..grid.num_states()).map(|index| if grid.state(index).heading < 2 { 0.05 } else { 0.95 }).collect()
}

/// A run of observations without a goal from a state that should see one (somebody stands in front), then good ones
/// again: with the remedy the filter needs no more of them than without that run; without the remedy it needs more.
#[test]
fn remedy_against_observations_without_a_landmark() {
    let grid = published_grid();
    let state = 128;
    let good: Vec<f64> = (0..grid.num_states())
        .map(|index| match (index == state, grid.are_neighbors(index, state)) {
            (true, _) => 0.6,
            (_, true) => 0.2,
            _ => 0.02,
        })
        .collect();
    let steps_after = |num_without: usize, remedy: Remedy| {
        let mut filter = MarkovFilter::new(Belief::known(grid, state, 0.8), Outcomes::exact(), remedy);
        for _ in 0..num_without {
            filter.observe(&half_blind(&grid), false);
            filter.act(Action::Turn(4));
        }
        (0..50).find(|_| filter.observe(&good, true) && filter.localized() == Some(state)).unwrap_or(50)
    };
    for num_without in [1, 3, 10, 40] {
        let (with, without) =
            (steps_after(num_without, Remedy::default()), steps_after(0, Remedy::default()));
        assert!(with <= without, "{num_without} observations: {with} steps, without them {without}");
    }
    assert!(steps_after(40, Remedy::none()) > steps_after(0, Remedy::none()) + 10);
}

/// The first experiment of the source, with drawn observations: the robot walks along the right edge from state 0, known,
/// and the belief follows. Twenty seeds; in 18 of them it is right at the end, and in 90 % of all steps.
#[test]
fn synthetic_walk_along_the_edge() {
    let grid = published_grid();
    let expected = |state: usize| {
        let at = grid.pose(state);
        let (ahead, left) = (3.0 + at.x_m, at.y_m); // of the goal at (-3, 0)
        let bearing = visloc_core::geom::angle::difference(left.atan2(ahead).abs() * -left.signum(), 0.0);
        let own = at.heading_difference_rad(&PlanarPose::new(0.0, 0.0, std::f64::consts::PI));
        let distance2 = ahead * ahead + left * left;
        (own < 0.1 && bearing.abs() < 0.6)
            .then_some(BlobView { area_px: 10_000.0 / distance2, bearing_rad: -bearing })
    };
    let captures = (0..grid.num_states()).flat_map(|s| (0..50).map(move |_| s)).map(|s| (s, expected(s)));
    let tables = learn_tables(CaseLimits::default(), grid.num_states(), captures).softened(0.1);
    let (mut right_at_end, mut right_steps) = (0, 0);
    for seed in 1..=20 {
        let mut rng = RngTree::new(seed).stream("walk", 0);
        let mut filter =
            MarkovFilter::new(Belief::known(grid, 0, 0.8), Outcomes::published(), Remedy::default());
        let mut likelihoods = Vec::new();
        for t in 1..=11 {
            filter.act(Action::ADVANCE);
            let view = if rng.random_bool(0.05) { None } else { expected(32 * t) };
            tables.likelihoods(view.as_ref(), &mut likelihoods);
            filter.observe(&likelihoods, view.is_some());
            right_steps += usize::from(filter.belief().best().0 == 32 * t);
        }
        right_at_end += usize::from(filter.belief().best().0 == 352);
    }
    assert!(right_at_end >= 18 && right_steps >= 198, "{right_at_end} of 20, {right_steps} of 220");
}

/// A penalty, a lift, and a restart without knowledge: what the localizer believes afterwards.
#[test]
fn starts_follow_their_priors() {
    let Map::Field(field) = Map::load("robocup-spl-2010").unwrap() else { panic!("a field") };
    let model = FieldObservationModel::new(&field, &FieldModelConfig::default()).unwrap();
    let config = MarkovConfig {
        start: KnownStart {
            is_known: true,
            x_m: 1.25,
            y_m: 0.25,
            keep_old_pose_share: 0.4,
            ..KnownStart::default()
        },
        ..MarkovConfig::default()
    };
    let mut localizer = Markov::new(config, &model).unwrap();
    let mass = |localizer: &Markov, holds: &dyn Fn(&PlanarPose) -> bool| -> f64 {
        let belief = localizer.belief();
        let states = belief.probabilities().iter().enumerate();
        states.filter(|(i, _)| holds(&belief.grid().pose(*i))).map(|(_, p)| p).sum()
    };
    let mut rng = RngTree::new(1).stream("unused", 0);
    let percept = Percept {
        camera: Camera::pinhole((320, 240), (300.0, 300.0), (160.0, 120.0)).unwrap(),
        ..Percept::default()
    };
    let mut step = |localizer: &mut Markov, is_lifted| {
        localizer.step(&StepInput { percept: &percept, odometry: None, is_lifted }, &mut rng).reliability
    };
    assert!(step(&mut localizer, false) > 0.6, "the start is known");
    assert!(step(&mut localizer, true) == 0.0, "lifted");
    let is_old = |pose: &PlanarPose| pose.distance_m(&PlanarPose::new(1.25, 0.25, 0.0)) < 0.8;
    let kept = mass(&localizer, &is_old);
    assert!(kept > 0.4 && kept < 0.6, "the old pose keeps its share and a little of the rest: {kept}");
    let lines = SideLines::of(&field, Half::Negative);
    localizer.reset_to(&StartPrior::SideLines(lines));
    assert!(localizer.estimate().reliability == 0.0);
    let on_lines = mass(&localizer, &|pose| pose.x_m < 0.0 && pose.y_m.abs() > 1.5);
    assert!(on_lines > 0.6 * 0.8 - 0.02, "the prior's share of what the old pose leaves: {on_lines}");
    localizer.reset();
    let half = mass(&localizer, &|pose| pose.x_m < 0.0);
    assert!((half - 0.5).abs() < 1e-9, "anywhere: {half}");
}
