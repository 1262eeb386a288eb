//! Recordings in other forms than MCAP, and images as files.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::support::{MAP, Workspace, data_lines};

fn testdata(name: &str) -> String {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata").join(name);
    path.to_str().unwrap().to_owned()
}

#[test]
fn every_form_of_a_recording_gives_the_same_poses() {
    let workspace = Workspace::new();
    let estimates = |source: &str| {
        workspace.must(&["localize", source, "--map", MAP, "--estimates", "e.csv"]);
        workspace.read("e.csv")
    };
    let (sqlite, ros1) = (testdata("R1-first-frames.db3"), testdata("R1-first-frames.bag"));
    let expected = estimates(&sqlite);
    assert_eq!(data_lines(&expected).len(), 7, "a head and 6 frames");
    assert_eq!(estimates(&ros1), expected);
    for (source, copy) in [(&sqlite, "a.mcap"), (&ros1, "b.mcap")] {
        let said = workspace.must(&["record", source, "--out", copy]).stdout;
        assert!(said.contains("41 messages"), "{said}");
        assert_eq!(estimates(copy), expected);
    }
}

#[test]
fn images_come_out_as_they_are() {
    let workspace = Workspace::new();
    let source = testdata("R1-first-frames.bag");
    let said = workspace.must(&["extract", &source, "--out", "images"]).stdout;
    assert!(said.contains("6 images"), "{said}");
    let list = workspace.read("images/rgb.txt");
    let lines = data_lines(&list);
    assert_eq!(lines.len(), 6);
    for line in lines {
        let name = line.split_once(' ').unwrap().1;
        assert!(fs::read(workspace.path("images").join(name)).unwrap().starts_with(&[0xff, 0xd8]));
    }
    assert!(workspace.read("images/camera.yaml").contains("image_width: 320"));
    let error = workspace.refused(&["extract", &source, "--out", "images"]);
    assert!(error.contains("new or empty folder"), "{error}");
    // The folder is a source of its own, and its files stay as they are.
    workspace.must(&["extract", "images", "--out", "again", "--every", "2"]);
    let names = |folder: &str| {
        let entries = fs::read_dir(workspace.path(folder).join("rgb")).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let all = names("images");
    let expected: Vec<_> = all.iter().step_by(2).cloned().collect();
    assert_eq!(names("again"), expected);
    let bytes = |folder: &str| fs::read(workspace.path(folder).join("rgb").join(&all[0])).unwrap();
    assert_eq!(bytes("again"), bytes("images"));
    workspace.must(&["extract", &source, "--out", "png", "--format", "png", "--frames", "2"]);
    assert_eq!(names("png").len(), 2);
}

#[test]
fn damaged_bags_are_refused_by_every_command_that_reads_them() {
    let workspace = Workspace::new();
    for (name, start) in [("x.db3", "SQLite format 3\0"), ("x.bag", "#ROSBAG V2.0\n"), ("x.mcap", "")] {
        for rest in ["", "and nothing that fits"] {
            workspace.write(name, &format!("{start}{rest}"));
            for args in [
                &["localize", name, "--map", MAP][..],
                &["slam", name],
                &["record", name, "--out", "out.mcap", "--overwrite"],
                &["extract", name, "--out", "out"],
                &["likelihood", name, "--map", MAP],
            ] {
                let error = workspace.refused(args);
                assert!(error.contains(name) && error.contains("expected"), "{args:?}: {error}");
            }
        }
    }
}
