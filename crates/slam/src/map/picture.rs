//! The images of keyframes: at hand, or packed and unpacked when they are looked at. This crate has no codec: who has one passes it in.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, MutexGuard, PoisonError, Weak},
};

use visloc_core::GrayImage;

use crate::image::Pyramid;

/// Makes an image of packed bytes; `None` if they are no image.
pub type Unpack = fn(&[u8]) -> Option<GrayImage>;

/// Packs an image; `None` if that cannot be done.
pub type Pack = fn(&GrayImage) -> Option<Vec<u8>>;

/// The image of a keyframe.
#[derive(Debug, Clone)]
pub enum KeyframePicture {
    /// As it was taken.
    Here(Arc<Pyramid>),
    /// Packed since the camera has not been near it for long.
    Resting(Arc<PackedPicture>),
    /// As it was stored.
    Packed(Arc<PackedPicture>),
}

impl KeyframePicture {
    /// The image and its halvings; `None` if it cannot be unpacked.
    #[must_use]
    pub fn pyramid(&self) -> Option<Arc<Pyramid>> {
        match self {
            Self::Here(pyramid) => Some(Arc::clone(pyramid)),
            Self::Resting(packed) | Self::Packed(packed) => packed.pyramid(),
        }
    }

    /// Where it is kept once it is unpacked; `None` if it is as it was taken.
    #[must_use]
    pub fn shelf(&self) -> Option<&Arc<PictureShelf>> {
        match self {
            Self::Here(_) => None,
            Self::Resting(packed) | Self::Packed(packed) => Some(&packed.shelf),
        }
    }
}

/// How images that nobody has looked at for long are packed, so that a run over many places does not need the memory of all their images.
#[derive(Debug, Clone)]
pub struct Packing {
    /// Packs an image.
    pub pack: Pack,
    /// Unpacks it.
    pub unpack: Unpack,
    /// How many images stay as they were taken, those of the keyframes that the camera was near last.
    pub num_at_hand: usize,
    /// Where unpacked ones are kept. A landmark is looked for as it was seen first: there should be room for what some images in a row look at, or images
    /// are unpacked again and again.
    pub shelf: Arc<PictureShelf>,
}

impl Packing {
    /// The packed image; `None` if it is packed already or cannot be packed.
    #[must_use]
    pub fn packed(&self, picture: &KeyframePicture) -> Option<KeyframePicture> {
        let KeyframePicture::Here(pyramid) = picture else { return None };
        let image = pyramid.level(0);
        let size_px = (image.width() as u32, image.height() as u32);
        let bytes = (self.pack)(image)?;
        let packed = PackedPicture::new(bytes, size_px, pyramid.num_levels(), self.unpack, &self.shelf);
        Some(KeyframePicture::Resting(Arc::new(packed)))
    }
}

/// An image that is packed. It is unpacked when it is asked for, and kept as long as it is in use or among the last that were
/// asked for.
#[derive(Debug)]
pub struct PackedPicture {
    bytes: Box<[u8]>,
    /// Width and height, pixels.
    size_px: (u32, u32),
    num_levels: usize,
    unpack: Unpack,
    unpacked: Mutex<Weak<Pyramid>>,
    shelf: Arc<PictureShelf>,
}

impl PackedPicture {
    /// Of packed bytes that should hold an image of this size.
    #[must_use]
    pub fn new(
        bytes: Vec<u8>,
        size_px: (u32, u32),
        num_levels: usize,
        unpack: Unpack,
        shelf: &Arc<PictureShelf>,
    ) -> Self {
        // Encoders leave room for more.
        let bytes = bytes.into_boxed_slice();
        let (unpacked, shelf) = (Mutex::default(), Arc::clone(shelf));
        Self { bytes, size_px, num_levels, unpack, unpacked, shelf }
    }

    /// The packed bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn pyramid(&self) -> Option<Arc<Pyramid>> {
        let mut unpacked = lock(&self.unpacked);
        if let Some(pyramid) = unpacked.upgrade() {
            self.shelf.put(&pyramid);
            return Some(pyramid);
        }
        let (width, height) = (self.size_px.0 as usize, self.size_px.1 as usize);
        let image =
            (self.unpack)(&self.bytes).filter(|image| (image.width(), image.height()) == (width, height))?;
        let pyramid = Arc::new(Pyramid::new(image, self.num_levels));
        *unpacked = Arc::downgrade(&pyramid);
        self.shelf.put(&pyramid);
        Some(pyramid)
    }
}

/// The unpacked images that were asked for last: a bound on the memory that a large map takes.
#[derive(Debug)]
pub struct PictureShelf {
    most: usize,
    /// The one that was asked for last at the end.
    kept: Mutex<VecDeque<Arc<Pyramid>>>,
}

impl PictureShelf {
    /// With room for so many images.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self { most, kept: Mutex::default() }
    }

    /// An image is asked for. What is in use is asked for many times in a row, so it is looked for from the end.
    fn put(&self, pyramid: &Arc<Pyramid>) {
        let mut kept = lock(&self.kept);
        if let Some(place) = kept.iter().rposition(|other| Arc::ptr_eq(other, pyramid)) {
            kept.remove(place);
        }
        while kept.len() >= self.most {
            kept.pop_front();
        }
        kept.push_back(Arc::clone(pyramid));
    }
}

/// What is locked is replaced as a whole, so that it is sound even after a panic.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_asked_for_last_stays_unpacked() {
        let shelf = Arc::new(PictureShelf::new(2));
        let unpack: Unpack = |bytes| GrayImage::from_raw(4, 3, bytes.to_vec()).ok();
        let packed = [0, 1, 2].map(|gray| PackedPicture::new(vec![gray; 12], (4, 3), 1, unpack, &shelf));
        let gray = |number: usize| packed[number].pyramid().unwrap().level(0).get(0, 0);
        let are_unpacked = || packed.each_ref().map(|it| lock(&it.unpacked).strong_count() > 0);
        assert_eq!([0, 1, 0, 2].map(gray), [0, 1, 0, 2]);
        assert_eq!(are_unpacked(), [true, false, true], "the first was asked for again, the second was not");
        // In use it stays, and is on the shelf again once it is asked for.
        let in_use = packed[0].pyramid().unwrap();
        assert_eq!([1, 2].map(gray), [1, 2]);
        assert!(Arc::ptr_eq(&in_use, &packed[0].pyramid().unwrap()));
        drop(in_use);
        assert_eq!(are_unpacked(), [true, false, true]);
    }
}
