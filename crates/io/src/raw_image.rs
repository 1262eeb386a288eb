//! Rows of pixels as cameras deliver them: [`decode`].
//!
//! Encodings are those of `sensor_msgs/image_encodings.hpp` of ROS. YUV is that of BT.601 with limited range, as OpenCV and
//! `cv_bridge` take it.

use visloc_core::{RgbImage, geom::MAX_IMAGE_SIDE_PX};

/// Pixels as they come from a camera or a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawImage {
    /// Width and height, pixels.
    pub size_px: (u32, u32),
    /// Order and kind of the values, such as `rgb8` or `bayer_rggb8`.
    pub encoding: String,
    /// Bytes from the start of a row to the start of the next.
    pub step: u32,
    /// Whether values of 16 bits have their high byte first.
    pub is_big_endian: bool,
    /// All rows.
    pub data: Vec<u8>,
}

/// How values make pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layout {
    /// So many values a pixel; where red, green and blue stand.
    Channels(usize, [usize; 3]),
    /// One value a pixel behind a filter; column and row of the first red one.
    Bayer(usize, usize),
    /// Two pixels share their color in four bytes; where the first brightness, U and V stand.
    Yuv422([usize; 3]),
    /// All brightness, then colors of four pixels each; where U and V stand.
    Yuv420([usize; 2]),
}

/// The encodings that are read: name, layout, bytes of a value.
const ENCODINGS: [(&str, Layout, usize); 27] = [
    ("rgb8", Layout::Channels(3, [0, 1, 2]), 1),
    ("bgr8", Layout::Channels(3, [2, 1, 0]), 1),
    ("rgba8", Layout::Channels(4, [0, 1, 2]), 1),
    ("bgra8", Layout::Channels(4, [2, 1, 0]), 1),
    ("mono8", Layout::Channels(1, [0, 0, 0]), 1),
    ("8UC1", Layout::Channels(1, [0, 0, 0]), 1),
    // Without a word on the order of its channels an image is in that of OpenCV.
    ("8UC3", Layout::Channels(3, [2, 1, 0]), 1),
    ("8UC4", Layout::Channels(4, [2, 1, 0]), 1),
    ("rgb16", Layout::Channels(3, [0, 1, 2]), 2),
    ("bgr16", Layout::Channels(3, [2, 1, 0]), 2),
    ("mono16", Layout::Channels(1, [0, 0, 0]), 2),
    ("bayer_rggb8", Layout::Bayer(0, 0), 1),
    ("bayer_grbg8", Layout::Bayer(1, 0), 1),
    ("bayer_gbrg8", Layout::Bayer(0, 1), 1),
    ("bayer_bggr8", Layout::Bayer(1, 1), 1),
    ("bayer_rggb16", Layout::Bayer(0, 0), 2),
    ("bayer_grbg16", Layout::Bayer(1, 0), 2),
    ("bayer_gbrg16", Layout::Bayer(0, 1), 2),
    ("bayer_bggr16", Layout::Bayer(1, 1), 2),
    ("yuv422", Layout::Yuv422([1, 0, 2]), 1),
    ("uyvy", Layout::Yuv422([1, 0, 2]), 1),
    ("UYVY", Layout::Yuv422([1, 0, 2]), 1),
    ("yuv422_yuy2", Layout::Yuv422([0, 1, 3]), 1),
    ("yuyv", Layout::Yuv422([0, 1, 3]), 1),
    ("YUYV", Layout::Yuv422([0, 1, 3]), 1),
    ("nv12", Layout::Yuv420([0, 1]), 1),
    ("nv21", Layout::Yuv420([1, 0]), 1),
];

/// The picture.
///
/// Values of 16 bits are brought to 8 over their whole range, or over that of 12 bits if none is larger. Colors behind a Bayer filter are
/// the means of the nearest pixels that have them.
///
/// # Errors
/// If the encoding is not known, or rows or bytes are missing: what was expected and what was found.
pub fn decode(image: &RawImage) -> Result<RgbImage, String> {
    let RawImage { encoding, data, .. } = image;
    let (_, layout, value_bytes) =
        *ENCODINGS.iter().find(|(name, ..)| *name == encoding).ok_or_else(|| unknown(encoding))?;
    let (width, height, step) = (image.size_px.0 as usize, image.size_px.1 as usize, image.step as usize);
    if width == 0 || height == 0 || width.max(height) > MAX_IMAGE_SIDE_PX as usize {
        return Err(format!(
            "expected an image of 1 to {MAX_IMAGE_SIDE_PX} px a side, found {width} x {height} px"
        ));
    }
    let (row_bytes, num_rows) = match layout {
        Layout::Channels(num_channels, _) => (width * num_channels * value_bytes, height),
        Layout::Bayer(..) if width < 2 || height < 2 => {
            return Err(format!("expected at least 2 x 2 px in {encoding}, found {width} x {height} px"));
        }
        Layout::Bayer(..) => (width * value_bytes, height),
        Layout::Yuv422(_) => (width.next_multiple_of(2) * 2, height),
        Layout::Yuv420(_) => (width.next_multiple_of(2), height + height.div_ceil(2)),
    };
    // The last row may end without padding.
    let is_complete = step
        .checked_mul(num_rows - 1)
        .and_then(|before| before.checked_add(row_bytes))
        .is_some_and(|num_bytes| num_bytes <= data.len());
    if step < row_bytes || !is_complete {
        return Err(format!(
            "raw image of {width} x {height} px in {encoding}: expected {num_rows} rows of at least {row_bytes} bytes, found rows \
             of {step} and {} bytes in all",
            data.len()
        ));
    }
    let rows = (0..num_rows).map(|y| &data[y * step..y * step + row_bytes]);
    let mut values = Vec::with_capacity(row_bytes / value_bytes * num_rows);
    if value_bytes == 1 {
        rows.for_each(|row| values.extend_from_slice(row));
    } else {
        let value = |pair: &[u8]| match image.is_big_endian {
            true => u16::from_be_bytes([pair[0], pair[1]]),
            false => u16::from_le_bytes([pair[0], pair[1]]),
        };
        let pairs = || rows.clone().flat_map(|row| row.chunks_exact(2));
        let range = range_of(pairs().map(value).max().unwrap_or(0));
        values.extend(pairs().map(|pair| to_8_bits(value(pair), range)));
    }
    let rgb = match layout {
        Layout::Channels(num_channels, order) => {
            values.chunks_exact(num_channels).flat_map(|pixel| order.map(|channel| pixel[channel])).collect()
        }
        Layout::Bayer(red_x, red_y) => of_bayer(&values, (width, height), (red_x, red_y)),
        Layout::Yuv422(order) => of_yuv422(&values, width, order),
        Layout::Yuv420(order) => of_yuv420(&values, (width, height), order),
    };
    RgbImage::from_raw(image.size_px.0, image.size_px.1, rgb).map_err(|error| error.to_string())
}

fn unknown(encoding: &str) -> String {
    if matches!(encoding, "16UC1" | "32FC1") {
        return format!(
            "image encoding '{encoding}' is that of depth images; name a topic of color or gray ones"
        );
    }
    let known: Vec<&str> = ENCODINGS.iter().map(|(name, ..)| *name).collect();
    format!("image encoding '{encoding}': expected one of {}; convert the recording", known.join(", "))
}

/// The largest value that there can be, by the largest one of an image. Cameras with sensors of 12 bits (and of 10) often leave the
/// four high bits of 16 empty; over the whole range such an image, and no other that is worth anything, would be black.
pub(crate) fn range_of(largest: u16) -> u16 {
    const OF_12_BITS: u16 = (1 << 12) - 1;
    if largest <= OF_12_BITS { OF_12_BITS } else { u16::MAX }
}

/// A value over the whole range of 8 bits.
pub(crate) fn to_8_bits(value: u16, range: u16) -> u8 {
    ((u32::from(value) * 255 + u32::from(range / 2)) / u32::from(range)) as u8
}

/// Bilinear: each missing color is the mean of the pixels with that color that touch this one. At the borders the pixels inside
/// are mirrored, which keeps the pattern.
fn of_bayer(values: &[u8], (width, height): (usize, usize), (red_x, red_y): (usize, usize)) -> Vec<u8> {
    let mirrored = |at: usize, offset: isize, length: usize| match at.checked_add_signed(offset) {
        None => 1,
        Some(beyond) if beyond >= length => length - 2,
        Some(inside) => inside,
    };
    let mut rgb = Vec::with_capacity(values.len() * 3);
    for y in 0..height {
        for x in 0..width {
            let at = |dx: isize, dy: isize| {
                u32::from(values[mirrored(y, dy, height) * width + mirrored(x, dx, width)])
            };
            let beside = || (at(-1, 0) + at(1, 0)).div_ceil(2);
            let above = || (at(0, -1) + at(0, 1)).div_ceil(2);
            let cross = || (at(-1, 0) + at(1, 0) + at(0, -1) + at(0, 1) + 2) / 4;
            let corners = || (at(-1, -1) + at(1, -1) + at(-1, 1) + at(1, 1) + 2) / 4;
            let here = u32::from(values[y * width + x]);
            let pixel = match (x % 2 == red_x, y % 2 == red_y) {
                (true, true) => [here, cross(), corners()],
                (false, false) => [corners(), cross(), here],
                (false, true) => [beside(), here, above()],
                (true, false) => [above(), here, beside()],
            };
            rgb.extend(pixel.map(|value| value as u8));
        }
    }
    rgb
}

fn of_yuv422(values: &[u8], width: usize, [first_y, u, v]: [usize; 3]) -> Vec<u8> {
    let mut rgb = Vec::with_capacity(values.len() / 2 * 3);
    for row in values.chunks_exact(width.next_multiple_of(2) * 2) {
        for x in 0..width {
            let pair = &row[x / 2 * 4..x / 2 * 4 + 4];
            rgb.extend(rgb_of_yuv(pair[first_y + x % 2 * 2], pair[u], pair[v]));
        }
    }
    rgb
}

fn of_yuv420(values: &[u8], (width, height): (usize, usize), [u, v]: [usize; 2]) -> Vec<u8> {
    let row_bytes = width.next_multiple_of(2);
    let (brightness, colors) = values.split_at(row_bytes * height);
    let mut rgb = Vec::with_capacity(width * height * 3);
    for y in 0..height {
        for x in 0..width {
            let color = &colors[y / 2 * row_bytes + x / 2 * 2..][..2];
            rgb.extend(rgb_of_yuv(brightness[y * row_bytes + x], color[u], color[v]));
        }
    }
    rgb
}

/// BT.601 with limited range, in units of 2^-20 as OpenCV.
fn rgb_of_yuv(y: u8, u: u8, v: u8) -> [u8; 3] {
    let brightness = (i32::from(y) - 16).max(0) * 1_220_542;
    let (u, v) = (i32::from(u) - 128, i32::from(v) - 128);
    let sums = [v * 1_673_527, v * -852_492 + u * -409_993, u * 2_116_026];
    sums.map(|sum| ((brightness + sum + (1 << 19)) >> 20).clamp(0, 255) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raw(size_px: (u32, u32), encoding: &str, step: u32, data: &[u8]) -> RawImage {
        RawImage { size_px, encoding: encoding.to_owned(), step, is_big_endian: false, data: data.to_vec() }
    }

    #[test]
    fn orders_of_channels() {
        let decode = |encoding, step, data: &[u8]| decode(&raw((2, 1), encoding, step, data));
        let rgb = RgbImage::from_raw(2, 1, vec![1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!(decode("rgb8", 6, &[1, 2, 3, 4, 5, 6]).unwrap(), rgb);
        assert_eq!(decode("bgr8", 8, &[3, 2, 1, 6, 5, 4, 0, 0]).unwrap(), rgb);
        assert_eq!(decode("8UC3", 8, &[3, 2, 1, 6, 5, 4]).unwrap(), rgb);
        assert_eq!(decode("rgba8", 8, &[1, 2, 3, 0, 4, 5, 6, 0]).unwrap(), rgb);
        assert_eq!(decode("bgra8", 8, &[3, 2, 1, 0, 6, 5, 4, 0]).unwrap(), rgb);
        assert_eq!(decode("mono8", 2, &[9, 8]).unwrap().data(), [9, 9, 9, 8, 8, 8]);
        assert_eq!(decode("mono16", 4, &[0, 128, 255, 255]).unwrap().data(), [128, 128, 128, 255, 255, 255]);
        let big = RawImage { is_big_endian: true, ..raw((2, 1), "mono16", 4, &[128, 0, 255, 255]) };
        assert_eq!(super::decode(&big).unwrap().data(), [128, 128, 128, 255, 255, 255]);
        // A sensor of 12 bits: 4095 and half of it.
        assert_eq!(decode("mono16", 4, &[255, 15, 0, 8]).unwrap().data(), [255, 255, 255, 128, 128, 128]);
    }

    #[test]
    fn missing_bytes_and_unknown_encodings_are_refused() {
        let refused =
            |size_px, encoding, step, data: &[u8]| decode(&raw(size_px, encoding, step, data)).unwrap_err();
        assert!(refused((2, 1), "rgb8", 6, &[0; 5]).contains("5 bytes in all"));
        assert!(refused((2, 1), "rgb8", 5, &[0; 6]).contains("at least 6 bytes"));
        assert!(refused((2, 2), "nv12", 2, &[0; 5]).contains("3 rows"));
        assert!(refused((1, 2), "bayer_rggb8", 1, &[0; 2]).contains("2 x 2"));
        assert!(refused((2, 1), "16UC1", 4, &[0; 4]).contains("depth"));
        assert!(refused((2, 1), "jpeg", 4, &[0; 4]).contains("bayer_rggb8"));
        for (name, ..) in ENCODINGS {
            assert!(refused((u32::MAX, u32::MAX), name, u32::MAX, &[0]).contains("px a side"));
            assert!(refused((16_384, 16_384), name, u32::MAX, &[0]).contains("1 bytes in all"));
            assert!(refused((0, 1), name, 0, &[]).contains("0 x 1"));
        }
    }

    /// A picture that is smooth enough for a filter to lose little of it.
    fn smooth(width: usize, height: usize) -> RgbImage {
        let mut image = RgbImage::new(width as u32, height as u32);
        for y in 0..height {
            for x in 0..width {
                image.set(
                    x as u32,
                    y as u32,
                    [(40 + 8 * x) as u8, (60 + 5 * y) as u8, (200 - 4 * x - 3 * y) as u8],
                );
            }
        }
        image
    }

    fn largest_difference(a: &RgbImage, b: &RgbImage) -> u8 {
        a.data().iter().zip(b.data()).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
    }

    #[test]
    fn all_four_bayer_patterns_give_the_picture_back() {
        let picture = smooth(12, 10);
        for (name, pattern) in
            [("rggb", [0, 1, 1, 2]), ("grbg", [1, 0, 2, 1]), ("gbrg", [1, 2, 0, 1]), ("bggr", [2, 1, 1, 0])]
        {
            let behind_filter =
                |x: usize, y: usize| picture.data()[(y * 12 + x) * 3 + pattern[y % 2 * 2 + x % 2]];
            let values: Vec<u8> = (0..10)
                .flat_map(|y| (0..12).map(move |x| (x, y)))
                .map(|(x, y)| behind_filter(x, y))
                .collect();
            let found = decode(&raw((12, 10), &format!("bayer_{name}8"), 12, &values)).unwrap();
            // Linear but for the borders, where the slope is not known.
            assert!(largest_difference(&found, &picture) <= 8, "{name}");
            let wide: Vec<u8> =
                values.iter().flat_map(|value| (u16::from(*value) * 257).to_le_bytes()).collect();
            assert_eq!(decode(&raw((12, 10), &format!("bayer_{name}16"), 24, &wide)).unwrap(), found);
        }
    }

    #[test]
    fn yuv_as_opencv_converts_it() {
        // cv2.cvtColor(..., COLOR_YUV2RGB_UYVY) of these bytes
        let expected = [154, 0, 0, 236, 77, 44, 146, 255, 255, 0, 55, 0];
        let yuyv = [50, 90, 120, 200, 235, 128, 16, 60];
        let uyvy = [90, 50, 200, 120, 128, 235, 60, 16];
        assert_eq!(decode(&raw((4, 1), "yuv422_yuy2", 8, &yuyv)).unwrap().data(), expected);
        assert_eq!(decode(&raw((4, 1), "yuv422", 8, &uyvy)).unwrap().data(), expected);
        let nv12 = [50, 120, 50, 120, 90, 200];
        let nv21 = [50, 120, 50, 120, 200, 90];
        for (name, bytes) in [("nv12", nv12), ("nv21", nv21)] {
            let found = decode(&raw((2, 2), name, 2, &bytes)).unwrap();
            assert_eq!(found.data(), [&expected[..6], &expected[..6]].concat(), "{name}");
        }
    }
}
