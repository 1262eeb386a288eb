//! What an edge is part of, from the colors on both of its sides.

use nalgebra::{Point2, Vector2};
use visloc_base::RgbImage;

use super::{EdgeSegment, SurfaceClass};
use crate::{DoorSide, FeatureKind};

/// An edge and what it is part of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Labelled {
    /// Where it is.
    pub segment: EdgeSegment,
    /// What it is part of; `None` if the colors beside it are of nothing known.
    pub kind: Option<FeatureKind>,
}

/// How far from the edge the colors are taken, pixels: past the blur of the edge, before the next surface.
const OFFSETS_PX: [f64; 2] = [2.2, 3.4];
/// Places along the edge at which the colors are taken.
const MAX_PLACES: usize = 10;
/// Share of these colors that must be of one class.
const MIN_SHARE: f64 = 0.6;

/// Looks at both sides of an edge.
pub(super) fn label(
    image: &RgbImage,
    class_of: &impl Fn([u8; 3]) -> SurfaceClass,
    segment: &EdgeSegment,
    min_wall_share: f64,
) -> Option<FeatureKind> {
    let along = segment.direction();
    // To the right of somebody who goes along the edge, in the image with y down.
    let right = Vector2::new(-along.y, along.x);
    let (right_class, right_brightness) = side_class(image, class_of, segment, &right);
    let (left_class, left_brightness) = side_class(image, class_of, segment, &-right);
    let kind = kind_between(left_class, right_class, &right)?;
    let (wall, floor) = match left_class {
        SurfaceClass::Floor => (right_brightness, left_brightness),
        _ => (left_brightness, right_brightness),
    };
    let is_too_dark = kind == FeatureKind::WallFoot && wall < min_wall_share * floor;
    (!is_too_dark).then_some(kind)
}

/// What lies between two surfaces. `right` points from the edge to the second one.
fn kind_between(left: SurfaceClass, right: SurfaceClass, to_right: &Vector2<f64>) -> Option<FeatureKind> {
    use SurfaceClass::{Door, Floor, Wall};
    match (left, right) {
        (Door(paint), Wall) | (Wall, Door(paint)) => {
            let is_door_second = matches!(right, Door(_));
            let is_door_at_larger_x = is_door_second == (to_right.x > 0.0);
            let side = if is_door_at_larger_x { DoorSide::Left } else { DoorSide::Right };
            Some(FeatureKind::DoorEdge { side, paint })
        }
        (Wall, Floor) | (Floor, Wall) => Some(FeatureKind::WallFoot),
        (Door(_), Floor) | (Floor, Door(_)) => Some(FeatureKind::DoorFoot),
        _ => None,
    }
}

/// The class that most of the pixels on one side belong to, and their mean brightness, 0 to 255.
fn side_class(
    image: &RgbImage,
    class_of: &impl Fn([u8; 3]) -> SurfaceClass,
    segment: &EdgeSegment,
    side: &Vector2<f64>,
) -> (SurfaceClass, f64) {
    let num_places = ((segment.length_px() / 2.0) as usize).clamp(2, MAX_PLACES);
    let mut votes: [(SurfaceClass, u32); 4] = [(SurfaceClass::Unknown, 0); 4];
    let (mut total, mut brightness) = (0_u32, 0_u32);
    for place in 0..num_places {
        let t = (place as f64 + 0.5) / num_places as f64;
        let on_edge = segment.start + (segment.end - segment.start) * t;
        for offset in OFFSETS_PX {
            let Some(rgb) = pixel(image, on_edge + side * offset) else { continue };
            total += 1;
            brightness += u32::from(rgb[0].max(rgb[1]).max(rgb[2]));
            let class = class_of(rgb);
            if class == SurfaceClass::Unknown {
                continue;
            }
            let slot = votes.iter_mut().find(|(known, count)| *known == class || *count == 0);
            if let Some(slot) = slot {
                *slot = (class, slot.1 + 1);
            }
        }
    }
    let best = votes.iter().max_by_key(|(_, count)| *count).copied().unwrap_or((SurfaceClass::Unknown, 0));
    let suffices = best.1 > 0 && f64::from(best.1) >= MIN_SHARE * f64::from(total);
    let class = if suffices { best.0 } else { SurfaceClass::Unknown };
    (class, f64::from(brightness) / f64::from(total.max(1)))
}

fn pixel(image: &RgbImage, at: Point2<f64>) -> Option<[u8; 3]> {
    let (x, y) = (at.x.round(), at.y.round());
    let is_inside = x >= 0.0 && y >= 0.0 && x < f64::from(image.width()) && y < f64::from(image.height());
    is_inside.then(|| image.get(x as u32, y as u32))
}
