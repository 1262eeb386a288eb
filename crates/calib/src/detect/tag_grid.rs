//! The grid of tags in one level of the pyramid.

use std::collections::BTreeMap;

use nalgebra::Point2;

use super::{DetectReject, grow::Corners};
use crate::{
    AprilGrid,
    tags::{find_quads, read_tag},
};

/// Corners of a tag, clockwise from the tag's upper left one.
type TagCorners = [Point2<f64>; 4];

/// Longest side of a tag, as a share of the image's longer side.
const MAX_SIDE: f64 = 0.6;

/// How the tags lie on the board: corner k of the board is corner (first + k) or (first - k) of the tag.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Layout {
    first: usize,
    is_mirrored: bool,
}

impl Layout {
    fn corner(self, k: usize) -> usize {
        if self.is_mirrored { (self.first + 4 - k) % 4 } else { (self.first + k) % 4 }
    }
}

/// Numbered corners of a grid. How a tag is turned on the board, and whether rows are counted up or down, is told from the
/// neighbors: boards of different makers differ.
pub(super) fn find(
    corners: &Corners<'_>,
    grid: &AprilGrid,
) -> Result<Vec<(usize, Point2<f64>)>, DetectReject> {
    let tags = read_tags(corners, grid);
    let mut votes: BTreeMap<Layout, usize> = BTreeMap::new();
    for tag in tags.keys() {
        if let Some(layout) = vote(&tags, *tag, grid) {
            *votes.entry(layout).or_default() += 1;
        }
    }
    let Some((layout, _)) = votes.iter().max_by_key(|(_, count)| **count) else {
        return Err(if tags.is_empty() {
            DetectReject::NoBoard(corners.saddles.len())
        } else {
            DetectReject::FewTags(tags.len())
        });
    };
    // A tag that lies otherwise than the rest was read wrongly.
    let agreeing = tags.iter().filter(|(tag, _)| vote(&tags, **tag, grid).is_none_or(|own| own == *layout));
    let agreeing: Vec<_> = agreeing.collect();
    if agreeing.len() < 4 {
        return Err(DetectReject::FewTags(agreeing.len()));
    }
    Ok(agreeing.iter().flat_map(|(tag, px)| (0..4).map(|k| (4 * **tag + k, px[layout.corner(k)]))).collect())
}

/// Tags of the grid by their place, counted from its first.
fn read_tags(corners: &Corners<'_>, grid: &AprilGrid) -> BTreeMap<usize, TagCorners> {
    let longer = corners.image.width().max(corners.image.height()) as f64;
    let mut tags = BTreeMap::new();
    let mut twice = Vec::new();
    for quad in find_quads(corners.image, corners.saddles, corners.index, MAX_SIDE * longer) {
        let Some(tag) = read_tag(corners.image, &quad.corners_px, grid.border_cells) else { continue };
        let Some(place) = tag.id.checked_sub(grid.first_id).filter(|p| *p < grid.columns * grid.rows) else {
            continue;
        };
        let px = [0, 1, 2, 3].map(|k| quad.corners_px[(tag.first_corner + k) % 4]);
        if tags.insert(place, px).is_some() {
            twice.push(place);
        }
    }
    // A number that is seen twice says nothing.
    for place in twice {
        tags.remove(&place);
    }
    tags
}

/// How a tag lies, from a neighbor in its row and one in its column.
fn vote(tags: &BTreeMap<usize, TagCorners>, tag: usize, grid: &AprilGrid) -> Option<Layout> {
    let (column, row) = (tag % grid.columns, tag / grid.columns);
    let here = center(&tags[&tag]);
    let at = |column: usize, row: usize| tags.get(&(row * grid.columns + column)).map(center);
    let right = (column + 1 < grid.columns).then(|| at(column + 1, row)).flatten().map(|p| p - here);
    let left = column.checked_sub(1).and_then(|column| at(column, row)).map(|p| here - p);
    let below = (row + 1 < grid.rows).then(|| at(column, row + 1)).flatten().map(|p| p - here);
    let above = row.checked_sub(1).and_then(|row| at(column, row)).map(|p| here - p);
    let (x, y) = (right.or(left)?, below.or(above)?);
    // The corner that lies against x and y is the first, then comes the one along x.
    let axes = nalgebra::Matrix2::from_columns(&[x, y]).try_inverse()?;
    let place = |px: &Point2<f64>| axes * (px - here);
    let own = tags[&tag].map(|px| place(&px));
    let nearest = |sx: f64, sy: f64| {
        (0..4).max_by(|a, b| {
            let along = |k: usize| sx * own[k].x + sy * own[k].y;
            along(*a).total_cmp(&along(*b))
        })
    };
    let (first, second) = (nearest(-1.0, -1.0)?, nearest(1.0, -1.0)?);
    match (second + 4 - first) % 4 {
        1 => Some(Layout { first, is_mirrored: false }),
        3 => Some(Layout { first, is_mirrored: true }),
        _ => None,
    }
}

fn center(corners: &TagCorners) -> Point2<f64> {
    Point2::from(corners.iter().map(|p| p.coords).sum::<nalgebra::Vector2<f64>>() / 4.0)
}
