//! What is said about wrong inputs needs no knowledge of the program's insides.

use crate::support::{MAP, Workspace, excerpt_text};

/// What a message must not contain: names of types and the like.
const INSIDES: [&str; 18] = [
    "usize",
    "isize",
    "u8",
    "u16",
    "u32",
    "u64",
    "i32",
    "i64",
    "f32",
    "f64",
    "Some(",
    "None",
    "Ok(",
    "Err(",
    "::",
    "struct",
    "enum",
    "Tracking(",
];

fn assert_plain(text: &str, what: &str) {
    for inside in INSIDES {
        let is_word = |(at, _): (usize, &str)| {
            let before = text[..at].chars().next_back();
            let after = text[at + inside.len()..].chars().next();
            let is_part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
            let is_name = inside.chars().all(char::is_alphanumeric);
            !is_name || !(is_part(before) || is_part(after))
        };
        assert!(!text.match_indices(inside).any(is_word), "{what}: {text}");
    }
    // CamelCase names of types; products such as CameraInfo of ROS are known to users.
    let is_type_name = |word: &&str| {
        let humps =
            word.chars().zip(word.chars().skip(1)).filter(|(a, b)| a.is_lowercase() && b.is_uppercase());
        let is_known = ["CameraInfo", "OpenCV", "RoboCup"].iter().any(|known| word.contains(known));
        humps.count() > 0 && word.starts_with(char::is_uppercase) && !is_known
    };
    let mut words = text.split(|c: char| !c.is_ascii_alphanumeric());
    assert_eq!(words.find(is_type_name), None, "{what}: {text}");
}

#[test]
fn no_message_shows_names_of_types() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    let on_bag = ["localize", &bag, "--map", MAP];
    let files: [(&str, &str, &[&str]); 17] = [
        ("a.toml", "num_particles = \"many\"", &["--algorithm", "mc", "--config", "a.toml"]),
        ("b.toml", "num_particles = 1.5", &["--algorithm", "mc", "--config", "b.toml"]),
        ("c.toml", "num_particles = -5", &["--algorithm", "mc", "--config", "c.toml"]),
        ("d.toml", "num_particles = [1]", &["--algorithm", "mc", "--config", "d.toml"]),
        ("e.toml", "analysis = 3", &["--pipeline", "e.toml"]),
        ("f.toml", "analysis = { colors = 1 }", &["--pipeline", "f.toml"]),
        ("g.toml", "features = 7", &["--pipeline", "g.toml"]),
        ("h.toml", "[lift]\nmax_unloaded_n = true", &["--pipeline", "h.toml"]),
        ("i.toml", "image = 3", &["--topics", "i.toml"]),
        ("j.toml", "camera = 1", &["--robot", "j.toml"]),
        ("k.toml", "[camera]\npitch_down_deg = \"x\"", &["--robot", "k.toml"]),
        ("l.toml", "width = \"x\"\nheight = []", &["--camera", "l.toml"]),
        ("m.toml", "kind = \"robocup-field\"\nlength_m = \"x\"", &["--map", "m.toml"]),
        ("n.toml", "kind = \"office\"\nwalls = 4", &["--map", "n.toml"]),
        ("o.toml", "kind = 1", &["--map", "o.toml"]),
        ("p.toml", "frames_per_sec = [\n", &[]),
        ("q.toml", "motion = [{ stand = 3 }]", &[]),
    ];
    for (name, text, options) in files {
        workspace.write(name, text);
        let scenario = format!("sim:{name}");
        let command = match options {
            [] => vec!["localize", &scenario],
            ["--map", map] => vec!["localize", &bag, "--map", map],
            options => [&on_bag[..], options].concat(),
        };
        let outcome = workspace.visloc(&command);
        assert_plain(&format!("{}{}", outcome.stdout, outcome.stderr), name);
    }
    for (key, value) in [("tracking.max_matches", "many"), ("tracking", "3"), ("features.descriptor", "4")] {
        let error = workspace.refused(&["slam", &bag, "--set", &format!("{key}={value}")]);
        assert_plain(&error, key);
    }
    let outcome = workspace.visloc(&[&on_bag[..], &["--frames", "x"]].concat());
    assert_plain(&outcome.stderr, "--frames");
    let outcome = workspace.visloc(&["demo", "--moon", "x"]);
    assert!(outcome.code == 2 && !outcome.stderr.contains("as a value"), "{}", outcome.stderr);
    assert!(workspace.visloc(&[&on_bag[..], &["--config", "missing.toml"]].concat()).code == 1);
}

/// What is asked for in a way that nobody has foreseen is answered with what to do instead.
#[test]
fn what_is_meant_otherwise_is_answered_with_what_to_do() {
    let workspace = Workspace::new();
    let bag = excerpt_text("R1");
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/desk-clip");
    workspace.write("room.vmap", "x");
    workspace.write("camera.xml", "<?xml version=\"1.0\"?>\n<opencv_storage/>\n");
    workspace.write("other.yaml", "lens: good\n");
    for folder in ["photos", "parts/part0"] {
        std::fs::create_dir_all(workspace.path(folder)).unwrap();
    }
    workspace.write("photos/a.heic", "x");
    workspace.write("parts/part0/a.png", "x");
    workspace.write("robot.csv", "t,x,y,yaw\n1,0,0,0\n2,1,0,0\n");
    workspace.write(
        "way.tum",
        "# t_s tx ty tz qx qy qz qw, camera to world, map units\n1 0 0 0 0.5 -0.5 0.5 -0.5\n",
    );
    let board = ["--size", "9x6", "--square", "0.03"];
    let cases: [(&[&str], &str); 22] = [
        (&["slam", "loop:"], "loop:: expected loop:DIR|FILE.mp4"),
        (
            &["slam", "loop:sim:tour"],
            "expected a folder of images or a video file to repeat, found nothing of that name",
        ),
        (&["demo", "slam", "--scenario", "tour"], "error: tour: expected a tour of a camera: room, hall"),
        (&["experiment", "office", "gone.mcap"], "with map.yaml beside it, found no gone.mcap"),
        (&["simulate", "office+sun"], "factors: expected in a building some of corners, exposure, mount"),
        (&["map", "check", "room.vmap"], "found one of SLAM"),
        (&["localize", &bag, "--map", "robocup"], "did you mean 'robocup-spl-2010'?"),
        (&["check-camera", "camera.xml"], "found XML"),
        (&["check-camera", "other.yaml"], "transforms.json"),
        (&["slam", "photos"], "1 .heic files: convert them to JPEG or PNG"),
        (&["calibrate", "photos", board[0], board[1], board[2], board[3]], "1 .heic files"),
        (&["extract", "parts", "--out", "d"], "part0: name that folder"),
        (
            &["calibrate", clip, board[0], board[1], board[2], board[3]],
            "usable pictures of the board, found 0",
        ),
        (
            &["slam", clip, "--from", "1s", "--until", "0.5s"],
            "--until: expected a place behind that of --from",
        ),
        (&["slam", clip, "--from", "5s"], "it is 2.0 s long"),
        (&["slam", &bag, "--from", "50s"], "the source has 90 images, 8.9 s long"),
        (&["simulate", "still", "--out", "still.bag"], "name it .mcap"),
        (
            &["camera", "board", board[0], board[1], board[2], board[3], "--out", "truth.toml"],
            "ends with .svg",
        ),
        (&["evaluate", "way.tum", "robot.csv"], "of the same kind (--as robot takes"),
        (
            &["likelihood", "sim:office", "--out", "d"],
            "expected the map of a RoboCup field, found a building",
        ),
        (&["map", "show", "field.yaml"], "made TOML by visloc map import"),
        (&["config", "show", "nope"], "nope: there are no parameters of that name"),
    ];
    for (command, expected) in cases {
        let error = workspace.refused(command);
        assert!(error.contains(expected), "{command:?}: {error}");
    }
    let error = workspace.visloc(&["studio", "--listen", "127.0.0.1:7911"]).stderr;
    assert!(error.contains("--listen 127.0.0.1 --port 7911"), "{error}");
    workspace.must(&["check-camera", &format!("{clip}/camera.yaml"), clip]);
    workspace.must(&["slam", clip, "--save", "desk.vmap", "--trajectory", "desk.tum"]);
    let error = workspace.refused(&["map", "align", "desk.vmap", "--to", "desk.tum", "--out", "desk.vmap"]);
    assert!(error.contains("expected places in meters, found map units"), "{error}");
}

#[test]
fn numbers_are_asked_for_in_words() {
    let workspace = Workspace::new();
    workspace.write("a.toml", "num_particles = \"many\"");
    let command = ["localize", "sim:still", "--frames", "2", "--algorithm", "mc", "--config", "a.toml"];
    let error = workspace.refused(&command);
    assert!(error.contains("expected a whole number from 0 on, found \"many\""), "{error}");
}

#[cfg(unix)]
#[test]
fn a_loop_of_links_is_no_typing_mistake() {
    let workspace = Workspace::new();
    std::os::unix::fs::symlink(workspace.path("b.mcap"), workspace.path("a.mcap")).unwrap();
    std::os::unix::fs::symlink(workspace.path("a.mcap"), workspace.path("b.mcap")).unwrap();
    let error = workspace.refused(&["localize", "a.mcap", "--map", MAP]);
    assert!(
        error.to_lowercase().contains("too many levels of symbolic links") && !error.contains("did you mean"),
        "{error}"
    );
}
