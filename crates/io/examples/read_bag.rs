//! Prints what is in a recording: `cargo run --release -p visloc-io --example read_bag -- recording.mcap`.

use std::{env, process::ExitCode};

use visloc_core::Source;
use visloc_io::bag::{BagReader, BagTopics};

fn main() -> ExitCode {
    let Some(path) = env::args().nth(1) else {
        eprintln!("usage: read_bag RECORDING");
        return ExitCode::FAILURE;
    };
    let mut bag = match BagReader::open(&path, BagTopics::default()) {
        Ok(bag) => bag,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    for topic in bag.available_topics() {
        println!("{:28} {:36} {} messages", topic.topic, topic.type_name, topic.num_messages);
    }
    let (mut num_frames, mut num_with_truth, mut num_with_odometry) = (0, 0, 0);
    while let Some(next) = bag.next_item() {
        match next {
            Ok(frame) => {
                num_frames += 1;
                num_with_truth += usize::from(frame.truth.is_some());
                num_with_odometry += usize::from(frame.frame.odometry.is_some());
            }
            Err(error) => println!("ended early: {error}"),
        }
    }
    println!("{num_frames} frames, {num_with_truth} with truth, {num_with_odometry} with odometry");
    println!("{} frames with held values", bag.num_frames_with_held_values());
    for skipped in bag.status().skipped.iter().take(10) {
        println!(
            "left out: {} {:?}: {}",
            skipped.origin,
            skipped.at.map(|at| at.to_string()),
            skipped.reason
        );
    }
    println!("{} messages left out", bag.status().skipped.len());
    ExitCode::SUCCESS
}
