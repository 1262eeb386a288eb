//! A cell of the table: one input with one damage for one argument of one command.

use std::fmt;

use super::{
    damages::{Damage, Verdict, verdict},
    kinds::{Input, Kind},
    slots::{Good, SLOTS, Slot},
};

/// One input with one damage for one argument of one command.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    pub slot: &'static Slot,
    pub kind: Kind,
    pub damage: Damage,
    pub verdict: Verdict,
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Slot { command, argument, .. } = self.slot;
        write!(f, "{command} {argument}, {:?}, {:?} ({:?})", self.kind, self.damage, self.verdict)
    }
}

/// The whole table.
pub fn all_cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    for slot in SLOTS {
        for kind in slot.kinds {
            for damage in Damage::ALL {
                let Some(verdict) = verdict(*kind, damage) else { continue };
                let Some(verdict) = for_slot(slot, *kind, damage, verdict) else { continue };
                cells.push(Cell { slot, kind: *kind, damage, verdict });
            }
        }
    }
    cells
}

/// What a command makes of a damage; `None` if it is not tried.
fn for_slot(slot: &Slot, kind: Kind, damage: Damage, verdict: Verdict) -> Option<Verdict> {
    use Damage::{Half, Huge, LastByte, Middle};
    Some(match (slot.good, verdict) {
        (Good::Endless, verdict) if verdict != Verdict::Refused => return None,
        (Good::TooSmall, verdict) if verdict != Verdict::Refused => Verdict::TooSmall,
        // Nobody asked for what is behind the damage.
        (Good::Beginning, _) if matches!(damage, Half | LastByte | Middle | Huge) => Verdict::Fine,
        // Images are copied without a calibration, too.
        (Good::NoCamera, _) if kind == Kind::TumCamera && verdict != Verdict::Fine => Verdict::Told,
        (_, verdict) => verdict,
    })
}

impl Cell {
    /// The content of the damaged file; `None` if it is no file with a content.
    pub fn content(&self, input: &Input) -> Option<Vec<u8>> {
        let (_, bytes) = input.main();
        let text = || String::from_utf8(bytes.to_vec()).unwrap();
        Some(match self.damage {
            Damage::Good | Damage::ForeignName | Damage::OddName => bytes.to_vec(),
            Damage::Empty => Vec::new(),
            Damage::Blank => b"\n".to_vec(),
            Damage::Half => half(bytes),
            Damage::LastByte => bytes[..bytes.len() - 1].to_vec(),
            Damage::Middle => [&bytes[..bytes.len() / 3], &bytes[bytes.len() * 2 / 3..]].concat(),
            Damage::Random => {
                (0..500_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8 | 0x80).collect()
            }
            Damage::Zeros => vec![0; bytes.len()],
            Damage::AsPicture => Kind::Png.good().main().1.to_vec(),
            Damage::AsBag => Kind::Bag.good().main().1.to_vec(),
            Damage::AsProse => b"Dear diary,\n\ntoday my robot found its place.\n".to_vec(),
            Damage::AsJson => br#"{ "type": "FeatureCollection", "features": [] }"#.to_vec(),
            Damage::AsZip => [b"PK\x03\x04\x14\0\0\0\x08\0".to_vec(), vec![7; 90]].concat(),
            Damage::AsGzip => [b"\x1f\x8b\x08\0\0\0\0\0\0\x03".to_vec(), vec![9; 90]].concat(),
            Damage::HugeNumbers => with_numbers(&text(), |_, _| Some("1e300".to_owned())).into_bytes(),
            Damage::NotANumber => {
                with_numbers(&text(), |i, num| (i + 1 == num).then(|| "nan".to_owned())).into_bytes()
            }
            Damage::DeepNesting => nested(self.kind).into_bytes(),
            Damage::Twice => twice(&text()).into_bytes(),
            Damage::ForeignByte => {
                let at = bytes.iter().position(u8::is_ascii_alphabetic).unwrap_or(0) + 1;
                [&bytes[..at], &[0xe9], &bytes[at..]].concat()
            }
            Damage::Windows => format!("\u{feff}{}", text().replace('\n', "\r\n")).into_bytes(),
            Damage::Backwards => {
                text().lines().rev().map(|line| format!("{line}\n")).collect::<String>().into_bytes()
            }
            _ => return None,
        })
    }
}

/// The first half, cut within a line.
fn half(bytes: &[u8]) -> Vec<u8> {
    let at = bytes.len() / 2;
    let is_break = |byte: &u8| *byte == b'\n';
    let Some(start) = bytes[..at].iter().rposition(is_break) else { return bytes[..at].to_vec() };
    let end = bytes[at..].iter().position(is_break).map_or(bytes.len(), |end| at + end);
    bytes[..start + 1 + (end - start) / 3].to_vec()
}

/// The text with other numbers, of which `change` gets the place and how many there are.
fn with_numbers(text: &str, change: impl Fn(usize, usize) -> Option<String>) -> String {
    let parts = parts(text);
    let is_number = |part: &str| part.parse::<f64>().is_ok() && part.contains(|c: char| c.is_ascii_digit());
    let num = parts.iter().filter(|part| is_number(part)).count();
    let mut i = 0;
    let mut out = String::new();
    for part in parts {
        if is_number(part) {
            out += &change(i, num).unwrap_or_else(|| part.to_owned());
            i += 1;
        } else {
            out += part;
        }
    }
    out
}

/// Words of letters, digits, signs and dots, and what is between them.
fn parts(text: &str) -> Vec<&str> {
    let is_word =
        |c: char| c.is_alphanumeric() || matches!(c, '-' | '+' | '.' | '_' | '/' | '#' | '$' | '%' | '@');
    let mut parts = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let kind = is_word(first);
        let end = rest.find(|c: char| is_word(c) != kind).unwrap_or(rest.len());
        parts.push(&rest[..end]);
        rest = &rest[end..];
    }
    parts
}

/// The line in the middle twice.
fn twice(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let is_plain =
        |line: &&str| !line.starts_with(['#', '[', '%', ' ']) && line.contains(|c: char| c.is_ascii_digit());
    let middle = lines.iter().rposition(is_plain).unwrap_or(0);
    let again = lines.iter().enumerate().flat_map(|(i, line)| vec![*line; if i == middle { 2 } else { 1 }]);
    again.map(|line| format!("{line}\n")).collect()
}

/// Brackets in brackets, in the form of the kind.
fn nested(kind: Kind) -> String {
    const DEPTH: usize = 100_000;
    match kind {
        Kind::Svg => {
            let (open, close) = ("<g>".repeat(DEPTH), "</g>".repeat(DEPTH));
            format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\">{open}<path d=\"M0 0h1\" stroke=\"black\"/>{close}</svg>"
            )
        }
        Kind::Urdf => format!("<robot name=\"r\">{}{}</robot>", "<a>".repeat(DEPTH), "</a>".repeat(DEPTH)),
        Kind::Benchmark => format!("{{\"key\": {}", "[".repeat(DEPTH)),
        Kind::Experiment => format!("{{\"experiment\": {}", "[".repeat(DEPTH)),
        kind if kind.good().main().0.ends_with("toml") => format!("name = {}", "[".repeat(DEPTH)),
        _ => format!("cam0: {}", "[".repeat(DEPTH)),
    }
}
