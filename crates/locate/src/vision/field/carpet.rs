//! What the carpet looks like: its brightness and its color, learned from image to image.

use visloc_core::RgbImage;

use crate::vision::{
    color::{CarpetColor, CarpetLearner, ColorClass, ColorTable, FOLLOW, Shares, luma, shares},
    px_in,
};

/// Brightness of a carpet in ordinary light, until some has been seen.
const TYPICAL_LUMA: u32 = 90;
/// Every so many pixels one is looked at, in an image 320 px wide.
pub(in crate::vision) const STEP_PX: u32 = 12;
/// So many green pixels tell the carpet's brightness, and so many near ones its color.
const MIN_LUMA_SAMPLES: u32 = 10;
const MIN_COLOR_SAMPLES: usize = 20;
/// Ground so near is taken for carpet if it is green, meters: boards stand beyond the field.
const NEAR_M: f64 = 2.5;
/// The table is made anew when the color has changed by so much.
const NOTABLE_CHANGE: f64 = 0.004;

/// The image's rows are divided into so many bands, each with its own brightness.
const BANDS: usize = 8;

visloc_core::with_defaults! {
    /// The carpet of late.
    #[derive(Debug)]
    pub(super) struct Carpet {
        luma: u32 = TYPICAL_LUMA,
        /// Brightness in each band of rows from top to bottom, if it is learned.
        band_lumas: [u32; BANDS] = [TYPICAL_LUMA; BANDS],
        learner: CarpetLearner = CarpetLearner::default(),
        learned_in_table: Option<CarpetColor> = None,
        color: Option<Shares> = None,
        /// The color that the table was made with.
        in_table: Option<Shares> = None,
        /// Shares of red and of green of the near pixels.
        samples: [Vec<f32>; 2] = [Vec::new(), Vec::new()],
    }
}

impl Carpet {
    /// Mean brightness, 0 to 255.
    pub fn luma(&self) -> u32 {
        self.luma
    }

    /// Mean brightness around a row of an image that has so many, 0 to 255.
    pub fn luma_at(&self, row: u32, num_rows: u32) -> u32 {
        self.band_lumas[band_of(row, num_rows)]
    }

    /// Looks at a coarse grid of pixels; afterwards only the carpet's own green is green in the table. `ground_m` tells how far
    /// away the ground is that is seen at a pixel. The color is a median: robots in green hide less than half of the carpet.
    pub fn look(
        &mut self,
        image: &RgbImage,
        table: &mut ColorTable,
        ground_m: impl Fn(u32, u32) -> Option<f64>,
    ) {
        if table.is_learned() {
            self.learn(image, table, ground_m);
            return;
        }
        self.samples.iter_mut().for_each(Vec::clear);
        let step = px_in(image.width(), STEP_PX) as usize;
        let (mut sum, mut count) = (0, 0);
        for y in (image.height() / 4..image.height()).step_by(step) {
            for x in (6..image.width()).step_by(step) {
                let rgb = image.get(x, y);
                let [r, g, b] = rgb;
                let class = table.class(r, g, b);
                if class == ColorClass::Green {
                    sum += luma(rgb);
                    count += 1;
                }
                let is_any_green = matches!(class, ColorClass::Green | ColorClass::OtherGreen);
                if is_any_green && ground_m(x, y).is_some_and(|m| m < NEAR_M) {
                    let Shares { red, green } = shares(rgb);
                    self.samples[0].push(red);
                    self.samples[1].push(green);
                }
            }
        }
        if count >= MIN_LUMA_SAMPLES {
            self.luma = sum / count;
        }
        self.band_lumas = [self.luma; BANDS];
        self.follow(table);
    }

    /// Learns the color from the ground near the robot, then the brightness of all that has this color below the horizon.
    fn learn(
        &mut self,
        image: &RgbImage,
        table: &mut ColorTable,
        ground_m: impl Fn(u32, u32) -> Option<f64>,
    ) {
        let step = px_in(image.width(), STEP_PX) as usize;
        let grid = || {
            (0..image.height())
                .step_by(step)
                .flat_map(|y| (6..image.width()).step_by(step).map(move |x| (x, y)))
        };
        self.learner.clear();
        for (x, y) in grid().filter(|(x, y)| ground_m(*x, *y).is_some_and(|m| m < NEAR_M)) {
            self.learner.add(image.get(x, y));
        }
        self.learner.learn();
        let color = self
            .learner
            .color()
            .filter(|now| !self.learned_in_table.is_some_and(|made| made.is_much_like(now)));
        if let Some(color) = color {
            table.follow(color);
            self.learned_in_table = Some(*color);
        }
        let mut bands = [(0, 0); BANDS];
        for (x, y) in grid() {
            let rgb = image.get(x, y);
            if table.class(rgb[0], rgb[1], rgb[2]) == ColorClass::Green {
                let (sum, count) = &mut bands[band_of(y, image.height())];
                *sum += luma(rgb);
                *count += 1;
            }
        }
        let (sum, count) = bands.iter().fold((0, 0), |all, band| (all.0 + band.0, all.1 + band.1));
        if count >= MIN_LUMA_SAMPLES {
            self.luma = sum / count;
        }
        self.band_lumas =
            bands.map(|(sum, count)| if count >= MIN_LUMA_SAMPLES { sum / count } else { self.luma });
    }

    fn follow(&mut self, table: &mut ColorTable) {
        if self.samples[0].len() < MIN_COLOR_SAMPLES {
            return;
        }
        let [red, green] = self.samples.each_mut().map(|all| {
            let middle = all.len() / 2;
            *all.select_nth_unstable_by(middle, f32::total_cmp).1
        });
        let now = Shares { red, green };
        let color = self.color.map_or(now, |before| before.toward(now, FOLLOW));
        self.color = Some(color);
        if self.in_table.is_none_or(|made| made.difference(color) > NOTABLE_CHANGE) {
            table.narrow_green(color);
            self.in_table = Some(color);
        }
    }
}

fn band_of(row: u32, num_rows: u32) -> usize {
    (row as usize * BANDS / num_rows.max(1) as usize).min(BANDS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::color::{ColorConfig, GoalColors};

    const CARPET: [u8; 3] = [60, 118, 68];
    const BOARD: [u8; 3] = [28, 99, 38];

    /// Carpet below row 60, a board above it.
    fn image(carpet: [u8; 3]) -> RgbImage {
        let mut image = RgbImage::new(160, 120);
        for y in 0..120 {
            for x in 0..160 {
                image.set(x, y, if y < 60 { BOARD } else { carpet });
            }
        }
        image
    }

    fn class(table: &ColorTable, [r, g, b]: [u8; 3]) -> ColorClass {
        table.class(r, g, b)
    }

    fn near_below_row_50(_: u32, y: u32) -> Option<f64> {
        (y > 50).then_some(1.0)
    }

    #[test]
    fn a_board_of_another_green_is_no_carpet() {
        let (mut carpet, mut table) =
            (Carpet::default(), ColorTable::new(&ColorConfig::table(), GoalColors::default()));
        assert_eq!([BOARD, CARPET].map(|rgb| class(&table, rgb)), [ColorClass::Green; 2]);
        carpet.look(&image(CARPET), &mut table, near_below_row_50);
        assert_eq!(class(&table, CARPET), ColorClass::Green);
        assert_eq!(class(&table, BOARD), ColorClass::OtherGreen);
        // In the shade it is the same carpet.
        assert_eq!(class(&table, CARPET.map(|v| v / 2)), ColorClass::Green);
        // Nothing near to be seen: what was learned stays.
        carpet.look(&image(BOARD), &mut table, |_, _| None);
        assert_eq!(class(&table, BOARD), ColorClass::OtherGreen);
    }

    #[test]
    fn the_color_follows_the_light() {
        let (mut carpet, mut table) =
            (Carpet::default(), ColorTable::new(&ColorConfig::table(), GoalColors::default()));
        // From 96 on it is yellow rather than green.
        for red in 60..90 {
            let now = [red, 118, 68];
            for _ in 0..5 {
                carpet.look(&image(now), &mut table, near_below_row_50);
            }
            assert_eq!(class(&table, now), ColorClass::Green, "{now:?}");
        }
    }
}
