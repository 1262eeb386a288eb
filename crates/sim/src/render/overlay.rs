//! Surfaces that let through what is behind them: nets and shadows.

use super::prepare::Prepared;
use super::raster::{Visible, inverse_depth};
use super::rays::Rays;
use super::shade::shade;
use crate::scene::{Surface, Texture};

/// Lays an overlay over the pixels where nothing opaque is nearer.
pub(super) fn lay_over(
    image: &mut [[f32; 4]],
    prepared: &Prepared,
    (surface, texture): (&Surface, &Texture),
    visible: &Visible,
    rays: &Rays,
) {
    for row in prepared.rows.clone() {
        for column in prepared.columns.clone() {
            let i = row * rays.width + column;
            let (x, y) = (rays.x[i], rays.y[i]);
            let w = inverse_depth(&prepared.local, x, y);
            if w <= visible.inverse_depth[i] {
                continue;
            }
            let color = shade(prepared, surface, texture, (x, y, w), rays.pitch);
            let opacity = color[3];
            for (part, over) in image[i].iter_mut().zip(color) {
                *part += (over - *part) * opacity;
            }
        }
    }
}
