//! Which surface a color belongs to.

/// What a pixel's color says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceClass {
    /// None of the known surfaces, or too dark to tell.
    Unknown,
    /// Wall.
    Wall,
    /// Floor.
    Floor,
    /// Door of one of the map's colors, by index.
    Door(u8),
}

/// Colors of a building's surfaces in white light, red, green, blue.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OfficeColors {
    /// Of the walls.
    pub wall: [u8; 3],
    /// Of the floor.
    pub floor: [u8; 3],
    /// Of the doors.
    pub doors: Vec<[u8; 3]>,
}

/// Hues this far from a surface's own still belong to it, degrees.
const MAX_HUE_OFF_DEG: f64 = 28.0;
/// A color counts as gray up to this saturation ...
const MAX_GRAY_SATURATION: f64 = 0.36;
/// ... and as that of a colorful surface from this share of the surface's own saturation on.
const MIN_SATURATION_SHARE: f64 = 0.55;
/// Darker colors tell nothing; brightness is the largest of red, green and blue.
const MIN_BRIGHTNESS: f64 = 22.0;
/// Reference surfaces below this saturation are gray.
const GRAY_SURFACE_SATURATION: f64 = 0.3;

/// Bits of each channel that the table tells apart.
const BITS: u32 = 5;

/// The class of every color, as a table.
///
/// Hue and saturation hardly change with brightness, so a surface keeps its class where light changes along a corridor.
#[derive(Debug, Clone)]
pub struct OfficeTable {
    classes: Vec<SurfaceClass>,
}

impl OfficeTable {
    /// The table of a building.
    pub fn new(colors: &OfficeColors) -> Self {
        let mut surfaces = vec![
            Surface::new(SurfaceClass::Wall, colors.wall),
            Surface::new(SurfaceClass::Floor, colors.floor),
        ];
        for (paint, rgb) in (0..=u8::MAX).zip(&colors.doors) {
            surfaces.push(Surface::new(SurfaceClass::Door(paint), *rgb));
        }
        let count = 1_u32 << (3 * BITS);
        let middle = |code: u32, shift: u32| {
            let step = 8 - BITS;
            (((code >> shift) & ((1 << BITS) - 1)) << step) as u8 + (1 << (step - 1))
        };
        let class = |code: u32| {
            let rgb = [middle(code, 2 * BITS), middle(code, BITS), middle(code, 0)];
            classify(&surfaces, rgb)
        };
        Self { classes: (0..count).map(class).collect() }
    }

    /// Class of a color.
    #[inline]
    pub fn class(&self, rgb: [u8; 3]) -> SurfaceClass {
        let [r, g, b] = rgb.map(|value| usize::from(value) >> (8 - BITS));
        self.classes[(r << (2 * BITS)) | (g << BITS) | b]
    }
}

struct Surface {
    class: SurfaceClass,
    hue_deg: f64,
    saturation: f64,
}

impl Surface {
    fn new(class: SurfaceClass, rgb: [u8; 3]) -> Self {
        let (hue_deg, saturation, _) = visloc_core::hue_saturation_brightness(rgb);
        Self { class, hue_deg, saturation }
    }

    fn is_gray(&self) -> bool {
        self.saturation < GRAY_SURFACE_SATURATION
    }
}

fn classify(surfaces: &[Surface], rgb: [u8; 3]) -> SurfaceClass {
    let (hue_deg, saturation, brightness) = visloc_core::hue_saturation_brightness(rgb);
    if brightness < MIN_BRIGHTNESS {
        return SurfaceClass::Unknown;
    }
    let hue_off = |surface: &Surface| {
        let off = (surface.hue_deg - hue_deg).rem_euclid(360.0);
        off.min(360.0 - off)
    };
    let colorful = surfaces.iter().filter(|surface| {
        !surface.is_gray()
            && saturation >= MIN_SATURATION_SHARE * surface.saturation
            && hue_off(surface) <= MAX_HUE_OFF_DEG
    });
    if let Some(nearest) = colorful.min_by(|a, b| hue_off(a).total_cmp(&hue_off(b))) {
        return nearest.class;
    }
    let gray = surfaces.iter().find(|surface| surface.is_gray() && saturation <= MAX_GRAY_SATURATION);
    gray.map_or(SurfaceClass::Unknown, |surface| surface.class)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_keep_their_class_from_a_tenth_of_the_light_to_full_light() {
        let colors = OfficeColors {
            wall: [235, 234, 228],
            floor: [216, 181, 58],
            doors: vec![[176, 39, 31], [36, 76, 168]],
        };
        let table = OfficeTable::new(&colors);
        for percent in [15, 30, 60, 100] {
            let lit = |rgb: [u8; 3]| rgb.map(|value| (u32::from(value) * percent / 100) as u8);
            assert_eq!(table.class(lit(colors.wall)), SurfaceClass::Wall, "{percent} %");
            assert_eq!(table.class(lit(colors.floor)), SurfaceClass::Floor, "{percent} %");
            assert_eq!(table.class(lit(colors.doors[0])), SurfaceClass::Door(0), "{percent} %");
            assert_eq!(table.class(lit(colors.doors[1])), SurfaceClass::Door(1), "{percent} %");
        }
        assert_eq!(table.class([3, 2, 4]), SurfaceClass::Unknown);
    }
}
