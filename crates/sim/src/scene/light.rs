//! Light of area lamps, sampled where the scene is built.

use nalgebra::{Point3, Vector3};
use serde::Deserialize;

use super::Shape;

/// A lamp that shines downwards from a patch of the ceiling.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lamp {
    /// Middle of the patch along x, meters.
    pub x_m: f32,
    /// Middle of the patch along y, meters.
    pub y_m: f32,
    /// Height, meters.
    pub z_m: f32,
    /// Relative strength; only the ratios between the lamps of a scene matter.
    pub power: f32,
}

/// All light of a scene.
#[derive(Debug, Clone, Default)]
pub(crate) struct Light {
    lamps: Vec<Lamp>,
    /// Light from everywhere, as multiple of the mean light of the lamps on the floor.
    ambient: f32,
    /// Makes the mean on the floor 1.
    scale: f32,
}

impl Light {
    /// Light scaled so that its mean over a floor of the given half sizes, meters, is 1.
    pub(crate) fn new(lamps: Vec<Lamp>, ambient: f32, half_floor_m: (f32, f32)) -> Self {
        let steps: Vec<f32> = (-4..=4).map(|i| i as f32 / 4.0).collect();
        let spots = steps.iter().flat_map(|x| steps.iter().map(move |y| (*x, *y)));
        let spots: Vec<_> =
            spots.map(|(x, y)| Point3::new(x * half_floor_m.0, y * half_floor_m.1, 0.0)).collect();
        Self::over(lamps, ambient, &spots)
    }

    /// Light scaled so that its mean over spots of the floor is 1.
    pub(crate) fn over(lamps: Vec<Lamp>, ambient: f32, spots: &[Point3<f32>]) -> Self {
        let mut light = Self { lamps, ambient: 0.0, scale: 1.0 };
        let sum: f32 = spots.iter().map(|spot| light.on(spot, &Vector3::z())).sum();
        let mean = sum / spots.len().max(1) as f32;
        if mean > 0.0 {
            light.scale = 1.0 / (mean * (1.0 + ambient));
            light.ambient = ambient / (1.0 + ambient);
        } else {
            light.ambient = 1.0;
        }
        light
    }

    /// Light on a small surface with a normal, seen from the normal's side.
    pub(crate) fn on(&self, point: &Point3<f32>, normal: &Vector3<f32>) -> f32 {
        let direct: f32 = self.lamps.iter().map(|lamp| toward(lamp, point).dot(normal).max(0.0)).sum();
        // Surfaces that face the ceiling get a little more of the scattered light than those that face the floor.
        self.ambient * (1.0 + 0.15 * normal.z) + direct * self.scale
    }

    /// The light around a point, for round and moving things.
    pub(crate) fn around(&self, point: &Point3<f32>) -> (f32, Vector3<f32>) {
        let sum: Vector3<f32> = self.lamps.iter().map(|lamp| toward(lamp, point)).sum();
        // A sum of directions underestimates the light on slanted sides; the ambient part makes up for it.
        let strength: f32 = self.lamps.iter().map(|lamp| toward(lamp, point).norm()).sum();
        let lost = (strength - sum.norm()).max(0.0) * self.scale;
        (self.ambient + 0.5 * lost, sum * self.scale)
    }
}

/// Direction to a lamp; its length is the light on a surface that faces it. The lamp's own size keeps the light finite
/// and smooth when it is near.
fn toward(lamp: &Lamp, point: &Point3<f32>) -> Vector3<f32> {
    const LAMP_SIZE_M: f32 = 0.6;
    let way = Point3::new(lamp.x_m, lamp.y_m, lamp.z_m) - point;
    let distance2 = way.norm_squared() + LAMP_SIZE_M * LAMP_SIZE_M;
    let distance = distance2.sqrt();
    let downwards = (way.z / distance).max(0.0);
    way * (lamp.power * downwards / (distance2 * distance))
}

/// Light at regular points of a quad.
#[derive(Debug, Clone)]
pub struct LightGrid {
    columns: usize,
    rows: usize,
    values: Vec<f32>,
}

impl LightGrid {
    /// Samples the light over a quad about every 30 cm.
    pub(crate) fn new(light: &Light, shape: &Shape) -> Option<Self> {
        let Shape::Quad { corner, right, down } = shape else { return None };
        let cells = |length_m: f32| ((length_m / 0.3).ceil() as usize).clamp(1, 48) + 1;
        let (columns, rows) = (cells(right.norm()), cells(down.norm()));
        // The side from which the texture is not mirrored.
        let normal = down.cross(right).try_normalize(1e-9)?;
        let mut values = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let (u, v) = (column as f32 / (columns - 1) as f32, row as f32 / (rows - 1) as f32);
                values.push(light.on(&(corner + right * u + down * v), &normal));
            }
        }
        Some(Self { columns, rows, values })
    }

    /// Light at a point given as shares (0 to 1) of width and height.
    #[inline]
    pub(crate) fn at(&self, u: f32, v: f32) -> f32 {
        let x = u.clamp(0.0, 0.9999) * (self.columns - 1) as f32;
        let y = v.clamp(0.0, 0.9999) * (self.rows - 1) as f32;
        let (x0, y0) = (x as usize, y as usize);
        let (fx, fy) = (x - x0 as f32, y - y0 as f32);
        let i = y0 * self.columns + x0;
        let top = self.values[i] + (self.values[i + 1] - self.values[i]) * fx;
        let j = i + self.columns;
        let bottom = self.values[j] + (self.values[j + 1] - self.values[j]) * fx;
        top + (bottom - top) * fy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamp(x_m: f32) -> Lamp {
        Lamp { x_m, y_m: 0.0, z_m: 3.0, power: 5.0 }
    }

    #[test]
    fn mean_on_the_floor_is_one_and_it_is_brighter_below_a_lamp() {
        let light = Light::new(vec![lamp(2.0)], 0.4, (3.0, 2.0));
        let floor = |x| light.on(&Point3::new(x, 0.0, 0.0), &Vector3::z());
        assert!(floor(2.0) > 1.2 && floor(-2.0) < 0.8 && floor(-2.0) > 0.2);
        let dark = Light::new(vec![], 0.4, (3.0, 2.0));
        assert!((dark.on(&Point3::origin(), &Vector3::x()) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn grid_agrees_with_the_light_itself() {
        let light = Light::new(vec![lamp(1.0), lamp(-2.0)], 0.3, (3.0, 2.0));
        let shape = Shape::level((0.0, 0.0), (6.0, 4.0), 0.0);
        let grid = LightGrid::new(&light, &shape).unwrap();
        for (u, v) in [(0.1, 0.2), (0.5, 0.5), (0.93, 0.4)] {
            let point = Point3::new(-3.0 + 6.0 * u, 2.0 - 4.0 * v, 0.0);
            assert!((grid.at(u, v) - light.on(&point, &Vector3::z())).abs() < 0.02);
        }
    }
}
