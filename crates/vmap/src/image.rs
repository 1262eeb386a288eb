//! The images of keyframes: packed as JPEG.

use std::sync::Arc;

use visloc_core::GrayImage;
use visloc_io::image_codec::{decode_gray, encode_gray_jpeg};
use visloc_slam::map::{KeyframePicture, PackedPicture, PictureShelf};

/// Bytes that a keyframe may take, with its image and its share of all else.
const MOST_BYTES: usize = 39_500;
/// Bytes that an image may take in any case.
const LEAST_BYTES: usize = 8_000;
/// Qualities that are tried, until one is small enough.
const QUALITIES: [u8; 8] = [90, 80, 70, 60, 50, 40, 25, 10];
/// Images that are kept unpacked; about 1.4 bytes a pixel each.
pub const SHELF_PICTURES: usize = 64;
/// Levels of the pyramids that are made of them.
const NUM_LEVELS: usize = 5;

/// Bytes that an image may take where all else takes so many for each keyframe.
pub fn budget(others: usize) -> usize {
    MOST_BYTES.saturating_sub(others).max(LEAST_BYTES)
}

/// The bytes of an image, so many if that is possible. One that was packed before stays as it is.
pub fn packed(picture: &KeyframePicture, most_bytes: usize) -> Option<Vec<u8>> {
    let pyramid = match picture {
        KeyframePicture::Packed(packed) => return Some(packed.bytes().to_vec()),
        KeyframePicture::Here(pyramid) => pyramid,
    };
    let mut smallest = None;
    for quality in QUALITIES {
        let bytes = encode_gray_jpeg(pyramid.level(0), quality).ok()?;
        let is_small = bytes.len() <= most_bytes;
        smallest = Some(bytes);
        if is_small {
            break;
        }
    }
    smallest
}

/// An image of packed bytes.
pub fn unpacked(bytes: Vec<u8>, size_px: (u32, u32), shelf: &Arc<PictureShelf>) -> KeyframePicture {
    let unpack = |bytes: &[u8]| -> Option<GrayImage> { decode_gray(bytes).ok() };
    KeyframePicture::Packed(Arc::new(PackedPicture::new(bytes, size_px, NUM_LEVELS, unpack, shelf)))
}
