//! Pictures of a calibration.

use std::path::Path;

use anyhow::Result;
use visloc_calib::{Calibration, Coverage, SeenCorner};
use visloc_core::{GrayImage, RgbImage};
use visloc_plot::{
    Color, Histogram, HistogramSeries, ImageDots, ImageLine, ImagePicture, Picture, histogram, image_picture,
};

/// Most lines: more hide each other.
const MAX_ARROWS: usize = 1500;
/// Arrows are so long for the usual residual, as a share of the image's width.
const ARROW: f64 = 0.02;
/// Side of the square in which residuals are dots, and its half width in standard deviations.
const CLOUD: (u32, f64) = (440, 5.0);

/// Draws all pictures into a folder; `worst` is the picture with the largest residuals.
pub fn draw(
    folder: &Path,
    found: &Calibration,
    coverage: &Coverage,
    worst: Option<(&str, &GrayImage)>,
) -> Result<()> {
    coverage_picture(found, coverage).save(folder, "coverage")?;
    vectors(found).save(folder, "vectors")?;
    cloud(found).save(folder, "residuals")?;
    distances(found).save(folder, "distances")?;
    if let Some((name, image)) = worst {
        corners(found, name, image).save(folder, "corners")?;
    }
    Ok(())
}

fn dots(label: &str, color: Color, diameter_px: f64, points_px: Vec<(f64, f64)>) -> ImageDots {
    ImageDots { label: label.to_owned(), color, diameter_px, points_px }
}

fn places<'a>(corners: impl Iterator<Item = &'a SeenCorner>) -> Vec<(f64, f64)> {
    corners.map(|c| (c.px.x, c.px.y)).collect()
}

/// How many times an image is enlarged or not.
fn enlargement(found: &Calibration) -> u32 {
    (900 / found.camera.size_px().0.max(1)).max(1)
}

/// Number of corners in each cell as color, and all corners.
fn coverage_picture(found: &Calibration, coverage: &Coverage) -> Picture {
    let (width, height) = found.camera.size_px();
    let mut image = RgbImage::new(width, height);
    let most = coverage.counts.iter().copied().max().unwrap_or(1).max(1);
    for y in 0..height {
        for x in 0..width {
            let cell = |v: u32, size: u32, count: usize| v as usize * count / size as usize;
            let (column, row) = (cell(x, width, coverage.cells.0), cell(y, height, coverage.cells.1));
            let count = coverage.counts[row * coverage.cells.0 + column];
            // The square root: whether there are any corners matters more than how many.
            let color = Color::scale((count as f64 / most as f64).sqrt());
            image.set(x, y, if count == 0 { [0x88, 0x88, 0x88] } else { color.parts() });
        }
    }
    let advice = coverage.advice.first().map_or_else(String::new, |advice| format!("; next: {advice}"));
    let size = (f64::from(width) / 260.0).max(3.0);
    image_picture(&ImagePicture {
        title: "What the pictures cover".to_owned(),
        subtitle: format!(
            "{:.0} % of the cells have corners: none where it is gray, up to {most} where it is lightest{advice}",
            100.0 * coverage.covered
        ),
        image,
        enlargement: enlargement(found),
        dots: vec![dots("corners of all pictures", Color::WHITE, size, places(found.corners()))],
        ..ImagePicture::default()
    })
}

fn blank(width: u32, height: u32) -> RgbImage {
    let mut image = RgbImage::new(width, height);
    image.data_mut().fill(0xf4);
    image
}

/// Residuals as enlarged lines from the projected corner.
fn vectors(found: &Calibration) -> Picture {
    let (width, height) = found.camera.size_px();
    let scale = ARROW * f64::from(width) / found.rms_px.max(1e-6);
    let line = |corner: &SeenCorner| {
        let end = corner.px + corner.residual_px * scale;
        let color = if corner.is_outlier { Color::VERMILION } else { Color::BLUE };
        ImageLine { label: String::new(), color, points_px: vec![(corner.px.x, corner.px.y), (end.x, end.y)] }
    };
    let every = (found.num_corners() / MAX_ARROWS).max(1);
    let shown = found.corners().enumerate().filter(|(i, c)| i % every == 0 || c.is_outlier).map(|(_, c)| c);
    image_picture(&ImagePicture {
        title: "Residuals over the image".to_owned(),
        subtitle: format!(
            "lines from the corner, {scale:.0} times as long; a pattern means that the lens model does not fit"
        ),
        image: blank(width, height),
        enlargement: enlargement(found),
        lines: shown.map(line).collect(),
        dots: vec![dots("left out", Color::VERMILION, 4.0, places(found.corners().filter(|c| c.is_outlier)))],
        ..ImagePicture::default()
    })
}

/// All residuals around zero.
fn cloud(found: &Calibration) -> Picture {
    let (side, sigmas) = CLOUD;
    let middle = f64::from(side) / 2.0;
    let scale = middle / (sigmas * found.corner_noise_px.max(1e-9));
    let place = |x: f64, y: f64| (middle + x * scale, middle + y * scale);
    let ring = |sigma: f64| ImageLine {
        label: if sigma == 1.0 { "1, 2, 3 standard deviations".to_owned() } else { String::new() },
        color: Color::SKY_BLUE,
        points_px: (0..=72)
            .map(|i| {
                let (sin, cos) = (f64::from(i) * 5.0_f64.to_radians()).sin_cos();
                place(sigma * found.corner_noise_px * cos, sigma * found.corner_noise_px * sin)
            })
            .collect(),
    };
    let points = found.corners().filter(|c| !c.is_outlier).map(|c| place(c.residual_px.x, c.residual_px.y));
    image_picture(&ImagePicture {
        title: "Residuals".to_owned(),
        subtitle: format!("of all corners that were used; the square is {:.2} px wide", 2.0 * middle / scale),
        image: blank(side, side),
        enlargement: 2,
        lines: vec![ring(1.0), ring(2.0), ring(3.0)],
        dots: vec![dots("residual", Color::BLUE, 2.0, points.collect())],
        ..ImagePicture::default()
    })
}

fn distances(found: &Calibration) -> Picture {
    let values: Vec<f64> = found.corners().map(|c| c.residual_px.norm()).collect();
    histogram(&Histogram {
        title: "Distance between seen and projected corner".to_owned(),
        subtitle: format!("RMS {:.3} px, median {:.3} px", found.rms_px, found.median_px),
        value_label: "distance [px]".to_owned(),
        num_bins: 50,
        range: Some((0.0, 5.0 * found.corner_noise_px.max(1e-6))),
        series: vec![HistogramSeries { label: "corners".to_owned(), color: Color::BLUE, values }],
    })
}

/// One picture with its corners, rows joined in their order.
fn corners(found: &Calibration, name: &str, gray: &GrayImage) -> Picture {
    let image = gray.to_rgb();
    let seen = found.views.iter().find(|view| view.name == name).map_or(&[][..], |view| &view.corners);
    let rms_px = found.views.iter().find(|view| view.name == name).map_or(0.0, visloc_calib::View::rms_px);
    let chain = ImageLine {
        label: "order of the corners".to_owned(),
        color: Color::ORANGE,
        points_px: places(seen.iter()),
    };
    let size = (f64::from(found.camera.size_px().0) / 280.0).max(4.0);
    image_picture(&ImagePicture {
        title: format!("The board in {name}"),
        subtitle: format!(
            "{} corners, {rms_px:.3} px RMS: the picture with the largest residuals",
            seen.len()
        ),
        image,
        enlargement: enlargement(found),
        lines: vec![chain],
        dots: vec![
            dots("used", Color::BLUISH_GREEN, size, places(seen.iter().filter(|c| !c.is_outlier))),
            dots("left out", Color::VERMILION, size, places(seen.iter().filter(|c| c.is_outlier))),
        ],
        ..ImagePicture::default()
    })
}
