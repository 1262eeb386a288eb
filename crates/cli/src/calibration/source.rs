//! Where the pictures come from. Everything that calibrates asks here.

use std::path::{Path, PathBuf};

use anyhow::{Context, Error, Result, anyhow, bail};
use visloc_core::{GrayImage, Timestamp};
use visloc_io::{
    image_codec::read_gray_image,
    sequence::{image_files, is_image},
    sources::{OpenPictures, SourceAddress, SourceOptions, TopicOptions, open_pictures},
};

use crate::{
    args::PictureSourceArgs,
    host::host,
    report::SkippedReport,
    run::{Progress, picture_options, prepare, refuse_source_options},
    say,
};

/// Pictures of a video or camera are taken this far apart or farther, seconds: neighbors show the same.
const APART_SECS: f64 = 0.5;
/// Most pictures that are taken from a video or camera.
const MAX_PICTURES: usize = 120;

/// Which pictures of a video or camera are taken.
#[derive(Debug, Clone, Copy)]
pub struct Taking {
    /// So far apart, seconds.
    pub apart_secs: f64,
    /// At most so many are used.
    pub most: usize,
    /// Whether those of a recording are spread over all of it, or are its first ones.
    pub is_spread: bool,
    /// What to do before a camera, for people.
    pub advice: &'static str,
}

/// Of a board.
pub const OF_BOARD: Taking = Taking {
    apart_secs: APART_SECS,
    most: MAX_PICTURES,
    is_spread: true,
    advice: "show the board from all sides",
};

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
        self.clone().into_pixels()
    }

    /// Reads it, and lets go of what was kept.
    pub fn into_pixels(self) -> Result<GrayImage> {
        match self.pixels {
            Pixels::File(path) => Ok(read_gray_image(&path)?),
            Pixels::Kept(image) => Ok(image),
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

/// What was asked for has been done with the pictures that there are, or has failed.
///
/// # Errors
/// Why it has failed, with the damage of the source as a note, or the damage.
pub fn end(done: Result<()>, damage: Option<Error>) -> Result<()> {
    match (done, damage) {
        (Err(error), Some(damage)) => {
            say::note!("{damage}");
            Err(error)
        }
        (done, damage) => done.and(damage.map_or(Ok(()), Err)),
    }
}

/// The pictures of a folder by name, a single one, or some of those of any other source.
///
/// # Errors
/// If there are none, or an option is of no use for this source.
pub fn open_images(source: &str, args: &PictureSourceArgs, taking: Taking) -> Result<NamedImages> {
    let mut images: Vec<NamedImage> = Vec::new();
    let (mut num_seen, mut step) = (0, 1);
    let damage = each_image(source, args, taking, &mut |image| {
        let is_kept = !image.is_file();
        if num_seen % step == 0 {
            images.push(image);
        }
        num_seen += 1;
        // Half of them, twice as far apart, show as much of a long recording.
        if is_kept && images.len() > taking.most {
            step *= 2;
            images = std::mem::take(&mut images).into_iter().step_by(2).collect();
        }
        Ok(())
    })?;
    Ok(NamedImages { images, damage })
}

/// Takes the pictures of [`open_images`] one after the other, and says why there are not more of them, if the source is damaged behind
/// them.
///
/// # Errors
/// As [`open_images`], or if one cannot be taken.
pub fn each_image(
    source: &str,
    args: &PictureSourceArgs,
    taking: Taking,
    take: &mut dyn FnMut(NamedImage) -> Result<()>,
) -> Result<Option<Error>> {
    let topics = TopicOptions { image: args.image_topic.clone(), ..TopicOptions::default() };
    let options = picture_options(&args.pictures, topics)?;
    let path = Path::new(source);
    if path.is_file() && is_image(path) {
        refuse_source_options(&options, &format!("{source} is an image, which is read as it is"))?;
        return take(named(path.to_path_buf())).map(|()| None);
    }
    let is_folder = path.is_dir() && !path.join("metadata.yaml").exists();
    let images = if is_folder { image_files(path)? } else { Vec::new() };
    if !images.is_empty() {
        refuse_source_options(
            &options,
            &format!("{source} is a folder of images, which are read as they are"),
        )?;
        return images.into_iter().map(named).try_for_each(take).map(|()| None);
    }
    // A folder without images of its own may be a dataset.
    let mut num_taken = 0;
    let found = each_in_stream(source, &options, taking, &mut |image| {
        num_taken += 1;
        take(image)
    });
    let damage = if is_folder {
        found.with_context(|| format!("{source}: expected PNG or JPEG images, found none"))?
    } else {
        found?
    };
    match damage {
        None if num_taken == 0 => bail!("{source}: expected pictures, found none"),
        Some(damage) if num_taken == 0 => Err(damage),
        damage => Ok(damage),
    }
}

fn named(path: PathBuf) -> NamedImage {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    NamedImage { name, at: None, pixels: Pixels::File(path) }
}

/// Takes images of a stream one after the other; see [`each_image`].
///
/// # Errors
/// If there is no such source, it has no use for an option, or an image cannot be taken.
pub fn each_in_stream(
    source: &str,
    options: &SourceOptions,
    taking: Taking,
    take: &mut dyn FnMut(NamedImage) -> Result<()>,
) -> Result<Option<Error>> {
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
    let (mut num_taken, mut damage) = (0, None);
    let mut last: Option<Timestamp> = None;
    let most = if taking.is_spread && !is_live { usize::MAX } else { taking.most };
    while num_taken < most {
        let picture = match pictures.next_item() {
            Some(Ok(picture)) => picture,
            Some(Err(broken)) => {
                damage = Some(anyhow!("{broken}{}", say::before(num_taken, "picture", "used")));
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
        let pixels = Pixels::Kept(GrayImage::from_rgb(&picture.image));
        take(NamedImage { name, at: Some(picture.at), pixels })?;
        num_taken += 1;
    }
    progress.clear();
    SkippedReport::new(pictures.status().skipped).lines().iter().for_each(|line| say::note!("{line}"));
    Ok(damage)
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use visloc_core::RgbImage;
    use visloc_io::image_codec::save_png;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: PictureSourceArgs,
    }

    #[test]
    fn pictures_of_a_long_recording_are_spread_over_all_of_it() {
        let folder = tempfile::tempdir().unwrap();
        save_png(&RgbImage::new(32, 32), &folder.path().join("image.png")).unwrap();
        std::fs::create_dir(folder.path().join("rgb")).unwrap();
        let list: String = (0..301).map(|second| format!("{second}.0 image.png\n")).collect();
        std::fs::write(folder.path().join("rgb/rgb.txt"), list.replace("image", "../image")).unwrap();
        let source = folder.path().join("rgb").display().to_string();
        let secs = |taking: Taking| -> Vec<u32> {
            let args = Line::parse_from(["test"]).args;
            let images = open_images(&source, &args, taking).unwrap().images;
            images.iter().map(|image| image.at.unwrap().secs().round() as u32).collect()
        };
        let spread = secs(OF_BOARD);
        assert_eq!((spread.len(), spread[1] - spread[0], spread.last().copied()), (76, 4, Some(300)));
        let first = secs(Taking { is_spread: false, ..OF_BOARD });
        assert_eq!((first.len(), first.last().copied()), (OF_BOARD.most, Some(119)));
    }
}
