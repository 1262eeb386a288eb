//! What can be wrong with an input, and what is to become of it.

use super::kinds::{
    Kind,
    Nature::{Lines, Messages, Picture, Sections, Table, Text},
};

/// What can be wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Damage {
    /// Nothing.
    Good,
    /// There is no such file.
    Missing,
    /// No byte.
    Empty,
    /// The second half is missing.
    Half,
    /// The last byte is missing.
    LastByte,
    /// A third in the middle is missing.
    Middle,
    /// Random bytes.
    Random,
    /// As many zeros, as after a crash of the computer.
    Zeros,
    /// Only an empty line.
    Blank,
    /// A picture.
    AsPicture,
    /// A recording.
    AsBag,
    /// A text that is no table.
    AsProse,
    /// JSON.
    AsJson,
    /// A ZIP archive.
    AsZip,
    /// Compressed with gzip.
    AsGzip,
    /// A folder in place of a file.
    Folder,
    /// A file in place of the folder.
    NoFolder,
    /// A device that never ends.
    Device,
    /// A pipe into which nobody writes.
    Pipe,
    /// A symbolic link to itself.
    LinkLoop,
    /// A file with a hole of a tebibyte.
    Huge,
    /// A name that is longer than a name may be.
    LongName,
    /// A name that is not UTF-8.
    ForeignName,
    /// A name with a line break and a quote.
    OddName,
    /// Every number is out of reach.
    HugeNumbers,
    /// The last number is not a number.
    NotANumber,
    /// Brackets in brackets, a hundred thousand times.
    DeepNesting,
    /// A line that stands there twice.
    Twice,
    /// A byte that is not UTF-8 in the middle of a word.
    ForeignByte,
    /// Lines as Windows ends them, and its mark in front.
    Windows,
    /// The lines of the file backwards, so that time goes back.
    Backwards,
}

impl Damage {
    /// All of them.
    pub const ALL: [Self; 31] = [
        Self::Good,
        Self::Missing,
        Self::Empty,
        Self::Half,
        Self::LastByte,
        Self::Middle,
        Self::Random,
        Self::Zeros,
        Self::Blank,
        Self::AsPicture,
        Self::AsBag,
        Self::AsProse,
        Self::AsJson,
        Self::AsZip,
        Self::AsGzip,
        Self::Folder,
        Self::NoFolder,
        Self::Device,
        Self::Pipe,
        Self::LinkLoop,
        Self::Huge,
        Self::LongName,
        Self::ForeignName,
        Self::OddName,
        Self::HugeNumbers,
        Self::NotANumber,
        Self::DeepNesting,
        Self::Twice,
        Self::ForeignByte,
        Self::Windows,
        Self::Backwards,
    ];
}

/// What is to become of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// An error that names it; nothing is written.
    Refused,
    /// An error that names it; what came before the damage is kept.
    Kept,
    /// It is used, and what was left out is told; or it is refused.
    Told,
    /// It is as good as any.
    Fine,
    /// It is as good as any, but too small for the command: an error that names it or the source that it is for.
    TooSmall,
}

/// What is to become of a kind with a damage; `None` if it cannot have it.
pub fn verdict(kind: Kind, damage: Damage) -> Option<Verdict> {
    use Damage as D;
    use Verdict::{Fine, Kept, Refused, Told};
    let nature = kind.nature();
    let is_text = matches!(nature, Text | Table | Lines);
    let is_json = matches!(kind, Kind::Experiment | Kind::Benchmark);
    let is_part = kind.good().is_part();
    if is_optional(kind)
        && !matches!(damage, D::Good | D::Windows | D::LastByte | D::ForeignName | D::OddName)
    {
        // The images can be used without it.
        return matches!(
            damage,
            D::Random | D::AsBag | D::HugeNumbers | D::NotANumber | D::Device | D::Pipe | D::Huge
        )
        .then_some(Told);
    }
    Some(match damage {
        D::Good => Fine,
        D::OddName => Fine,
        D::ForeignName | D::LongName | D::NoFolder if is_part => return whole_folder(damage),
        // Where it is told as text it cannot be named.
        D::ForeignName => Fine,
        // In a folder something else may be found in its place.
        D::Missing if matches!(kind, Kind::Tum | Kind::Euroc | Kind::BagMetadata) => Fine,
        D::Missing if is_part && kind != Kind::Images => Told,
        // The recording is followed by what does not belong to it.
        D::Huge if nature == Messages => Told,
        D::Missing | D::LongName | D::Folder | D::Device | D::Pipe | D::LinkLoop | D::Huge => Refused,
        D::NoFolder => return None,
        // A table that says nothing changes nothing.
        D::Empty | D::Blank if nature == Table => Fine,
        D::Empty | D::Blank | D::Random | D::Zeros => Refused,
        D::AsPicture if nature == Picture => return None,
        // A recording is known by its content, not by its name.
        D::AsBag if nature == Messages && kind != Kind::Video => return None,
        D::AsPicture | D::AsBag | D::AsProse | D::AsZip | D::AsGzip | D::AsJson => Refused,
        D::Half | D::Middle if nature == Messages => Kept,
        D::LastByte if nature == Messages => Told,
        D::Half | D::Middle if nature == Sections => Told,
        D::Half if nature == Lines => Told,
        // What JPEG decoders make of missing bytes in the middle cannot be told from a picture.
        D::Middle if kind == Kind::Jpeg => return None,
        // What is left of a list or a table may be a whole one.
        D::Middle if matches!(kind, Kind::Tum | Kind::Kitti) => Told,
        D::Middle if matches!(kind, Kind::Euroc | Kind::PosesTable | Kind::CameraRos) => return None,
        D::Half | D::Middle if nature == Table => return None,
        D::Half | D::Middle => Refused,
        // The line break, or a checksum behind the last pixel.
        D::LastByte if kind == Kind::Jpeg || kind == Kind::GridPicture || is_json => Refused,
        D::LastByte if kind == Kind::Svg || nature == Picture => return None,
        D::LastByte => Fine,
        D::HugeNumbers | D::NotANumber if !is_text || is_json => return None,
        D::HugeNumbers if kind == Kind::BagMetadata => return None,
        // It is in a matrix that does not matter for one camera.
        D::NotANumber if kind == Kind::CameraRos => Fine,
        D::NotANumber if matches!(kind, Kind::BagMetadata | Kind::Topics) => return None,
        D::HugeNumbers if kind == Kind::Topics => return None,
        D::HugeNumbers | D::NotANumber if nature == Lines => Told,
        D::HugeNumbers | D::NotANumber => Refused,
        D::DeepNesting if nature == Lines || !is_text => return None,
        D::DeepNesting => Refused,
        D::Twice if nature == Table => Refused,
        D::Twice if nature == Lines => Told,
        D::Twice => return twice(kind),
        D::ForeignByte if !is_text || kind == Kind::Dxf => return None,
        D::ForeignByte => Refused,
        D::Windows if is_text => Fine,
        D::Backwards if nature == Lines => Told,
        D::Backwards if kind == Kind::PosesTum || kind == Kind::Kitti => Told,
        D::Windows | D::Backwards => return None,
    })
}

/// A truth beside images that do not need it.
fn is_optional(kind: Kind) -> bool {
    kind == Kind::TumTruth
}

fn whole_folder(damage: Damage) -> Option<Verdict> {
    (damage == Damage::NoFolder).then_some(Verdict::Refused)
}

/// Text in which no line may stand twice.
fn twice(kind: Kind) -> Option<Verdict> {
    use Kind::{CameraKalibr, CameraToml, MapField, MapOffice, PosesTum};
    matches!(kind, CameraToml | CameraKalibr | MapField | MapOffice | PosesTum).then_some(Verdict::Told)
}
