//! Small pieces of images: taken, warped, compared and aligned.

mod align;
mod score;
mod warp;

pub use align::{AlignLimits, Aligned, align};
pub use score::SearchPatch;
pub use warp::{PatchWarp, Template, WarpGeometry};

/// Side of a patch, pixels.
pub const PATCH_PX: usize = 8;
/// Side of a patch with a border of one pixel, for gradients.
pub const BORDERED_PX: usize = PATCH_PX + 2;
/// From the top-left pixel of a patch to its center, pixels: a patch covers the pixels -4 to 3 around its center.
pub const HALF_PX: usize = PATCH_PX / 2;
