//! Scenario files and their mistakes.

use visloc_sim::{BUILT_IN_SCENARIOS, Scenario, ScenarioError, Simulation};

#[test]
fn built_in_scenarios_load_and_say_what_they_are() {
    for (name, _) in BUILT_IN_SCENARIOS {
        let scenario = Scenario::load(name).unwrap();
        assert_eq!(scenario.name, name);
        assert!(!scenario.summary.is_empty());
        assert!(scenario.num_frames() > 100);
    }
}

#[test]
fn mistakes_name_file_line_and_key() {
    let error = |text: &str| Scenario::parse("my.toml", text).unwrap_err().to_string();
    assert_eq!(
        error("map = \"robocup-spl-2010\"\n[camera]\nshutter_secs = 5.0\n"),
        "scenario my.toml, line 3: camera.shutter_secs: expected a number from 0 to 0.1, found 5"
    );
    let unknown = error("[camera]\nsize = [320, 240]\n");
    assert!(
        unknown.contains("line 2") && unknown.contains("`size`") && unknown.contains("size_px"),
        "{unknown}"
    );
    let motion = error("[[motion]]\nstand.secs = 1.0\n\n[[motion]]\nwalk = { speed_m_per_s = 0.2 }\n");
    assert!(motion.contains("line 5: motion[1].walk.through_m: expected at least one point"), "{motion}");
    let color = error("[[robots]]\njersey = \"blue\"\n");
    assert!(color.contains("line 2") && color.contains("#d9c21a"), "{color}");
    assert!(error("[[motion]]\nfly.secs = 1.0\n").contains("fly"));
    assert!(error("[camera]\nfocal_px = [nan, 1.0]\n").contains("camera"));
    assert!(error("duration_secs = -1.0\n").contains("line 1: duration_secs"));
}

#[test]
fn missing_files_maps_and_free_space_are_errors() {
    let missing = Scenario::load("no-such-scenario").unwrap_err().to_string();
    assert!(missing.contains("no-such-scenario") && missing.contains("kidnaps-unsensed"), "{missing}");
    let no_map = Scenario { map: "moon".to_owned(), ..Scenario::default() };
    assert!(Simulation::new(&no_map, 1).unwrap_err().to_string().contains("moon"));
    let mut crowded = Scenario::load("tour").unwrap();
    crowded.people = (0..80)
        .map(|i| {
            let mut person = Scenario::load("crowd").unwrap().people.remove(0);
            person.at.x_m = -2.7 + 0.6 * f64::from(i % 10);
            person.at.y_m = -1.75 + 0.5 * f64::from(i / 10);
            person
        })
        .collect();
    assert!(matches!(Simulation::new(&crowded, 1), Err(ScenarioError::NoSpace { .. })));
}
