//! How well a patch can be followed.

use visloc_core::GrayImage;

/// Half the side of the window, pixels.
const HALF: usize = 4;
/// Pixels needed around a corner.
pub const MARGIN_PX: usize = HALF + 1;

/// Smaller eigenvalue of the mean structure tensor of the 8 x 8 px window around a pixel, (gray levels per pixel)^2;
/// 0 too close to the border.
///
/// Source: Shi and Tomasi, "Good features to track", 1994.
#[must_use]
pub fn shi_tomasi_score(image: &GrayImage, x: usize, y: usize) -> f32 {
    if x < MARGIN_PX || y < MARGIN_PX || x + MARGIN_PX >= image.width() || y + MARGIN_PX >= image.height() {
        return 0.0;
    }
    let (mut xx, mut xy, mut yy) = (0_i32, 0_i32, 0_i32);
    for row in y - HALF..y + HALF {
        let columns = x - HALF..x + HALF;
        let up = &image.row(row - 1)[columns.clone()];
        let down = &image.row(row + 1)[columns.clone()];
        let middle = &image.row(row)[x - HALF - 1..=x + HALF];
        for i in 0..2 * HALF {
            let dx = i32::from(middle[i + 2]) - i32::from(middle[i]);
            let dy = i32::from(down[i]) - i32::from(up[i]);
            xx += dx * dx;
            xy += dx * dy;
            yy += dy * dy;
        }
    }
    // Gradients are taken over two pixels.
    let scale = 0.25 / (4 * HALF * HALF) as f32;
    let (xx, xy, yy) = (xx as f32 * scale, xy as f32 * scale, yy as f32 * scale);
    0.5 * (xx + yy - ((xx - yy).powi(2) + 4.0 * xy * xy).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_score_edges_and_planes_do_not() {
        let mut image = GrayImage::new(40, 40);
        for y in 20..40 {
            for x in 20..40 {
                image.data_mut()[y * 40 + x] = 200;
            }
        }
        assert!(shi_tomasi_score(&image, 20, 20) > 100.0);
        assert_eq!(shi_tomasi_score(&image, 20, 30), 0.0);
        assert_eq!(shi_tomasi_score(&image, 10, 10), 0.0);
        assert_eq!(shi_tomasi_score(&image, 0, 39), 0.0);
    }
}
