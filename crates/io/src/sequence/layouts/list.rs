//! Lists of images with their times.

use std::path::Path;

use visloc_core::{SkippedInput, Timestamp, files};

use super::Contents;
use crate::{FileError, sequence::ImageFile, text::data_lines};

/// Time and file of an image, as a line of a list names them.
pub(super) type Parsed<'a> = Result<(Timestamp, &'a str), String>;

/// Reads a list into the contents. Lines that cannot be read, or whose time is not after the one before, are left out and
/// noted.
pub(super) fn read_list(
    list: &Path,
    folder: &Path,
    parse: impl Fn(&str) -> Parsed<'_>,
    contents: &mut Contents,
) -> Result<(), FileError> {
    let text = files::read_text(list).map_err(FileError::io(list))?;
    for (number, line) in data_lines(&text) {
        let last = contents.images.last().map(|image| image.at);
        let parsed = parse(line).and_then(|(at, name)| match last {
            Some(last) if last >= at => Err(format!("expected a time after {last}, found {at}")),
            _ => Ok(ImageFile { at, path: folder.join(name) }),
        });
        match parsed {
            Ok(image) => contents.images.push(image),
            Err(reason) => {
                let origin = format!("{}, line {number}", list.display());
                contents.skipped.push(SkippedInput { at: None, origin, reason });
            }
        }
    }
    Ok(())
}
