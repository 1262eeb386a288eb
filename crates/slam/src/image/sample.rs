//! Brightness between the pixels.

use visloc_core::GrayImage;

/// Samples a square of `N x N` positions one pixel apart, row by row, between the pixels (bilinear). `left` and `top` are
/// the first position, pixels. `None` if a pixel that is needed lies outside of the image.
#[inline]
pub fn sample_square<const N: usize>(image: &GrayImage, left: f32, top: f32, out: &mut [f32]) -> Option<()> {
    let side = N as f32 + 1.0;
    let is_inside =
        left >= 0.0 && top >= 0.0 && left + side < image.width() as f32 && top + side < image.height() as f32;
    if !is_inside {
        return None;
    }
    let (column, row) = (left as usize, top as usize);
    let (fx, fy) = (left - column as f32, top - row as f32);
    let (w00, w01, w10, w11) = ((1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy);
    for i in 0..N {
        let start = (row + i) * image.width() + column;
        let upper = &image.data()[start..=start + N];
        let lower = &image.data()[start + image.width()..=start + image.width() + N];
        let line = &mut out[i * N..(i + 1) * N];
        for lane in 0..N {
            line[lane] = w00 * f32::from(upper[lane])
                + w01 * f32::from(upper[lane + 1])
                + w10 * f32::from(lower[lane])
                + w11 * f32::from(lower[lane + 1]);
        }
    }
    Some(())
}
