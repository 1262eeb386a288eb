//! What the studio is given by other commands, and what it refuses.

use std::{
    io::{BufRead as _, BufReader, Read as _, Write as _},
    net::{TcpListener, TcpStream},
};

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
    workspace.must(&["slam", "sim:room", "--until", "12", "--record", "slam.mcap"]);
    workspace.must(&["slam", "sim:room", "--until", "12", "--trajectory", "first.tum"]);
    workspace.must(&["slam", "slam.mcap", "--trajectory", "again.tum"]);
    let poses = |name: &str| std::fs::read_to_string(workspace.path(name)).unwrap();
    assert_eq!(poses("first.tum"), poses("again.tum"), "of the same images the same poses");
    let mut slam = RecordingIndex::open(&workspace.path("slam.mcap")).unwrap();
    assert_eq!(slam.num_frames(), 12);
    assert!(slam.state(11).unwrap().floats("landmarks").is_some());
}

/// Watches until the program ends, and says as fast as possible that everything has been drawn; how many bytes came.
fn watch(address: &str, token: &str) -> usize {
    /// A masked text message, `drawn`.
    const DRAWN: [u8; 11] = [0x81, 0x85, 0, 0, 0, 0, b'd', b'r', b'a', b'w', b'n'];
    let mut page = TcpStream::connect(address).unwrap();
    write!(
        page,
        "GET /socket?token={token} HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
    .unwrap();
    let (mut num_bytes, mut buffer) = (0, [0; 1 << 16]);
    while let Ok(count) = page.read(&mut buffer) {
        if count == 0 || page.write_all(&DRAWN).is_err() {
            break;
        }
        num_bytes += count;
    }
    num_bytes
}

#[test]
fn what_cannot_be_driven_is_refused_with_what_can() {
    let workspace = Workspace::new();
    let publish = ["--publish", "127.0.0.1:0", "--allow-drive"];
    workspace.must(&["simulate", "tour", "--frames", "2", "--out", "short.mcap"]);
    for run in
        [&["localize", "short.mcap", "--map", "robocup-spl-2010"][..], &["slam", "sim:room", "--until", "2"]]
    {
        let refused = workspace.visloc(&[run, &publish].concat());
        assert!(
            refused.code == 1 && refused.stderr.contains("--allow-drive: expected"),
            "{}",
            refused.stderr
        );
    }
    // A robot that is driven has no end that is known before.
    let range = workspace.refused(&[&["slam", "sim:robocup", "--until", "2"][..], &publish].concat());
    assert!(range.contains("--until"), "{range}");
    let alone = workspace.visloc(&["localize", "sim:tour", "--allow-drive"]);
    assert!(alone.code == 2 && alone.stderr.contains("--publish"), "{}", alone.stderr);
}

/// Who drives needs a token, also on this computer; and a robot that nobody drives stands.
#[test]
fn a_driven_robot_asks_for_a_token_and_stands_until_it_is_driven() {
    let workspace = Workspace::new();
    let run = ["localize", "sim:tour", "--frames", "20", "--publish", "127.0.0.1:0", "--allow-drive"];
    let done = workspace.must(&[&run[..], &["--record", "run.mcap"]].concat());
    assert!(
        done.stdout.contains("--connect 127.0.0.1:") && done.stdout.contains(" --token "),
        "{}",
        done.stdout
    );
    let mut run = RecordingIndex::open(&workspace.path("run.mcap")).unwrap();
    let mut place = |frame| run.state(frame).unwrap().header["truth"]["pose"].clone();
    assert_eq!(place(1), place(19), "it walks by itself");
    assert_eq!(run.state(19).unwrap().header["drive"]["is_driven"], false);
}

#[test]
fn a_driven_robot_in_a_map_of_slam_stands_until_it_is_driven() {
    let workspace = Workspace::new();
    workspace.must(&["slam", "sim:office-walk", "--until", "12s", "--save", "walk.vmap"]);
    let run =
        ["localize", "sim:office-walk", "--map", "walk.vmap", "--frames", "30", "--trajectory", "way.tum"];
    let drive = ["--publish", "127.0.0.1:0", "--allow-drive", "--record", "run.mcap"];
    let done = workspace.must(&[&run[..], &drive].concat());
    assert!(done.stdout.contains(" --token "), "{}", done.stdout);
    let mut recording = RecordingIndex::open(&workspace.path("run.mcap")).unwrap();
    assert_eq!(recording.state(29).unwrap().header["drive"]["is_driven"], false);
    let way = workspace.read("way.tum");
    let place = |line: &str| -> Vec<f64> {
        line.split_whitespace().skip(1).take(3).map(|number| number.parse().unwrap()).collect()
    };
    let places: Vec<Vec<f64>> = way.lines().filter(|line| !line.starts_with('#')).map(place).collect();
    let [first, last] = [places.first().unwrap(), places.last().unwrap()];
    let way_m = first.iter().zip(last).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    assert!(places.len() > 20 && way_m < 0.1, "it walks by itself: {way_m} m in {} poses", places.len());
}

#[test]
fn whoever_watches_changes_no_estimate() {
    let workspace = Workspace::new();
    let run = ["localize", "sim:kidnaps", "--frames", "60", "--seed", "3"];
    workspace.must(&[&run[..], &["--trajectory", "alone.tum"]].concat());
    let publish = ["--trajectory", "watched.tum", "--publish", "127.0.0.1:0", "--token", "secret"];
    let mut watched = workspace.start(&[&run[..], &publish[..]].concat());
    let mut lines = BufReader::new(watched.stdout.take().unwrap()).lines().map(Result::unwrap);
    let line = lines.find(|line| line.contains("--connect")).expect("it says where to look");
    let mut words = line.split_whitespace().skip_while(|word| *word != "--connect").skip(1);
    let num_bytes = watch(words.next().unwrap(), "secret");
    lines.for_each(drop);
    assert!(watched.wait().unwrap().success());
    // On a busy machine most images are left out; a single one has more than this.
    assert!(num_bytes > 30_000, "it was watched, with images: {num_bytes} bytes");
    assert_eq!(workspace.read("alone.tum"), workspace.read("watched.tum"));
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
    workspace.must(&["slam", "sim:room", "--until", "12", "--record", "slam.rrd"]);
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
    assert!(
        studio(&["sim:team", "--map", "robocup-spl-2010"]).contains("--map: sim:team has a field of its own")
    );
    assert!(studio(&["sim:team", "--fps", "3"]).contains("--fps"));
    assert!(studio(&["--scene", "moon"]).contains("sim:team"));
    assert!(studio(&["sim:moon"]).contains("error: sim:moon: expected the file of a scenario"));
    for command in [&["localize"][..], &["slam"], &["record", "--out", "team.mcap"]] {
        let error = workspace.refused(&[command, &["sim:team"]].concat());
        assert!(error.contains("a team of robots") && error.contains("visloc studio sim:team"), "{error}");
    }
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let error = workspace.refused(&["studio", "--no-open", "--port", &port]);
    assert!(error.contains("--port"), "{error}");
}
