//! A camera image with what was found in it.

use std::borrow::Cow;

use visloc_core::RgbImage;

use crate::{
    Color, Picture,
    header::{Header, LegendEntry, Symbol},
    svg::{Canvas, Paint, Point, Rect},
};

const MARGIN_PX: f64 = 24.0;
/// Longest side of the image in a picture, so that what is written beside it can be read and a page can show it.
const MOST_SIDE_PX: f64 = 1280.0;

/// A narrower picture has no room for what is written above it.
const LEAST_HEADER_PX: f64 = 320.0;

/// An image and what is drawn over it. Places are pixels of the image; (0, 0) is the center of its top left pixel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ImagePicture {
    /// Large, at the top.
    pub title: String,
    /// Below the title.
    pub subtitle: String,
    /// The image.
    pub image: RgbImage,
    /// How many times it is enlarged; at least 1 is used, but a large image is made smaller.
    pub enlargement: u32,
    /// Below everything else.
    pub boxes: Vec<ImageBoxes>,
    /// Above the boxes.
    pub lines: Vec<ImageLine>,
    /// Above everything else.
    pub dots: Vec<ImageDots>,
}

/// Upright rectangles of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageBoxes {
    /// In the legend.
    pub label: String,
    /// Of the outline.
    pub color: Color,
    /// Left, top, right, bottom: the outermost pixels that belong to it.
    pub bounds_px: Vec<[u32; 4]>,
}

/// A line through points.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageLine {
    /// In the legend.
    pub label: String,
    /// Of the line.
    pub color: Color,
    /// From one end to the other.
    pub points_px: Vec<(f64, f64)>,
}

/// Single pixels of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageDots {
    /// In the legend.
    pub label: String,
    /// Of the filling.
    pub color: Color,
    /// Diameter, pixels of the image.
    pub diameter_px: f64,
    /// Where.
    pub points_px: Vec<(f64, f64)>,
}

/// The image enlarged without smoothing, and everything over it. Kinds without a single member are left out, of the
/// legend too.
pub fn image_picture(input: &ImagePicture) -> Picture {
    let (width_px, height_px) = (f64::from(input.image.width()), f64::from(input.image.height()));
    let scale = f64::from(input.enlargement.max(1)).min(MOST_SIDE_PX / width_px.max(height_px).max(1.0));
    let right = MARGIN_PX + width_px * scale;
    let header_right = right.max(MARGIN_PX + LEAST_HEADER_PX);
    let header = Header::new((MARGIN_PX, header_right), &input.title, &input.subtitle, legend(input));
    let top = header.height_px() + 10.0;
    let rect = Rect { left: MARGIN_PX, top, right, bottom: top + height_px * scale };
    let mut canvas = Canvas::new(header_right + MARGIN_PX, rect.bottom + MARGIN_PX);
    header.draw(&mut canvas);
    canvas.begin_part("image");
    if let Some(png) = png_of(&smaller(&input.image, (1.0 / scale) as u32)) {
        canvas.png(&rect, &png);
    }
    canvas.end_group();
    canvas.begin_clip(&rect);
    let place = |(x, y): (f64, f64)| (rect.left + (x + 0.5) * scale, rect.top + (y + 0.5) * scale);
    draw_boxes(&mut canvas, input, &rect, scale);
    for line in &input.lines {
        let points: Vec<Point> = line.points_px.iter().map(|point| place(*point)).collect();
        // A dark rim, because the image below may have any color.
        canvas.polyline(&points, &Paint::stroke(Color::BLACK, 4.5).opacity(0.6));
        canvas.polyline(&points, &Paint::stroke(line.color, 2.2));
    }
    for dots in &input.dots {
        let paint = Paint::fill(dots.color).outlined(Color::BLACK, 0.8);
        for point in &dots.points_px {
            canvas.circle(place(*point), 0.5 * dots.diameter_px * scale.max(1.0), &paint);
        }
    }
    canvas.end_group();
    canvas.finish()
}

fn draw_boxes(canvas: &mut Canvas, input: &ImagePicture, rect: &Rect, scale: f64) {
    for boxes in &input.boxes {
        for [left, top, right, bottom] in &boxes.bounds_px {
            let x = |column: u32| rect.left + f64::from(column) * scale;
            let y = |row: u32| rect.top + f64::from(row) * scale;
            let bounds = Rect { left: x(*left), top: y(*top), right: x(right + 1), bottom: y(bottom + 1) };
            canvas.rect(&bounds, &Paint::stroke(Color::BLACK, 4.0).opacity(0.6));
            canvas.rect(&bounds, &Paint::stroke(boxes.color, 2.0));
        }
    }
}

fn legend(input: &ImagePicture) -> Vec<LegendEntry> {
    let dots = input.dots.iter().filter(|dots| !dots.points_px.is_empty());
    let dots = dots.map(|dots| {
        LegendEntry::new(&format!("{} ({})", dots.label, dots.points_px.len()), Symbol::RimmedDot(dots.color))
    });
    let lines = input.lines.iter().filter(|line| line.points_px.len() > 1);
    let lines = lines.filter(|line| !line.label.is_empty());
    let lines = lines.map(|line| LegendEntry::new(&line.label, Symbol::Line(line.color)));
    let boxes = input.boxes.iter().filter(|boxes| !boxes.bounds_px.is_empty());
    let boxes = boxes.map(|boxes| LegendEntry::new(&boxes.label, Symbol::Patch(boxes.color, 0.5)));
    dots.chain(lines).chain(boxes).collect()
}

/// The means of squares of so many pixels a side.
fn smaller(image: &RgbImage, side: u32) -> Cow<'_, RgbImage> {
    if side < 2 {
        return Cow::Borrowed(image);
    }
    let mut small = RgbImage::new(image.width() / side, image.height() / side);
    for (x, y) in (0..small.height()).flat_map(|y| (0..image.width() / side).map(move |x| (x, y))) {
        let mut sums = [0; 3];
        for (i, j) in (0..side).flat_map(|j| (0..side).map(move |i| (i, j))) {
            let px = image.get(side * x + i, side * y + j);
            sums.iter_mut().zip(px).for_each(|(sum, value)| *sum += u32::from(value));
        }
        small.set(x, y, sums.map(|sum| (sum / (side * side)) as u8));
    }
    Cow::Owned(small)
}

/// `None` for an image without pixels.
fn png_of(image: &RgbImage) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width(), image.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().ok()?.write_image_data(image.data()).ok()?;
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> ImagePicture {
        let mut image = RgbImage::new(8, 6);
        for y in 0..6 {
            for x in 0..8 {
                image.set(x, y, if x < 4 { [200, 30, 40] } else { [20, 160, 60] });
            }
        }
        ImagePicture {
            image,
            enlargement: 10,
            dots: vec![
                ImageDots {
                    label: "kept".into(),
                    color: Color::BLUE,
                    diameter_px: 1.0,
                    points_px: vec![(6.0, 4.0)],
                },
                ImageDots {
                    label: "none".into(),
                    color: Color::ORANGE,
                    diameter_px: 1.0,
                    points_px: Vec::new(),
                },
            ],
            ..ImagePicture::default()
        }
    }

    #[cfg(feature = "png")]
    #[test]
    fn pixels_are_sharp_and_dots_are_at_their_centers() {
        let picture = image_picture(&picture());
        let png = picture.png(1.0).unwrap();
        let pixels = resvg::tiny_skia::Pixmap::decode_png(&png).unwrap();
        let top = pixels.height() as f64 - MARGIN_PX - 60.0;
        let color = |x: f64, y: f64| {
            let pixel = pixels.pixel((MARGIN_PX + x) as u32, (top + y) as u32).unwrap();
            [pixel.red(), pixel.green(), pixel.blue()]
        };
        assert_eq!(color(38.0, 2.0), [200, 30, 40]);
        assert_eq!(color(42.0, 2.0), [20, 160, 60]);
        assert_eq!(color(65.0, 45.0), Color::BLUE.parts());
        assert_eq!(color(71.0, 45.0), [20, 160, 60]);
    }

    #[test]
    fn empty_kinds_are_not_in_the_legend() {
        let svg = image_picture(&picture()).svg().to_owned();
        assert!(svg.contains("kept (1)") && !svg.contains("none"));
        let _ = image_picture(&ImagePicture::default());
    }

    #[test]
    fn what_is_written_above_a_narrow_image_fits() {
        let input = ImagePicture {
            title: "100 %: 812 landmarks of the map".into(),
            image: RgbImage::new(36, 64),
            enlargement: 2,
            ..picture()
        };
        let drawn = image_picture(&input);
        let width_px: f64 = drawn.svg().split('"').nth(3).unwrap().parse().unwrap();
        assert!(width_px >= LEAST_HEADER_PX, "{width_px}");
    }

    #[test]
    fn a_large_image_is_made_smaller() {
        let mut image = RgbImage::new(4000, 3000);
        image.data_mut().fill(90);
        let input = ImagePicture { image, dots: picture().dots, ..ImagePicture::default() };
        let drawn = image_picture(&input);
        let width_px: f64 = drawn.svg().split('"').nth(3).unwrap().parse().unwrap();
        assert!(width_px < 1400.0, "{width_px}");
        assert_eq!(smaller(&input.image, 3).get(1332, 999), [90; 3]);
    }
}
