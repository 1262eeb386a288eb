//! Maps, algorithms and parameters with mistakes.

use visloc_core::RgbImage;
use visloc_io::image_codec::save_png;

use crate::support::{MAP, Workspace, excerpt_text};

#[test]
fn maps_with_mistakes_name_the_place() {
    let workspace = Workspace::new();
    let good = workspace.must(&["map", "show", MAP]).stdout;
    workspace.write("good.toml", &good);
    assert!(workspace.must(&["map", "check", "good.toml"]).stdout.contains("6 x 4 m"));
    workspace.write("negative.toml", &good.replace("width_m = 4.0", "width_m = -4.0"));
    let error = workspace.refused(&["map", "check", "negative.toml"]);
    assert!(error.contains("negative.toml") && error.contains("width_m") && error.contains("-4"), "{error}");
    workspace.write("missing.toml", &good.replace("length_m = 6.0", ""));
    let error = workspace.refused(&["localize", &excerpt_text("R1"), "--map", "missing.toml"]);
    assert!(error.contains("missing.toml") && error.contains("length_m"), "{error}");
    let error = workspace.refused(&["map", "check", "nowhere.toml"]);
    assert!(error.contains("nowhere.toml") && error.contains(MAP), "{error}");
}

#[test]
fn unknown_algorithm_lists_the_known_ones() {
    let bag = excerpt_text("R1");
    let error = Workspace::new().refused(&["localize", &bag, "--map", MAP, "--algorithm", "kalman"]);
    assert!(error.contains("kalman") && error.contains("evolutionary") && error.contains("mce"), "{error}");
}

#[test]
fn parameters_come_from_files() {
    let workspace = Workspace::new();
    let defaults = workspace.must(&["config", "show", "mce"]).stdout;
    workspace.write("mce.toml", &defaults);
    let bag = excerpt_text("R1");
    let run = |options: &[&str], file: &str| {
        let base =
            ["localize", &bag, "--map", MAP, "--algorithm", "mce", "--frames", "20", "--estimates", file];
        workspace.must(&[&base[..], options].concat());
        workspace.read(file)
    };
    let plain = run(&[], "plain.csv");
    assert_eq!(plain, run(&["--config", "mce.toml"], "defaults.csv"));
    workspace.write("few.toml", "num_particles = 30\n");
    assert_ne!(plain, run(&["--config", "few.toml"], "few.csv"));
    workspace.write("pipeline.toml", "[analysis]\nmax_line_pixels = 3\n");
    assert_ne!(plain, run(&["--pipeline", "pipeline.toml"], "pipeline.csv"));
}

#[test]
fn parameters_with_mistakes_name_file_and_line() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    let base = ["localize", &bag, "--map", MAP, "--estimates", "kept.csv"];
    workspace.write("kept.csv", "an earlier run");
    for (option, name) in [("--config", "a.toml"), ("--pipeline", "b.toml"), ("--topics", "c.toml")] {
        workspace.write(name, "\nnum_partikles = 5\n");
        let error = workspace.refused(&[&base[..], &[option, name]].concat());
        assert!(
            error.contains(name) && error.contains("line 2") && error.contains("num_partikles"),
            "{error}"
        );
    }
    assert_eq!(workspace.read("kept.csv"), "an earlier run", "a typing mistake destroys nothing");
}

#[test]
fn unknown_keys_have_a_nearest_one_and_colors_can_be_named_in_part() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    let base = ["localize", &bag, "--map", MAP, "--frames", "5"];
    workspace.write("e.toml", "\n[explorers]\nperod = 5\n");
    let error = workspace.refused(&[&base[..], &["--config", "e.toml"]].concat());
    let wanted = "line 3: unknown key `perod` in [explorers], did you mean `period`?";
    assert!(error.contains("e.toml") && error.contains(wanted), "{error}");
    workspace.write("c.toml", "[analysis.colors.green]\nmin_saturation = 0.25\n");
    let error = workspace.refused(&[&base[..], &["--pipeline", "c.toml"]].concat());
    assert!(error.contains("green makes no difference") && error.contains("source = \"table\""), "{error}");
    workspace
        .write("c.toml", "analysis.colors.source = \"table\"\nanalysis.colors.green.min_saturation = 0.25\n");
    workspace.must(&[&base[..], &["--pipeline", "c.toml"]].concat());
    workspace.write("c.toml", "[analysis.colors.green]\nfrom_degrees = 80\n");
    let error = workspace.refused(&[&base[..], &["--pipeline", "c.toml"]].concat());
    assert!(error.contains("in [analysis.colors.green], did you mean `from_deg`?"), "{error}");
    for (words, wanted) in [
        (
            ["--set", "analysis.column_step_px=6"],
            "found one of the pipeline: --set pipeline.analysis.column_step_px=6",
        ),
        (["--set", "pipeline.num_exploiters=9"], "found one of evolutionary: --set num_exploiters=9"),
        (["--set", "period=9"], "did you mean `explorers.period`?"),
        (
            ["--config", "c.toml"],
            "c.toml: expected parameters of evolutionary, found those of the pipeline: give it with --pipeline",
        ),
        (
            ["--config", "m.toml"],
            "m.toml: expected parameters of evolutionary, found those of mce: give it with --algorithm mce",
        ),
        (
            ["--pipeline", "e.toml"],
            "e.toml: expected parameters of the pipeline, found those of evolutionary: give it with --config",
        ),
    ] {
        workspace.write("c.toml", "[analysis]\ncolumn_step_px = 6\n");
        workspace.write("e.toml", "num_exploiters = 9\n");
        workspace.write("m.toml", "num_particles = 9\n");
        let error = workspace.refused(&[&base[..], &words].concat());
        assert!(error.contains(wanted) && error.len() < 200, "{error}");
    }
}

#[test]
fn every_parameter_is_shown_with_its_meaning() {
    let workspace = Workspace::new();
    for name in ["evolutionary", "kld", "markov", "pipeline", "topics", "sdvl", "orb-sdvl"] {
        let text = workspace.must(&["config", "show", name]).stdout;
        let lines: Vec<&str> = text.lines().collect();
        let is_value = |line: &str| line.contains(" = ") && !line.starts_with('#');
        let is_explained = |pair: &[&str]| !is_value(pair[1]) || pair[0].starts_with('#');
        assert!(lines.windows(2).all(is_explained), "{text}");
    }
    let topics = workspace.must(&["config", "show", "topics"]).stdout;
    assert!(topics.contains("# camera_frame ="), "{topics}");
    workspace.write("topics.toml", &topics);
    workspace.must(&[
        "localize",
        &excerpt_text("R1"),
        "--map",
        MAP,
        "--frames",
        "5",
        "--topics",
        "topics.toml",
    ]);
}

#[test]
fn colors_are_learned_from_a_painted_image() {
    let workspace = Workspace::new();
    let mut image = RgbImage::new(40, 30);
    let mut labels = RgbImage::new(40, 30);
    for y in 0..30 {
        for x in 0..40 {
            let (color, label) =
                if x < 20 { ([150, 60, 140], [0, 255, 0]) } else { ([240, 235, 225], [255; 3]) };
            image.set(x, y, color);
            labels.set(x, y, if y < 20 { label } else { [0; 3] });
        }
    }
    save_png(&image, &workspace.path("image.png")).unwrap();
    save_png(&labels, &workspace.path("labels.png")).unwrap();
    workspace.must(&["colors", "image.png", "--labels", "labels.png", "--out", "colors.toml"]);
    let text = workspace.read("colors.toml");
    assert!(text.contains("[analysis.colors.green]"), "{text}");
    let bag = excerpt_text("R1");
    workspace.must(&["localize", &bag, "--map", MAP, "--pipeline", "colors.toml", "--frames", "5"]);
    save_png(&RgbImage::new(40, 20), &workspace.path("small.png")).unwrap();
    let error = workspace.refused(&["colors", "image.png", "--labels", "small.png", "--out", "c.toml"]);
    assert!(error.contains("40 x 30") && error.contains("40 x 20"), "{error}");
}

/// A file of parameters in the form of ROS 2 does what the same words do that are typed, and what is typed wins.
#[test]
fn parameters_of_ros_2_are_options_and_parameters() {
    let workspace = Workspace::new();
    workspace.write(
        "p.yaml",
        "/**:\n  ros__parameters:\n    source: sim:tour\n    frames: 20\n    seed: 3\n    trajectory: file.tum\n    \
         config: { explorers: { num_random: 20 } }\n    pipeline.analysis.column_step_px: 6\namcl:\n  ros__parameters: { a: 1 }\n",
    );
    workspace.must(&["localize", "--params-file", "p.yaml"]);
    let typed = [
        "localize",
        "sim:tour",
        "--frames",
        "20",
        "--seed",
        "3",
        "--set",
        "explorers.num_random=20",
        "--set",
        "pipeline.analysis.column_step_px=6",
        "--trajectory",
    ];
    workspace.must(&[&typed[..], &["typed.tum"]].concat());
    let read = |name: &str| workspace.read(name);
    assert_eq!(read("file.tum"), read("typed.tum"));
    workspace.must(&["localize", "--params-file", "p.yaml", "--seed", "4", "--trajectory", "other.tum"]);
    assert_ne!(read("other.tum"), read("typed.tum"));

    let refused = |text: &str, words: &[&str]| {
        workspace.write("bad.yaml", &format!("/**:\n  ros__parameters: {{ {text} }}\n"));
        workspace.refused(&[words, &["--params-file", "bad.yaml"]].concat())
    };
    let localize = ["localize", "sim:tour", "--frames", "1"];
    let said = refused("algoritm: mce", &localize);
    assert!(said.contains("bad.yaml: unknown parameter `algoritm`, did you mean `algorithm`?"), "{said}");
    let said = refused("seed: many", &localize);
    assert!(said.starts_with("error: bad.yaml: invalid value 'many' for '--seed"), "{said}");
    let said = refused("config.explorers.num_randm: 5", &localize);
    assert!(said.contains("unknown key `num_randm` in [explorers], did you mean `num_random`?"), "{said}");
    let said = refused("config.tracking.max_matchs: 5", &["slam", "sim:room", "--until", "2"]);
    assert!(said.contains("did you mean `max_matches`?"), "{said}");
}

#[test]
fn options_of_the_pipeline_that_change_nothing_are_refused() {
    let workspace = Workspace::new();
    for (source, features, option) in [
        ("sim:still", "rich", "office.refinement.max_tracks=3"),
        ("sim:office", "rich", "analysis.max_line_pixels=3"),
        ("sim:still", "pixels", "refinement.max_tracks=3"),
        ("sim:office", "pixels", "office.refinement.max_tracks=3"),
        ("sim:still", "rich", "office = { refinement = { max_tracks = 3 } }"),
        ("sim:still", "rich", "refinement = { evidence_per_image = 3 }"),
        ("sim:still", "rich", "refinement.evidence_per_image=3"),
        ("sim:still", "rich", "refinement.evidence_deadband=0.1"),
        ("sim:still", "rich", "refinement.max_evidence_difference=0.5"),
        ("sim:still", "rich", "refinement.max_bend_evidence=3"),
        ("sim:still", "rich", "refinement.evidence_kept=0.5"),
        ("sim:still", "rich", "refinement.stale_evidence_kept=0.5"),
        ("sim:still", "rich", "refinement.blurring_turn_rad_per_s=0.5"),
        ("sim:still", "pixels", "analysis.max_line_borders=3"),
        ("sim:still", "pixels", "analysis.max_goal_borders=3"),
    ] {
        let option = format!("pipeline.{option}");
        let base = ["localize", source, "--frames", "2", "--features", features, "--set", &option];
        let error = workspace.refused(&base);
        assert!(error.contains(&option) && error.contains("it would change nothing"), "{error}");
    }
    workspace.must(&[
        "localize",
        "sim:office",
        "--frames",
        "2",
        "--set",
        "pipeline.office.refinement.max_tracks=3",
    ]);
}

#[test]
fn options_for_parts_of_slam_that_are_off_are_refused() {
    let workspace = Workspace::new();
    let base = ["slam", "sim:room", "--until", "2"];
    for (off, option) in [
        ("features.descriptor=patches", "features.max_orb_distance=50"),
        ("features.descriptor=patches", "features.orb_margin_px=4"),
        ("features.descriptor=patches", "features={orb_margin_px = 4}"),
        ("tracking.reject_outliers=false", "tracking.max_hypotheses=50"),
        ("mapping.adjust_bundles=false", "mapping.adjust_lens=false"),
        ("mapping.adjust_bundles=false", "mapping.bundle_keyframes=5"),
        ("mapping.adjust_bundles=false", "mapping.bundle_first_iterations=5"),
        ("mapping.adjust_bundles=false", "mapping.bundle_last_iterations=5"),
    ] {
        let error = workspace.refused(&[&base[..], &["--set", off, "--set", option]].concat());
        assert!(error.contains(option) && error.contains("it would change nothing"), "{error}");
    }
    let orb = ["--set", "features.max_orb_distance=50", "--set", "features.descriptor=orb"];
    workspace.must(&[&base[..], &orb].concat());
    workspace
        .must(&[&base[..], &["--set", "features={max_orb_distance = 50, descriptor = \"orb\"}"]].concat());
    workspace.write("orb.toml", "features.max_orb_distance = 50\n");
    let error = workspace.refused(&[&base[..], &["--config", "orb.toml"]].concat());
    assert!(error.contains("orb.toml: features.max_orb_distance: it would change nothing"), "{error}");
    workspace.must(&[&base[..], &["--config", "orb.toml", "--set", "features.descriptor=orb"]].concat());
}

#[test]
fn values_that_do_not_go_together_name_where_they_come_from() {
    let workspace = Workspace::new();
    workspace.write("few.toml", "tracking.max_matches = 40\n");
    let base = ["slam", "sim:room", "--until", "2", "--config", "few.toml"];
    let error = workspace.refused(&[&base[..], &["--set", "tracking.min_matches=50"]].concat());
    let place = "few.toml, --set tracking.min_matches=50: tracking.min_matches: expected at most 40";
    assert!(error.contains(place), "{error}");
}

#[test]
fn options_that_a_job_of_slam_does_not_use_are_refused() {
    let workspace = Workspace::new();
    workspace.must(&["slam", "sim:room", "--until", "60", "--save", "room.vmap", "--trajectory", "way.tum"]);
    let jobs: [(&[&str], &[&str], &str); 3] = [
        (
            &["slam", "sim:room", "--until", "5", "--load", "room.vmap", "--fixed"],
            &["start.min_points=60", "mapping.lost_ratio=0.5", "relocation.close_loops=false"],
            "tracking.max_matches=100",
        ),
        (
            &["localize", "sim:room", "--frames", "5", "--map", "room.vmap"],
            &["start.min_points=60", "relocation.new_map_secs=3"],
            "mapping.lost_ratio=0.5",
        ),
        (
            &["slam", "sim:room", "--until", "60", "--poses", "way.tum", "--save", "given.vmap"],
            &["start.min_points=60", "tracking.max_matches=100", "mapping.lost_ratio=0.5"],
            "mapping.max_new_candidates=200",
        ),
    ];
    for (job, unused, used) in jobs {
        for option in unused {
            let error = workspace.refused(&[job, &["--set", option]].concat());
            assert!(error.contains(&format!("--set {option}: it would change nothing: ")), "{error}");
            let (key, value) = option.split_once('=').unwrap();
            workspace.write("job.toml", &format!("{key} = {value}\n"));
            let error = workspace.refused(&[job, &["--config", "job.toml"]].concat());
            assert!(error.contains(&format!("job.toml: {key}: it would change nothing: ")), "{error}");
        }
        workspace.must(&[job, &["--set", used]].concat());
    }
}

#[test]
fn parameters_of_algorithms_that_are_off_are_refused() {
    let workspace = Workspace::new();
    for (algorithm, option) in [
        ("evolutionary", "explorers.num_grid=300"),
        ("evolutionary-grid", "explorers.num_random=30"),
        ("evolutionary", "evidence.kept=0.9"),
        ("mce", "sample_size.max_error=0.1"),
        ("mce", "injection.alpha_slow=0.1"),
        ("mce", "resampling.min_effective_share=0.3"),
        ("markov", "start.x_m=1"),
    ] {
        let run = ["localize", "sim:tour", "--frames", "2", "--algorithm", algorithm, "--set", option];
        let error = workspace.refused(&run);
        assert!(error.contains("it would change nothing: it counts only with "), "{error}");
    }
    // In a building evidence counts.
    workspace.must(&["localize", "sim:office", "--frames", "2", "--set", "evidence.kept=0.9"]);
}

#[test]
fn numbers_that_no_key_can_have_are_told_as_they_were_typed() {
    let workspace = Workspace::new();
    for (value, found) in [
        ("nan", "found nan or inf"),
        ("-inf", "found nan or inf"),
        ("1e99", "found 1e99"),
        ("99999999999999999999", "found 1"),
    ] {
        let option = format!("num_exploiters={value}");
        let error = workspace.refused(&["localize", "sim:still", "--frames", "2", "--set", &option]);
        assert!(
            error.contains("num_exploiters") && error.contains(found) && !error.contains("null"),
            "{error}"
        );
    }
    let error = workspace.visloc(&["localize", "sim:still", "--seed", "-3"]).stderr;
    assert!(
        error.contains("invalid value '-3' for '--seed <SEED>': expected a whole number from 0 on"),
        "{error}"
    );
}
