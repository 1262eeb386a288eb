//! What the sections hold, in the wire format of `postcard` (version 1).

use std::{
    io::{self, Cursor, Read, Seek, Write},
    sync::Arc,
};

use serde::{Deserialize, Serialize, de::DeserializeOwned};
use visloc_core::geom::{Camera, Distortion};
use visloc_slam::{
    Readout,
    map::{PictureShelf, RestoreError, Restoring, SessionCamera, StoredKeyframe, StoredLandmark},
};

use crate::{
    Damage, MapScale, OpenedMap, ScaleSource, Session, VisualMap, VmapError,
    container::{Entry, Kind, Section, Sections, assemble},
    image::{UNPACKED, budget, packed, unpacked},
};

const SESSIONS: Kind = Kind(*b"SESS");
const SCALES: Kind = Kind(*b"SCAL");
const LEVELS: Kind = Kind(*b"LEVL");
const CAMERAS: Kind = Kind(*b"CAMS");
const READOUTS: Kind = Kind(*b"READ");
const KEYFRAMES: Kind = Kind(*b"KEYF");
const LANDMARKS: Kind = Kind(*b"LAND");
const PICTURE: Kind = Kind(*b"PICT");

/// Landmarks of a section: what one damaged byte costs.
const LANDMARKS_A_SECTION: usize = 512;
/// Longest readout: no camera that makes a video takes that long for an image.
const MOST_READOUT_SECS: f64 = 1.0;

/// A camera as plain numbers.
#[derive(Debug, Serialize, Deserialize)]
struct PlainCamera {
    size_px: (u32, u32),
    focal_px: (f64, f64),
    center_px: (f64, f64),
    lens: Distortion,
}

impl PlainCamera {
    fn new(camera: &Camera) -> Self {
        let (focal_px, center_px) = (camera.focal_px(), camera.center_px());
        Self { size_px: camera.size_px(), focal_px, center_px, lens: camera.distortion() }
    }

    fn camera(&self) -> Result<Camera, String> {
        Camera::checked(self.size_px, self.focal_px, self.center_px, self.lens).map_err(|e| e.to_string())
    }
}

impl VisualMap {
    /// The file.
    pub fn to_bytes(&self, own: &SessionCamera) -> Vec<u8> {
        let mut bytes = Vec::new();
        // Writing into memory does not fail.
        let _ = self.write(own, &mut bytes);
        bytes
    }

    /// Writes the file.
    pub(crate) fn write(&self, own: &SessionCamera, file: &mut impl Write) -> io::Result<()> {
        assemble(&sections(self, own), file)
    }

    /// Reads a file, whatever the bytes are.
    ///
    /// # Errors
    /// If it is no map, of a newer version, or damaged where nothing can be spared.
    pub fn from_bytes(file: &[u8]) -> Result<OpenedMap, VmapError> {
        Self::read(Cursor::new(file), Restoring::from)
    }

    /// The same of a file that need not be in memory.
    pub(crate) fn read(
        file: impl Read + Seek,
        make: fn(Restoring) -> Restoring,
    ) -> Result<OpenedMap, VmapError> {
        read(file, make)
    }
}

/// The sections of a map.
fn sections(map: &VisualMap, own: &SessionCamera) -> Vec<Section> {
    let stored = map.map.stored(own);
    let plain =
        |camera: &SessionCamera| (PlainCamera::new(&camera.calibrated), PlainCamera::new(&camera.camera));
    let cameras: Vec<(PlainCamera, PlainCamera)> = stored.cameras.iter().map(plain).collect();
    let mut sections = vec![
        section(SESSIONS, 0, &map.sessions),
        section(SCALES, 0, &map.scales),
        section(CAMERAS, 0, &cameras),
        section(KEYFRAMES, 0, &stored.keyframes),
    ];
    // What is not said is that aligned maps are level and no other is.
    let is_aligned = |scale: &MapScale| scale.source == ScaleSource::Aligned;
    if map.levels.contains(&true) || map.scales.iter().any(is_aligned) {
        sections.push(section(LEVELS, 0, &map.levels));
    }
    // What is not said is that all cameras expose all at once.
    if stored.cameras.iter().any(|camera| !camera.readout.is_at_once()) {
        let readouts: Vec<[f64; 2]> = stored.cameras.iter().map(|camera| camera.readout.0.into()).collect();
        sections.push(section(READOUTS, 0, &readouts));
    }
    let mut landmarks = map.map.stored_landmarks();
    let of_section = || landmarks.by_ref().take(LANDMARKS_A_SECTION).collect();
    let of_sections =
        std::iter::repeat_with(of_section).take_while(|some: &Vec<StoredLandmark>| !some.is_empty());
    sections.extend((0..).zip(of_sections).map(|(number, some)| section(LANDMARKS, number, &some)));
    let others: usize = sections.iter().map(|section| section.stored.len()).sum();
    let most_bytes = budget(others / stored.keyframes.len().max(1));
    for (number, picture) in (0..).zip(&stored.pictures) {
        if let Some(bytes) = picture.as_ref().and_then(|picture| packed(picture, most_bytes)) {
            sections.push(Section::as_it_is(PICTURE, number, bytes));
        }
    }
    sections
}

fn section<T: Serialize + ?Sized>(kind: Kind, number: u32, content: &T) -> Section {
    // Numbers, lists and names have no value that cannot be written.
    let content = postcard::to_stdvec(content).unwrap_or_default();
    Section::of_numbers(kind, number, &content)
}

/// Reads a file.
fn read(file: impl Read + Seek, make: fn(Restoring) -> Restoring) -> Result<OpenedMap, VmapError> {
    let mut reader = Reader { sections: Sections::read(file)?, damages: Vec::new() };
    if let Some(reason) = reader.sections.head_damage.take() {
        reader.damages.push(Damage {
            section: "head".to_owned(),
            reason,
            loss: "nothing is lost, there is a copy",
        });
    }
    let cameras: Vec<(PlainCamera, PlainCamera)> = reader.needed(CAMERAS)?;
    // Files of cameras that expose all at once, and of earlier versions, have none.
    let readouts: Vec<[f64; 2]> = match reader.of_kind(READOUTS)[..] {
        [] => Vec::new(),
        _ => reader.spared(READOUTS, "how long images take to be exposed is not known"),
    };
    let session = |(number, (calibrated, camera)): (usize, &(PlainCamera, PlainCamera))| {
        let is_possible = |secs: &[f64; 2]| secs.iter().all(|secs| secs.abs() <= MOST_READOUT_SECS);
        let readout = readouts.get(number).copied().filter(is_possible).unwrap_or_default();
        let readout = Readout(readout.into());
        Ok(SessionCamera { calibrated: calibrated.camera()?, camera: camera.camera()?, readout })
    };
    let cameras: Result<Vec<SessionCamera>, String> = cameras.iter().enumerate().map(session).collect();
    let cameras =
        cameras.map_err(|reason| VmapError::Section { section: name(CAMERAS, None).to_owned(), reason })?;
    let keyframes: Vec<StoredKeyframe> = reader.needed(KEYFRAMES)?;
    let sessions: Vec<Session> = reader.spared(SESSIONS, "where the map comes from is not known");
    let scales: Vec<MapScale> = reader.spared(SCALES, "the scale is not known");
    // Files of earlier versions have none.
    let levels = match reader.of_kind(LEVELS)[..] {
        [] => Vec::new(),
        _ => reader.spared(LEVELS, "which way is up is not known"),
    };
    let mut restoring = make(Restoring::new(&cameras, &keyframes)?);
    reader.landmarks(&mut restoring)?;
    reader.pictures(&cameras, &keyframes, &mut restoring);
    let Reader { damages, .. } = reader;
    let map = restoring.finish();
    Ok(OpenedMap { map: VisualMap { map, scales, levels, sessions }, damages })
}

/// The name of a section, for people.
fn name(kind: Kind, number: Option<u32>) -> String {
    let name = match kind {
        SESSIONS => "sessions",
        SCALES => "scales",
        LEVELS => "levels",
        CAMERAS => "cameras",
        READOUTS => "readouts",
        KEYFRAMES => "keyframes",
        LANDMARKS => "landmarks",
        PICTURE => "picture",
        _ => "unknown",
    };
    number.map_or_else(|| name.to_owned(), |number| format!("{name} {number}"))
}

struct Reader<F> {
    sections: Sections<F>,
    damages: Vec<Damage>,
}

impl<F: Read + Seek> Reader<F> {
    fn decoded<T: DeserializeOwned>(&mut self, entry: &Entry) -> Result<T, String> {
        let content = self.sections.content(entry)?;
        match postcard::take_from_bytes(&content) {
            Ok((value, [])) => Ok(value),
            Ok(_) => Err("there is more in it than expected".to_owned()),
            Err(error) => Err(error.to_string()),
        }
    }

    fn only<T: DeserializeOwned>(&mut self, kind: Kind) -> Result<T, String> {
        let entry = self.sections.entries.iter().find(|entry| entry.kind == kind).copied();
        self.decoded(&entry.ok_or("it is missing")?)
    }

    /// A section without which there is no map.
    fn needed<T: DeserializeOwned>(&mut self, kind: Kind) -> Result<T, VmapError> {
        self.only(kind).map_err(|reason| VmapError::Section { section: name(kind, None), reason })
    }

    /// A section that can be spared.
    fn spared<T: DeserializeOwned + Default>(&mut self, kind: Kind, loss: &'static str) -> T {
        self.only(kind).unwrap_or_else(|reason| {
            self.damages.push(Damage { section: name(kind, None), reason, loss });
            T::default()
        })
    }

    fn of_kind(&self, kind: Kind) -> Vec<Entry> {
        self.sections.entries.iter().filter(|entry| entry.kind == kind).copied().collect()
    }

    /// Adds the landmarks, a section at a time.
    fn landmarks(&mut self, restoring: &mut Restoring) -> Result<(), RestoreError> {
        for entry in self.of_kind(LANDMARKS) {
            match self.decoded::<Vec<StoredLandmark>>(&entry) {
                Ok(more) => more.iter().try_for_each(|landmark| restoring.add_landmark(landmark))?,
                Err(reason) => {
                    let (section, loss) = (name(LANDMARKS, Some(entry.number)), "its landmarks are lost");
                    self.damages.push(Damage { section, reason, loss });
                }
            }
        }
        Ok(())
    }

    /// Adds the images by the numbers of their keyframes.
    fn pictures(
        &mut self,
        cameras: &[SessionCamera],
        keyframes: &[StoredKeyframe],
        restoring: &mut Restoring,
    ) {
        let shelf = Arc::new(PictureShelf::new(UNPACKED));
        for entry in self.of_kind(PICTURE) {
            let number = entry.number as usize;
            let camera = keyframes.get(number).and_then(|keyframe| cameras.get(keyframe.camera as usize));
            match (self.sections.content(&entry), camera) {
                (Ok(bytes), Some(camera)) => {
                    restoring.set_picture(number, unpacked(bytes, camera.camera.size_px(), &shelf));
                }
                (content, _) => {
                    let section = name(PICTURE, Some(entry.number));
                    let reason = content.err().unwrap_or_else(|| "it has no keyframe".to_owned());
                    self.damages.push(Damage { section, reason, loss: "nothing is searched in its image" });
                }
            }
        }
    }
}
