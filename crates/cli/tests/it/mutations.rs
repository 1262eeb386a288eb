//! Every parser on damaged inputs: what the fuzzer does for hours, for some seconds and always in the same way.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
};

use rustix::time::{ClockId, clock_gettime};
use visloc_core::RngTree;

use crate::parsers::{PARSERS, Parser};

/// Damaged inputs of each parser.
const NUM_INPUTS: u64 = 400;
/// No input takes longer, seconds of the processor; parsers are linear, and these inputs are short.
const MAX_SECS: f64 = 5.0;
/// Most letters of an input that is shown.
const MAX_SHOWN: usize = 600;

#[test]
fn no_parser_stumbles_over_damaged_input() {
    let next = AtomicUsize::new(0);
    let faults = Mutex::new(Vec::new());
    let work = || {
        while let Some(parser) = PARSERS.get(next.fetch_add(1, Ordering::Relaxed)) {
            let seeds = (parser.seeds)();
            let fault = (0..NUM_INPUTS).find_map(|number| fault(parser, &seeds, number));
            faults.lock().unwrap().extend(fault);
        }
    };
    let num_threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..num_threads).for_each(|_| drop(scope.spawn(work))));
    let faults = faults.into_inner().unwrap();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Inputs that the fuzzer found: the parser, and what was wrong.
const FOUND: [(&str, &str); 8] = [
    // Millimeters taken for meters: gigabytes of floor.
    (
        "map_dxf",
        "0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n8\nA-WALL\n90\n4\n70\n1\n10\n0\n20\n0\n10\n6000\n20\n0\n10\n6000\n20\n2000\n\
         10\n0\n20\n2000\n0\nENDSEC\n0\nEOF\n",
    ),
    // A wall of 6 km, and as many cells of floor beside it: seconds.
    (
        "map_dxf",
        "0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n8\nA-WALL\n90\n4\n70\n1\n10\n0\n20\n0\n10\n6000\n20\n0\n\
         0\nCIRCLE\n8\nA-WALL\n10\n0\n20\n0\n40\n9\n0\nENDSEC\n0\nEOF\n",
    ),
    // The number came back with another last bit.
    ("studio_messages", "\u{1}\0\0\u{b}-\0\0\0{\"number\":1.222222222222222e+105,\"arrays\":{}}"),
    // A picture without width.
    ("image_stream", "P5\n0 7\n255\n"),
    // More captures than there is memory for.
    (
        "experiment_records",
        "\0{\"experiment\":\"markov\",\"seed\":1,\"settings\":{\"captures\":{\"per_state\":18446744073709551615,\"seed\":1}}}",
    ),
    // A map was made once more for its pictures: a minute.
    (
        "experiment_records",
        "\0{\"experiment\":\"slam-configs\",\"seed\":1,\"settings\":{\"study\":\"configs\",\"sequences\":[\"sim:room\"],\
         \"configurations\":[\"config1\"],\"max_frames\":18446744073709551615}}",
    ),
    // A building of another kind became a map file that is none.
    (
        "studio_buildings",
        "{\"plan\":{\"kind\":\"ofFice\",\"name\":\"drawn\",\"walls\":[{\"from\":[0.0,0.0],\"to\":[8.0,0.0]},\
         {\"from\":[8.0,0.0],\"to\":[8.0,2.0]},{\"from\":[8.0,2.0],\"to\":[0.0,2.0]},{\"from\":[0.0,2.0],\"to\":[0.0,0.0]}],\
         \"doors\":[{\"from\":[1.0,0.0],\"to\":[1.9,0.0],\"color\":\"red\"}]}}",
    ),
    // The first picture stopped builds with overflow checks.
    ("studio_commands", "{\"type\":\"defaults\"}"),
];

#[test]
fn what_the_fuzzer_found_stays_mended() {
    for (number, (name, input)) in (0..).zip(FOUND) {
        let parser = PARSERS.iter().find(|parser| parser.name == name).unwrap();
        assert_eq!(fault_of(parser, number, input.as_bytes()), None);
    }
}

#[test]
fn good_inputs_are_short_enough() {
    for parser in PARSERS {
        let seeds = (parser.seeds)();
        assert!(!seeds.is_empty(), "{}", parser.name);
        assert!(seeds.iter().all(|seed| seed.len() <= parser.max_bytes), "{}", parser.name);
    }
}

/// What goes wrong with one damaged input, if anything does.
fn fault(parser: &Parser, seeds: &[Vec<u8>], number: u64) -> Option<String> {
    let mut dice = Dice { tree: RngTree::new(19).subtree(parser.name, number), count: 0 };
    let mut input = dice.pick(seeds).clone();
    // The first inputs are the good ones.
    for _ in 0..if number < seeds.len() as u64 { 0 } else { 1 + dice.below(3) } {
        damage(&mut input, seeds, &mut dice);
        input.truncate(parser.max_bytes);
    }
    fault_of(parser, number, &input)
}

/// What goes wrong with an input, if anything does.
fn fault_of(parser: &Parser, number: u64, input: &[u8]) -> Option<String> {
    let start = processor_secs();
    let outcome = catch_unwind(AssertUnwindSafe(|| (parser.read)(input)));
    let secs = processor_secs() - start;
    let what = match outcome {
        Err(_) => "panics".to_owned(),
        Ok(()) if secs > MAX_SECS => format!("takes {secs:.1} s"),
        Ok(()) => return None,
    };
    let shown = input[..input.len().min(MAX_SHOWN)].escape_ascii();
    Some(format!("{}, input {number} of {} bytes {what}: {shown}", parser.name, input.len()))
}

/// Time that this thread has had the processor.
fn processor_secs() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Random numbers of one input.
struct Dice {
    tree: RngTree,
    count: u64,
}

impl Dice {
    /// Below a bound, which is above 0.
    fn below(&mut self, bound: usize) -> usize {
        self.count += 1;
        (self.tree.stream_seed("dice", self.count) % bound as u64) as usize
    }

    fn pick<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }

    /// A part of an input.
    fn part(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.below(length + 1);
        let longest = (length - start).min(1 << self.below(12));
        start..start + self.below(longest + 1)
    }
}

/// Numbers at the borders of types and behind them.
const NUMBERS: [&str; 18] = [
    "0",
    "-0",
    "-1",
    "1",
    "255",
    "256",
    "65536",
    "2147483648",
    "4294967295",
    "9223372036854775807",
    "18446744073709551616",
    "1e-320",
    "1e39",
    "1e300",
    "1e999",
    "nan",
    "-inf",
    "0.1e",
];
/// Words that begin or end something, in one of the formats.
const WORDS: [&str; 30] = [
    "[",
    "]",
    "{",
    "}",
    "(",
    "<g>",
    "</g>",
    "<!--",
    "\"",
    "'",
    "\"\"\"",
    ": ",
    "- ",
    " = ",
    "[[motion]]\n",
    "&a ",
    "*a",
    "!!",
    "|\n",
    "#",
    ",",
    "\n",
    "\r\n",
    "\t",
    "\0",
    "\u{feff}",
    "e",
    "Z",
    "  0\nSECTION\n",
    "NaN",
];

/// One damage.
fn damage(input: &mut Vec<u8>, seeds: &[Vec<u8>], dice: &mut Dice) {
    let length = input.len();
    match dice.below(11) {
        0 => input.truncate(dice.below(length + 1)),
        1 if length > 0 => input[dice.below(length)] ^= 1 << dice.below(8),
        2 if length > 0 => input[dice.below(length)] = *dice.pick(&[0, 1, 0x7f, 0x80, 0xff]),
        3 => {
            let number = *dice.pick(&[0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_fff0, u64::MAX >> 1, u64::MAX]);
            let bytes = number.to_le_bytes();
            let width = *dice.pick(&[2, 4, 8]);
            let at = dice.below(length + 1);
            let end = length.min(at + width);
            input.splice(at..end, bytes[..width].to_vec());
        }
        4 => {
            let other = dice.pick(&NUMBERS);
            let at = dice.below(length + 1);
            let is_digit = |byte: &u8| byte.is_ascii_digit();
            let start = input[at..].iter().position(is_digit).map_or(length, |i| at + i);
            let end = input[start..].iter().position(|byte| !is_digit(byte)).map_or(length, |i| start + i);
            input.splice(start..end, other.bytes());
        }
        5 => drop(input.drain(dice.part(length))),
        6 => {
            let part = input[dice.part(length)].to_vec();
            let at = dice.below(length + 1);
            input.splice(at..at, part);
        }
        7 => {
            let (at, byte, count) = (dice.below(length + 1), dice.below(256) as u8, 1 << dice.below(14));
            input.splice(at..at, vec![byte; count]);
        }
        8 => {
            let (at, count) = (dice.below(length + 1), 1 << dice.below(13));
            let words = dice.pick(&WORDS).repeat(count);
            input.splice(at..at, words.into_bytes());
        }
        9 => {
            let other = dice.pick(seeds);
            let part = other[dice.part(other.len())].to_vec();
            let at = dice.part(length);
            input.splice(at, part);
        }
        _ => {
            let word = dice.pick(&WORDS);
            let at = dice.below(length + 1);
            input.splice(at..at, word.bytes());
        }
    }
}
