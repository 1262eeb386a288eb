//! What a simulation delivers.

use visloc_core::{GroundContact, Source, SourceFrame};
use visloc_sim::{Scenario, Simulation};
use visloc_world::Map;

fn frames(simulation: &mut Simulation) -> Vec<SourceFrame> {
    std::iter::from_fn(|| simulation.next_item()).map(Result::unwrap).collect()
}

/// A scenario with tiny pictures, for tests of everything but the pictures.
fn small(name: &str) -> Scenario {
    let mut scenario = Scenario::load(name).unwrap();
    scenario.camera.size_px = [16, 12];
    scenario.camera.focal_px = [18.0, 18.0];
    scenario.camera.center_px = [7.5, 5.5];
    scenario.frames_per_sec = 10.0;
    scenario.room = None;
    scenario.furniture.clear();
    scenario.panels.clear();
    scenario
}

fn pressure_n(frame: &SourceFrame) -> f64 {
    match frame.frame.ground_contact {
        Some(GroundContact::Pressure(forces)) => forces.iter().sum(),
        _ => panic!("expected pressure values"),
    }
}

#[test]
fn same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let scenario = Scenario::load("crowd").unwrap();
    let run = |seed, num_threads| {
        let simulation = Simulation::new(&scenario, seed).unwrap();
        frames(&mut simulation.with_threads(num_threads).with_num_frames(9))
    };
    let one = run(3, 1);
    assert_eq!(one.len(), 9);
    for other in [run(3, 2), run(3, 3)] {
        one.iter().zip(&other).for_each(|(a, b)| expect_same(a, b));
    }
    assert!(one[0].frame.image != run(4, 1)[0].frame.image, "seeds do not matter");
}

fn expect_same(a: &SourceFrame, b: &SourceFrame) {
    assert_eq!(a.frame.at, b.frame.at);
    assert!(a.frame.image == b.frame.image, "pictures differ");
    assert_eq!(a.frame.odometry, b.frame.odometry);
    assert_eq!(a.frame.robot_from_camera, b.frame.robot_from_camera);
    assert_eq!(a.frame.ground_contact, b.frame.ground_contact);
    assert_eq!(a.truth, b.truth);
}

#[test]
fn frames_that_are_left_out_change_no_others() {
    let scenario = Scenario::load("crowd").unwrap();
    let simulation = || Simulation::new(&scenario, 3).unwrap().with_num_frames(20);
    let all = frames(&mut simulation());
    for num_threads in [1, 2] {
        let mut some = simulation().with_threads(num_threads).with_step(3);
        assert_eq!(some.status().num_items, Some(7));
        let some = frames(&mut some);
        assert_eq!(some.len(), 7);
        all.iter().step_by(3).zip(&some).for_each(|(a, b)| expect_same(a, b));
    }
}

#[test]
fn frames_have_regular_stamps_and_their_number_can_only_be_cut() {
    let scenario = small("still");
    let simulation = Simulation::new(&scenario, 1).unwrap();
    assert_eq!(simulation.status().num_items, Some(200));
    let all = frames(&mut simulation.with_num_frames(203));
    assert_eq!(all.len(), 200);
    assert_eq!(all[0].frame.at.nanos(), 1_700_000_000_000_000_000);
    assert_eq!(all[10].frame.at.secs_since(all[0].frame.at), 1.0);
    let cut = frames(&mut Simulation::new(&scenario, 1).unwrap().with_num_frames(5));
    assert_eq!(cut.len(), 5);
    assert!(
        cut.iter()
            .zip(&all)
            .all(|(a, b)| a.frame.odometry == b.frame.odometry && a.frame.image == b.frame.image)
    );
}

#[test]
fn kidnaps_move_the_truth_but_not_the_odometry() {
    for (name, num_kidnaps, is_sensed) in [("kidnaps", 4, true), ("kidnaps-unsensed", 3, false)] {
        let all = frames(&mut Simulation::new(&small(name), 2).unwrap());
        let (mut kidnaps, mut carried_from) = (0, None);
        for (i, frame) in all.iter().enumerate() {
            let truth = frame.truth.unwrap();
            let is_carried = truth.height_m > 0.0;
            if is_carried && is_sensed {
                assert!(pressure_n(frame) < 1.0, "{} N in the air", pressure_n(frame));
            } else {
                assert!((pressure_n(frame) - 45.0).abs() < 5.0, "{} N", pressure_n(frame));
            }
            match (is_carried, carried_from) {
                (true, None) => carried_from = Some(i - 1),
                (false, Some(before)) => {
                    kidnaps += 1;
                    let moved =
                        truth.world_from_robot.distance_m(&all[before].truth.unwrap().world_from_robot);
                    let before_odometry = all[before].frame.odometry.unwrap();
                    let reported = frame.frame.odometry.unwrap().distance_m(&before_odometry);
                    assert!(moved > 1.0, "{name}: moved {moved} m");
                    assert!(reported < 0.05, "{name}: odometry moved {reported} m");
                    carried_from = None;
                }
                _ => {}
            }
        }
        assert_eq!(kidnaps, num_kidnaps, "{name}");
    }
}

/// One test per scenario, so that they run side by side.
fn check_way(name: &str) {
    for seed in 0..2 {
        let mut simulation = Simulation::new(&small(name), seed).unwrap();
        let Map::Field(field) = simulation.map().clone() else { panic!("a field") };
        let (half_x, half_y) = field.half_carpet_m();
        let all = frames(&mut simulation);
        let mut quarters = [false; 4];
        for pair in all.windows(2) {
            let pose = pair[1].truth.unwrap().world_from_robot;
            assert!(pose.x_m.abs() < half_x - 0.2 && pose.y_m.abs() < half_y - 0.2, "{name}: {pose:?}");
            quarters[usize::from(pose.x_m > 0.0) + 2 * usize::from(pose.y_m > 0.0)] = true;
            let is_carried = pair.iter().any(|frame| frame.truth.unwrap().height_m > 0.0);
            let step = pose.distance_m(&pair[0].truth.unwrap().world_from_robot);
            assert!(is_carried || step < 0.045, "{name}: {step} m in 0.1 s");
        }
        assert_eq!(quarters, [true; 4], "{name}, seed {seed}");
    }
}

#[test]
fn tour_stays_on_the_carpet_and_comes_around() {
    check_way("tour");
}

#[test]
fn tour_of_2024_stays_on_the_carpet_and_comes_around() {
    check_way("tour-2024");
}

#[test]
fn crowd_leaves_a_way_that_stays_on_the_carpet_and_comes_around() {
    check_way("crowd");
}

#[test]
fn demo_stays_on_the_carpet_and_comes_around() {
    check_way("demo");
}

#[test]
fn odometry_drifts_but_follows() {
    let all = frames(&mut Simulation::new(&small("tour"), 5).unwrap());
    let (mut truth_m, mut odometry_m) = (0.0, 0.0);
    for pair in all.windows(11).step_by(10) {
        let truth = |i: usize| pair[i].truth.unwrap().world_from_robot;
        truth_m += truth(10).distance_m(&truth(0));
        odometry_m += pair[10].frame.odometry.unwrap().distance_m(&pair[0].frame.odometry.unwrap());
    }
    let ratio = odometry_m / truth_m;
    assert!(truth_m > 20.0 && (0.88..1.12).contains(&ratio), "{truth_m} m, ratio {ratio}");
    assert!((ratio - 1.0).abs() > 0.01, "the odometry has no systematic error: {ratio}");
}
