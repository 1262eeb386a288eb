//! The images of keyframes: at hand, or packed and unpacked when they are looked at.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, MutexGuard, PoisonError, Weak},
};

use visloc_core::GrayImage;

use crate::image::Pyramid;

/// Makes an image of packed bytes; `None` if they are no image.
pub type Unpack = fn(&[u8]) -> Option<GrayImage>;

/// The image of a keyframe.
#[derive(Debug, Clone)]
pub enum KeyframePicture {
    /// As it was taken.
    Here(Arc<Pyramid>),
    /// As it was stored.
    Packed(Arc<PackedPicture>),
}

impl KeyframePicture {
    /// The image and its halvings; `None` if it cannot be unpacked.
    #[must_use]
    pub fn pyramid(&self) -> Option<Arc<Pyramid>> {
        match self {
            Self::Here(pyramid) => Some(Arc::clone(pyramid)),
            Self::Packed(packed) => packed.pyramid(),
        }
    }
}

/// An image that is packed. It is unpacked when it is asked for, and kept as long as it is in use or among the last that were
/// unpacked.
#[derive(Debug)]
pub struct PackedPicture {
    bytes: Vec<u8>,
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

/// The images that were unpacked last: a bound on the memory that a large map takes.
#[derive(Debug)]
pub struct PictureShelf {
    most: usize,
    kept: Mutex<VecDeque<Arc<Pyramid>>>,
}

impl PictureShelf {
    /// With room for so many images.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self { most, kept: Mutex::default() }
    }

    fn put(&self, pyramid: &Arc<Pyramid>) {
        let mut kept = lock(&self.kept);
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
