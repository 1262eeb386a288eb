//! The images of keyframes: packed as JPEG.

use std::sync::Arc;

use visloc_core::GrayImage;
use visloc_io::image_codec::{decode_gray, encode_gray_jpeg};
use visloc_slam::map::{KeyframePicture, Map, PackedPicture, Packing, PictureShelf};

/// Bytes that a keyframe may take, with its image and its share of all else.
const MOST_BYTES: usize = 39_500;
/// Bytes that an image may take in any case.
const LEAST_BYTES: usize = 8_000;
/// Qualities that are tried, until one is small enough.
const QUALITIES: [u8; 8] = [90, 80, 70, 60, 50, 40, 25, 10];
/// Quality of images that are packed while a run goes on.
const RESTING_QUALITY: u8 = 80;
/// Images of a run that stay as they were taken: SLAM keeps up to 150 keyframes of one room.
const AT_HAND: usize = 160;
/// The same beside a map that stays as it is: a camera soon goes on, or back to what the map shows.
const AT_HAND_BESIDE: usize = 16;
/// Images that are kept unpacked; about 1.4 bytes a pixel each.
pub const UNPACKED: usize = 32;
/// Levels of the pyramids that are made of them.
const NUM_LEVELS: usize = 5;

/// Bytes that an image may take where all else takes so many for each keyframe.
pub fn budget(others: usize) -> usize {
    MOST_BYTES.saturating_sub(others).max(LEAST_BYTES)
}

/// The bytes of an image, so many if that is possible. One that is stored already stays as it is.
pub fn packed(picture: &KeyframePicture, most_bytes: usize) -> Option<Vec<u8>> {
    let pyramid = match picture {
        KeyframePicture::Packed(packed) => return Some(packed.bytes().to_vec()),
        KeyframePicture::Resting(packed) if packed.bytes().len() <= most_bytes => {
            return Some(packed.bytes().to_vec());
        }
        picture => picture.pyramid()?,
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
    KeyframePicture::Packed(Arc::new(PackedPicture::new(bytes, size_px, NUM_LEVELS, unpack, shelf)))
}

fn unpack(bytes: &[u8]) -> Option<GrayImage> {
    decode_gray(bytes).ok()
}

/// How a run packs the images of keyframes that the camera has not been near for long ([`visloc_slam::Slam::set_packing`]): as JPEG, in an eighth of
/// the memory. The 160 keyframes that it was near last keep their images as they were taken, and of the others the 32 that were asked for last stay unpacked.
#[must_use]
pub fn packing() -> Packing {
    let pack = |image: &GrayImage| encode_gray_jpeg(image, RESTING_QUALITY).ok();
    Packing { pack, unpack, num_at_hand: AT_HAND, shelf: Arc::new(PictureShelf::new(UNPACKED)) }
}

/// The same for what a camera sees beside a map that stays as it is. Images of both are unpacked onto one shelf: a camera is hardly ever near both.
pub(crate) fn packing_beside(map: &Map) -> Packing {
    let pictures = map.all_keyframes().filter_map(|(_, keyframe)| keyframe.picture.as_ref());
    let shelf = pictures.filter_map(KeyframePicture::shelf).next().map(Arc::clone);
    let alone = packing();
    Packing { num_at_hand: AT_HAND_BESIDE, shelf: shelf.unwrap_or(alone.shelf), ..alone }
}

#[cfg(test)]
mod tests {
    use visloc_core::{Timestamp, geom::Camera};
    use visloc_slam::{
        image::Pyramid,
        map::{Restoring, SessionCamera, StoredKeyframe},
    };

    use super::*;

    /// Blocks of many grays.
    fn image() -> GrayImage {
        let mut image = GrayImage::new(160, 120);
        for (i, value) in image.data_mut().iter_mut().enumerate() {
            let (column, row) = (i % 160 / 8, i / 160 / 8);
            *value = (column * 37 + row * 91 + column * row * 13) as u8;
        }
        image
    }

    #[test]
    fn what_is_added_to_a_map_is_unpacked_onto_its_shelf() {
        let camera = Camera::pinhole((160, 120), (100.0, 100.0), (80.0, 60.0)).unwrap();
        let keyframe = StoredKeyframe {
            at: Timestamp::default(),
            map: 0,
            camera: 0,
            rotation: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            translation: [0.0; 3],
            gradient_noise: Vec::new(),
            turned_from: None,
        };
        let mut map = Restoring::new(&[SessionCamera::as_calibrated(&camera)], &[keyframe]).unwrap();
        let shelf = Arc::new(PictureShelf::new(UNPACKED));
        map.set_picture(0, unpacked(Vec::new(), (160, 120), &shelf));
        assert!(Arc::ptr_eq(&packing_beside(&map.finish()).shelf, &shelf));
        assert!(!Arc::ptr_eq(&packing_beside(&Map::new()).shelf, &shelf), "it has no images");
    }

    #[test]
    fn a_file_takes_over_what_rests_if_it_is_small_enough() {
        let taken = KeyframePicture::Here(Arc::new(Pyramid::new(image(), NUM_LEVELS)));
        let packing = packing();
        let resting = packing.packed(&taken).unwrap();
        assert!(packing.packed(&resting).is_none(), "it is packed already");
        let KeyframePicture::Resting(bytes) = &resting else { panic!("{resting:?}") };
        let num = bytes.bytes().len();
        assert_eq!(packed(&resting, num).unwrap(), bytes.bytes());
        let smaller = packed(&resting, num - 1).unwrap();
        assert!(smaller.len() < num, "{} of {num}", smaller.len());
        let (before, after) = (taken.pyramid().unwrap(), resting.pyramid().unwrap());
        assert_eq!(before.num_levels(), after.num_levels());
        let levels = before.level(0).data().iter().zip(after.level(0).data());
        let square = |(a, b): (&u8, &u8)| (f64::from(*a) - f64::from(*b)).powi(2);
        let rms = (levels.map(square).sum::<f64>() / f64::from(160 * 120)).sqrt();
        assert!(rms < 6.0, "{rms} gray levels");
    }
}
