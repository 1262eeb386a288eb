//! The result in the terminal.

use visloc_calib::{Calibration, Coverage, DropReason, DroppedView};

use super::Detected;
use crate::say;

/// Lines of pictures that were left out.
const MAX_LEFT_OUT: usize = 8;

/// Prints camera, quality and advice.
pub fn print(found: &Calibration, coverage: &Coverage, detected: &Detected) {
    let num_images = detected.views.len() + detected.rejected.len();
    say::line!(
        "{num_images} images of {} x {} px, the board in {}, {} used with {} corners ({} corners left out)",
        detected.size_px.0,
        detected.size_px.1,
        detected.views.len(),
        found.views.len(),
        found.num_corners(),
        found.num_outliers()
    );
    print_left_out(found, detected);
    print_parameters(found);
    say::line!("corners in {:.0} % of the image", 100.0 * coverage.covered);
    if coverage.advice.is_empty() {
        say::line!("the pictures cover image, tilts and distances well");
    }
    for (i, advice) in coverage.advice.iter().enumerate() {
        say::line!("  {} {advice}", if i == 0 { "next:" } else { "     " });
    }
}

fn print_left_out(found: &Calibration, detected: &Detected) {
    let (same, dropped): (Vec<&DroppedView>, Vec<&DroppedView>) =
        found.dropped.iter().partition(|view| matches!(view.reason, DropReason::SameView(_)));
    if let Some(first) = same.first() {
        say::line!(
            "  {} {} the same view as another one and {} not counted again; the first: {} {}",
            same.len(),
            if same.len() == 1 { "shows" } else { "show" },
            if same.len() == 1 { "is" } else { "are" },
            first.name,
            first.reason
        );
    }
    let dropped = dropped.iter().map(|view| (view.name.clone(), view.reason.to_string()));
    let left_out: Vec<_> = detected.rejected.iter().cloned().chain(dropped).collect();
    for (name, reason) in left_out.iter().take(MAX_LEFT_OUT) {
        say::line!("  left out: {name}: {reason}");
    }
    if left_out.len() > MAX_LEFT_OUT {
        say::line!("  left out: {} more", left_out.len() - MAX_LEFT_OUT);
    }
}

fn print_parameters(found: &Calibration) {
    say::line!();
    for p in &found.parameters {
        if matches!(p.name, "fx" | "fy" | "cx" | "cy") {
            say::line!("  {}  {:10.3} +- {:.3} px", p.name, p.value, p.standard_deviation);
        } else {
            say::line!("  {}  {:10.6} +- {:.6}", p.name, p.value, p.standard_deviation);
        }
    }
    say::line!();
    say::line!(
        "reprojection error {:.3} px RMS, {:.3} px median; a corner is known to {:.3} px along each axis",
        found.rms_px,
        found.median_px,
        found.corner_noise_px
    );
}
