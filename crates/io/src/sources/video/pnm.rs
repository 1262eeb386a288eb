//! Images in a pipe: PGM (gray) and PPM (color), 8 bits.

use std::io::{self, BufRead, ErrorKind, Read};

use visloc_core::{GrayImage, RgbImage, geom::MAX_IMAGE_SIDE_PX};

/// Longest header; longer ones are none.
const MAX_HEADER_BYTES: u64 = 64;

/// What is wanted of every pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pixels {
    /// Brightness.
    Gray,
    /// Red, green and blue.
    Color,
}

/// An image from a pipe.
#[derive(Debug, Clone, PartialEq)]
pub enum PnmImage {
    /// From PGM.
    Gray(GrayImage),
    /// From PPM.
    Color(RgbImage),
}

/// Reads the next image; `None` at the end.
///
/// # Errors
/// If it is no such image. The end within an image is an error of kind `UnexpectedEof`.
pub fn read_pnm(input: &mut impl BufRead) -> io::Result<Option<PnmImage>> {
    if input.fill_buf()?.is_empty() {
        return Ok(None);
    }
    let magic = token(input)?;
    let (pixels, num_channels) = match magic.as_str() {
        "P5" => (Pixels::Gray, 1),
        "P6" => (Pixels::Color, 3),
        _ => return Err(wrong(format!("expected an image as PGM or PPM, found '{magic}'"))),
    };
    let (width, height, most) = (number(input)?, number(input)?, number(input)?);
    let sides = 1..=MAX_IMAGE_SIDE_PX as usize;
    if !sides.contains(&width) || !sides.contains(&height) || most != 255 {
        return Err(wrong(format!(
            "expected an image of 1 to {MAX_IMAGE_SIDE_PX} px a side and 255 levels, found {width} x {height} px and {most}"
        )));
    }
    let mut data = vec![0; width * height * num_channels];
    input.read_exact(&mut data)?;
    let image = match pixels {
        Pixels::Gray => GrayImage::from_raw(width, height, data).map(PnmImage::Gray),
        Pixels::Color => RgbImage::from_raw(width as u32, height as u32, data).map(PnmImage::Color),
    };
    image.map(Some).map_err(|error| wrong(error.to_string()))
}

fn wrong(reason: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, reason)
}

/// A word and the one white space behind it.
fn token(input: &mut impl BufRead) -> io::Result<String> {
    let mut word = Vec::new();
    let mut bytes = input.take(MAX_HEADER_BYTES).bytes();
    loop {
        match bytes.next().transpose()? {
            Some(byte) if byte.is_ascii_whitespace() => break,
            Some(byte) => word.push(byte),
            None if word.len() as u64 == MAX_HEADER_BYTES => break,
            None => return Err(ErrorKind::UnexpectedEof.into()),
        }
    }
    Ok(String::from_utf8_lossy(&word).into_owned())
}

fn number(input: &mut impl BufRead) -> io::Result<usize> {
    let word = token(input)?;
    word.parse().map_err(|_| wrong(format!("expected a number in the header of an image, found '{word}'")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_one_after_the_other_until_the_end() {
        let bytes = b"P5\n2 1\n255\n\x0a\x20P6\n1 1\n255\n\x01\x02\x03";
        let mut input = &bytes[..];
        let gray = read_pnm(&mut input).unwrap();
        assert_eq!(gray, Some(PnmImage::Gray(GrayImage::from_raw(2, 1, vec![10, 32]).unwrap())));
        let color = read_pnm(&mut input).unwrap();
        assert_eq!(color, Some(PnmImage::Color(RgbImage::from_raw(1, 1, vec![1, 2, 3]).unwrap())));
        assert_eq!(read_pnm(&mut input).unwrap(), None);
    }

    #[test]
    fn cut_and_foreign_bytes_are_told_apart() {
        let whole = b"P5\n2 1\n255\n\x0a\x20";
        for length in 1..whole.len() {
            let error = read_pnm(&mut &whole[..length]).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::UnexpectedEof, "{length}");
        }
        for bytes in
            [&b"RIFF    "[..], b"P5\n0 1\n255\n", b"P5\n99999 1\n255\n", b"P5\nx 1\n255\n", &[b'P'; 80]]
        {
            assert_eq!(read_pnm(&mut &bytes[..]).unwrap_err().kind(), ErrorKind::InvalidData);
        }
    }
}
