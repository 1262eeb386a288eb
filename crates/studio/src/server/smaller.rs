//! Images for slow links: a quarter of the pixels, and what belongs on them without the pixels that were dropped.

use std::sync::Arc;

use visloc_base::RgbImage;
use visloc_data::image_codec::{decode, encode_jpeg};

use crate::{Message, MessageBuilder};

/// Quality of small images.
const JPEG_QUALITY: u8 = 55;
/// Smaller ones stay as they are, pixels.
const LEAST_WIDTH: u32 = 160;
/// Most of an image's overlay.
const LEFT_OUT: &str = "dropped";
const JPEG: &str = "jpeg";

/// An image message with a smaller image. Its `size_px` stays that of the camera, in which all that belongs on the image is told;
/// pages stretch the image to it. `None` if there is nothing to make smaller.
pub(super) fn smaller(bytes: &[u8]) -> Option<Arc<[u8]>> {
    let message = Message::read(bytes).ok()?;
    let image = decode(message.bytes(JPEG)?).ok()?;
    if image.width() < LEAST_WIDTH {
        return None;
    }
    let jpeg = encode_jpeg(&half(&image)?, JPEG_QUALITY).ok()?;
    let mut small = MessageBuilder::new(message.kind, &message.header).ok()?;
    small.bytes(JPEG, &jpeg);
    for name in message.names().filter(|name| ![JPEG, LEFT_OUT].contains(name)) {
        small.floats(name, message.floats(name)?.into_iter().map(f64::from));
    }
    Some(small.finish().into())
}

/// The mean of each two by two pixels.
#[allow(clippy::cast_possible_truncation)]
fn half(image: &RgbImage) -> Option<RgbImage> {
    let (width, height) = (image.width() / 2, image.height() / 2);
    let mut data = Vec::with_capacity((width * height * 3) as usize);
    for y in 0..height {
        let rows = [image.row(2 * y), image.row(2 * y + 1)];
        for x in 0..width as usize {
            for channel in 0..3 {
                let sum = |row: &[u8]| u16::from(row[6 * x + channel]) + u16::from(row[6 * x + 3 + channel]);
                data.push(((sum(rows[0]) + sum(rows[1]) + 2) / 4) as u8);
            }
        }
    }
    RgbImage::from_raw(width, height, data).ok()
}

#[cfg(test)]
pub(super) mod tests {
    use serde_json::json;

    use super::*;
    use crate::MessageKind;

    /// An image message with everything on it.
    pub fn large() -> Arc<[u8]> {
        let data = (0..320 * 240 * 3_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let image = RgbImage::from_raw(320, 240, data).unwrap();
        let mut message =
            MessageBuilder::new(MessageKind::Image, &json!({ "number": 7, "size_px": [320, 240] })).unwrap();
        message.bytes(JPEG, &encode_jpeg(&image, 85).unwrap());
        message.floats("kept", [1.0, 2.0, 0.0]);
        message.floats(LEFT_OUT, vec![0.5; 3000]);
        message.finish().into()
    }

    #[test]
    fn a_small_image_is_stretched_to_the_camera_and_keeps_what_was_kept() {
        let large = large();
        let bytes = smaller(&large).unwrap();
        assert!(4 * bytes.len() < large.len(), "{} of {} bytes", bytes.len(), large.len());
        let small = Message::read(&bytes).unwrap();
        assert_eq!(small.header, Message::read(&large).unwrap().header);
        assert_eq!(small.floats("kept"), Some(vec![1.0, 2.0, 0.0]));
        assert_eq!(small.floats(LEFT_OUT), None);
        let image = decode(small.bytes(JPEG).unwrap()).unwrap();
        assert_eq!((image.width(), image.height()), (160, 120));
        let twice = smaller(&smaller(&large).unwrap()).unwrap();
        assert!(smaller(&twice).is_none(), "no smaller than needed");
        assert!(smaller(b"no image").is_none());
    }
}
