//! Less for slow links: images of fewer pixels and fewer bytes for each, and scenes without what only a panel shows.

use std::sync::Arc;

use visloc_core::RgbImage;
use visloc_io::image_codec::{decode, encode_jpeg};

use crate::Message;

/// Array of the image's bytes in its message.
const JPEG: &str = "jpeg";
/// Array of what was not used of an image: most of the message of a small one.
const DROPPED: &str = "dropped";

/// A step down: pixels on a side that become one, and quality of the JPEG.
const STEPS: [(usize, u8); 4] = [(1, 85), (1, 50), (2, 55), (4, 50)];
/// The smallest.
const MAX_LEVEL: usize = STEPS.len() - 1;
/// From this step on the dropped pixels are left out.
const WITHOUT_DROPPED: usize = 2;

/// A scene without the parameters and their meaning, most of its bytes; nothing if it has none. It says that it `is_brief`.
pub(super) fn brief(scene: &[u8]) -> Option<Vec<u8>> {
    let mut message = Message::read(scene).ok()?;
    message.header.remove("pipeline")?;
    let contenders = message.header.get_mut("contenders").and_then(|all| all.as_array_mut());
    for contender in contenders.into_iter().flatten().filter_map(|contender| contender.as_object_mut()) {
        contender.remove("parameters");
    }
    message.header.insert("is_brief".to_owned(), true.into());
    Some(message.write())
}

/// An image message with a smaller image; level 0 is as it was made. What is drawn over the image stays, in pixels of the original,
/// only dropped pixels are left out of the smallest ones. A message that cannot be read stays as it is.
pub(super) fn smaller(message: &Arc<[u8]>, level: usize) -> Arc<[u8]> {
    let reduced = || {
        let (factor, quality) = *STEPS.get(level)?;
        let read = Message::read(message).ok()?;
        let image = decode(read.bytes(JPEG)?).ok()?;
        let jpeg = encode_jpeg(&shrunk(&image, factor)?, quality).ok()?;
        let without: &[&str] = if level < WITHOUT_DROPPED { &[] } else { &[DROPPED] };
        Some(read.with_bytes(JPEG, &jpeg, without).into())
    };
    if level == 0 { Arc::clone(message) } else { reduced().unwrap_or_else(|| Arc::clone(message)) }
}

/// Each square of pixels becomes its mean.
fn shrunk(image: &RgbImage, factor: usize) -> Option<RgbImage> {
    if factor <= 1 {
        return Some(image.clone());
    }
    let (from_width, from_height) = (image.width() as usize, image.height() as usize);
    let [width, height] = [from_width, from_height].map(|side| (side / factor).max(1));
    let data = image.data();
    let mean = |x: usize, y: usize, channel: usize| {
        let rows = (y * factor..(y + 1) * factor).filter(|row| *row < from_height);
        let (mut sum, mut count) = (0_usize, 0_usize);
        for row in rows {
            for column in (x * factor..(x + 1) * factor).filter(|column| *column < from_width) {
                sum += usize::from(data[(row * from_width + column) * 3 + channel]);
                count += 1;
            }
        }
        (sum / count.max(1)) as u8
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let bytes = pixels.flat_map(|(x, y)| [0, 1, 2].map(|channel| mean(x, y, channel))).collect();
    RgbImage::from_raw(width as u32, height as u32, bytes).ok()
}

visloc_core::with_defaults! {
    /// Chooses how small images are, by how long they took.
    /// By default the smallest, until it is known how long it takes.
    #[derive(Debug)]
    pub(super) struct ImageSize {
        level: usize = MAX_LEVEL,
        num_slow: u32 = 0,
        num_fast: u32 = 0,
        /// So many fast ones before a larger image is tried.
        patience: u32 = PATIENCE.0,
    }
}

/// Images that are drawn within this time cost nothing, seconds: a page on this computer that is merely busy keeps all of them.
pub(super) const FAST_SECS: f64 = 0.15;
/// One that takes so many times as long is enough to be sure, with the steps that it is worth.
const CERTAIN: [(f64, usize); 2] = [(8.0, 3), (4.0, 2)];
/// So many slow ones in a row before images become smaller: one alone may be a busy page.
const SLOW_IN_A_ROW: u32 = 2;
/// Fast ones before a larger image is tried: while none has been slow, after the first try that went wrong, and at most after more of them.
const PATIENCE: (u32, u32, u32) = (1, 32, 512);

impl ImageSize {
    /// 0 as it was made, to [`MAX_LEVEL`], the smallest.
    pub fn level(&self) -> usize {
        self.level
    }

    /// An image of this size has been drawn, so many seconds after it was sent.
    pub fn note(&mut self, took_secs: f64) {
        if took_secs > FAST_SECS {
            self.num_slow += 1;
            // A larger one was tried in vain: the next try comes later.
            if self.num_fast < self.patience && self.num_slow == 1 {
                self.patience = (2 * self.patience).clamp(PATIENCE.1, PATIENCE.2);
            }
            self.num_fast = 0;
            let certain = CERTAIN.iter().find(|(times, _)| took_secs > times * FAST_SECS);
            let steps = certain.map_or(usize::from(self.num_slow >= SLOW_IN_A_ROW), |(_, steps)| *steps);
            if steps > 0 {
                (self.level, self.num_slow) = ((self.level + steps).min(MAX_LEVEL), 0);
            }
            return;
        }
        self.num_slow = 0;
        self.num_fast += 1;
        if self.num_fast >= self.patience {
            self.num_fast = 0;
            if self.level == 0 {
                self.patience = PATIENCE.1 / 2;
            } else {
                self.level -= 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MessageBuilder, MessageKind};

    #[test]
    fn each_step_is_smaller_and_what_is_drawn_over_it_stays() {
        let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8;
        let image = RgbImage::from_raw(160, 120, (0..160 * 120 * 3).map(noise).collect()).unwrap();
        let header = serde_json::json!({ "size_px": [160, 120] });
        let mut message = MessageBuilder::new(MessageKind::Image, &header).unwrap();
        message.bytes(JPEG, &encode_jpeg(&image, 85).unwrap());
        message.floats("kept", [7.0, 8.0, 1.0]);
        let message: Arc<[u8]> = message.finish().into();
        let mut last = message.len() + 1;
        for (level, (factor, _)) in STEPS.iter().enumerate() {
            let bytes = smaller(&message, level);
            assert!(bytes.len() < last, "level {level}: {} of {last}", bytes.len());
            last = bytes.len();
            let read = Message::read(&bytes).unwrap();
            assert_eq!(read.floats("kept").unwrap(), [7.0, 8.0, 1.0]);
            assert_eq!(read.header["size_px"], header["size_px"]);
            let width = decode(read.bytes(JPEG).unwrap()).unwrap().width();
            assert_eq!(width as usize, 160 / factor);
        }
        let odd: Arc<[u8]> = Arc::from([3; 10]);
        assert_eq!(smaller(&odd, 2), odd, "what cannot be read stays as it is");
    }

    #[test]
    fn a_slow_link_gets_smaller_images_and_a_mended_one_the_whole_ones_again() {
        let mut size = ImageSize::default();
        assert_eq!(size.level(), MAX_LEVEL, "nothing is known about the link");
        (0..MAX_LEVEL).for_each(|_| size.note(0.02));
        assert_eq!(size.level(), 0, "whole ones after a few");
        size.note(0.3);
        size.note(0.02);
        assert_eq!(size.level(), 0, "one image that is a little slow is nothing");
        (0..20).for_each(|_| size.note(0.3));
        assert_eq!(size.level(), MAX_LEVEL);
        (0..PATIENCE.2 * 8).for_each(|_| size.note(0.02));
        assert_eq!(size.level(), 0);
        size.note(2.0);
        assert_eq!(size.level(), MAX_LEVEL, "one that is very slow is enough");
    }

    #[test]
    fn a_link_that_bears_one_size_is_hardly_troubled_by_larger_ones() {
        let mut size = ImageSize::default();
        let (mut num_slow, mut levels) = (0, [0; STEPS.len()]);
        for _ in 0..4000 {
            let is_slow = size.level() < 2;
            levels[size.level()] += 1;
            num_slow += u32::from(is_slow);
            size.note(if is_slow { 0.2 } else { 0.02 });
        }
        assert!(levels[2] > 3800 && num_slow < 60, "{levels:?}, {num_slow}");
    }
}
