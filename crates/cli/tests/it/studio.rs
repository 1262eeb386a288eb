//! What the studio is given by other commands, and what it refuses.

use std::net::TcpListener;

use visloc_studio::recording::RecordingIndex;

use crate::support::Workspace;

#[test]
fn runs_are_recorded() {
    let workspace = Workspace::new();
    workspace.must(&["localize", "sim:tour", "--frames", "9", "--record", "out/run.mcap"]);
    let mut run = RecordingIndex::open(&workspace.path("out/run.mcap")).unwrap();
    assert_eq!(run.num_frames(), 9);
    assert_eq!(run.state(8).unwrap().header["contenders"][0]["name"], "evolutionary");
    assert!(run.has_input(), "it can be computed again");
    workspace.must(&["localize", "out/run.mcap", "--map", "robocup-spl-2010", "--estimates", "again.csv"]);
    let again = std::fs::read_to_string(workspace.path("again.csv")).unwrap();
    assert_eq!(again.lines().count(), 1 + 9, "a recording is a bag as well");
    workspace.must(&["slam", "sim:room", "--end", "12", "--record", "slam.mcap"]);
    workspace.must(&["slam", "sim:room", "--end", "12", "--trajectory", "first.tum"]);
    workspace.must(&["slam", "slam.mcap", "--trajectory", "again.tum"]);
    let poses = |name: &str| std::fs::read_to_string(workspace.path(name)).unwrap();
    assert_eq!(poses("first.tum"), poses("again.tum"), "of the same images the same poses");
    let mut slam = RecordingIndex::open(&workspace.path("slam.mcap")).unwrap();
    assert_eq!(slam.num_frames(), 12);
    assert!(slam.state(11).unwrap().floats("landmarks").is_some());
}

/// In a program that is built without the viewer's files; else they are written, see `rerun.rs` of the crate of that name.
#[cfg(not(feature = "rerun"))]
#[test]
fn files_of_the_rerun_viewer_say_what_to_build() {
    let workspace = Workspace::new();
    let error = workspace.refused(&["localize", "sim:tour", "--frames", "3", "--record", "run.rrd"]);
    assert!(error.contains("--features rerun") && error.contains("run.rrd"), "{error}");
    assert!(!workspace.path("run.rrd").exists());
}

#[cfg(feature = "rerun")]
#[test]
fn runs_are_written_for_the_rerun_viewer_directly_and_from_recordings() {
    let workspace = Workspace::new();
    workspace.must(&["localize", "sim:tour", "--frames", "9", "--record", "run.rrd"]);
    workspace.must(&["localize", "sim:tour", "--frames", "9", "--record", "run.mcap"]);
    workspace.must(&["studio", "--replay", "run.mcap", "--export", "again.rrd"]);
    workspace.must(&["slam", "sim:room", "--end", "12", "--record", "slam.rrd"]);
    for name in ["run.rrd", "again.rrd", "slam.rrd"] {
        let bytes = std::fs::read(workspace.path(name)).unwrap();
        assert!(bytes.starts_with(b"RRF"), "{name}: {:?}", &bytes[..4]);
    }
}

#[test]
fn what_cannot_be_shown_is_refused_at_once() {
    let workspace = Workspace::new();
    let studio = |more: &[&str]| workspace.refused(&[&["studio", "--no-open", "--port", "0"], more].concat());
    assert!(studio(&["--scene", "moon"]).contains("robocup-2010"));
    assert!(studio(&["--replay", "missing.mcap"]).contains("missing.mcap"));
    workspace.write("notes.txt", "no recording");
    assert!(studio(&["--replay", "notes.txt"]).contains("expected a recording"));
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let error = workspace.refused(&["studio", "--no-open", "--port", &port]);
    assert!(error.contains("--port"), "{error}");
}
