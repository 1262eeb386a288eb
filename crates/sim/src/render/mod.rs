//! From a scene and a camera pose to an image, on the processor.
//!
//! `rays` holds the direction of every pixel (so any lens works), `prepare` moves surfaces to the camera frame and
//! bounds them on the screen, `raster` finds the nearest surface of each pixel, `shade` colors it, `overlay` lays nets
//! and shadows over it, `blur` and `sensor` make a photograph of it. `labels` says what each pixel shows.

mod blur;
mod labels;
mod overlay;
mod prepare;
mod raster;
mod rays;
mod renderer;
mod sensor;
mod shade;

pub use blur::CameraMotion;
pub use labels::LabelImage;
pub use renderer::{Renderer, Shot};
pub use sensor::Sensor;
