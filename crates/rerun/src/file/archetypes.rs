//! Shapes as what the viewer calls archetypes.

use re_sdk::{AsComponents, RecordingStream, RecordingStreamError};
use re_sdk_types::{
    archetypes::{
        AnnotationContext, Arrows3D, Clear, EncodedImage, LineStrips2D, LineStrips3D, Mesh3D, Points2D,
        Points3D, Scalars, SeriesLines, TextDocument, TextLog, ViewCoordinates,
    },
    components::{ClassId, Color as Rgba, MediaType, Radius as Size, TextLogLevel},
    datatypes::{AnnotationInfo, ClassDescription},
};

use crate::{
    Color, Entry, Shape,
    entry::{Mesh, Mood, Radius},
};

/// Writes an entry at the time that the stream has.
pub(super) fn log(stream: &RecordingStream, entry: Entry) -> Result<(), RecordingStreamError> {
    let write = |thing: &dyn AsComponents| stream.log_with_static(&*entry.path, entry.is_static, thing);
    match entry.shape {
        Shape::Nothing => write(&Clear::flat()),
        Shape::UpIsZ => write(&ViewCoordinates::RIGHT_HAND_Z_UP()),
        Shape::Jpeg(bytes) => write(&EncodedImage::from_file_contents(bytes)),
        Shape::Dots { places, classes, color, radius } => {
            let dots =
                Points2D::new(places).with_radii([Size::new_ui_points(radius)]).with_show_labels(false);
            if classes.is_empty() {
                write(&dots.with_colors([rgba(color)]))
            } else {
                write(&dots.with_class_ids(classes.into_iter().map(ClassId::from)))
            }
        }
        Shape::Classes(classes) => {
            let class = |(id, (name, color)): (u16, (String, Color))| {
                ClassDescription::from(AnnotationInfo {
                    id,
                    label: Some(name.into()),
                    color: Some(color.into()),
                })
            };
            write(&AnnotationContext::new((0..).zip(classes).map(class).collect::<Vec<_>>()))
        }
        Shape::Strokes { strips, color, radius } => write(
            &LineStrips2D::new(strips).with_colors([rgba(color)]).with_radii([Size::new_ui_points(radius)]),
        ),
        Shape::Points { places, color, radius } => {
            write(&Points3D::new(places).with_colors([rgba(color)]).with_radii([size(radius)]))
        }
        Shape::Lines { strips, colors, radius } => {
            write(&LineStrips3D::new(strips).with_colors(rgbas(&colors)).with_radii([size(radius)]))
        }
        Shape::Arrows { origins, vectors, colors, radius } => write(
            &Arrows3D::from_vectors(vectors)
                .with_origins(origins)
                .with_colors(rgbas(&colors))
                .with_radii([size(radius)]),
        ),
        Shape::Mesh(Mesh { vertices, colors, triangles }) => {
            write(&Mesh3D::new(vertices).with_vertex_colors(rgbas(&colors)).with_triangle_indices(triangles))
        }
        Shape::Values(values) => write(&Scalars::new(values)),
        Shape::Curves(curves) => {
            let (names, colors): (Vec<String>, Vec<Color>) = curves.into_iter().unzip();
            write(&SeriesLines::new().with_names(names).with_colors(rgbas(&colors)))
        }
        Shape::Event { text, mood } => {
            let (level, color) = match mood {
                Mood::Good => (TextLogLevel::INFO, Color::TRUE_WAY),
                Mood::Bad => (TextLogLevel::WARN, Color::rgb(0xff_6b_5e)),
                Mood::Neutral => (TextLogLevel::INFO, Color::TRUTH),
            };
            write(&TextLog::new(text).with_level(level).with_color(rgba(color)))
        }
        Shape::Markdown(text) => write(&TextDocument::new(text).with_media_type(MediaType::markdown())),
    }
}

fn rgba(color: Color) -> Rgba {
    let [red, green, blue, opacity] = color.0;
    Rgba::from_unmultiplied_rgba(red, green, blue, opacity)
}

fn rgbas(colors: &[Color]) -> Vec<Rgba> {
    colors.iter().copied().map(rgba).collect()
}

fn size(radius: Radius) -> Size {
    match radius {
        Radius::Meters(meters) => Size::new_scene_units(meters),
        Radius::Screen(points) => Size::new_ui_points(points),
    }
}

impl From<Color> for re_sdk_types::datatypes::Rgba32 {
    fn from(color: Color) -> Self {
        let [red, green, blue, opacity] = color.0;
        Self::from_unmultiplied_rgba(red, green, blue, opacity)
    }
}
