//! Which images of keyframes are at hand: those that the camera was near last.

use crate::map::{KeyframeId, KeyframePicture, Map, Packing};

/// The keyframes whose images are at hand, those that the camera was near last at the end.
#[derive(Debug, Default)]
pub(super) struct AtHand {
    keyframes: Vec<KeyframeId>,
}

impl AtHand {
    /// All that are not packed yet.
    pub fn of(map: &Map) -> Self {
        let is_here = |picture: &KeyframePicture| matches!(picture, KeyframePicture::Here(_));
        let here = map.all_keyframes().filter(|(_, keyframe)| keyframe.picture.as_ref().is_some_and(is_here));
        Self { keyframes: here.map(|(id, _)| id).collect() }
    }

    /// Adds a keyframe that has just been made.
    pub fn add(&mut self, made: KeyframeId) {
        self.keyframes.push(made);
    }

    /// The camera is near these keyframes, most important first.
    pub fn come_near(&mut self, near: &[KeyframeId]) {
        for id in near.iter().rev() {
            if let Some(place) = self.keyframes.iter().rposition(|other| other == id) {
                self.keyframes[place..].rotate_left(1);
            }
        }
    }

    /// Packs the image of the keyframe that the camera was near longest ago, if more are at hand than should be.
    pub fn pack_one(&mut self, map: &mut Map, packing: &Packing) {
        // Those that were culled have no image any more.
        self.keyframes.retain(|id| map.keyframe(*id).picture.is_some());
        if self.keyframes.len() > packing.num_at_hand {
            map.pack_picture(self.keyframes.remove(0), packing);
        }
    }

    /// Packs all images.
    pub fn pack_all(&mut self, map: &mut Map, packing: &Packing) {
        self.keyframes.drain(..).for_each(|id| map.pack_picture(id, packing));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use visloc_core::{GrayImage, Timestamp};

    use super::*;
    use crate::{
        image::Pyramid,
        lie::CameraFromWorld,
        map::{NewKeyframe, PictureShelf},
    };

    #[test]
    fn images_that_the_camera_was_not_near_for_long_are_packed() {
        let mut map = Map::new();
        let mut made = |frame: usize| {
            map.add_keyframe(NewKeyframe {
                frame,
                at: Timestamp::default(),
                pyramid: Arc::new(Pyramid::new(GrayImage::new(40, 30), 2)),
                camera_from_world: CameraFromWorld::identity(),
                turned_from: None,
                odometry: None,
            })
        };
        let ids: Vec<KeyframeId> = (0..6).map(&mut made).collect();
        let mut at_hand = AtHand::of(&map);
        let packing = Packing {
            pack: |image| Some(image.data().to_vec()),
            unpack: |bytes| GrayImage::from_raw(40, 30, bytes.to_vec()).ok(),
            num_at_hand: 3,
            shelf: Arc::new(PictureShelf::new(1)),
        };
        at_hand.come_near(&[ids[0], ids[2]]);
        map.cull_keyframe(ids[4], ids[5]);
        for _ in 0..4 {
            at_hand.pack_one(&mut map, &packing);
        }
        let is_here = |id: &&KeyframeId| matches!(map.keyframe(**id).picture, Some(KeyframePicture::Here(_)));
        let here: Vec<&KeyframeId> = ids.iter().filter(is_here).collect();
        assert_eq!(here, [&ids[0], &ids[2], &ids[5]], "the culled one has none, and three are enough");
        at_hand.pack_all(&mut map, &packing);
        assert!(!ids.iter().any(|id| matches!(map.keyframe(*id).picture, Some(KeyframePicture::Here(_)))));
        let unpacked = map.keyframe(ids[1]).pyramid().unwrap();
        assert_eq!((unpacked.num_levels(), unpacked.level(0).width()), (1, 40));
    }
}
