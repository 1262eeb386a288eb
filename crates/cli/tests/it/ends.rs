//! A run with an empty or useless result says so, and does not end as if all were well.

use visloc_core::RgbImage;

use crate::support::{MAP, Workspace, excerpt_text};

#[test]
fn nothing_to_show_is_an_error_that_says_why() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    let black = RgbImage::new(64, 48);
    workspace.bag("black.mcap", 20, |_, next| {
        next.frame.image = RgbImage::new(next.frame.image.width(), next.frame.image.height());
    });
    std::fs::create_dir(workspace.path("photos")).unwrap();
    for name in ["photos/a.png", "photos/b.png", "labels.png", "image.png"] {
        let bytes = visloc_io::image_codec::encode_png(&black).unwrap();
        std::fs::write(workspace.path(name), bytes).unwrap();
    }
    workspace.write("one.tum", "1.0 0 0 0 0 0 0 1\n2.0 1 0 0 0 0 0 1\n");
    workspace.write("other.tum", "100.0 0 0 0 0 0 0 1\n101.0 1 0 0 0 0 0 1\n");
    workspace.write("no-frames.toml", "duration_secs = 0.001\nframes_per_sec = 30.0\n");
    let cases: [(&[&str], &str); 8] = [
        (&["calibrate", "photos", "--size", "9x6", "--square", "0.025"], "found"),
        (&["calibrate-robot", "black.mcap", "--map", MAP], "expected"),
        (&["evaluate", "one.tum", "other.tum"], "are both of the same run?"),
        (&["colors", "image.png", "--labels", "labels.png", "--out", "c.toml"], "green: expected at least"),
        (&["likelihood", "black.mcap", "--map", MAP], "no pixel of a line or goal"),
        (&["simulate", "no-frames.toml", "--out", "none.mcap"], "at least one frame"),
        (&["localize", "sim:no-frames.toml"], "no frame that can be used"),
        (&["slam", &bag, "--from", "900"], "no image"),
    ];
    for (command, part) in cases {
        let outcome = workspace.visloc(command);
        assert_eq!(outcome.code, 1, "{command:?}: {}{}", outcome.stdout, outcome.stderr);
        assert!(outcome.stderr.contains(part), "{command:?}: {}", outcome.stderr);
    }
    assert_ne!(workspace.visloc(&["experiment", "kidnap", "--runs", "0"]).code, 0);
    assert_ne!(workspace.visloc(&["record", &bag, "--out", "n.mcap", "--frames", "0"]).code, 0);
}
