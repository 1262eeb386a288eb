//! Images in files, in messages and in the pipe of a video.

use visloc_core::{RgbImage, Timestamp};
use visloc_io::{
    bag::{EncodedImage, ImagePayload},
    image_codec::{decode, decode_gray, encode_jpeg, encode_png},
    raw_image::RawImage,
    sources::read_pnm,
};

fn picture() -> RgbImage {
    let mut image = RgbImage::new(24, 16);
    for (i, byte) in image.data_mut().iter_mut().enumerate() {
        *byte = (i * 7 % 251) as u8;
    }
    image
}

pub fn file_seeds() -> Vec<Vec<u8>> {
    vec![
        encode_jpeg(&picture(), 90).unwrap(),
        encode_jpeg(&picture(), 20).unwrap(),
        encode_png(&picture()).unwrap(),
    ]
}

pub fn file(bytes: &[u8]) {
    let color = decode(bytes).map(|image| (image.width(), image.height()));
    let gray = decode_gray(bytes).map(|image| (image.width() as u32, image.height() as u32));
    assert_eq!(color.ok(), gray.ok(), "the same picture in gray");
}

/// Orders of channels that are or may be known, and some that are not.
const ENCODINGS: [&str; 24] = [
    "rgb8",
    "bgr8",
    "rgba8",
    "bgra8",
    "mono8",
    "mono16",
    "bayer_rggb8",
    "bayer_bggr8",
    "bayer_gbrg8",
    "bayer_grbg8",
    "yuv422",
    "yuv422_yuy2",
    "yuyv",
    "uyvy",
    "nv12",
    "nv21",
    "nv24",
    "8UC1",
    "8UC3",
    "16UC1",
    "rgb16",
    "bgr16",
    "32FC1",
    "",
];

/// Encoding, width, height (16 bit), bytes a row (32 bit), and the pixels.
pub fn raw_seeds() -> Vec<Vec<u8>> {
    let head = |encoding: u8, width: u16, height: u16, step: u32| {
        [&[encoding][..], &width.to_le_bytes(), &height.to_le_bytes(), &step.to_le_bytes()].concat()
    };
    let all = (0..ENCODINGS.len() as u8).flat_map(|encoding| {
        [1, 2, 3, 4, 6].map(|channels| [head(encoding, 8, 6, 8 * channels), vec![90; 8 * 6 * 8]].concat())
    });
    all.collect()
}

pub fn raw(bytes: &[u8]) {
    let [encoding, w0, w1, h0, h1, s0, s1, s2, s3, data @ ..] = bytes else { return };
    let payload = ImagePayload::Raw(RawImage {
        size_px: (u32::from(u16::from_le_bytes([*w0, *w1])), u32::from(u16::from_le_bytes([*h0, *h1]))),
        encoding: ENCODINGS[usize::from(*encoding) % ENCODINGS.len()].to_owned(),
        step: u32::from_le_bytes([*s0, *s1, *s2, *s3]),
        is_big_endian: *encoding >= 128,
        data: data.to_vec(),
    });
    let _ = EncodedImage { at: Timestamp::default(), frame_id: String::new(), payload }.decode();
}

pub fn stream_seeds() -> Vec<Vec<u8>> {
    let gray = [b"P5\n4 3\n255\n".to_vec(), vec![70; 12]].concat();
    let color = [b"P6\n2 2\n255\n".to_vec(), vec![9; 12]].concat();
    vec![gray.clone(), color.clone(), [gray.clone(), color, gray].concat()]
}

pub fn stream(mut bytes: &[u8]) {
    while let Ok(Some(_)) = read_pnm(&mut bytes) {}
}
