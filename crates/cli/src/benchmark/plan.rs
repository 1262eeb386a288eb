//! Which runs are done.

use anyhow::Result;

use super::{Claims, Kind, Recording, claims::Contender, find::start_words, store::CellKey};

/// The first seed; nothing was ever chosen with it and those that follow.
const FIRST_SEED: u64 = 101;
/// Images of each recording in a quick benchmark.
const QUICK_FRAMES: (u32, u32) = (400, 240);
/// Images of the recordings on which times are measured; also in a quick benchmark.
const TIMED_FRAMES: (u32, u32) = (600, 300);
const QUICK_TIMED_FRAMES: (u32, u32) = (200, 120);

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
    fn num_seeds(&self, contender: &Contender) -> u64 {
        self.seeds.unwrap_or(if self.is_quick { 1 } else { contender.seeds })
    }

    /// Images for accuracy and for times.
    fn frames(&self, kind: Kind) -> (Option<u32>, u32) {
        let of_kind = |(map, slam): (u32, u32)| if kind == Kind::Map { map } else { slam };
        let timed = of_kind(if self.is_quick { QUICK_TIMED_FRAMES } else { TIMED_FRAMES });
        let frames = self.frames.or(self.is_quick.then(|| of_kind(QUICK_FRAMES)));
        (frames, self.frames.map_or(timed, |frames| frames.min(timed)))
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
    pub fn new(claims: &Claims, recordings: &'a [Recording], limits: &Limits, program: &str) -> Result<Self> {
        let mut plan = Self { accuracy: Vec::new(), times: Vec::new() };
        let mut seen: Vec<&str> = Vec::new();
        for recording in recordings {
            let (kind, is_first) = (recording.kind, !seen.contains(&recording.class.as_str()));
            if limits.is_quick && !is_first {
                continue;
            }
            seen.push(&recording.class);
            let is_of =
                |contender: &&Contender| contender.kind == kind && (contender.quick || !limits.is_quick);
            let contenders: Vec<&Contender> = claims.contenders.iter().filter(is_of).collect();
            let most_seeds = contenders.iter().map(|contender| limits.num_seeds(contender)).max();
            let (frames, timed_frames) = limits.frames(kind);
            for number in 0..most_seeds.unwrap_or(0) {
                // Each seed makes a simulation anew, with another start.
                let seed = FIRST_SEED + number;
                let words = match recording.is_simulated() && kind == Kind::Map {
                    true => start_words(&recording.source, None, Some(seed))?,
                    false => recording.words.clone(),
                };
                let run = |contender: &&Contender, frames: Option<u32>| {
                    let key = key(recording, contender, seed, &words, frames);
                    Run { recording, key: CellKey { program: program.to_owned(), ..key } }
                };
                let wanted = contenders.iter().filter(|contender| number < limits.num_seeds(contender));
                plan.accuracy.push(wanted.map(|contender| run(contender, frames)).collect());
                if is_first && number == 0 {
                    let mut timed: Vec<_> =
                        contenders.iter().map(|contender| run(contender, Some(timed_frames))).collect();
                    timed.iter_mut().for_each(|run| run.key.is_timed = true);
                    plan.times.append(&mut timed);
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

/// What tells the run of a recording from others, but for the program.
fn key(
    recording: &Recording,
    contender: &Contender,
    seed: u64,
    of_recording: &[String],
    frames: Option<u32>,
) -> CellKey {
    let kind = recording.kind;
    let mut words = vec![kind.command().to_owned(), recording.source.clone()];
    words.extend(of_recording.iter().chain(&contender.words).cloned());
    words.extend(["--seed".to_owned(), seed.to_string()]);
    let option = if kind == Kind::Map { "--frames" } else { "--end" };
    words.extend(frames.map(|frames| [option.to_owned(), frames.to_string()]).into_iter().flatten());
    CellKey {
        program: String::new(),
        class: recording.class.clone(),
        recording: recording.name.clone(),
        num_bytes: recording.num_bytes,
        contender: contender.name.clone(),
        seed,
        words,
        is_timed: false,
    }
}
