//! The end of the field: the upper border of the carpet in the image.

use visloc_core::RgbImage;

use crate::vision::{
    blur_px,
    color::{ColorClass, ColorTable},
    px_in,
};

/// Carpet is so many green pixels in a row at least, in images up to 640 px wide: letters and borders on boards may be mixed to its color.
const MIN_CARPET_PX: u32 = 3;

/// Where the carpet ends, as an upper convex hull over the image's columns.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FieldEnd {
    columns: Vec<(f64, f64)>,
    hull: Vec<(f64, f64)>,
}

/// Going up from the bottom, so many pixels in a row without carpet end the field, in an image 320 px wide; more only if a line is as thick there.
const MAX_GAP_PX: u32 = 14;

impl FieldEnd {
    /// Finds the carpet's end in every `step_px`-th column, not above `first_row`, and takes the hull (2010 figure
    /// 4.10). A column that stands out alone is a green thing beyond the field and is left out. `line_px` says how many rows a line across
    /// the view has at a column and row.
    pub(super) fn find(
        &mut self,
        (image, table): (&RgbImage, &ColorTable),
        step_px: u32,
        first_row: u32,
        line_px: impl Fn(u32, u32) -> u32,
    ) {
        self.columns.clear();
        let mut column = step_px / 2;
        while column < image.width() {
            let line_px = |row| line_px(column, row);
            let row = first_carpet_row(image, table, (column, first_row), line_px).unwrap_or(image.height());
            self.columns.push((f64::from(column), f64::from(row)));
            column += step_px;
        }
        self.hull.clear();
        for i in 0..self.columns.len() {
            let (x, y) = self.columns[i];
            let before = self.columns[i.saturating_sub(1)].1;
            let after = self.columns[(i + 1).min(self.columns.len() - 1)].1;
            push_hull(&mut self.hull, (x, y.max(before.min(after))));
        }
    }

    /// Row of the carpet's end in a column, pixels.
    pub fn row_px(&self, column_px: f64) -> f64 {
        let after = self.hull.partition_point(|(x, _)| *x < column_px);
        match (after.checked_sub(1).map(|i| self.hull[i]), self.hull.get(after)) {
            (Some((x0, y0)), Some((x1, y1))) => y0 + (y1 - y0) * (column_px - x0) / (x1 - x0),
            (Some((_, y)), None) => y,
            (None, Some((_, y))) => *y,
            (None, None) => 0.0,
        }
    }

    /// Corners of the hull (column, row), pixels, from left to right.
    pub fn hull(&self) -> &[(f64, f64)] {
        &self.hull
    }
}

/// The highest carpet that hangs together with the carpet at the bottom of the column. What is green beyond the field is
/// cut off from it by the floor around the carpet.
fn first_carpet_row(
    image: &RgbImage,
    table: &ColorTable,
    (column, first_row): (u32, u32),
    line_px: impl Fn(u32) -> u32,
) -> Option<u32> {
    let max_gap = px_in(image.width(), MAX_GAP_PX);
    let stride = blur_px(image.width());
    let min_carpet = MIN_CARPET_PX * stride;
    let (mut gap, mut green, mut end) = (0, 0, None);
    // The gap after which the carpet that was found last is the end.
    let mut most = None;
    let (mut row, width) = (image.height(), image.width() as usize);
    let at = |row: u32| row as usize * width + column as usize;
    let pixels = image.pixels().get(at(first_row)..=at(row - 1)).unwrap_or_default();
    for pixels in pixels.rchunks(stride as usize * width) {
        let [r, g, b] = pixels[pixels.len() - 1];
        let is_green = table.class(r, g, b) == ColorClass::Green;
        green = if is_green { green + stride } else { 0 };
        gap += stride;
        if green >= min_carpet {
            (gap, end, most) = (0, Some(row - 1), None);
        }
        if gap > max_gap
            && let Some(end) = end
            && gap > *most.get_or_insert_with(|| line_px(end) + 2 * min_carpet)
        {
            break;
        }
        row = row.saturating_sub(stride);
    }
    end
}

/// Adds a point to an upper hull (rows grow downwards) whose points come from left to right. Source: Andrew 1979.
fn push_hull(hull: &mut Vec<(f64, f64)>, point: (f64, f64)) {
    while let [.., a, b] = hull[..] {
        let turn = (b.0 - a.0) * (point.1 - a.1) - (b.1 - a.1) * (point.0 - a.0);
        if turn > 0.0 {
            break;
        }
        hull.pop();
    }
    hull.push(point);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::color::{ColorConfig, GoalColors};

    fn found(carpet_row: impl Fn(u32) -> u32) -> FieldEnd {
        found_where(|x, y| if y >= carpet_row(x) { [60, 140, 80] } else { [150, 150, 150] })
    }

    fn found_where(color: impl Fn(u32, u32) -> [u8; 3]) -> FieldEnd {
        let mut image = RgbImage::new(160, 120);
        for x in 0..160 {
            for y in 0..120 {
                image.set(x, y, color(x, y));
            }
        }
        let mut end = FieldEnd::default();
        let table = ColorTable::new(&ColorConfig::default(), GoalColors::default());
        end.find((&image, &table), 10, 0, |_, row| row / 10);
        end
    }

    #[test]
    fn a_line_before_the_feet_does_not_end_the_field() {
        let rows = |first: u32, last: u32| {
            found_where(move |_, y| if (first..last).contains(&y) { [220; 3] } else { [60, 140, 80] })
        };
        assert!(rows(92, 106).row_px(80.0) < 1.0);
        assert!(rows(32, 46).row_px(80.0) > 45.0, "too thick for a line that is farther away");
        assert!(rows(80, 106).row_px(80.0) > 105.0, "a wall");
    }

    #[test]
    fn straight_border() {
        let end = found(|x| 40 + x / 8);
        for x in [10.0, 80.0, 150.0] {
            assert!((end.row_px(x) - (40.0 + x / 8.0)).abs() < 1.5);
        }
    }

    #[test]
    fn hull_bridges_an_obstacle_on_the_carpet() {
        let end = found(|x| if (60..100).contains(&x) { 90 } else { 50 });
        assert!((end.row_px(80.0) - 50.0).abs() < 1.0);
    }

    #[test]
    fn a_single_green_column_does_not_lift_the_hull() {
        let end = found(|x| if (73..80).contains(&x) { 10 } else { 50 });
        assert!((end.row_px(75.0) - 50.0).abs() < 1.0);
    }

    #[test]
    fn no_carpet_means_everything_is_above_the_end() {
        assert!((found(|_| 200).row_px(80.0) - 120.0).abs() < 1e-9);
    }
}
