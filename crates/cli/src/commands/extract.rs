//! `visloc extract`: the images of a source as files.

use std::{
    fmt::Write as _,
    io::Write as _,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, anyhow, bail};
use visloc_core::{Picture, Source, Timestamp, files};
use visloc_io::{
    camera_file::{CameraFormat, write_camera},
    image_codec::{encode_jpeg, encode_png},
    sequence::{Calibration, fit_calibration, read_calibration},
    sources::{OpenPictures, SourceOptions, open_pictures},
};

use crate::{
    args::{ExtractArgs, ExtractFormat},
    host::host,
    report::SkippedReport,
    run::{Progress, expect_new_folder, prepare, source_options},
    say,
    settings::topic_options,
};

/// JPEG as `visloc record` writes it.
const JPEG_QUALITY: u8 = 90;

/// Runs the command.
pub fn execute(args: &ExtractArgs) -> Result<()> {
    let stride = args.every as usize;
    let mut options = SourceOptions {
        seed: args.seed.given,
        num_threads: args.threads.given(),
        range: args.range.range(),
        ..source_options(&args.options, topic_options(&args.topics)?)?
    };
    options.usual.max_frames = args.frames.map(|frames| (frames as usize).saturating_mul(stride));
    prepare(&args.source)?;
    let OpenPictures { mut pictures, calibration, warnings } = open_pictures(&args.source, &options, host())?;
    warnings.iter().for_each(|warning| say::note!("{warning}"));
    let calibration = match &options.camera {
        Some(path) => Some((read_calibration(path)?, path.clone())),
        None => calibration,
    };
    let mut folder = Folder::create(&args.out, args.format)?;
    let progress = Progress::new(pictures.status().num_items);
    let (mut num_seen, mut error): (usize, Option<anyhow::Error>) = (0, None);
    while args.frames.is_none_or(|most| folder.num_images < most as usize) {
        let picture = match pictures.next_item() {
            Some(Ok(picture)) => picture,
            Some(Err(broken)) => {
                error = Some(broken.into());
                break;
            }
            None => break,
        };
        if num_seen % stride == 0 {
            if folder.num_images == 0 {
                folder.add_camera(&picture, calibration.as_ref())?;
            }
            // On a full disk what was written stays, with its list.
            if let Err(full) = folder.add(&picture) {
                error = Some(full);
                break;
            }
        }
        num_seen += 1;
        progress.advance();
    }
    progress.clear();
    let num_images = folder.num_images;
    let error = error.or(folder.finish().err());
    if num_images > 0 {
        say::line!("{}: {}", args.out.display(), say::count(num_images, "image"));
    }
    SkippedReport::new(pictures.status().skipped).lines().iter().for_each(|line| say::line!("{line}"));
    match error {
        Some(error) if num_images == 0 => Err(error),
        Some(error) => Err(anyhow!("{error:#}{}", say::before(num_images, "image", "written"))),
        None if num_images == 0 => bail!("{}: no image came", args.source),
        None => Ok(()),
    }
}

/// The folder that is being filled.
struct Folder {
    path: PathBuf,
    format: ExtractFormat,
    /// Made with the first image: of a source that gives none no folder is left.
    list: Option<files::NewFile>,
    num_images: usize,
    last_at: Option<Timestamp>,
}

impl Folder {
    fn create(path: &Path, format: ExtractFormat) -> Result<Self> {
        expect_new_folder(path)?;
        Ok(Self { path: path.into(), format, list: None, num_images: 0, last_at: None })
    }

    /// Appends a line to the list of images.
    fn list(&mut self, line: &str) -> std::io::Result<()> {
        let list = match &mut self.list {
            Some(list) => list,
            empty => {
                let mut list = files::NewFile::create(&self.path.join("rgb.txt"))?;
                writeln!(list, "# seconds file")?;
                empty.insert(list)
            }
        };
        writeln!(list, "{line}")
    }

    /// Writes the calibration, if there is one.
    fn add_camera(&self, picture: &Picture, calibration: Option<&(Calibration, PathBuf)>) -> Result<()> {
        let Some((calibration, from)) = calibration else {
            say::note!("the calibration is not known, so there is no camera.yaml; --camera FILE gives one");
            return Ok(());
        };
        let size_px = (picture.image.width(), picture.image.height());
        let mut warnings = Vec::new();
        let camera = fit_calibration(calibration, size_px, from, &mut warnings)?;
        warnings.iter().for_each(|warning| say::note!("{warning}"));
        let mut head = String::from("Calibration of the images beside it, by visloc extract.");
        let _ = write!(head, " From: {}", from.display());
        let text = write_camera(&camera, CameraFormat::Ros, &head).map_err(|reason| anyhow!(reason))?;
        let path = self.path.join("camera.yaml");
        files::replace(&path, text).with_context(|| path.display().to_string())
    }

    /// Writes an image and its line in the list.
    fn add(&mut self, picture: &Picture) -> Result<()> {
        if self.last_at.is_some_and(|last| last >= picture.at) {
            return Ok(());
        }
        self.last_at = Some(picture.at);
        let encoded;
        let (bytes, ending) = match (self.format, picture.file.as_deref()) {
            (ExtractFormat::Original, Some(bytes)) => {
                (bytes, if bytes.starts_with(b"\x89PNG") { "png" } else { "jpg" })
            }
            (ExtractFormat::Original | ExtractFormat::Png, _) => {
                encoded = encode_png(&picture.image)?;
                (&encoded[..], "png")
            }
            (ExtractFormat::Jpeg, _) => {
                encoded = encode_jpeg(&picture.image, JPEG_QUALITY)?;
                (&encoded[..], "jpg")
            }
        };
        let name = format!("rgb/{}.{ending}", picture.at);
        let path = self.path.join(&name);
        files::replace(&path, bytes).with_context(|| path.display().to_string())?;
        self.list(&format!("{} {name}", picture.at)).with_context(|| self.path.display().to_string())?;
        self.num_images += 1;
        Ok(())
    }

    /// Completes the list.
    fn finish(self) -> Result<()> {
        let finished = self.list.map_or(Ok(()), files::NewFile::finish);
        finished.with_context(|| self.path.join("rgb.txt").display().to_string())
    }
}
