//! Surfaces that let through what is behind them: nets and shadows.

use super::{
    prepare::Prepared,
    raster::{Visible, inverse_depth},
    rays::Rays,
    shade::{Run, shade_run},
};
use crate::scene::{Surface, Texture};

/// Pixels that are shaded together.
const LONGEST_RUN: usize = 32;

/// Lays an overlay over the pixels where nothing opaque is nearer.
pub(super) fn lay_over(
    image: &mut [[f32; 4]],
    prepared: &Prepared,
    (surface, texture): (&Surface, &Texture),
    visible: &Visible,
    rays: &Rays,
) {
    let mut depths = [0.0_f32; LONGEST_RUN];
    let mut colors = [[0.0_f32; 4]; LONGEST_RUN];
    for row in prepared.rows.clone() {
        let mut next = row * rays.width + prepared.columns.start;
        let end = row * rays.width + prepared.columns.end;
        while next < end {
            // A run of neighbors where the overlay is in front.
            let start = next;
            while next < end && next - start < LONGEST_RUN {
                let (x, y) = (rays.x[next], rays.y[next]);
                let is_hidden = prepared.local.plane_inverse_depth(x, y) <= visible.inverse_depth[next];
                let w = if is_hidden { 0.0 } else { inverse_depth(&prepared.local, x, y) };
                if w <= visible.inverse_depth[next] {
                    break;
                }
                depths[next - start] = w;
                next += 1;
            }
            let len = next - start;
            if len == 0 {
                next += 1;
                continue;
            }
            let run = Run {
                x: &rays.x[start..next],
                y: &rays.y[start..next],
                inverse_depth: &depths[..len],
                pitch: rays.pitch,
            };
            shade_run(prepared, surface, texture, run, &mut colors[..len]);
            for (pixel, over) in image[start..next].iter_mut().zip(&colors) {
                for part in 0..3 {
                    pixel[part] += (over[part] - pixel[part]) * over[3];
                }
            }
        }
    }
}
