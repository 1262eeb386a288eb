//! `visloc evaluate`.

use crate::support::Workspace;

/// A walk along x at 10 poses a second, off by `error_m` sideways.
fn tum(error_m: f64) -> String {
    (0..50)
        .map(|i| format!("{:.1} {:.2} {error_m} 0 0 0 0 1\n", f64::from(i) / 10.0, f64::from(i) / 100.0))
        .collect()
}

#[test]
fn errors_by_hand() {
    let workspace = Workspace::new();
    workspace.write("truth.tum", &tum(0.0));
    workspace.write("estimate.tum", &tum(0.25));
    let outcome = workspace.must(&["evaluate", "truth.tum", "estimate.tum", "--json", "e.json"]);
    assert!(outcome.stdout.contains("0.25"), "{}", outcome.stdout);
    let report = workspace.json("e.json");
    assert_eq!(report["frames"], 50);
    for part in ["mean", "median", "rmse", "p95", "max"] {
        assert!((report["position_error_m"][part].as_f64().unwrap() - 0.25).abs() < 1e-9, "{part}");
    }
    assert_eq!(report["localized_share"], 1.0);
}

#[test]
fn a_table_tells_its_reliability() {
    let workspace = Workspace::new();
    workspace.write("truth.tum", &tum(0.0));
    let lines = (0..50).map(|i| {
        let reliability = if i < 10 { 0.2 } else { 0.9 };
        format!("{:.1},{:.2},0.5,0,{reliability}\n", f64::from(i) / 10.0, f64::from(i) / 100.0)
    });
    workspace.write("estimate.csv", &format!("t,x,y,yaw,reliability\n{}", lines.collect::<String>()));
    let plots = ["--plots", "plots", "--map", "robocup-spl-2010"];
    workspace.must(&[&["evaluate", "truth.tum", "estimate.csv", "--json", "e.json"], &plots[..]].concat());
    let report = workspace.json("e.json");
    assert_eq!(report["localized_share"], 0.8);
    assert_eq!(report["time_to_localize_s"], 1.0);
    assert!(workspace.path("plots/trajectories.png").exists() && workspace.path("plots/errors.svg").exists());
}

#[test]
fn mistakes_name_file_and_line() {
    let workspace = Workspace::new();
    workspace.write("truth.tum", &tum(0.0));
    workspace.write("bad.tum", "0 1 2 0 0 0 0 1\n1 x 2 0 0 0 0 1\n");
    let error = workspace.refused(&["evaluate", "truth.tum", "bad.tum"]);
    assert!(error.contains("bad.tum") && error.contains("line 2"), "{error}");
    workspace.write("other.tum", "900 1 2 0 0 0 0 1\n");
    let error = workspace.refused(&["evaluate", "truth.tum", "other.tum"]);
    assert!(error.contains("other.tum") && error.contains("same run"), "{error}");
    workspace.write("table.csv", "t,x,y,yaw,reliability\n0,0,0,0,2\n");
    let error = workspace.refused(&["evaluate", "truth.tum", "table.csv"]);
    assert!(error.contains("table.csv, line 2"), "{error}");
    assert!(workspace.refused(&["evaluate", "none.tum", "bad.tum"]).contains("none.tum"));
}

/// A camera that flies a loop, once as it was and once half as large and turned.
fn loops() -> (String, String) {
    let (mut truth, mut estimate) = (String::new(), String::new());
    for i in 0..100 {
        let (sin, cos) = (f64::from(i) / 15.0).sin_cos();
        let z = 0.1 * f64::from(i % 10);
        truth += &format!("{:.2} {cos} {sin} {z} 0.5 0.5 0.5 0.5\n", f64::from(i) / 10.0);
        let (x, y) = (0.5 * cos, -0.5 * z);
        estimate +=
            &format!("{:.3} {x} {y} {} 0 0.70710678 0.70710678 0\n", f64::from(i) / 10.0 + 0.004, 0.5 * sin);
    }
    (truth, estimate)
}

#[test]
fn cameras_are_aligned_and_compared() {
    let workspace = Workspace::new();
    let (truth, estimate) = loops();
    workspace.write("truth.tum", &truth);
    workspace.write("estimate.tum", &estimate);
    let files = ["evaluate", "truth.tum", "estimate.tum", "--json", "e.json"];
    workspace.must(&[&files[..], &["--plots", "plots"]].concat());
    let report = workspace.json("e.json");
    assert_eq!((&report["kind"], &report["alignment"]), (&"camera".into(), &"sim3".into()));
    assert_eq!((&report["pairs"], &report["rpe_pairs"]), (&100.into(), &99.into()));
    assert!(report["ate_m"]["rmse"].as_f64().unwrap() < 1e-6, "{report}");
    assert!((report["scale"].as_f64().unwrap() - 2.0).abs() < 1e-6);
    assert!((report["coverage"].as_f64().unwrap() - 1.0).abs() < 0.01);
    for picture in ["errors.png", "trajectory.svg", "trajectory-side.png"] {
        assert!(workspace.path(&format!("plots/{picture}")).exists(), "{picture}");
    }
    workspace.must(&[&files[..], &["--align", "se3", "--delta", "0.5m", "--all-pairs"]].concat());
    let report = workspace.json("e.json");
    assert!(report["ate_m"]["rmse"].as_f64().unwrap() > 0.3 && report["rpe_delta"] == "0.5m", "{report}");
    let error = workspace.refused(&[&files[..], &["--offset", "-30"]].concat());
    assert!(error.contains("--offset"), "{error}");
    let outcome = workspace.visloc(&[&files[..], &["--delta", "far"]].concat());
    assert!(outcome.code == 2 && outcome.stderr.contains("0.5m"), "{}", outcome.stderr);
}

#[test]
fn a_truth_without_times_takes_those_beside_it() {
    let workspace = Workspace::new();
    let (truth, estimate) = loops();
    // The rotation of the quaternion, and the place behind each row.
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(' ').collect();
        format!("0 0 1 {} 1 0 0 {} 0 1 0 {}\n", fields[1], fields[2], fields[3])
    };
    workspace.write("poses.txt", &truth.lines().map(row).collect::<String>());
    workspace.write("estimate.tum", &estimate);
    let files = ["evaluate", "poses.txt", "estimate.tum", "--json", "e.json"];
    let error = workspace.refused(&files);
    assert!(error.contains("times.txt"), "{error}");
    let times = |num: usize| (0..num).map(|i| format!("{:.2}\n", i as f64 / 10.0)).collect::<String>();
    workspace.write("times.txt", &times(99));
    let error = workspace.refused(&files);
    assert!(error.contains("times.txt") && error.contains("99"), "{error}");
    workspace.write("times.txt", &times(100));
    workspace.must(&files);
    let report = workspace.json("e.json");
    assert_eq!(report["pairs"], 100);
    assert!(report["ate_m"]["rmse"].as_f64().unwrap() < 1e-6, "{report}");
    // By number only poses of the same images can be compared.
    workspace.write("part.txt", &truth.lines().take(40).map(row).collect::<String>());
    let error = workspace.refused(&["evaluate", "poses.txt", "part.txt"]);
    assert!(error.contains("100 and 40 poses"), "{error}");
    // Twelve numbers are a camera's, also where it drives straight ahead.
    let straight = |i: usize| format!("1 0 0 0 0 1 0 0 0 0 1 {i}\n");
    workspace.write("straight.txt", &(0..20).map(straight).collect::<String>());
    workspace.must(&["evaluate", "straight.txt", "straight.txt", "--align", "none", "--json", "s.json"]);
    assert_eq!(workspace.json("s.json")["pairs"], 20);
    let error = workspace.refused(&["evaluate", "straight.txt", "straight.txt"]);
    assert!(error.contains("not on a line"), "{error}");
}
