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
    fn takes(&self, contender: &Contender) -> bool {
        contender.quick || !self.is_quick
    }

    fn num_seeds(&self, contender: &Contender) -> u64 {
        self.seeds.unwrap_or(if self.is_quick { 1 } else { contender.seeds })
    }

    fn frames(&self, kind: Kind) -> Option<u32> {
        self.frames.or_else(|| self.is_quick.then(|| of_kind(QUICK_FRAMES, kind)))
    }

    fn timed_frames(&self, kind: Kind) -> u32 {
        let most = of_kind(if self.is_quick { QUICK_TIMED_FRAMES } else { TIMED_FRAMES }, kind);
        self.frames.map_or(most, |frames| frames.min(most))
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
        claims: &Claims,
        recordings: &'a [Recording],
        limits: &Limits,
        program: &'a str,
    ) -> Result<Self> {
        let mut plan = Self { accuracy: Vec::new(), times: Vec::new() };
        let mut seen: Vec<&str> = Vec::new();
        for recording in recordings {
            let (kind, is_first) = (recording.kind, !seen.contains(&recording.class.as_str()));
            if limits.is_quick && !is_first {
                continue;
            }
            seen.push(&recording.class);
            let is_of = |contender: &&Contender| contender.kind == kind && limits.takes(contender);
            let contenders: Vec<&Contender> = claims.contenders.iter().filter(is_of).collect();
            let most_seeds =
                contenders.iter().map(|contender| limits.num_seeds(contender)).max().unwrap_or(0);
            for number in 0..most_seeds {
                let images = Images::new(recording, FIRST_SEED + number, program)?;
                let wanted = contenders.iter().filter(|contender| number < limits.num_seeds(contender));
                plan.accuracy.push(
                    wanted.map(|contender| images.run(contender, limits.frames(kind), false)).collect(),
                );
                if is_first && number == 0 {
                    let frames = Some(limits.timed_frames(kind));
                    plan.times.extend(contenders.iter().map(|contender| images.run(contender, frames, true)));
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

/// What runs with the same seed have in common.
struct Images<'a> {
    recording: &'a Recording,
    seed: u64,
    program: &'a str,
    /// Options that belong to the recording.
    words: Vec<String>,
}

impl<'a> Images<'a> {
    fn new(recording: &'a Recording, seed: u64, program: &'a str) -> Result<Self> {
        // Each seed makes a simulation anew, with another start.
        let words = match recording.is_simulated() && recording.kind == Kind::Map {
            true => start_words(&recording.source, None, Some(seed))?,
            false => recording.words.clone(),
        };
        Ok(Self { recording, seed, program, words })
    }

    fn run<'r>(&self, contender: &Contender, frames: Option<u32>, is_timed: bool) -> Run<'r>
    where
        'a: 'r,
    {
        let kind = self.recording.kind;
        let mut words = vec![kind.command().to_owned(), self.recording.source.clone()];
        words.extend(self.words.iter().chain(&contender.words).cloned());
        words.extend(["--seed".to_owned(), self.seed.to_string()]);
        if let Some(frames) = frames {
            words.extend([
                if kind == Kind::Map { "--frames" } else { "--end" }.to_owned(),
                frames.to_string(),
            ]);
        }
        let key = CellKey {
            program: self.program.to_owned(),
            class: self.recording.class.clone(),
            recording: self.recording.name.clone(),
            num_bytes: self.recording.num_bytes,
            contender: contender.name.clone(),
            seed: self.seed,
            words,
            is_timed,
        };
        Run { recording: self.recording, key }
    }
}
