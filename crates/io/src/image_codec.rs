//! JPEG and PNG pictures.

use std::{
    io::{self, BufRead, Cursor},
    path::{Path, PathBuf},
};

use image::{
    DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError, ImageFormat, ImageReader,
    Limits, metadata::Orientation,
};
use thiserror::Error;
use visloc_core::{GrayImage, RgbImage, files, geom::MAX_IMAGE_SIDE_PX};

use crate::raw_image::{range_of, to_8_bits};

/// Most memory that decoding may take, bytes.
const MAX_DECODE_BYTES: u64 = 256 << 20;

/// Longest file that is read, bytes: a picture, and the film that phones put behind it.
const MAX_FILE_BYTES: u64 = 256 << 20;

/// Why a picture cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ImageCodecError {
    /// The bytes are not a picture that can be decoded.
    #[error("expected a JPEG or PNG picture, found {num_bytes} bytes: {reason}")]
    Decode {
        /// Length of the data.
        num_bytes: usize,
        /// What is wrong.
        reason: String,
    },
    /// The picture cannot be encoded.
    #[error("cannot encode a picture of {width} x {height} px: {reason}")]
    Encode {
        /// Width, pixels.
        width: u32,
        /// Height, pixels.
        height: u32,
        /// What is wrong.
        reason: String,
    },
    /// The file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

/// Decodes JPEG or PNG bytes, whatever they contain: gray and 16-bit pictures become 8-bit color, 12 bits in 16 too. A picture whose Exif data
/// say that it is turned is turned back.
///
/// # Errors
/// If the bytes are not such a picture, are cut off, or the picture is larger than 16384 px a side.
pub fn decode(bytes: &[u8]) -> Result<RgbImage, ImageCodecError> {
    let image = decode_any(bytes)?.into_rgb8();
    let (width, height) = image.dimensions();
    RgbImage::from_raw(width, height, image.into_raw())
        .map_err(|error| ImageCodecError::Decode { num_bytes: bytes.len(), reason: error.to_string() })
}

/// As [`decode`], to gray; color pictures are weighted by ITU-R BT.601.
///
/// # Errors
/// As [`decode`].
pub fn decode_gray(bytes: &[u8]) -> Result<GrayImage, ImageCodecError> {
    let gray = match decode_any(bytes)? {
        DynamicImage::ImageLuma8(gray) => gray,
        gray @ DynamicImage::ImageLumaA8(_) => gray.into_luma8(),
        color => {
            let color = color.into_rgb8();
            let (width, height) = color.dimensions();
            let rgb = RgbImage::from_raw(width, height, color.into_raw());
            return rgb.map(|rgb| GrayImage::from_rgb(&rgb)).map_err(|error| ImageCodecError::Decode {
                num_bytes: bytes.len(),
                reason: error.to_string(),
            });
        }
    };
    let (width, height) = gray.dimensions();
    GrayImage::from_raw(width as usize, height as usize, gray.into_raw())
        .map_err(|error| ImageCodecError::Decode { num_bytes: bytes.len(), reason: error.to_string() })
}

fn decode_any(bytes: &[u8]) -> Result<DynamicImage, ImageCodecError> {
    let decode_error = |reason: String| ImageCodecError::Decode { num_bytes: bytes.len(), reason };
    let reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| decode_error(error.to_string()))?;
    match reader.format() {
        // The decoder paints missing parts gray; a picture half gray must not reach an algorithm.
        Some(ImageFormat::Jpeg) => check_jpeg(bytes).map_err(decode_error)?,
        Some(ImageFormat::Png) => {}
        _ => return Err(decode_error("the format is neither".into())),
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_IMAGE_SIDE_PX);
    limits.max_image_height = Some(MAX_IMAGE_SIDE_PX);
    limits.max_alloc = Some(MAX_DECODE_BYTES);
    let decoded = upright(reader, limits).map_err(|error| match error {
        ImageError::Limits(_) => decode_error(too_large(bytes)),
        error => decode_error(error.to_string()),
    });
    Ok(in_8_bits(decoded?))
}

/// Decodes, and turns the picture as its Exif data say that it is to be looked at: cameras that were held upright or upside down write it as their
/// sensor has it.
fn upright(mut reader: ImageReader<Cursor<&[u8]>>, mut limits: Limits) -> Result<DynamicImage, ImageError> {
    reader.limits(limits.clone());
    let mut decoder = reader.into_decoder()?;
    limits.reserve(decoder.total_bytes())?;
    decoder.set_limits(limits)?;
    // Data that cannot be read say nothing.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut image = DynamicImage::from_decoder(decoder)?;
    image.apply_orientation(orientation);
    Ok(image)
}

/// Values of 16 bits in 8, as those of raw images.
fn in_8_bits(image: DynamicImage) -> DynamicImage {
    let of = |values: &[u16]| {
        let range = range_of(values.iter().copied().max().unwrap_or(0));
        values.iter().map(|value| to_8_bits(*value, range)).collect::<Vec<u8>>()
    };
    let (width, height) = (image.width(), image.height());
    let small = match &image {
        DynamicImage::ImageLuma16(gray) => {
            image::GrayImage::from_raw(width, height, of(gray)).map(DynamicImage::ImageLuma8)
        }
        DynamicImage::ImageRgb16(color) => {
            image::RgbImage::from_raw(width, height, of(color)).map(DynamicImage::ImageRgb8)
        }
        DynamicImage::ImageLumaA16(_) => return in_8_bits(image.into_luma16().into()),
        DynamicImage::ImageRgba16(_) => return in_8_bits(image.into_rgb16().into()),
        _ => None,
    };
    small.unwrap_or(image)
}

/// What was found and what there may be.
fn too_large(bytes: &[u8]) -> String {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().ok();
    let size = reader.and_then(|reader| reader.into_dimensions().ok());
    let found = size.map_or_else(String::new, |(width, height)| format!(" of {width} x {height} px"));
    let millions = MAX_DECODE_BYTES / 3 / 1_000_000;
    format!(
        "the picture{found} is too large: at most {MAX_IMAGE_SIDE_PX} px a side and {millions} million px in all; make it smaller"
    )
}

/// Checks that the picture goes on to its end mark and has data enough for its size. Whatever stands behind the end does not matter: phones
/// append films and notes.
///
/// Source: ITU-T T.81, annex B. Segments have lengths, so the pictures in them (thumbnails) and their end marks are passed over. Each block of
/// 8 x 8 px has one code at least, and a code one bit.
fn check_jpeg(bytes: &[u8]) -> Result<(), String> {
    const START: u8 = 0xd8;
    const END: u8 = 0xd9;
    const SCAN: u8 = 0xda;
    // Marks without a segment: the start, restarts, and a byte of a private use of old times.
    let is_alone = |mark: u8| matches!(mark, START | 0xd0..=0xd7 | 0x01);
    let is_frame = |mark: u8| matches!(mark, 0xc0..=0xcf) && !matches!(mark, 0xc4 | 0xc8 | 0xcc);
    let missing = || "the JPEG is cut off or damaged, its end mark is missing".to_owned();
    let mut rest = bytes;
    loop {
        let mark = next_mark(&mut rest).ok_or_else(missing)?;
        if mark == END {
            return Ok(());
        }
        if is_alone(mark) {
            continue;
        }
        let (length, _) = rest.split_first_chunk::<2>().ok_or_else(missing)?;
        if is_frame(mark)
            && let Some([height_0, height_1, width_0, width_1]) = rest.get(3..7)
        {
            let width = usize::from(u16::from_be_bytes([*width_0, *width_1]));
            let height = usize::from(u16::from_be_bytes([*height_0, *height_1]));
            if bytes.len() * 8 < (width / 8) * (height / 8) {
                return Err(format!("the JPEG is damaged: its data cannot be {width} x {height} px"));
            }
        }
        // The data of a scan have no length; they end with the next mark that is not a restart.
        let length = if mark == SCAN { 2 } else { usize::from(u16::from_be_bytes(*length)).max(2) };
        rest = rest.get(length..).unwrap_or_default();
    }
}

/// Goes on behind the next mark.
fn next_mark(rest: &mut &[u8]) -> Option<u8> {
    loop {
        // Looks at many bytes at a time.
        rest.skip_until(0xff).ok()?;
        let mark = *rest.first()?;
        if !matches!(mark, 0 | 0xff) {
            *rest = &rest[1..];
            return Some(mark);
        }
    }
}

/// Encodes as JPEG with a quality from 1 to 100.
///
/// # Errors
/// If the image is empty or larger than 65535 px a side.
pub fn encode_jpeg(image: &RgbImage, quality: u8) -> Result<Vec<u8>, ImageCodecError> {
    let mut bytes = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, quality.clamp(1, 100));
    write_image(encoder, image)?;
    Ok(bytes)
}

/// As [`encode_jpeg`], of one channel.
///
/// # Errors
/// As [`encode_jpeg`].
pub fn encode_gray_jpeg(image: &GrayImage, quality: u8) -> Result<Vec<u8>, ImageCodecError> {
    let mut bytes = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, quality.clamp(1, 100));
    write_gray(encoder, image)?;
    Ok(bytes)
}

/// Encodes as PNG.
///
/// # Errors
/// If the image is empty.
pub fn encode_png(image: &RgbImage) -> Result<Vec<u8>, ImageCodecError> {
    let mut bytes = Vec::new();
    write_image(image::codecs::png::PngEncoder::new(&mut bytes), image)?;
    Ok(bytes)
}

/// Encodes as PNG of one channel; every pixel stays exact.
///
/// # Errors
/// If the image is empty.
pub fn encode_gray_png(image: &GrayImage) -> Result<Vec<u8>, ImageCodecError> {
    let mut bytes = Vec::new();
    write_gray(image::codecs::png::PngEncoder::new(&mut bytes), image)?;
    Ok(bytes)
}

fn write_gray(encoder: impl ImageEncoder, image: &GrayImage) -> Result<(), ImageCodecError> {
    let side = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    let (width, height) = (side(image.width()), side(image.height()));
    encoder
        .write_image(image.data(), width, height, ExtendedColorType::L8)
        .map_err(|error| ImageCodecError::Encode { width, height, reason: error.to_string() })
}

fn write_image(encoder: impl ImageEncoder, image: &RgbImage) -> Result<(), ImageCodecError> {
    let (width, height) = (image.width(), image.height());
    let encode_error = |reason: String| ImageCodecError::Encode { width, height, reason };
    if width == 0 || height == 0 {
        return Err(encode_error("expected at least one pixel".into()));
    }
    encoder
        .write_image(image.data(), width, height, ExtendedColorType::Rgb8)
        .map_err(|error| encode_error(error.to_string()))
}

/// The bytes of a JPEG or PNG file, not looked at yet.
///
/// # Errors
/// If the file cannot be read or is too long for a picture.
pub fn read_image_file(path: &Path) -> Result<Vec<u8>, ImageCodecError> {
    files::read(path, MAX_FILE_BYTES)
        .map_err(|source| ImageCodecError::Io { path: path.to_path_buf(), source })
}

/// Width and height of a JPEG or PNG file as it is decoded, turned as it says, pixels, by its header; `None` if it has none that can be read.
pub fn image_size(path: &Path) -> Option<(u32, u32)> {
    let mut decoder = ImageReader::open(path).ok()?.with_guessed_format().ok()?.into_decoder().ok()?;
    let (width, height) = decoder.dimensions();
    let is_on_its_side = decoder.orientation().is_ok_and(|orientation| {
        use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
        matches!(orientation, Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH)
    });
    Some(if is_on_its_side { (height, width) } else { (width, height) })
}

/// Reads a JPEG or PNG file.
///
/// # Errors
/// If the file cannot be read or decoded.
pub fn read_image(path: &Path) -> Result<RgbImage, ImageCodecError> {
    decode(&read_image_file(path)?)
}

/// Reads a JPEG or PNG file as gray.
///
/// # Errors
/// If the file cannot be read or decoded.
pub fn read_gray_image(path: &Path) -> Result<GrayImage, ImageCodecError> {
    decode_gray(&read_image_file(path)?)
}

/// A gray image in another size, width and height in pixels; averages where it gets smaller. The borders stay where they are.
pub fn resize_gray(image: GrayImage, (width, height): (u32, u32)) -> GrayImage {
    if (image.width(), image.height()) == (width as usize, height as usize) {
        return image;
    }
    let factor = image.width() / (width as usize).max(1);
    if factor > 1 && (image.width(), image.height()) == (factor * width as usize, factor * height as usize) {
        return image.shrunk(factor);
    }
    let old_px = (image.width() as u32, image.height() as u32);
    let resized = image::GrayImage::from_raw(old_px.0, old_px.1, image.data().to_vec())
        .map(|old| image::imageops::resize(&old, width, height, image::imageops::FilterType::Triangle));
    let resized = resized.map(image::GrayImage::into_raw).unwrap_or_default();
    GrayImage::from_raw(width as usize, height as usize, resized).unwrap_or(image)
}

/// Saves as PNG.
///
/// # Errors
/// If the image cannot be encoded or the file not be written.
pub fn save_png(image: &RgbImage, path: &Path) -> Result<(), ImageCodecError> {
    save(&encode_png(image)?, path)
}

/// Saves as JPEG with a quality from 1 to 100.
///
/// # Errors
/// If the image cannot be encoded or the file not be written.
pub fn save_jpeg(image: &RgbImage, quality: u8, path: &Path) -> Result<(), ImageCodecError> {
    save(&encode_jpeg(image, quality)?, path)
}

fn save(bytes: &[u8], path: &Path) -> Result<(), ImageCodecError> {
    files::replace(path, bytes).map_err(|source| ImageCodecError::Io { path: path.to_path_buf(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> RgbImage {
        let mut image = RgbImage::new(32, 24);
        for y in 0..24 {
            for x in 0..32 {
                image.set(x, y, [(x * 7) as u8, (y * 9) as u8, 100]);
            }
        }
        image
    }

    #[test]
    fn png_is_exact_and_jpeg_close() {
        let image = gradient();
        assert_eq!(decode(&encode_png(&image).unwrap()).unwrap(), image);
        let jpeg = decode(&encode_jpeg(&image, 95).unwrap()).unwrap();
        let difference = image.data().iter().zip(jpeg.data()).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(difference < 30, "{difference}");
    }

    #[test]
    fn cut_and_foreign_bytes_are_refused() {
        let jpeg = encode_jpeg(&gradient(), 90).unwrap();
        for length in 0..jpeg.len() {
            assert!(decode(&jpeg[..length]).is_err(), "{length} of {} bytes", jpeg.len());
        }
        let png = encode_png(&gradient()).unwrap();
        assert!(decode(&png[..png.len() / 2]).is_err());
        let error = decode(b"GIF89a").unwrap_err().to_string();
        assert!(error.contains("expected a JPEG or PNG") && error.contains("6 bytes"), "{error}");
        assert!(encode_jpeg(&RgbImage::default(), 90).is_err());
    }

    #[test]
    fn half_the_size_is_the_mean_of_four_pixels() {
        let image = GrayImage::from_raw(4, 2, vec![10, 20, 100, 100, 30, 40, 100, 100]).unwrap();
        let half = resize_gray(image.clone(), (2, 1));
        // The triangle filter reaches half a pixel into the neighbors.
        assert!(half.get(0, 0).abs_diff(35) < 12 && half.get(1, 0).abs_diff(95) < 12, "{:?}", half.data());
        assert_eq!(resize_gray(image.clone(), (4, 2)), image);
    }

    #[test]
    fn what_phones_put_behind_and_into_a_picture_is_passed_over() {
        let jpeg = encode_jpeg(&gradient(), 90).unwrap();
        let picture = decode(&jpeg).unwrap();
        for behind in [&[0; 5][..], b"SEFT\x01\xff", b"\0\0\0\x18ftypmp42 a film", &jpeg, &jpeg[..300]] {
            assert_eq!(decode(&[&jpeg, behind].concat()).unwrap(), picture);
        }
        // A thumbnail in a segment has an end mark of its own, which is not that of the picture.
        let thumbnail = encode_jpeg(&RgbImage::new(8, 8), 50).unwrap();
        let length = u16::try_from(thumbnail.len() + 2).unwrap().to_be_bytes();
        let with_thumbnail = [&jpeg[..2], &[0xff, 0xe1], &length, &thumbnail, &jpeg[2..]].concat();
        assert_eq!(decode(&with_thumbnail).unwrap(), picture);
        assert!(
            decode(&with_thumbnail[..with_thumbnail.len() - 50]).unwrap_err().to_string().contains("cut off")
        );
    }

    #[test]
    fn a_picture_is_turned_as_its_exif_data_say() {
        let jpeg = encode_jpeg(&gradient(), 95).unwrap();
        let picture = decode(&jpeg).unwrap();
        let with_orientation = |value: u8| {
            // A TIFF directory with one entry: tag 0x112, one short number.
            let entry = [0x12, 0x01, 3, 0, 1, 0, 0, 0, value, 0, 0, 0];
            let exif = [&b"Exif\0\0II*\0\x08\0\0\0\x01\0"[..], &entry, &[0; 4]].concat();
            let length = u16::try_from(exif.len() + 2).unwrap().to_be_bytes();
            [&jpeg[..2], &[0xff, 0xe1], &length, &exif, &jpeg[2..]].concat()
        };
        assert_eq!(decode(&with_orientation(1)).unwrap(), picture);
        let upside_down = decode(&with_orientation(3)).unwrap();
        assert_eq!(upside_down.get(31, 23), picture.get(0, 0));
        let (w, h) = (picture.width(), picture.height());
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), with_orientation(6)).unwrap();
        assert_eq!(image_size(file.path()), Some((h, w)));
        let on_its_side = decode_gray(&with_orientation(6)).unwrap();
        assert_eq!((on_its_side.width() as u32, on_its_side.height() as u32), (h, w));
        let gray = decode_gray(&jpeg).unwrap();
        // The upper left corner of what the sensor saw is the upper right one of what was seen.
        assert_eq!(on_its_side.get(h as usize - 1, 0), gray.get(0, 0));
    }

    #[test]
    fn huge_sizes_in_a_header_reserve_no_memory() {
        let mut png = encode_png(&gradient()).unwrap();
        png[16..20].copy_from_slice(&60_000_u32.to_be_bytes());
        assert!(decode(&png).is_err());
    }

    /// Decoding it would take seconds. A large picture of one color, the least data that there can be, is decoded.
    #[test]
    fn a_jpeg_of_a_few_bytes_is_no_large_picture() {
        let mut jpeg = encode_jpeg(&gradient(), 90).unwrap();
        let frame_at = jpeg.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
        jpeg[frame_at + 5..frame_at + 9].copy_from_slice(&[0x21, 0xfb, 0x1f, 0x00]);
        let error = decode(&jpeg).unwrap_err().to_string();
        assert!(error.contains("cannot be 7936 x 8699 px"), "{error}");
        let one_color = encode_gray_jpeg(&GrayImage::new(1600, 1200), 10).unwrap();
        assert_eq!(decode_gray(&one_color).unwrap().width(), 1600);
    }

    #[test]
    fn what_is_too_large_is_told_with_its_size() {
        for (width, height) in [(12_000, 9000), (20_000, 10)] {
            let mut png = Vec::new();
            let gray = image::GrayImage::new(width, height);
            let encoder = image::codecs::png::PngEncoder::new(&mut png);
            let color = ExtendedColorType::Rgb8;
            let data = if height > 10 { vec![0; 3 * width as usize * height as usize] } else { Vec::new() };
            match height {
                10 => encoder.write_image(gray.as_raw(), width, height, ExtendedColorType::L8).unwrap(),
                _ => encoder.write_image(&data, width, height, color).unwrap(),
            }
            let error = decode(&png).unwrap_err().to_string();
            assert!(error.contains(&format!("{width} x {height} px is too large")), "{error}");
        }
    }

    #[test]
    fn values_of_12_bits_in_16_are_brought_to_their_whole_range() {
        for (values, expected) in [([0, 0x0800, 0x0fff], [0, 128, 255]), ([0, 0x8000, 0xffff], [0, 128, 255])]
        {
            let gray = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(3, 1, values.to_vec()).unwrap();
            let color = DynamicImage::ImageLuma16(gray.clone()).into_rgb16();
            for image in [DynamicImage::ImageLuma16(gray), DynamicImage::ImageRgb16(color)] {
                let mut png = Cursor::new(Vec::new());
                image.write_to(&mut png, ImageFormat::Png).unwrap();
                assert_eq!(decode_gray(png.get_ref()).unwrap().data(), expected);
            }
        }
    }
}
