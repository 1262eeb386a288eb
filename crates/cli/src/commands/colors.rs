//! `visloc colors`: color classes from a labelled image.

use anyhow::{Context, Result, bail};
use serde::Serialize;
use visloc_core::RgbImage;
use visloc_io::image_codec::read_image;
use visloc_locate::vision::color::{ColorClass, ColorConfig, calibrate_colors};

use crate::{args::ColorsArgs, run::write_text, say};

/// Pure colors of the label image and what they mean. Black is not labelled.
const LABELS: [([u8; 3], ColorClass); 5] = [
    ([0, 255, 0], ColorClass::Green),
    ([255, 255, 255], ColorClass::White),
    ([255, 255, 0], ColorClass::Yellow),
    ([0, 0, 255], ColorClass::Blue),
    ([255, 128, 0], ColorClass::Orange),
];

/// So far may a label be from its pure color in each channel: drawing programs differ in what they call orange.
const LABEL_TOLERANCE: u8 = 40;

/// A file for `visloc localize --pipeline`.
#[derive(Serialize)]
struct PipelineFile {
    analysis: AnalysisSection,
}

#[derive(Serialize)]
struct AnalysisSection {
    colors: ColorConfig,
}

/// Runs the command.
pub fn execute(args: &ColorsArgs) -> Result<()> {
    let image = read_image(&args.image).with_context(|| args.image.display().to_string())?;
    let labels = read_image(&args.labels).with_context(|| args.labels.display().to_string())?;
    let size = |image: &RgbImage| (image.width(), image.height());
    if size(&image) != size(&labels) {
        let ((w, h), (label_w, label_h)) = (size(&image), size(&labels));
        bail!(
            "{}: expected {w} x {h} px as the image, found {label_w} x {label_h} px",
            args.labels.display()
        );
    }
    let labelled = labelled_pixels(&image, &labels);
    for (_, class) in LABELS {
        let count = labelled.iter().filter(|(_, known)| *known == class).count();
        say::line!("{:<8} {count} pixels", class.name());
    }
    let colors = calibrate_colors(&ColorConfig::default(), &labelled)
        .with_context(|| args.labels.display().to_string())?;
    let file = PipelineFile { analysis: AnalysisSection { colors } };
    write_text(&args.out, &toml::to_string(&file).context("color classes")?)?;
    let out = args.out.display().to_string();
    say::line!("{out}: use it with visloc localize --pipeline {}", say::typed(&out));
    Ok(())
}

fn labelled_pixels(image: &RgbImage, labels: &RgbImage) -> Vec<([u8; 3], ColorClass)> {
    let pixels = (0..image.height()).flat_map(|y| (0..image.width()).map(move |x| (x, y)));
    pixels.filter_map(|(x, y)| Some((image.get(x, y), class_of_label(labels.get(x, y))?))).collect()
}

/// `None` for black and for the mixed colors at smoothed edges.
fn class_of_label(label: [u8; 3]) -> Option<ColorClass> {
    let is_near = |pure: &[u8; 3]| (0..3).all(|i| pure[i].abs_diff(label[i]) <= LABEL_TOLERANCE);
    LABELS.iter().find(|(pure, _)| is_near(pure)).map(|(_, class)| *class)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_drawing_programs_are_understood() {
        assert_eq!(class_of_label([255, 128, 0]), Some(ColorClass::Orange));
        assert_eq!(class_of_label([255, 165, 0]), Some(ColorClass::Orange));
        assert_eq!(class_of_label([250, 255, 3]), Some(ColorClass::Yellow));
        assert_eq!(class_of_label([0, 0, 0]), None);
        assert_eq!(class_of_label([127, 255, 127]), None, "the smoothed edge of a white patch on green");
    }
}
