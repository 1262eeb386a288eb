//! Gray pictures of occupancy grids: PGM and PNG.

use std::{fs, path::Path};

/// Rows of gray values, the first at the top.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GrayPicture {
    pub width: u32,
    pub height: u32,
    values: Vec<u8>,
}

/// No grid is larger, cells.
const MAX_CELLS: usize = 1 << 28;

impl GrayPicture {
    /// Reads a PGM (text or binary, 8 bit) or PNG picture. The error says what was found instead.
    pub fn read(path: &Path) -> Result<Self, String> {
        let bytes = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let picture = if bytes.starts_with(b"\x89PNG") { png(&bytes) } else { pgm(&bytes) };
        picture.map_err(|reason| format!("{}: {reason}", path.display()))
    }

    /// The value of a cell; `None` outside.
    pub fn at(&self, x: i64, y: i64) -> Option<u8> {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        let is_inside = x < self.width && y < self.height;
        is_inside.then(|| self.values[y as usize * self.width as usize + x as usize])
    }
}

fn checked(width: u32, height: u32, values: Vec<u8>) -> Result<GrayPicture, String> {
    if values.is_empty() || values.len() != width as usize * height as usize {
        return Err(format!("{width} x {height} cells, but {} values", values.len()));
    }
    Ok(GrayPicture { width, height, values })
}

fn pgm(bytes: &[u8]) -> Result<GrayPicture, String> {
    let mut at = 2;
    let mut next = || {
        loop {
            while bytes.get(at).is_some_and(u8::is_ascii_whitespace) {
                at += 1;
            }
            if bytes.get(at) != Some(&b'#') {
                break;
            }
            while bytes.get(at).is_some_and(|byte| *byte != b'\n') {
                at += 1;
            }
        }
        let from = at;
        while bytes.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        let text = std::str::from_utf8(&bytes[from.min(bytes.len())..at]).unwrap_or_default();
        (text.parse::<u32>().map_err(|_| "a broken PGM header".to_owned()), at)
    };
    if !bytes.starts_with(b"P5") && !bytes.starts_with(b"P2") {
        return Err("neither PGM nor PNG".to_owned());
    }
    let (width, height) = (next().0?, next().0?);
    let (max, end) = next();
    let max = max?;
    if max == 0 || max > 255 {
        return Err(format!("a PGM with values up to {max}, not 255"));
    }
    let count = width as usize * height as usize;
    if count > MAX_CELLS {
        return Err(format!("{width} x {height} cells"));
    }
    #[allow(clippy::cast_possible_truncation)]
    let scaled = |value: u32| (value.min(max) * 255 / max) as u8;
    let values = if bytes.starts_with(b"P5") {
        bytes.iter().skip(end + 1).take(count).map(|byte| scaled(u32::from(*byte))).collect()
    } else {
        (0..count).map(|_| next().0.map(scaled)).collect::<Result<_, _>>()?
    };
    checked(width, height, values)
}

fn png(bytes: &[u8]) -> Result<GrayPicture, String> {
    let text = |error: png::DecodingError| error.to_string();
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(text)?;
    let size = reader.output_buffer_size().filter(|size| *size <= 4 * MAX_CELLS).ok_or("a huge PNG")?;
    let mut values = vec![0; size];
    let info = reader.next_frame(&mut values).map_err(text)?;
    let samples = info.color_type.samples();
    values.truncate(info.buffer_size());
    // The mean of the color channels, as map_server takes it; opacity is left out.
    let num_colors = if samples >= 3 { 3 } else { 1 };
    #[allow(clippy::cast_possible_truncation)]
    let mean = |pixel: &[u8]| {
        let sum: usize = pixel[..num_colors].iter().map(|value| usize::from(*value)).sum();
        (sum / num_colors) as u8
    };
    checked(info.width, info.height, values.chunks_exact(samples).map(mean).collect())
}
