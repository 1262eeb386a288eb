//! One parser, named by `VISLOC_PARSER`, on the bytes of the fuzzer. With `VISLOC_SEEDS=FOLDER` it writes the good inputs to begin
//! with instead.
//!
//! All parsers stand in one table, which the tests of the project run over too; so they share one program here, and a new format needs
//! no new one.

#![no_main]

#[path = "../../crates/cli/tests/it/parsers/mod.rs"]
mod parsers;

use std::{
    env, fs,
    path::Path,
    process,
    sync::OnceLock,
    time::{Duration, Instant},
};

use libfuzzer_sys::fuzz_target;
use parsers::{PARSERS, Parser};

fn chosen() -> &'static Parser {
    static CHOSEN: OnceLock<&Parser> = OnceLock::new();
    CHOSEN.get_or_init(|| {
        if let Ok(folder) = env::var("VISLOC_SEEDS") {
            write_seeds(Path::new(&folder));
        }
        let name = env::var("VISLOC_PARSER").unwrap_or_default();
        PARSERS.iter().find(|parser| parser.name == name).unwrap_or_else(|| {
            let names: Vec<&str> = PARSERS.iter().map(|parser| parser.name).collect();
            eprintln!("set VISLOC_PARSER to one of: {}", names.join(", "));
            process::exit(2)
        })
    })
}

/// A folder of good inputs for each parser, and the longest input of each on standard output.
fn write_seeds(folder: &Path) {
    for parser in PARSERS {
        let folder = folder.join(parser.name);
        fs::create_dir_all(&folder).unwrap();
        for (i, seed) in (parser.seeds)().iter().enumerate() {
            fs::write(folder.join(format!("seed-{i:02}")), seed).unwrap();
        }
        println!("{} {}", parser.name, parser.max_bytes);
    }
    process::exit(0)
}

/// Most time for one input.
const MAX_TIME: Duration = Duration::from_secs(3);

/// Time on the processor.
fn processor_time() -> Duration {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    Duration::from_nanos(text.split(' ').next().unwrap().parse().unwrap())
}

/// What is made once, with the first input, is no matter of that input.
fn warm_up() {
    let parser = chosen();
    if let Some(seed) = (parser.seeds)().first() {
        (parser.read)(seed);
    }
}

fuzz_target!(init: { warm_up(); }, |bytes: &[u8]| {
    let read = chosen().read;
    let start = Instant::now();
    read(bytes);
    if start.elapsed() > MAX_TIME {
        // Perhaps other programs had the processor: once more, with a clock that stands still meanwhile.
        let start = processor_time();
        read(bytes);
        let took = processor_time() - start;
        assert!(took < MAX_TIME, "{} bytes took {took:?}", bytes.len());
    }
});
