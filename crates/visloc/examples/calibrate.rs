//! Calibrates a camera: `cargo run --release -p visloc --example calibrate`. The photos of the board are drawn here; your own are read
//! with `visloc::io::image_codec::read_gray_image`.

use visloc::{
    Camera, Distortion, RngTree,
    calib::{Board, Checkerboard, LensModel, ViewInput, calibrate, detect, render},
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let board = Board::Checkerboard(Checkerboard { columns: 9, rows: 6, square_m: 0.03 });
    let lens = Distortion::RadialTangential([-0.25, 0.09, 8e-4, -6e-4, -0.01]);
    let truth = Camera::new((640, 480), (521.3, 523.1), (323.8, 236.4), lens)?;
    let mut rng = RngTree::new(1).stream("photos", 0);
    let mut views = Vec::new();
    for i in 0..15 {
        let Some(pose) = render::random_pose(&board, &truth, &mut rng) else { continue };
        let photo = render::render(&board, &truth, &pose, &render::RenderSettings::default(), &mut rng);
        if let Ok(found) = detect(&board, &photo) {
            views.push(ViewInput { name: format!("photo {i}"), corners: found.corners });
        }
    }
    let calibration = calibrate(&board, truth.size_px(), &views, LensModel::RadialTangential)?;
    println!("{} photos, residual {:.3} px", calibration.views.len(), calibration.rms_px);
    for parameter in &calibration.parameters {
        println!("{} = {:.4} +- {:.4}", parameter.name, parameter.value, parameter.standard_deviation);
    }
    Ok(())
}
