//! A program that is stopped and goes on (Ctrl-Z and `fg`, a debugger) is on the network of ROS 2 again. A process of its own: all its
//! threads stop.

#![cfg(unix)]

use std::{
    process::{self, Command},
    thread,
    time::Duration,
};

use serde::{Deserialize, Serialize};
use visloc_io::ros2::{NodeSettings, TeamLink};

/// How long two nodes may take to find each other; far above what they need.
const NUM_TRIES: usize = 1200;
const TRY_EVERY: Duration = Duration::from_millis(25);

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Word(u32);

type Link = TeamLink<Word, Word>;

/// Says a word until the other one has heard it.
fn is_heard(from: &mut Link, to: &mut Link, word: Word) -> bool {
    (0..NUM_TRIES).any(|_| {
        from.publish(word);
        thread::sleep(TRY_EVERY);
        from.messages();
        to.messages().contains(&word)
    })
}

#[test]
fn links_are_there_again_after_a_stop() {
    let domain_id = 60 + u16::try_from(process::id() % 40).unwrap();
    let open =
        |number: u8| Link::open(&NodeSettings { domain_id, name: format!("robot_{number}") }, "ours", number);
    let (mut a, mut b) = match (open(1), open(2)) {
        (Ok(a), Ok(b)) => (a, b),
        (Err(error), _) | (_, Err(error)) => return println!("skipped: {error}"),
    };
    assert!(is_heard(&mut a, &mut b, Word(1)), "never heard");
    let id = process::id();
    let stop = format!("kill -STOP {id}; sleep 0.5; kill -CONT {id}");
    assert!(Command::new("sh").args(["-c", &stop]).status().unwrap().success());
    assert!(
        is_heard(&mut a, &mut b, Word(2)) && is_heard(&mut b, &mut a, Word(3)),
        "not heard after the stop"
    );
}
