//! Scenario files and their mistakes.

use visloc_core::{Source, geom::Distortion};
use visloc_sim::{BUILT_IN_SCENARIOS, Factor, Scenario, ScenarioError, Simulation};

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

#[test]
fn sizes_and_counts_that_no_machine_bears_are_refused() {
    let error = |text: &str| Scenario::parse("my.toml", text).unwrap_err().to_string();
    for (text, key) in [
        ("[camera]\nsize_px = [100000, 100000]\n", "camera.size_px"),
        ("[camera]\nsize_px = [8192, 8192]\n", "camera.size_px"),
        ("frames_per_sec = 1e9\n", "frames_per_sec"),
        ("duration_secs = 1e300\n", "duration_secs"),
        ("duration_secs = 36000\nframes_per_sec = 1000\n", "duration_secs: expected at most 1200000 frames"),
        ("[camera]\nfocal_px = [1e-9, 1e-9]\n", "no lens does that"),
        ("[light]\nlamps = [4000000000, 1]\n", "light.lamps"),
    ] {
        let error = error(text);
        assert!(error.contains(key) && error.len() < 300, "{error}");
    }
    let many = "[[robots]]\njersey = \"#2040c0\"\n".repeat(1001);
    assert!(error(&many).contains("robots: expected at most 1000 entries, found 1001"));
    let long = "[[motion]]\nwander.secs = 3600.0\n".repeat(11);
    assert!(error(&long).contains("motion: expected at most 36000 seconds"));
}

#[test]
fn the_camera_has_any_lens_of_a_camera_file() {
    let camera = |text: &str| {
        Scenario::parse("my.toml", &format!("[camera]\n{text}\n")).map(|s| s.camera.camera().unwrap())
    };
    let fisheye =
        camera("model = \"kannala-brandt\"\nfocal_px = [120.0, 120.0]\ndistortion = [0.0, 0.0, 0.0, 0.0]")
            .unwrap();
    assert_eq!(fisheye.distortion(), Distortion::KannalaBrandt([0.0; 4]));
    let four = camera("distortion = [-0.1, 0.01, 0.0, 0.0]").unwrap();
    assert_eq!(four.distortion(), Distortion::RadialTangential([-0.1, 0.01, 0.0, 0.0, 0.0]));
    assert_eq!(camera("model = \"pinhole\"").unwrap().distortion(), Distortion::None);
    for wrong in
        ["model = \"omni\"\ndistortion = [0.1]", "model = \"kannala-brandt\"", "distortion = [0.1, 0.2]"]
    {
        let error = camera(wrong).unwrap_err().to_string();
        assert!(
            error.contains("camera: expected a possible calibration") && error.contains("kannala-brandt"),
            "{error}"
        );
    }
    // The simulator draws it, and a wide lens shows more of the field.
    let text = "[camera]\nmodel = \"kannala-brandt\"\nsize_px = [160, 120]\nfocal_px = [60.0, 60.0]\ncenter_px = [79.5, 59.5]\n\
                distortion = [0.0, 0.0, 0.0, 0.0]\n";
    let mut simulation =
        Simulation::new(&Scenario::parse("wide", text).unwrap(), 1).unwrap().with_num_frames(1);
    let frame = simulation.next_item().unwrap().unwrap().frame;
    assert_eq!((frame.camera.distortion(), frame.image.width()), (Distortion::KannalaBrandt([0.0; 4]), 160));
    let (least, most) = (frame.image.data().iter().min().unwrap(), frame.image.data().iter().max().unwrap());
    assert!(most - least > 50);
}

#[test]
fn a_map_stands_beside_the_file_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let map = visloc_world::BUILT_IN_MAPS[0].1;
    std::fs::create_dir(folder.path().join("maps")).unwrap();
    std::fs::write(folder.path().join("maps/mine.toml"), map).unwrap();
    let path = folder.path().join("walk.toml");
    std::fs::write(&path, "map = \"maps/mine.toml\"\n").unwrap();
    let scenario = Scenario::load(path.to_str().unwrap()).unwrap();
    assert!(Simulation::new(&scenario, 1).is_ok(), "{}", scenario.map);
    std::fs::write(&path, "map = \"robocup-spl-2010\"\n").unwrap();
    assert_eq!(Scenario::load(path.to_str().unwrap()).unwrap().map, "robocup-spl-2010");
}

#[test]
fn factors_change_what_is_seen_or_told_and_follow_the_seed() {
    let sixth = |name: &str| {
        let mut scenario = Scenario::load(name).unwrap();
        scenario.frames_per_sec = 1.0;
        scenario.camera.size_px = [80, 60];
        scenario.camera.focal_px = [60.0; 2];
        scenario.camera.center_px = [39.5, 19.5];
        let mut simulation = Simulation::new(&scenario, 3).unwrap().with_num_frames(6);
        let frame = std::iter::from_fn(|| simulation.next_item()).last().unwrap().unwrap().frame;
        (frame.image.into_raw(), frame.robot_from_camera)
    };
    let plain = sixth("tour-2024");
    for (factor, _) in Factor::ALL {
        let name = format!("tour-2024+{factor}");
        let found = sixth(&name);
        assert!(found != plain, "{name}");
        assert!(found == sixth(&name), "{name}");
    }
    assert_eq!(Scenario::load("tour+real").unwrap().factors.len(), Factor::ALL.len());
    let unknown = Scenario::load("tour+sun+moon").unwrap_err().to_string();
    assert!(unknown.contains("moon") && unknown.contains("mount"), "{unknown}");
    // In a building there is no carpet for the sun to shine on.
    let refused = Scenario::load("office+mount+sun").unwrap_err().to_string();
    assert!(refused.ends_with("in a building some of corners, exposure, mount, found sun"), "{refused}");
    assert!(Scenario::load("office+mount+exposure").is_ok() && Scenario::load("office+real").is_err());
}
