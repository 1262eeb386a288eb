//! Which runs are done.

use anyhow::Result;

use super::{Claims, Kind, Recording, claims::Contender, find::start_words, store::CellKey};

/// The first seed; nothing was ever chosen with it and those that follow.
const FIRST_SEED: u64 = 101;
/// Images of each recording in a quick benchmark.
const QUICK_FRAMES: (u32, u32) = (400, 240);
/// Images of the recordings on which times are measured.
const TIMED_FRAMES: (u32, u32) = (600, 300);

/// How much is done.
#[derive(Debug, Clone, Copy, Default)]
pub struct Limits {
    /// Excerpts of one recording of each class, with one seed and the first settings.
    pub is_quick: bool,
    /// Seeds, in place of those of the settings.
    pub seeds: Option<u64>,
    /// Images of each recording at most.
    pub frames: Option<u32>,
}

impl Limits {
    fn frames(&self, kind: Kind) -> Option<u32> {
        self.frames.or_else(|| self.is_quick.then(|| of_kind(QUICK_FRAMES, kind)))
    }
}

fn of_kind((map, slam): (u32, u32), kind: Kind) -> u32 {
    match kind {
        Kind::Map => map,
        Kind::Slam => slam,
    }
}

/// One run: settings on a recording with a seed; the key says which.
#[derive(Debug, Clone)]
pub struct Run<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// What tells it from others.
    pub key: CellKey,
}

/// All runs.
#[derive(Debug)]
pub struct Plan<'a> {
    /// For accuracy: runs on the same images stand together.
    pub accuracy: Vec<Vec<Run<'a>>>,
    /// For times and memory.
    pub times: Vec<Run<'a>>,
}

impl<'a> Plan<'a> {
    /// The runs on some recordings. `program` says which program does them.
    ///
    /// # Errors
    /// If a scenario of the simulator cannot be used.
    pub fn new(
        claims: &'a Claims,
        recordings: &'a [Recording],
        limits: &Limits,
        program: &str,
    ) -> Result<Self> {
        let mut plan = Self { accuracy: Vec::new(), times: Vec::new() };
        let mut seen = Vec::new();
        for recording in recordings {
            let is_first = !seen.contains(&&recording.class);
            if limits.is_quick && !is_first {
                continue;
            }
            seen.push(&recording.class);
            let contenders = claims.contenders.iter().filter(|contender| contender.kind == recording.kind);
            let contenders: Vec<_> =
                contenders.filter(|contender| contender.quick || !limits.is_quick).collect();
            let num_seeds = |contender: &Contender| match limits.seeds {
                Some(seeds) => seeds,
                None => {
                    if limits.is_quick {
                        1
                    } else {
                        contender.seeds
                    }
                }
            };
            let most_seeds = contenders.iter().map(|contender| num_seeds(contender)).max().unwrap_or(0);
            for number in 0..most_seeds {
                let seed = FIRST_SEED + number;
                let words = words(recording, seed)?;
                let run = |contender: &&'a Contender, frames, is_timed| {
                    let contender = *contender;
                    let words = [
                        vec![recording.kind.command().to_owned(), recording.source.clone()],
                        words.clone(),
                        contender.words.clone(),
                        vec!["--seed".to_owned(), seed.to_string()],
                        frame_words(recording.kind, frames),
                    ];
                    let key = CellKey {
                        program: program.to_owned(),
                        class: recording.class.clone(),
                        recording: recording.name.clone(),
                        num_bytes: recording.num_bytes,
                        contender: contender.name.clone(),
                        seed,
                        words: words.concat(),
                        is_timed,
                    };
                    Run { recording, key }
                };
                let frames = limits.frames(recording.kind);
                let wanted = contenders.iter().filter(|contender| number < num_seeds(contender));
                plan.accuracy.push(wanted.map(|contender| run(contender, frames, false)).collect());
                if is_first && number == 0 {
                    let most = of_kind(TIMED_FRAMES, recording.kind);
                    let frames = Some(frames.map_or(most, |frames| frames.min(most)));
                    plan.times.extend(contenders.iter().map(|contender| run(contender, frames, true)));
                }
            }
        }
        Ok(plan)
    }

    /// The runs for accuracy, one by one.
    pub fn runs(&self) -> impl Iterator<Item = &Run<'a>> {
        self.accuracy.iter().flatten()
    }
}

/// Options that belong to a recording; each seed makes a simulation anew.
fn words(recording: &Recording, seed: u64) -> Result<Vec<String>> {
    if recording.is_simulated() && recording.kind == Kind::Map {
        return start_words(&recording.source, None, Some(seed));
    }
    Ok(recording.words.clone())
}

fn frame_words(kind: Kind, frames: Option<u32>) -> Vec<String> {
    let option = match kind {
        Kind::Map => "--frames",
        Kind::Slam => "--end",
    };
    frames.map(|frames| vec![option.to_owned(), frames.to_string()]).unwrap_or_default()
}
