//! Scan lines: straight walks over the image that collect runs of one color class.

use visloc_core::{RgbImage, geom::Horizon};

use super::FieldAnalysisConfig;
use crate::vision::{
    blur_px,
    color::{ColorClass, ColorTable, luma},
    px_in,
};

/// Until some carpet has been passed its brightness deviates by this part of it.
const TYPICAL_ROUGHNESS: u32 = 20;

/// Direction of a scan line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// Along a row, to the right.
    Horizontal,
    /// Along a column, downwards.
    Vertical,
}

/// A walk over part of a row or column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ScanLine {
    pub direction: Direction,
    /// The row (horizontal) or column (vertical).
    pub fixed: u32,
    /// First position along the line.
    pub from: u32,
    /// End of the line, exclusive.
    pub to: u32,
    /// Distance to the next parallel line, pixels: how much of the image the line stands for.
    pub spacing: u32,
}

impl ScanLine {
    /// Pixel at a position along the line.
    #[inline]
    pub fn pixel(&self, position: u32) -> (u32, u32) {
        match self.direction {
            Direction::Horizontal => (position, self.fixed),
            Direction::Vertical => (self.fixed, position),
        }
    }
}

/// Neighboring pixels of one class along a scan line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Run {
    pub class: ColorClass,
    /// First position along the line.
    pub start: u32,
    /// One after the last position.
    pub end: u32,
    /// Brightness of the carpet beside this run, 0 to 255.
    pub green_luma: u32,
    /// Brightness that is white there.
    pub white_luma: u32,
}

/// The scan lines of one image: dense where the ground is far away, sparse near the robot.
pub(super) fn layout(
    config: &FieldAnalysisConfig,
    size_px: (u32, u32),
    horizon: &Horizon,
    lines: &mut Vec<ScanLine>,
) {
    lines.clear();
    let (width, height) = size_px;
    let horizon_row = horizon_row(horizon, size_px);
    let step = px_in(width, config.column_step_px);
    let far_end = (horizon_row + height / 3).min(height);
    for (i, column) in (step / 4..width).step_by((step as usize / 2).max(1)).enumerate() {
        let to = if i % 2 == 0 { height } else { far_end };
        let from = if i % 2 == 0 { 0 } else { horizon_row };
        if to > from {
            lines.push(ScanLine {
                direction: Direction::Vertical,
                fixed: column,
                from,
                to,
                spacing: step / 2,
            });
        }
    }
    let (min_step, max_step) = (px_in(width, config.min_row_step_px), px_in(width, config.max_row_step_px));
    let mut row = 0;
    while row < height {
        let spacing = if row < horizon_row {
            max_step.min((horizon_row - row).max(min_step))
        } else {
            (min_step + (row - horizon_row) / 16).min(max_step)
        };
        lines.push(ScanLine { direction: Direction::Horizontal, fixed: row, from: 0, to: width, spacing });
        row += spacing.max(1);
    }
}

/// Row of the horizon in the middle of the image, clamped to the image.
pub(super) fn horizon_row(horizon: &Horizon, size_px: (u32, u32)) -> u32 {
    let row = horizon.row_px(f64::from(size_px.0) / 2.0).unwrap_or(0.0);
    row.clamp(0.0, f64::from(size_px.1)) as u32
}

/// Walks along a line. `carpet_luma` is what the carpet's brightness is taken for until some carpet has been passed.
pub(super) fn scan_line(
    image: &RgbImage,
    table: &ColorTable,
    line: &ScanLine,
    carpet_luma: u32,
    runs: &mut Vec<Run>,
) {
    runs.clear();
    if line.from >= line.to {
        return;
    }
    let width = image.width() as usize;
    let at = |position: u32| {
        let (x, y) = line.pixel(position);
        y as usize * width + x as usize
    };
    // One pixel of those that blur into one suffices.
    let stride_px = blur_px(image.width());
    let stride = stride_px as usize * if line.direction == Direction::Horizontal { 1 } else { width };
    let mut carpet = NearbyCarpet::new(table, carpet_luma);
    let mut open = None;
    let mut position = line.from;
    for pixels in image.pixels()[at(line.from)..=at(line.to - 1)].chunks(stride) {
        let class = carpet.class(pixels[0]);
        if open != Some(class) {
            open = Some(class);
            if let Some(last) = runs.last_mut() {
                last.end = position;
            }
            let (green_luma, white_luma) = (carpet.luma_16 / 16, carpet.white_threshold());
            runs.push(Run { class, start: position, end: line.to, green_luma, white_luma });
        }
        position += stride_px;
    }
}

/// The carpet as it is followed along a line: white is judged against the carpet nearby.
struct NearbyCarpet<'a> {
    table: &'a ColorTable,
    /// Brightness and its mean deviation, in 1/16.
    luma_16: u32,
    deviation_16: u32,
    /// Brightness that is white; not known while more carpet has been passed than it was made of.
    white_threshold: Option<u32>,
}

impl<'a> NearbyCarpet<'a> {
    fn new(table: &'a ColorTable, luma: u32) -> Self {
        let (luma_16, deviation_16) = (luma * 16, luma * 16 / TYPICAL_ROUGHNESS);
        Self { table, luma_16, deviation_16, white_threshold: Some(table.white_threshold(luma)) }
    }

    /// Class of the next color on the way.
    #[inline]
    fn class(&mut self, rgb: [u8; 3]) -> ColorClass {
        let class = self.table.class_beside(rgb, || self.white_threshold());
        if class == ColorClass::Green {
            let luma_16 = luma(rgb) * 16;
            self.deviation_16 =
                self.deviation_16 - self.deviation_16 / 16 + luma_16.abs_diff(self.luma_16) / 16;
            self.luma_16 = self.luma_16 - self.luma_16 / 8 + luma_16 / 8;
            self.white_threshold = None;
        }
        class
    }

    /// Worked out only when it is asked for: most carpet is followed by carpet.
    #[inline]
    fn white_threshold(&mut self) -> u32 {
        let (table, luma, deviation_16) = (self.table, self.luma_16 / 16, self.deviation_16);
        *self.white_threshold.get_or_insert_with(|| table.white_threshold_beside(luma, deviation_16))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::color::{ColorConfig, GoalColors};

    const GREEN: [u8; 3] = [60, 140, 80];
    const WHITE: [u8; 3] = [230, 232, 228];

    fn classes(image: &RgbImage, line: &ScanLine) -> Vec<(ColorClass, u32, u32)> {
        let mut runs = Vec::new();
        scan_line(
            image,
            &ColorTable::new(&ColorConfig::default(), GoalColors::default()),
            line,
            100,
            &mut runs,
        );
        runs.iter().map(|run| (run.class, run.start, run.end)).collect()
    }

    #[test]
    fn runs_along_a_row_and_a_column() {
        let mut image = RgbImage::new(20, 10);
        for y in 0..10 {
            for x in 0..20 {
                image.set(x, y, if (8..11).contains(&x) { WHITE } else { GREEN });
            }
        }
        let row = ScanLine { direction: Direction::Horizontal, fixed: 4, from: 0, to: 20, spacing: 1 };
        let (green, white) = (ColorClass::Green, ColorClass::White);
        assert_eq!(classes(&image, &row), [(green, 0, 8), (white, 8, 11), (green, 11, 20)]);
        let column = ScanLine { direction: Direction::Vertical, fixed: 9, from: 2, to: 10, spacing: 1 };
        assert_eq!(classes(&image, &column), [(white, 2, 10)]);
    }

    #[test]
    fn white_is_judged_against_nearby_carpet() {
        // Left half in bright light, right half in the shade, each with a line of its brightness.
        let mut image = RgbImage::new(200, 1);
        for x in 0..200 {
            let light = if x < 100 { 1.0 } else { 0.4 };
            let color = if (40..45).contains(&x) || (160..165).contains(&x) { WHITE } else { GREEN };
            image.set(x, 0, color.map(|v| (f64::from(v) * light) as u8));
        }
        let row = ScanLine { direction: Direction::Horizontal, fixed: 0, from: 0, to: 200, spacing: 1 };
        let white: Vec<_> =
            classes(&image, &row).into_iter().filter(|run| run.0 == ColorClass::White).collect();
        assert_eq!(white, [(ColorClass::White, 40, 45), (ColorClass::White, 160, 165)]);
    }
}
