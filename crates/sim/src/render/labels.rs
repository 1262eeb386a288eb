//! What every pixel of a picture shows.

use nalgebra::{Matrix3, Point2, Point3, Vector3};

use crate::scene::{GroundMark, Label};

/// The label of every pixel, rows from top to bottom. A pixel has the label of what its center shows; nets and shadows,
/// through which one sees, have none.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LabelImage {
    width: u32,
    height: u32,
    labels: Vec<Label>,
}

impl LabelImage {
    pub(super) fn new(width: usize, height: usize, labels: Vec<Label>) -> Self {
        Self { width: width as u32, height: height as u32, labels }
    }

    /// Width, pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All labels, row by row.
    pub fn labels(&self) -> &[Label] {
        &self.labels
    }

    /// What a pixel shows; `None` outside the image.
    pub fn get(&self, x: i64, y: i64) -> Option<Label> {
        let is_inside = (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y);
        is_inside.then(|| self.labels[y as usize * self.width as usize + x as usize])
    }

    /// How many pixels show something.
    pub fn count(&self, label: Label) -> usize {
        self.labels.iter().filter(|other| **other == label).count()
    }
}

/// Tells lines from carpet: the point of the floor that a ray meets.
pub(super) struct Floor<'a> {
    pub(super) marks: &'a [GroundMark],
    pub(super) world_from_camera: Matrix3<f32>,
    pub(super) camera_in_world: Point3<f32>,
}

impl Floor<'_> {
    /// What a pixel of the carpet shows, for its ray (x, y, 1).
    pub(super) fn label(&self, x: f32, y: f32) -> Label {
        let ray = (self.world_from_camera * Vector3::new(x, y, 1.0)).cast::<f64>();
        let eye = self.camera_in_world.cast::<f64>();
        let reach = -eye.z / ray.z;
        let point = Point2::new(eye.x + reach * ray.x, eye.y + reach * ray.y);
        let is_painted = self.marks.iter().any(|mark| mark.distance_m(&point) < 0.0);
        if is_painted { Label::Line } else { Label::Carpet }
    }
}
