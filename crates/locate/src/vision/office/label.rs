//! What an edge is part of, from the colors on both of its sides.

use nalgebra::{Point2, Vector2};
use visloc_core::RgbImage;

use super::{EdgeSegment, SurfaceClass};
use crate::vision::{DoorSide, FeatureKind};

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
/// From one place along the edge at which colors are taken to the next, pixels, and how many places there are at most.
const PLACE_PX: f64 = 2.0;
const MAX_PLACES: usize = 96;
/// Places to both sides that vote with a place.
const WINDOW: usize = 3;
/// Share of the colors that must be of one class.
const MIN_SHARE: f64 = 0.6;
/// Classes that can be told apart: nothing known, wall, floor, and doors of so many colors.
const NUM_CLASSES: usize = 3 + 13;

/// Colors beside one place of an edge.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// For each side, how often each class is there.
    classes: [[Option<SurfaceClass>; OFFSETS_PX.len()]; 2],
    brightness: [u32; 2],
}

/// Looks at both sides of an edge all along it, and visits its parts of one kind each: the floor's border runs on
/// straight where a door begins. `class_of` tells the class of a color.
pub(super) fn label(
    image: &RgbImage,
    class_of: &impl Fn([u8; 3]) -> SurfaceClass,
    segment: &EdgeSegment,
    min_wall_share: f64,
    mut visit: impl FnMut(EdgeSegment, Option<FeatureKind>),
) {
    let along = segment.direction();
    // To the right of somebody who goes along the edge, in the image with y down.
    let right = Vector2::new(-along.y, along.x);
    let nowhere = Place { classes: [[None; OFFSETS_PX.len()]; 2], brightness: [0; 2] };
    let mut places = [nowhere; MAX_PLACES];
    let num_places = ((segment.length_px() / PLACE_PX) as usize).clamp(2, MAX_PLACES);
    let places = &mut places[..num_places];
    for (i, place) in places.iter_mut().enumerate() {
        let t = (i as f64 + 0.5) / num_places as f64;
        let at = segment.start + (segment.end - segment.start) * t;
        for (side, direction) in [-right, right].into_iter().enumerate() {
            for (offset_px, class) in OFFSETS_PX.into_iter().zip(&mut place.classes[side]) {
                let rgb = pixel(image, at + direction * offset_px);
                *class = rgb.map(class_of);
                place.brightness[side] += rgb.map_or(0, |[r, g, b]| u32::from(r.max(g).max(b)));
            }
        }
    }
    let places = &*places;
    let kind_at = |i: usize| {
        let window = &places[i.saturating_sub(WINDOW)..(i + WINDOW + 1).min(num_places)];
        kind_of(window, &right, min_wall_share)
    };
    let mut from = 0;
    let mut kind = kind_at(0);
    for i in 1..=num_places {
        let next = if i < num_places { kind_at(i) } else { None };
        if i == num_places || next != kind {
            let share = |i: usize| i as f64 / num_places as f64;
            visit(segment.part(share(from), share(i)), kind);
            (from, kind) = (i, next);
        }
    }
}

/// What an edge with these places is part of.
fn kind_of(places: &[Place], right: &Vector2<f64>, min_wall_share: f64) -> Option<FeatureKind> {
    let [(left_class, left_brightness), (right_class, right_brightness)] =
        [0, 1].map(|side| side_class(places, side));
    let kind = kind_between(left_class, right_class, right)?;
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
fn side_class(places: &[Place], side: usize) -> (SurfaceClass, f64) {
    let index = |class: SurfaceClass| match class {
        SurfaceClass::Unknown => 0,
        SurfaceClass::Wall => 1,
        SurfaceClass::Floor => 2,
        SurfaceClass::Door(paint) => (3 + usize::from(paint)).min(NUM_CLASSES - 1),
    };
    let mut votes = [(SurfaceClass::Unknown, 0_u32); NUM_CLASSES];
    let (mut total, mut brightness) = (0_u32, 0_u32);
    for place in places {
        brightness += place.brightness[side];
        for class in place.classes[side].into_iter().flatten() {
            let vote = &mut votes[index(class)];
            *vote = (class, vote.1 + 1);
            total += 1;
        }
    }
    let (class, count) =
        votes[1..].iter().max_by_key(|(_, count)| *count).copied().unwrap_or((SurfaceClass::Unknown, 0));
    let suffices = count > 0 && f64::from(count) >= MIN_SHARE * f64::from(total);
    let class = if suffices { class } else { SurfaceClass::Unknown };
    (class, f64::from(brightness) / f64::from(total.max(1)))
}

fn pixel(image: &RgbImage, at: Point2<f64>) -> Option<[u8; 3]> {
    let (x, y) = (at.x.round(), at.y.round());
    let is_inside = x >= 0.0 && y >= 0.0 && x < f64::from(image.width()) && y < f64::from(image.height());
    is_inside.then(|| image.get(x as u32, y as u32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::office::{GradientDetector, OfficeColors, OfficeTable};

    /// The floor's border runs on straight below wall, door and wall; it is cut where the door begins and ends.
    #[test]
    fn an_edge_is_cut_where_its_kind_changes() {
        let colors =
            OfficeColors { wall: [235, 234, 228], floor: [216, 181, 58], doors: vec![[176, 39, 31]] };
        let mut image = RgbImage::new(120, 60);
        for y in 0..60 {
            for x in 0..120 {
                let rgb = match (x, y) {
                    (_, 30..) => colors.floor,
                    (40..80, _) => colors.doors[0],
                    _ => colors.wall,
                };
                image.set(x, y, rgb);
            }
        }
        let mut segments = Vec::new();
        GradientDetector::default().detect(&image, 0, 9.0, 7.0, &mut segments);
        let table = OfficeTable::new(&colors);
        let mut parts = Vec::new();
        for segment in &segments {
            label(&image, &|rgb| table.class(rgb), segment, 0.4, |part, kind| {
                let along_x = [part.start.x.min(part.end.x), part.start.x.max(part.end.x)];
                parts.push((kind, along_x));
            });
        }
        for (kind, from, to) in [
            (FeatureKind::WallFoot, 2.0, 40.0),
            (FeatureKind::DoorFoot, 40.0, 80.0),
            (FeatureKind::WallFoot, 80.0, 117.0),
        ] {
            let is_it = |(found, ends): &(Option<FeatureKind>, [f64; 2])| {
                *found == Some(kind) && (ends[0] - from).abs() < 4.0 && (ends[1] - to).abs() < 4.0
            };
            assert!(parts.iter().any(is_it), "{kind:?} from {from} to {to}: {parts:?}");
        }
    }
}
