//! The image and what belongs on it.

use serde_json::Value;
use visloc_studio::Message;

use super::read::{list, numbers, single, tuples};
use crate::{Color, Entry, Shape};

const IMAGE: &str = "camera/image";
/// Classes of dots on the image: two kinds of kept pixels, then all reasons to drop one.
const KEPT: [(&str, Color); 2] =
    [("kept, on the floor", Color::rgb(0xff_ff_ff)), ("kept, upright", Color::rgb(0xff_d4_00))];
const FEATURES: [(&str, &str, Color, f32); 3] = [
    ("missed", "missed", Color::rgb(0xff_5d_5d), 1.4),
    ("candidates", "candidates", Color::rgb(0xff_9f_1c), 2.2),
    ("landmarks", "landmarks", Color::rgb(0x3d_dc_97), 2.2),
];

/// Kinds of dots, for the whole recording.
pub(super) fn classes(scene: &Message) -> Entry {
    let reasons = list(scene.header.get("drop_reasons")).filter_map(Value::as_str);
    let dropped = reasons.zip(Color::DROPPED).map(|(name, color)| (format!("dropped: {name}"), color));
    let kept = KEPT.map(|(name, color)| (name.to_owned(), color));
    Entry::always(IMAGE, Shape::Classes(kept.into_iter().chain(dropped).collect()))
}

/// An image of a robot on a known map.
pub(super) fn robot(image: &Message, lanes: &[String]) -> Vec<Entry> {
    let mut entries = jpeg(image);
    entries.push(dots(image, "dropped", KEPT.len(), 1.2));
    entries.push(dots(image, "kept", 0, 2.6));
    for (i, lane) in lanes.iter().enumerate() {
        let strips = strips(&tuples(image, &format!("theory{i}")).unwrap_or_default());
        let shape = Shape::Strokes { strips, color: Color::lane(i), radius: 1.0 };
        entries.push(Entry::now(format!("{IMAGE}/expected/{lane}"), shape));
    }
    entries.push(horizon(image));
    entries
}

/// An image of a camera without a map.
pub(super) fn features(image: &Message) -> Vec<Entry> {
    let mut entries = jpeg(image);
    for (array, name, color, radius) in FEATURES {
        let places = tuples::<2>(image, array).unwrap_or_default().into_iter().map(center).collect();
        let shape = Shape::Dots { places, classes: Vec::new(), color, radius };
        entries.push(Entry::now(format!("{IMAGE}/{name}"), shape));
    }
    entries
}

fn jpeg(image: &Message) -> Vec<Entry> {
    let bytes = image.bytes("jpeg").map(<[u8]>::to_vec);
    bytes.map(|bytes| Entry::now(IMAGE, Shape::Jpeg(bytes))).into_iter().collect()
}

/// Pixel centers are whole numbers here, and halves in the viewer.
fn center([x, y]: [f32; 2]) -> [f32; 2] {
    [x + 0.5, y + 0.5]
}

fn dots(image: &Message, name: &str, first_class: usize, radius: f32) -> Entry {
    let pixels = tuples::<3>(image, name).unwrap_or_default();
    let places = pixels.iter().map(|[x, y, _]| center([*x, *y])).collect();
    let classes = pixels.iter().map(|[.., kind]| first_class as u16 + *kind as u16).collect();
    Entry::now(format!("{IMAGE}/{name}"), Shape::Dots { places, classes, color: KEPT[0].1, radius })
}

/// Lines out of points, between which pairs of NaN end a line.
fn strips(points: &[[f32; 2]]) -> Vec<Vec<[f32; 2]>> {
    let lines = points.split(|[x, _]| x.is_nan()).filter(|line| line.len() > 1);
    lines.map(|line| line.iter().copied().map(center).collect()).collect()
}

fn horizon(image: &Message) -> Entry {
    let rows = numbers::<2>(image.header.get("horizon"));
    let size = numbers::<2>(image.header.get("size_px"));
    let line = rows.zip(size).map(|([left, right], [width, _])| {
        vec![center([0.0, single(left)]), center([single(width) - 1.0, single(right)])]
    });
    let shape =
        Shape::Strokes { strips: line.into_iter().collect(), color: Color::rgb(0x90_98_a0), radius: 0.5 };
    Entry::now(format!("{IMAGE}/horizon"), shape)
}

#[cfg(test)]
mod tests {
    use serde_json::json;
    use visloc_studio::{MessageBuilder, MessageKind};

    use super::*;

    #[test]
    fn pixels_keep_their_kinds_and_lines_their_ends() {
        let header = json!({ "size_px": [320, 240], "horizon": [10.0, 20.0] });
        let mut message = MessageBuilder::new(MessageKind::Image, &header).unwrap();
        message.bytes("jpeg", &[1, 2, 3]);
        message.floats("kept", [4.0, 5.0, 1.0]);
        message.floats("dropped", [6.0, 7.0, 3.0]);
        message.floats("theory0", [0.0, 0.0, 1.0, 1.0, f64::NAN, f64::NAN, 2.0, 2.0, 3.0, 3.0]);
        let image = Message::read(&message.finish()).unwrap();
        let entries = robot(&image, &["mc".to_owned()]);
        let at = |path: &str| &entries.iter().find(|entry| entry.path == path).unwrap().shape;
        assert_eq!(*at("camera/image"), Shape::Jpeg(vec![1, 2, 3]));
        let Shape::Dots { places, classes, .. } = at("camera/image/kept") else { panic!() };
        assert_eq!((places[0], classes[0]), ([4.5, 5.5], 1));
        let Shape::Dots { classes, .. } = at("camera/image/dropped") else { panic!() };
        assert_eq!(classes[0], 2 + 3);
        let Shape::Strokes { strips, .. } = at("camera/image/expected/mc") else { panic!() };
        assert_eq!(strips.len(), 2);
        let Shape::Strokes { strips, .. } = at("camera/image/horizon") else { panic!() };
        assert_eq!(strips[0], [[0.5, 10.5], [319.5, 20.5]]);
    }
}
