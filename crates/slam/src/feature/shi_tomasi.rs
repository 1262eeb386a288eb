//! How well a patch can be followed.

use visloc_core::GrayImage;

/// Half the side of the window, pixels.
const HALF: usize = 4;
/// Side of the window, pixels.
const SIDE: usize = 2 * HALF;
/// Pixels of the window.
const NUM: usize = SIDE * SIDE;
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
    let width = image.width();
    let window = &image.data()[(y - HALF - 1) * width + x - HALF - 1..];
    let (mut dx, mut dy) = ([0_i16; NUM], [0_i16; NUM]);
    for (row, (dx, dy)) in dx.chunks_exact_mut(SIDE).zip(dy.chunks_exact_mut(SIDE)).enumerate() {
        let up = &window[row * width + 1..][..SIDE];
        let middle = &window[(row + 1) * width..][..SIDE + 2];
        let down = &window[(row + 2) * width + 1..][..SIDE];
        for i in 0..SIDE {
            dx[i] = i16::from(middle[i + 2]) - i16::from(middle[i]);
            dy[i] = i16::from(down[i]) - i16::from(up[i]);
        }
    }
    let (xx, xy, yy) = (dot(&dx, &dx), dot(&dx, &dy), dot(&dy, &dy));
    // Gradients are taken over two pixels.
    let scale = 0.25 / NUM as f32;
    let (xx, xy, yy) = (xx as f32 * scale, xy as f32 * scale, yy as f32 * scale);
    0.5 * (xx + yy - ((xx - yy).powi(2) + 4.0 * xy * xy).sqrt())
}

/// Sum of products, in the form that the compiler makes the instruction of that multiplies pairs and adds them.
#[inline]
fn dot(a: &[i16; NUM], b: &[i16; NUM]) -> i32 {
    a.iter().zip(b).map(|(a, b)| i32::from(*a) * i32::from(*b)).sum()
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
