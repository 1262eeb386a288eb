//! What all halves of visloc mean when they say why a run found little.

/// Causes of a smaller share of the images are not told, unless there is no greater one.
pub const NOTABLE_SHARE: f64 = 0.2;
/// Causes that are told at most.
pub const MAX_FINDINGS: usize = 3;
/// Mean brightness of black images, 0 to 255.
pub const BLACK: f64 = 12.0;
/// Mean brightness of overexposed images, 0 to 255.
pub const WHITE: f64 = 245.0;
