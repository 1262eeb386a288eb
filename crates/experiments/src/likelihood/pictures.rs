//! Pictures and tables of likelihood maps.

use std::fmt::Write as _;

use visloc_core::{Frame, geom::PlanarPose};
use visloc_locate::vision::{FeatureKind, Percept};
use visloc_plot::{
    Color, HeatMap, ImageDots, ImagePicture, Mark, Panel, Picture, PoseMark, Series, TimeSeriesPicture,
    ValueAxis, heat_map, image_picture, surface_picture, time_series,
};
use visloc_world::field::Field;

use super::LikelihoodMap;

/// What pictures of a likelihood have in common.
#[derive(Debug, Clone, PartialEq)]
pub struct LikelihoodPictures<'a> {
    /// Large, at the top.
    pub title: String,
    /// Below the title.
    pub subtitle: String,
    /// Below the values.
    pub field: &'a Field,
    /// Where the robot is, if that is known.
    pub truth: Option<PlanarPose>,
}

impl LikelihoodPictures<'_> {
    /// The map as colors.
    pub fn heat(&self, map: &LikelihoodMap) -> Picture {
        heat_map(&self.values(map), Some(self.field.into()))
    }

    /// The map as a surface.
    pub fn surface(&self, map: &LikelihoodMap) -> Picture {
        surface_picture(&self.values(map), Some(self.field))
    }

    fn values(&self, map: &LikelihoodMap) -> HeatMap {
        HeatMap {
            title: self.title.clone(),
            subtitle: self.subtitle.clone(),
            value_label: "likelihood".to_owned(),
            grid: map.grid(),
            range: None,
            marks: self.marks(map),
        }
    }

    /// The likelihood over the heading at one place (x, y), meters: headings in radians.
    pub fn profile(&self, (x_m, y_m): (f64, f64), profile: &[(f64, f64)]) -> Picture {
        let points = profile.iter().map(|(yaw_rad, value)| (yaw_rad.to_degrees(), *value)).collect();
        let best = profile.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a });
        let mark = |label: &str, yaw_rad: f64| Mark {
            at_secs: yaw_rad.to_degrees(),
            label: format!("{label} {:.1}", yaw_rad.to_degrees()),
        };
        let truth = self.truth.map(|pose| mark("truth", pose.yaw_rad));
        time_series(&TimeSeriesPicture {
            title: self.title.clone(),
            subtitle: format!("At x {x_m:.2} m, y {y_m:.2} m"),
            x_label: "heading [deg]".to_owned(),
            panels: vec![Panel {
                label: "likelihood".to_owned(),
                axis: ValueAxis::Linear { min: 0.0, max: 1.0 },
                series: vec![Series::new("", Color::BLUE, points)],
                ..Panel::default()
            }],
            marks: truth.into_iter().chain(best.map(|(yaw_rad, _)| mark("maximum", yaw_rad))).collect(),
            range_secs: Some((-180.0, 180.0)),
            panel_px: Some(300.0),
            ..TimeSeriesPicture::default()
        })
    }

    /// The image with the pixels that are weighed.
    pub fn image(&self, frame: &Frame, percept: &Percept) -> Picture {
        let dots = |label: &str, color, kind: FeatureKind| ImageDots {
            label: label.to_owned(),
            color,
            diameter_px: 4.4,
            points_px: percept.pixels.iter().filter(|p| p.kind == kind).map(|p| (p.px.x, p.px.y)).collect(),
        };
        image_picture(&ImagePicture {
            title: self.title.clone(),
            subtitle: format!("{} pixels are weighed", percept.pixels.len()),
            image: frame.image.clone(),
            enlargement: 3,
            dots: vec![
                dots("line", Color::VERMILION, FeatureKind::FieldLine),
                dots("yellow goal", Color::ORANGE, FeatureKind::YellowGoal),
                dots("blue goal", Color::SKY_BLUE, FeatureKind::BlueGoal),
            ],
            ..ImagePicture::default()
        })
    }

    fn marks(&self, map: &LikelihoodMap) -> Vec<PoseMark> {
        let (maximum, _) = map.maximum();
        let truth = self.truth.map(|pose| PoseMark { label: "truth".to_owned(), color: Color::BLACK, pose });
        let maximum = PoseMark { label: "maximum".to_owned(), color: Color::VERMILION, pose: maximum };
        std::iter::once(maximum).chain(truth).collect()
    }
}

/// The map as a table for programs: x, y (meters), likelihood, heading (degrees).
pub fn map_csv(map: &LikelihoodMap) -> String {
    let mut text = "x_m,y_m,likelihood,heading_deg\n".to_owned();
    for (cell, value) in map.values.iter().enumerate() {
        let pose = map.pose(cell);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:.4},{:.4},{value:.6},{:.3}", pose.x_m, pose.y_m, pose.yaw_rad.to_degrees());
    }
    text
}

/// A heading profile as a table for programs: heading (degrees), likelihood.
pub fn profile_csv(profile: &[(f64, f64)]) -> String {
    let line = |(yaw_rad, value): &(f64, f64)| format!("{:.3},{value:.6}\n", yaw_rad.to_degrees());
    std::iter::once("heading_deg,likelihood\n".to_owned()).chain(profile.iter().map(line)).collect()
}
