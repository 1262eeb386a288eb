//! Lists of images with their times.

use std::path::Path;

use visloc_core::{SkippedInput, Timestamp, files};

use super::Contents;
use crate::{FileError, sequence::ImageFile, text::data_lines};

/// Time and file of an image, as a line of a list names them.
pub(super) type Parsed<'a> = Result<(Timestamp, &'a str), String>;

/// Reads a list into the contents, in the order of the times, whatever that of the lines. Lines that cannot be read, or whose time an
/// earlier one has, are left out and noted.
pub(super) fn read_list(
    list: &Path,
    folder: &Path,
    parse: impl Fn(&str) -> Parsed<'_>,
    contents: &mut Contents,
) -> Result<(), FileError> {
    let text = files::read_text(list).map_err(FileError::io(list))?;
    let mut leave_out = |number: usize, reason: String| {
        let origin = format!("{}, line {number}", list.display());
        contents.skipped.push(SkippedInput { at: None, origin, reason });
    };
    let mut listed = Vec::new();
    for (number, line) in data_lines(&text) {
        match parse(line) {
            Ok((at, name)) => listed.push((number, ImageFile { at, path: folder.join(name) })),
            Err(reason) => leave_out(number, reason),
        }
    }
    let num_late = listed.windows(2).filter(|pair| pair[1].1.at < pair[0].1.at).count();
    if num_late > 0 {
        let list = list.display();
        contents.warnings.push(format!(
            "{list}: {num_late} of {} images are listed after later ones; they are taken in the order of their times",
            listed.len()
        ));
    }
    listed.sort_by_key(|(_, image)| image.at);
    for (number, image) in listed {
        match contents.images.last() {
            Some(last) if last.at == image.at => {
                leave_out(number, format!("expected one image at a time, found {} again", image.at));
            }
            _ => contents.images.push(image),
        }
    }
    Ok(())
}
