//! The playground without the web.

use serde_json::json;
use visloc_studio::{Message, Session};

use crate::support::{all_localized, command_of, playground, scene, state, step_until, steps, tell, truth};

#[test]
fn the_same_seed_and_commands_give_the_same_bytes() {
    let run = |seed: u64| {
        let mut session = playground("robocup-2010", seed);
        steps(&mut session, 20);
        tell(&mut session, json!({ "type": "kidnap" }));
        tell(&mut session, json!({ "type": "robots", "count": 2 }));
        steps(&mut session, 20);
        let update = session.update(None).unwrap();
        (update.state.to_vec(), update.image.unwrap().to_vec())
    };
    assert!(run(5) == run(5), "the same seed");
    assert!(run(5) != run(6), "another seed");
}

#[test]
fn a_reset_repeats_the_run() {
    let mut session = playground("robocup-2010", 3);
    steps(&mut session, 30);
    let before = session.update(None).unwrap().state.to_vec();
    steps(&mut session, 10);
    tell(&mut session, json!({ "type": "reset", "seed": 3 }));
    steps(&mut session, 30);
    assert!(session.update(None).unwrap().state.to_vec() == before);
}

#[test]
fn both_algorithms_localize_and_recover_from_a_kidnap() {
    let mut session = playground("robocup-2010", 1);
    step_until(&mut session, 600, all_localized);
    tell(&mut session, json!({ "type": "kidnap", "x_m": -1.5, "y_m": 1.0, "yaw_rad": 2.0 }));
    steps(&mut session, 25);
    let carried = state(&mut session);
    assert!(carried["truth"]["height_m"].as_f64().unwrap() > 0.05);
    assert!(!all_localized(&carried), "the lift is felt");
    step_until(&mut session, 60, |state| state["truth"]["height_m"] == json!(0.0));
    let [x, y, _] = truth(&state(&mut session));
    assert!((x + 1.5).hypot(y - 1.0) < 0.1, "put down at {x}, {y}");
    step_until(&mut session, 900, all_localized);
}

#[test]
fn an_office_is_played_in_too() {
    let mut session = playground("office", 1);
    step_until(&mut session, 900, all_localized);
    let update = session.update(None).unwrap();
    assert_eq!(scene(&update)["world"]["kind"], "office");
    let image = Message::read(&update.image.unwrap()).unwrap();
    assert!(image.floats("theory0").unwrap().len() > 20, "the map is drawn over the image");
}

#[test]
fn whoever_carries_the_robot_decides_where_it_is() {
    let mut session = playground("robocup-2010", 2);
    for x_m in [0.0, 0.5, 1.0] {
        tell(&mut session, json!({ "type": "carry", "x_m": x_m, "y_m": 0.5, "yaw_rad": 1.0 }));
        steps(&mut session, 1);
        let held = state(&mut session);
        assert!((truth(&held)[0] - x_m).abs() < 1e-9 && held["truth"]["height_m"].as_f64().unwrap() > 0.2);
    }
    tell(&mut session, json!({ "type": "put_down" }));
    steps(&mut session, 1);
    assert_eq!(state(&mut session)["truth"]["height_m"], json!(0.0));
}

#[test]
fn parameters_change_behavior_and_keep_what_is_known() {
    let mut session = playground("robocup-2010", 1);
    tell(&mut session, json!({ "type": "algorithms", "names": ["mc", "kld"] }));
    step_until(&mut session, 900, all_localized);
    let change = json!({ "type": "parameter", "algorithm": 0, "path": "num_particles", "value": 777 });
    tell(&mut session, change);
    steps(&mut session, 2);
    let after = state(&mut session);
    assert_eq!(after["contenders"][0]["num_individuals"], json!(777));
    assert!(after["contenders"][0]["error"][0].as_f64().unwrap() < 0.5, "it begins where it was");
    let scene = scene(&session.update(None).unwrap());
    let parameters = scene["contenders"][0]["parameters"].as_array().unwrap();
    let changed = parameters.iter().find(|parameter| parameter["path"] == "num_particles").unwrap();
    assert_eq!(changed["value"], json!(777));
    assert!(changed["default"] != changed["value"] && changed["meaning"].as_str().unwrap().len() > 5);
    assert_eq!(scene["contenders"][0]["changed"], json!(["num_particles"]));
    tell(&mut session, json!({ "type": "defaults", "algorithm": 0 }));
    steps(&mut session, 1);
    assert!(state(&mut session)["contenders"][0]["num_individuals"] != json!(777));
}

#[test]
fn what_all_algorithms_share_is_changed_for_all() {
    let mut session = playground("robocup-2010", 1);
    tell(&mut session, json!({ "type": "parameter", "path": "features", "value": "pixels" }));
    steps(&mut session, 1);
    let parameter = json!({ "type": "parameter", "path": "analysis.max_pixels", "value": "many" });
    assert!(session.handle(&command_of(parameter)).is_err());
    let scene = scene(&session.update(None).unwrap());
    assert_eq!(scene["pipeline"]["changed"], json!(["features"]));
}

#[test]
fn what_makes_no_sense_is_refused_and_changes_nothing() {
    let mut session = playground("robocup-2010", 1);
    let before = session.update(None).unwrap().state.to_vec();
    for command in [
        json!({ "type": "parameter", "algorithm": 0, "path": "num_exploiters", "value": -3 }),
        json!({ "type": "parameter", "algorithm": 0, "path": "num_exploitres", "value": 3 }),
        json!({ "type": "parameter", "algorithm": 9, "path": "num_exploiters", "value": 3 }),
        json!({ "type": "algorithms", "names": [] }),
        json!({ "type": "algorithms", "names": ["mc", "kalman"] }),
        json!({ "type": "robots", "count": 4000 }),
        json!({ "type": "carry", "x_m": 1e9, "y_m": 0.0, "yaw_rad": 0.0 }),
        json!({ "type": "speed", "factor": -1.0 }),
        json!({ "type": "odometry", "factor": 1e6 }),
        json!({ "type": "head", "yaw_deg": 4000.0 }),
        json!({ "type": "seek", "frame": 3 }),
    ] {
        let error = session.handle(&command_of(command.clone())).unwrap_err().to_string();
        assert!(
            error.contains("expected") || error.contains("known") || error.contains("did you mean"),
            "{command}: {error}"
        );
    }
    assert!(session.update(None).unwrap().state.to_vec() == before);
}

#[test]
fn the_likelihood_of_every_place_is_high_where_the_robot_is() {
    let mut session = playground("robocup-2010", 1);
    tell(&mut session, json!({ "type": "likelihood", "is_on": true }));
    // Twenty pixels of one image may fit other places as well.
    let mut num_best = 0;
    for _ in 0..12 {
        steps(&mut session, 10);
        let message = Message::read(&session.update(None).unwrap().state).unwrap();
        let values = message.floats("likelihood").unwrap();
        let [x, y, _] = truth(&message.header);
        let [left, low, pitch, columns, rows] = [0, 1, 2, 3, 4].map(|i| f64::from(values[i]));
        assert_eq!(values.len() as f64, 5.0 + columns * rows);
        let cell = ((y - low) / pitch).floor() * columns + ((x - left) / pitch).floor();
        let (here, mut all) = (values[5 + cell as usize], values[5..].to_vec());
        all.sort_by(f32::total_cmp);
        num_best += u32::from(here > all[all.len() * 9 / 10]);
    }
    assert!(num_best >= 9, "in {num_best} of 12 images it is among the best tenth");
    tell(&mut session, json!({ "type": "likelihood", "is_on": false }));
    assert!(Message::read(&session.update(None).unwrap().state).unwrap().floats("likelihood").is_none());
}

#[test]
fn light_robots_and_odometry_change_the_world() {
    let mut session = playground("robocup-2010", 1);
    tell(&mut session, json!({ "type": "cover", "is_on": true }));
    steps(&mut session, 1);
    assert_eq!(state(&mut session)["contenders"][0]["num_kept"], json!(0), "a covered camera sees nothing");
    tell(&mut session, json!({ "type": "robots", "count": 3 }));
    tell(&mut session, json!({ "type": "odometry", "factor": 2.0 }));
    tell(&mut session, json!({ "type": "light", "exposure_stops": -1.0, "unevenness": 0.8 }));
    steps(&mut session, 1);
    let state = state(&mut session);
    assert_eq!(state["others"].as_array().unwrap().len(), 3);
    assert_eq!(state["controls"]["odometry_factor"], json!(2.0));
    assert_eq!(state["controls"]["unevenness"], json!(0.8));
}
