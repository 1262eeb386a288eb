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
}

/// How images that nobody has looked at for long are packed, so that a run over many places does not need the memory of all their images.
#[derive(Debug, Clone)]
pub struct Packing {
    /// Packs an image.
    pub pack: Pack,
    /// Unpacks it.
    pub unpack: Unpack,
    /// How many images stay as they were taken, those of the keyframes that the camera was near last. A landmark is looked for as it was seen first, in
    /// whatever keyframe of the map: they should be as many as a room has, or images are unpacked again and again.
    pub num_at_hand: usize,
    /// Where unpacked ones are kept.
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
/// unpacked.
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
