//! Pictures that show the same once more, as neighbors in a video do: what they say is not independent, since the errors of a corner that is
//! seen in the same way are the same.

use nalgebra::Complex;

use super::ViewInput;
use crate::BoardCorner;

/// Corners that moved less than this between two pictures are seen at the same place, as a share of the image's diagonal.
const SAME_PLACE: f64 = 0.05;
/// Corners that move less than this against each other, once shift, turn and scale of the board are taken off, are seen from the same
/// direction, as a share of their distance from its center: a tilt by 5 to 10 degrees is more.
const SAME_SHAPE: f64 = 0.02;

/// For each picture the number of one that shows the same view and is used in its place; `None` for those that are used. Of pictures that
/// show the same, one with most corners is used.
pub(super) fn same_views(inputs: &[ViewInput], size_px: (u32, u32)) -> Vec<Option<usize>> {
    let diagonal_px = f64::from(size_px.0).hypot(f64::from(size_px.1));
    let mut fullest: Vec<usize> = (0..inputs.len()).collect();
    fullest.sort_by_key(|i| std::cmp::Reverse(inputs[*i].corners.len()));
    let mut used: Vec<usize> = Vec::new();
    let mut same = vec![None; inputs.len()];
    for i in fullest {
        let is_same = |j: &&usize| show_the_same(&inputs[i].corners, &inputs[**j].corners, diagonal_px);
        same[i] = used.iter().find(is_same).copied();
        if same[i].is_none() {
            used.push(i);
        }
    }
    same
}

/// A place in the image, pixels: turn and scale of the plane are one factor.
type Place = Complex<f64>;

fn show_the_same(a: &[BoardCorner], b: &[BoardCorner], diagonal_px: f64) -> bool {
    let place = |corner: &BoardCorner| Place::new(corner.px.x, corner.px.y);
    let in_both = |corner: &BoardCorner| {
        let other = b.iter().find(|other| other.id == corner.id)?;
        Some((place(corner), place(other)))
    };
    let (in_a, in_b): (Vec<Place>, Vec<Place>) = a.iter().filter_map(in_both).unzip();
    if in_a.is_empty() || 2 * in_a.len() < a.len().max(b.len()) {
        return false;
    }
    let moved_px = mean(in_a.iter().zip(&in_b).map(|(a, b)| (b - a).norm_sqr())).sqrt();
    if moved_px > SAME_PLACE * diagonal_px {
        return false;
    }
    // The similarity transform that brings the one nearest to the other.
    let (in_a, in_b) = (centered(&in_a), centered(&in_b));
    let spread = mean(in_a.iter().map(Place::norm_sqr));
    let cross = in_a.iter().zip(&in_b).map(|(a, b)| a.conj() * b).sum::<Place>() / in_a.len() as f64;
    let factor = cross / spread.max(f64::MIN_POSITIVE);
    let bent = mean(in_a.iter().zip(&in_b).map(|(a, b)| (b - factor * a).norm_sqr()));
    bent <= SAME_SHAPE * SAME_SHAPE * spread
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let number = values.len();
    values.sum::<f64>() / number as f64
}

fn centered(places: &[Place]) -> Vec<Place> {
    let center = places.iter().sum::<Place>() / places.len() as f64;
    places.iter().map(|place| place - center).collect()
}
