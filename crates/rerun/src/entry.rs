//! What is written: shapes at paths.

use crate::Color;

/// A shape at a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Where in the tree of entities, such as `camera/image/kept`.
    pub path: String,
    /// What.
    pub shape: Shape,
    /// Whether it holds for the whole recording.
    pub is_static: bool,
}

impl Entry {
    /// What is there from now on, until something else is written at the path.
    pub fn now(path: impl Into<String>, shape: Shape) -> Self {
        Self { path: path.into(), shape, is_static: false }
    }

    /// What is there the whole time.
    pub fn always(path: impl Into<String>, shape: Shape) -> Self {
        Self { path: path.into(), shape, is_static: true }
    }
}

/// What there is to see. Points of the world are in meters, x and y on the ground, z up; points of images in pixels, whose
/// upper left *corner* is the origin.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// What was there is there no longer.
    Nothing,
    /// The world: z is up.
    UpIsZ,
    /// A camera image as JPEG.
    Jpeg(Vec<u8>),
    /// Dots on an image. `classes` is empty or has a number for each dot, which [`Shape::Classes`] above it in the tree explains.
    Dots {
        /// Places, pixels.
        places: Vec<[f32; 2]>,
        /// Kinds of dots.
        classes: Vec<u16>,
        /// Color, if there are no classes.
        color: Color,
        /// Radius on the screen.
        radius: f32,
    },
    /// Names and colors of kinds of dots, by their number.
    Classes(Vec<(String, Color)>),
    /// Lines on an image.
    Strokes {
        /// Each goes from point to point, pixels.
        strips: Vec<Vec<[f32; 2]>>,
        /// Their color.
        color: Color,
        /// Half of their width on the screen.
        radius: f32,
    },
    /// Balls in the world.
    Points {
        /// Places.
        places: Vec<[f32; 3]>,
        /// Their color.
        color: Color,
        /// How large.
        radius: Radius,
    },
    /// Lines in the world.
    Lines {
        /// Each goes from point to point.
        strips: Vec<Vec<[f32; 3]>>,
        /// One for all, or one for each.
        colors: Vec<Color>,
        /// How thick.
        radius: Radius,
    },
    /// Arrows in the world.
    Arrows {
        /// Where each begins.
        origins: Vec<[f32; 3]>,
        /// From its begin to its end.
        vectors: Vec<[f32; 3]>,
        /// One for all, or one for each.
        colors: Vec<Color>,
        /// How thick.
        radius: Radius,
    },
    /// Triangles in the world.
    Mesh(Mesh),
    /// A value of each curve of a plot; NaN where there is none.
    Values(Vec<f64>),
    /// Names and colors of the curves of a plot.
    Curves(Vec<(String, Color)>),
    /// Something happened.
    Event {
        /// What.
        text: String,
        /// Whether it is good, bad or neither.
        mood: Mood,
    },
    /// A text with Markdown.
    Markdown(String),
}

/// How large a thing is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Radius {
    /// In the world, meters.
    Meters(f32),
    /// On the screen, points.
    Screen(f32),
}

/// What an event means for the algorithm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mood {
    /// It knows its place.
    Good,
    /// It does not.
    Bad,
    /// Somebody else did something.
    Neutral,
}

/// Triangles with colored corners.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Corners.
    pub vertices: Vec<[f32; 3]>,
    /// One for each corner.
    pub colors: Vec<Color>,
    /// Corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Adds a convex polygon.
    pub fn fan(&mut self, corners: &[[f32; 3]], color: Color) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners);
        self.colors.extend(corners.iter().map(|_| color));
        let last = (corners.len() as u32).saturating_sub(1);
        self.triangles.extend((1..last).map(|i| [first, first + i, first + i + 1]));
    }

    /// Adds a straight strip on the ground, at a height.
    pub fn strip(&mut self, from: [f32; 2], to: [f32; 2], width: f32, z: f32, color: Color) {
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let length = dx.hypot(dy).max(1e-6);
        let (nx, ny) = (-dy / length * width / 2.0, dx / length * width / 2.0);
        let corner = |p: [f32; 2], side: f32| [p[0] + side * nx, p[1] + side * ny, z];
        self.fan(&[corner(from, 1.0), corner(from, -1.0), corner(to, -1.0), corner(to, 1.0)], color);
    }

    /// Adds an upright wall.
    pub fn wall(&mut self, from: [f32; 2], to: [f32; 2], height: f32, color: Color) {
        let ([ax, ay], [bx, by]) = (from, to);
        self.fan(&[[ax, ay, 0.0], [bx, by, 0.0], [bx, by, height], [ax, ay, height]], color);
    }
}
