//! Writes SVG elements. Coordinates are pixels at scale 1 with the origin at the top left, y down.

use std::fmt::Write;

use crate::{
    Color, Picture,
    font::{self, Weight},
    picture::MARK,
};

/// A point of the picture, pixels.
pub(crate) type Point = (f64, f64);

/// An axis-parallel rectangle of the picture, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rect {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

impl Rect {
    pub(crate) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(crate) fn height(&self) -> f64 {
        self.bottom - self.top
    }
}

/// How a shape is filled and outlined.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Paint {
    fill: Option<Color>,
    stroke: Option<(Color, f64)>,
    dashes: Option<&'static str>,
    opacity: f64,
}

impl Paint {
    pub(crate) fn fill(color: Color) -> Self {
        Self { fill: Some(color), stroke: None, dashes: None, opacity: 1.0 }
    }

    pub(crate) fn stroke(color: Color, width_px: f64) -> Self {
        Self { fill: None, stroke: Some((color, width_px)), dashes: None, opacity: 1.0 }
    }

    pub(crate) fn outlined(self, color: Color, width_px: f64) -> Self {
        Self { stroke: Some((color, width_px)), ..self }
    }

    pub(crate) fn dashed(self) -> Self {
        self.with_dashes("6 4")
    }

    /// With lengths of lines and gaps, pixels, as SVG writes them.
    pub(crate) fn with_dashes(self, dashes: &'static str) -> Self {
        Self { dashes: Some(dashes), ..self }
    }

    pub(crate) fn opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }
}

/// Where the given point lies on a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// How text is set.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TextStyle {
    pub(crate) size_px: f64,
    pub(crate) weight: Weight,
    pub(crate) color: Color,
    pub(crate) anchor: Anchor,
}

impl TextStyle {
    pub(crate) fn new(size_px: f64, color: Color) -> Self {
        Self { size_px, weight: Weight::Regular, color, anchor: Anchor::Start }
    }

    pub(crate) fn bold(self) -> Self {
        Self { weight: Weight::Bold, ..self }
    }

    pub(crate) fn anchor(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }
}

/// A picture in the making.
#[derive(Debug)]
pub(crate) struct Canvas {
    width_px: f64,
    height_px: f64,
    body: String,
    num_clips: usize,
}

impl Canvas {
    /// A white picture.
    pub(crate) fn new(width_px: f64, height_px: f64) -> Self {
        let mut canvas = Self { width_px, height_px, body: String::new(), num_clips: 0 };
        let all = Rect { left: 0.0, top: 0.0, right: width_px, bottom: height_px };
        canvas.rect(&all, &Paint::fill(Color::WHITE));
        canvas
    }

    pub(crate) fn rect(&mut self, rect: &Rect, paint: &Paint) {
        let (x, y) = (number(rect.left), number(rect.top));
        let (width, height) = (number(rect.width().max(0.0)), number(rect.height().max(0.0)));
        self.element(&format!("rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\""), paint);
    }

    pub(crate) fn circle(&mut self, center: Point, radius: f64, paint: &Paint) {
        let (x, y, r) = (number(center.0), number(center.1), number(radius));
        self.element(&format!("circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\""), paint);
    }

    pub(crate) fn line(&mut self, start: Point, end: Point, paint: &Paint) {
        self.path(&format!("M{}L{}", pair(start), pair(end)), paint);
    }

    /// An open line through all points; fewer than two points draw nothing.
    pub(crate) fn polyline(&mut self, points: &[Point], paint: &Paint) {
        if points.len() >= 2 {
            self.path(&path_data(points), paint);
        }
    }

    pub(crate) fn polygon(&mut self, points: &[Point], paint: &Paint) {
        self.path(&format!("{}Z", path_data(points)), paint);
    }

    /// A path from SVG path data.
    pub(crate) fn path(&mut self, data: &str, paint: &Paint) {
        self.element(&format!("path d=\"{data}\""), paint);
    }

    /// A PNG, enlarged to fill `rect` with its pixels as sharp squares.
    pub(crate) fn png(&mut self, rect: &Rect, png: &[u8]) {
        let (x, y) = (number(rect.left), number(rect.top));
        let (width, height) = (number(rect.width()), number(rect.height()));
        let data = base64(png);
        self.raw(&format!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" image-rendering=\"optimizeSpeed\" \
             style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{data}\"/>\n"
        ));
    }

    /// One line of text with its baseline at `at`.
    pub(crate) fn text(&mut self, at: Point, text: &str, style: &TextStyle) {
        let place = format!("x=\"{}\" y=\"{}\"", number(at.0), number(at.1));
        self.text_element(&place, text, style);
    }

    /// Text that runs upwards.
    pub(crate) fn vertical_text(&mut self, at: Point, text: &str, style: &TextStyle) {
        let place = format!("transform=\"translate({}) rotate(-90)\"", pair(at));
        self.text_element(&place, text, style);
    }

    /// Everything until [`Canvas::end_group`] is only visible inside `rect`.
    pub(crate) fn begin_clip(&mut self, rect: &Rect) {
        let id = self.num_clips;
        self.num_clips += 1;
        let (x, y) = (number(rect.left), number(rect.top));
        let (width, height) = (number(rect.width().max(0.0)), number(rect.height().max(0.0)));
        self.raw(&format!(
            "<clipPath id=\"c{id}\"><rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/></clipPath>\n\
             <g clip-path=\"url(#c{id})\">\n"
        ));
    }

    /// Everything until [`Canvas::end_group`] belongs to the named part of the picture.
    pub(crate) fn begin_part(&mut self, class: &str) {
        self.raw(&format!("<g class=\"{class}\">\n"));
    }

    /// Everything until [`Canvas::end_group`] lets the background through, evenly where shapes overlap.
    pub(crate) fn begin_faded(&mut self, opacity: f64) {
        self.raw(&format!("<g opacity=\"{}\">\n", number(opacity)));
    }

    pub(crate) fn end_group(&mut self) {
        self.raw("</g>\n");
    }

    pub(crate) fn finish(self) -> Picture {
        let (width, height) = (number(self.width_px), number(self.height_px));
        let body = self.body;
        Picture::new(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{}\">{MARK}\n{body}</svg>\n",
            font::FAMILIES
        ))
    }

    fn text_element(&mut self, place: &str, text: &str, style: &TextStyle) {
        let anchor = match style.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let weight = match style.weight {
            Weight::Regular => "",
            Weight::Bold => " font-weight=\"bold\"",
        };
        let (size, color, text) = (number(style.size_px), style.color, escape(text));
        self.raw(&format!(
            "<text {place} font-size=\"{size}\" fill=\"{color}\"{anchor}{weight}>{text}</text>\n"
        ));
    }

    fn element(&mut self, start: &str, paint: &Paint) {
        let mut end = match paint.fill {
            Some(color) => format!(" fill=\"{color}\""),
            None => " fill=\"none\"".to_owned(),
        };
        if let Some((color, width_px)) = paint.stroke {
            end += &format!(" stroke=\"{color}\" stroke-width=\"{}\"", number(width_px));
            end += " stroke-linejoin=\"round\"";
        }
        if let Some(dashes) = paint.dashes {
            end += &format!(" stroke-dasharray=\"{dashes}\"");
        }
        if paint.opacity < 1.0 {
            end += &format!(" opacity=\"{}\"", number(paint.opacity));
        }
        self.raw(&format!("<{start}{end}/>\n"));
    }

    fn raw(&mut self, text: &str) {
        self.body.push_str(text);
    }
}

/// Points closer together than this are one point for the eye, pixels.
const MERGE_PX: f64 = 0.3;

fn path_data(points: &[Point]) -> String {
    let mut data = String::new();
    let mut last: Option<Point> = None;
    for (i, &point) in points.iter().enumerate() {
        let is_end = i + 1 == points.len();
        let is_near = last.is_some_and(|(x, y)| (x - point.0).hypot(y - point.1) < MERGE_PX);
        if is_near && !is_end {
            continue;
        }
        // writing to a string cannot fail
        let _ = write!(data, "{}{}", if last.is_some() { 'L' } else { 'M' }, pair(point));
        last = Some(point);
    }
    data
}

pub(crate) fn pair(point: Point) -> String {
    format!("{} {}", number(point.0), number(point.1))
}

/// At most two decimals, never in exponent notation; far values and not a number become large values.
pub(crate) fn number(value: f64) -> String {
    let value = if value.is_nan() { -1e5 } else { value.clamp(-1e5, 1e5) };
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Replaces what XML gives a meaning and drops the characters that it forbids.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '\u{fffe}' | '\u{ffff}' => {}
            c if c.is_control() => {}
            c => escaped.push(c),
        }
    }
    escaped
}

/// Bytes as text of letters, digits, + and /, padded with =. Source: RFC 4648, section 4.
pub fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let value = (0..3).fold(0_u32, |value, i| value << 8 | u32::from(group.get(i).copied().unwrap_or(0)));
        for i in 0..4 {
            let is_padding = i > group.len();
            let letter = LETTERS[(value >> (18 - 6 * i)) as usize & 63];
            text.push(if is_padding { '=' } else { char::from(letter) });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_standard() {
        let texts = ["", "f", "fo", "foo", "foob", "fooba", "foobar"];
        let codes = ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"];
        for (text, code) in texts.iter().zip(codes) {
            assert_eq!(base64(text.as_bytes()), code);
        }
    }

    #[test]
    fn numbers_are_short_and_finite() {
        assert_eq!(number(1.0), "1");
        assert_eq!(number(-0.001), "0");
        assert_eq!(number(100.254), "100.25");
        assert_eq!(number(f64::INFINITY), "100000");
        assert_eq!(number(f64::NAN), "-100000");
    }

    #[test]
    fn near_points_are_merged_but_ends_are_kept() {
        let points: Vec<Point> = (0..=1000).map(|i| (f64::from(i) * 0.01, 0.0)).collect();
        let data = path_data(&points);
        assert!(data.starts_with("M0 0L") && data.ends_with("L10 0"), "{data}");
        assert!(data.matches('L').count() < 40);
    }

    #[test]
    fn text_cannot_break_the_xml() {
        assert_eq!(escape("a<b>&\u{1}c"), "a&lt;b&gt;&amp;c");
    }
}
