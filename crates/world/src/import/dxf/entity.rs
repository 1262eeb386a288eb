//! Entities of a DXF file and the lines that they draw.

use std::f64::consts::{PI, TAU};

use kurbo::{Affine, Point, Vec2};

use super::pairs::Pair;
use crate::import::drawing::{FLAT_M, Lines, is_far, push_curve};

/// An entity with the numbers that matter.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Entity {
    pub kind: String,
    pub line: Option<usize>,
    pub layer: String,
    /// Name of the block that it shows.
    pub block: String,
    /// Group codes with numbers, in their order.
    pub numbers: Vec<(i32, f64)>,
    /// The vertices of an old polyline: x, y, bulge.
    pub vertices: Vec<[f64; 3]>,
}

impl Entity {
    /// Takes what a pair says of the entity.
    pub fn take(&mut self, pair: &Pair<'_>) -> Result<(), String> {
        match pair.code {
            2 => pair.text().clone_into(&mut self.block),
            8 => pair.text().clone_into(&mut self.layer),
            10 | 11 | 20 | 21 | 40..=45 | 50 | 51 | 60 | 62 | 67 | 70 | 71 | 230 if self.is_read() => {
                self.numbers.push((pair.code, pair.number()?));
            }
            _ => {}
        }
        Ok(())
    }

    /// Whether it draws lines that are read.
    pub fn is_read(&self) -> bool {
        matches!(
            self.kind.as_str(),
            "LINE" | "LWPOLYLINE" | "POLYLINE" | "VERTEX" | "ARC" | "CIRCLE" | "INSERT" | "BLOCK"
        )
    }

    /// The first number with a code.
    pub fn number(&self, code: i32) -> Option<f64> {
        self.numbers.iter().find(|number| number.0 == code).map(|number| number.1)
    }

    /// The number with a code, or else what the format says that it is.
    pub fn or(&self, code: i32, default: f64) -> f64 {
        self.number(code).unwrap_or(default)
    }

    pub fn has_flag(&self, bit: u32) -> bool {
        let flags = self.or(70, 0.0) as i64;
        flags >> bit & 1 == 1
    }

    /// Its (x, y) with codes 10 and 20.
    pub fn place(&self) -> Point {
        Point::new(self.or(10, 0.0), self.or(20, 0.0))
    }

    /// From the entity's own axes to those of the drawing: mirrored ones have their z axis down.
    pub fn axes(&self) -> Affine {
        if self.or(230, 1.0) < 0.0 { Affine::FLIP_X } else { Affine::IDENTITY }
    }

    /// Its lines. The error says what is wrong with it.
    pub fn lines(&self, to_map: Affine) -> Result<Lines, String> {
        let mut lines = Lines::default();
        let closing = self.has_flag(0);
        match self.kind.as_str() {
            "LINE" => {
                let (Some(x), Some(y)) = (self.number(11), self.number(21)) else {
                    return Err("expected two ends (codes 10, 20, 11, 21), found one".to_owned());
                };
                lines.add(&[self.place(), Point::new(x, y)].map(|point| to_map * point))?;
            }
            "ARC" | "CIRCLE" => {
                let (from, to) = (self.or(50, 0.0).to_radians(), self.or(51, 360.0).to_radians());
                let sweep = if self.kind == "CIRCLE" { TAU } else { (to - from).rem_euclid(TAU) };
                let (center, radius) = (self.place(), self.or(40, 0.0));
                let to_map = to_map * self.axes();
                lines.add(&[to_map * on_circle(center, radius, from)])?;
                lines.add_arc(to_map, (center, radius), from, sweep)?;
            }
            _ => {
                let corners = if self.kind == "POLYLINE" { self.vertices.clone() } else { self.corners() };
                let to_map = to_map * self.axes();
                let next = corners.iter().skip(1).chain(corners.first().filter(|_| closing));
                lines.add(
                    &corners
                        .first()
                        .map(|[x, y, _]| to_map * Point::new(*x, *y))
                        .into_iter()
                        .collect::<Vec<_>>(),
                )?;
                for (from, to) in corners.iter().zip(next) {
                    lines.add_side(to_map, from, to)?;
                }
                lines.is_closed = closing;
                // The closing side ends where the first one begins.
                if closing
                    && lines.points.len() > 2
                    && lines.curves.last().is_none_or(|c| c[1] + 1 != lines.points.len())
                {
                    lines.points.pop();
                }
            }
        }
        if lines.points.len() < 2 {
            return Err(format!("expected at least two points, found {}", lines.points.len()));
        }
        Ok(lines)
    }

    /// The corners of a light polyline: x, y, and the bulge of the side that begins there.
    fn corners(&self) -> Vec<[f64; 3]> {
        let mut corners: Vec<[f64; 3]> = Vec::new();
        for (code, number) in &self.numbers {
            match (code, corners.last_mut()) {
                (10, _) => corners.push([*number, 0.0, 0.0]),
                (20, Some(corner)) => corner[1] = *number,
                (42, Some(corner)) => corner[2] = *number,
                _ => {}
            }
        }
        corners
    }
}

impl Lines {
    fn add(&mut self, points: &[Point]) -> Result<(), String> {
        for point in points {
            if is_far(point.x, point.y) {
                let [x, y] = [point.x, point.y];
                return Err(format!(
                    "expected places at most 10000 m from the origin, found ({x}, {y}); is the unit right? Else move the drawing there"
                ));
            }
            self.points.push([point.x, point.y]);
        }
        Ok(())
    }

    /// A side of a polyline: straight, or an arc whose bulge is the tangent of a quarter of its angle.
    fn add_side(&mut self, to_map: Affine, from: &[f64; 3], to: &[f64; 3]) -> Result<(), String> {
        let (a, b) = (Point::new(from[0], from[1]), Point::new(to[0], to[1]));
        let bulge = from[2];
        if bulge.abs() < 1e-9 || !bulge.is_finite() || a.distance(b) == 0.0 {
            return self.add(&[to_map * b]);
        }
        let sweep = 4.0 * bulge.atan();
        let chord = b - a;
        let off = 0.25 * (1.0 / bulge - bulge);
        let center = a.midpoint(b) + off * Vec2::new(-chord.y, chord.x);
        let radius = center.distance(a);
        self.add_arc(to_map, (center, radius), (a - center).atan2(), sweep)
    }

    /// An arc from where the lines end.
    fn add_arc(
        &mut self,
        to_map: Affine,
        (center, radius): (Point, f64),
        from_rad: f64,
        sweep_rad: f64,
    ) -> Result<(), String> {
        /// A circle of the largest radius has enough with so many.
        const MAX_STEPS: f64 = 2000.0;
        let [a, b, c, d, ..] = to_map.as_coeffs();
        let radius_m = radius * a.hypot(b).max(c.hypot(d));
        let step_rad = 2.0 * (1.0 - FLAT_M / radius_m.max(FLAT_M)).clamp(-1.0, 1.0).acos();
        let steps = (sweep_rad.abs() / step_rad).ceil().clamp(2.0, MAX_STEPS);
        let count = if steps.is_finite() { steps as usize } else { 2 };
        let at =
            |i: usize| to_map * on_circle(center, radius, from_rad + sweep_rad * i as f64 / count as f64);
        let mut arc = Lines::default();
        arc.add(&(1..=count).map(at).collect::<Vec<_>>())?;
        push_curve(&mut self.points, &mut self.curves, &arc.points);
        Ok(())
    }
}

fn on_circle(center: Point, radius: f64, angle_rad: f64) -> Point {
    let (sin, cos) = (angle_rad % (2.0 * PI)).sin_cos();
    Point::new(center.x + radius * cos, center.y + radius * sin)
}
