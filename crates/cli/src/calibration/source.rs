//! Where the pictures come from. Everything that calibrates asks here.

use std::path::{Path, PathBuf};

use anyhow::{Context, Error, Result, anyhow, bail};
use visloc_core::{GrayImage, Timestamp};
use visloc_io::{
    image_codec::read_gray_image,
    sequence::is_image,
    sources::{OpenPictures, SourceAddress, SourceOptions, TopicOptions, open_pictures},
};

use crate::{
    args::PictureSourceArgs,
    host::host,
    report::SkippedReport,
    run::{Progress, picture_options, prepare, refuse_source_options},
    say,
};

/// Pictures of a video or camera are taken this far apart, seconds: neighbors show the same.
const APART_SECS: f64 = 0.5;
/// Most pictures that are taken from a video or camera.
const MAX_PICTURES: usize = 120;

/// Which pictures of a video or camera are taken.
#[derive(Debug, Clone, Copy)]
pub struct Taking {
    /// So far apart, seconds.
    pub apart_secs: f64,
    /// At most so many.
    pub most: usize,
    /// What to do before a camera, for people.
    pub advice: &'static str,
}

/// Of a board.
pub const OF_BOARD: Taking =
    Taking { apart_secs: APART_SECS, most: MAX_PICTURES, advice: "show the board from all sides" };

/// A picture that can be read.
#[derive(Debug, Clone)]
pub struct NamedImage {
    /// For people.
    pub name: String,
    /// When it was taken, if that is known.
    pub at: Option<Timestamp>,
    pixels: Pixels,
}

#[derive(Debug, Clone)]
enum Pixels {
    /// Read when needed.
    File(PathBuf),
    /// Of a source that cannot go back.
    Kept(GrayImage),
}

impl NamedImage {
    /// Where it comes from, for errors.
    pub fn origin(&self) -> String {
        match &self.pixels {
            Pixels::File(path) => path.display().to_string(),
            Pixels::Kept(_) => self.name.clone(),
        }
    }

    /// Whether it is still to be read.
    pub fn is_file(&self) -> bool {
        matches!(self.pixels, Pixels::File(_))
    }

    /// Reads it.
    pub fn read(&self) -> Result<GrayImage> {
        match &self.pixels {
            Pixels::File(path) => Ok(read_gray_image(path)?),
            Pixels::Kept(image) => Ok(image.clone()),
        }
    }
}

/// Pictures of one source.
#[derive(Debug, Default)]
pub struct NamedImages {
    /// Those that were taken.
    pub images: Vec<NamedImage>,
    /// Why there are not more of them, if the source is damaged behind them.
    pub damage: Option<Error>,
}

impl NamedImages {
    /// What was asked for has been done with the pictures that there are, or has failed.
    ///
    /// # Errors
    /// Why it has failed, with the damage as a note, or the damage.
    pub fn end(self, done: Result<()>) -> Result<()> {
        match (done, self.damage) {
            (Err(error), Some(damage)) => {
                say::note!("{damage}");
                Err(error)
            }
            (done, damage) => done.and(damage.map_or(Ok(()), Err)),
        }
    }
}

/// The pictures of a folder by name, a single one, or some of those of any other source.
///
/// # Errors
/// If there are none, or an option is of no use for this source.
pub fn open_images(source: &str, args: &PictureSourceArgs, taking: Taking) -> Result<NamedImages> {
    let topics = TopicOptions { image: args.image_topic.clone(), ..TopicOptions::default() };
    let options = picture_options(&args.pictures, topics)?;
    let path = Path::new(source);
    if path.is_file() && is_image(path) {
        refuse_source_options(&options, &format!("{source} is an image, which is read as it is"))?;
        return Ok(NamedImages { images: vec![named(path.to_path_buf())], damage: None });
    }
    let is_folder = path.is_dir() && !path.join("metadata.yaml").exists();
    let images = if is_folder { in_folder(path)? } else { Vec::new() };
    if !images.is_empty() {
        refuse_source_options(
            &options,
            &format!("{source} is a folder of images, which are read as they are"),
        )?;
        return Ok(NamedImages { images, damage: None });
    }
    // A folder without images of its own may be a dataset.
    let found = in_stream(source, &options, taking);
    let found = if is_folder {
        found.with_context(|| format!("{source}: expected PNG or JPEG images, found none"))?
    } else {
        found?
    };
    if found.images.is_empty() {
        found.end(Ok(()))?;
        bail!("{source}: expected pictures, found none");
    }
    Ok(found)
}

fn in_folder(folder: &Path) -> Result<Vec<NamedImage>> {
    let entries = std::fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut images: Vec<NamedImage> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| is_image(path))
        .map(named)
        .collect();
    images.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(images)
}

fn named(path: PathBuf) -> NamedImage {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    NamedImage { name, at: None, pixels: Pixels::File(path) }
}

fn in_stream(source: &str, options: &SourceOptions, taking: Taking) -> Result<NamedImages> {
    if !source.contains(':') && !Path::new(source).exists() {
        bail!("{source}: expected a folder of images or a source of `visloc sources`, found nothing there");
    }
    let is_live = SourceAddress::parse(source)?.kind().is_live;
    prepare(source)?;
    if is_live {
        say::line!("{}; {} pictures are taken, Ctrl-C ends earlier", taking.advice, taking.most);
    }
    let OpenPictures { mut pictures, warnings, .. } = open_pictures(source, options, host())?;
    warnings.iter().for_each(|warning| say::note!("{warning}"));
    let progress = Progress::new(pictures.status().num_items);
    let (mut images, mut damage) = (Vec::new(), None);
    let mut last: Option<Timestamp> = None;
    while images.len() < taking.most {
        let picture = match pictures.next_item() {
            Some(Ok(picture)) => picture,
            Some(Err(broken)) => {
                damage = Some(anyhow!("{broken}{}", say::before(images.len(), "picture", "used")));
                break;
            }
            None => break,
        };
        progress.advance();
        if last.is_some_and(|last| picture.at.secs_since(last) < taking.apart_secs) {
            continue;
        }
        last = Some(picture.at);
        let name = format!("{:.3} s", picture.at.secs());
        let at = Some(picture.at);
        images.push(NamedImage { name, at, pixels: Pixels::Kept(GrayImage::from_rgb(&picture.image)) });
    }
    progress.clear();
    SkippedReport::new(pictures.status().skipped).lines().iter().for_each(|line| say::note!("{line}"));
    Ok(NamedImages { images, damage })
}
