//! A program that is stopped and goes on (Ctrl-Z and `fg`, a debugger) is on the network of ROS 2 again. A process of its own: all its
//! threads stop.

#![cfg(unix)]

use std::{
    process::{self, Command},
    thread,
    time::Duration,
};

use serde::{Deserialize, Serialize};
use visloc_io::ros2::{Network, TeamLink};

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
    let open = |network: &Network, number| Link::open(network, &format!("robot_{number}"), "ours", number);
    // The third one shares the participant of the first.
    let shared = Network::new(domain_id);
    let links =
        [(&shared, 1), (&Network::new(domain_id), 2), (&shared, 3)].map(|(network, i)| open(network, i));
    let [Ok(mut a), Ok(mut b), Ok(mut c)] = links else { return println!("skipped: no network") };
    assert!(is_heard(&mut a, &mut b, Word(1)) && is_heard(&mut c, &mut b, Word(2)), "never heard");
    let id = process::id();
    let stop = format!("kill -STOP {id}; sleep 0.5; kill -CONT {id}");
    assert!(Command::new("sh").args(["-c", &stop]).status().unwrap().success());
    assert!(
        is_heard(&mut a, &mut b, Word(3)) && is_heard(&mut b, &mut a, Word(4)),
        "not heard after the stop"
    );
    assert!(
        is_heard(&mut c, &mut b, Word(5)) && is_heard(&mut c, &mut a, Word(6)),
        "the third one not heard after the stop"
    );
}
