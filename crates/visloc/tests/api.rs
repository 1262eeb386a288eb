//! What a program with this crate alone can count on.

#![allow(clippy::unwrap_used)]

use std::{error::Error, fmt::Debug};

use visloc::{
    AnalysisError, Camera, CameraError, ConfigError, Estimate, Frame, FrameError, FrameOutcome,
    ImageSizeError, Map, MapError, Mount, Pipeline, PipelineBuilder, RgbImage, Slam, SourceError, Timestamp,
    settings::SettingsError,
};

fn is_error<T: Error + Send + Sync + 'static>() {}

fn is_sent<T: Debug + Send + 'static>() {}

fn is_shared<T: Debug + Clone + Send + Sync + 'static>() {}

#[test]
fn errors_cross_threads_and_fit_into_those_of_others() {
    is_error::<AnalysisError>();
    is_error::<CameraError>();
    is_error::<ConfigError>();
    is_error::<FrameError>();
    is_error::<ImageSizeError>();
    is_error::<MapError>();
    is_error::<SettingsError>();
    is_error::<SourceError>();
    is_error::<visloc::locate::PhotoError>();
    is_error::<visloc::slam::ConfigError>();
    is_error::<visloc::slam::SelfCalibrationError>();
    #[cfg(feature = "calib")]
    {
        is_error::<visloc::calib::BoardError>();
        is_error::<visloc::calib::CalibrateError>();
        is_error::<visloc::calib::DetectReject>();
    }
    #[cfg(feature = "io")]
    {
        is_error::<visloc::io::FileError>();
        is_error::<visloc::io::bag::BagError>();
        is_error::<visloc::io::sources::SourcesError>();
    }
    #[cfg(feature = "vmap")]
    is_error::<visloc::vmap::VmapError>();
}

#[test]
fn what_runs_moves_to_a_thread_and_what_is_known_is_shared() {
    is_sent::<Pipeline>();
    is_sent::<Slam>();
    is_shared::<Map>();
    is_shared::<Camera>();
    is_shared::<Frame>();
    is_shared::<Estimate>();
    is_shared::<FrameOutcome>();
    #[cfg(feature = "io")]
    is_sent::<visloc::io::bag::BagReader>();
    #[cfg(feature = "vmap")]
    {
        is_sent::<visloc::vmap::MapLocalizer>();
        is_shared::<visloc::vmap::VisualMap>();
    }
    let map = Map::built_in("robocup-spl-2010").unwrap();
    let builder: PipelineBuilder<'_> = Pipeline::builder(&map);
    assert!(format!("{builder:?}").contains("evolutionary"));
}

/// A frame that cannot be used costs nothing but itself.
#[test]
fn a_frame_that_cannot_be_used_is_told_by_its_type() {
    let map = Map::built_in("robocup-spl-2010").unwrap();
    let camera = Camera::pinhole((320, 240), (373.0, 373.0), (159.5, 119.5)).unwrap();
    let frame = |width: u32, height_m: f64| {
        let mount = Mount { height_m, tilt_rad: 0.3, ..Mount::default() };
        Frame::new(Timestamp::from_secs(1.0), RgbImage::new(width, 240), camera, mount.robot_from_camera())
    };
    let mut pipeline = Pipeline::builder(&map).build().unwrap();
    assert!(matches!(pipeline.step(&frame(0, 0.5)), Err(AnalysisError::Size { found_px: (0, 240), .. })));
    assert!(matches!(pipeline.step(&frame(320, f64::NAN)), Err(AnalysisError::Mount { .. })));
    assert!(pipeline.step(&frame(320, 0.5)).is_ok());
}
