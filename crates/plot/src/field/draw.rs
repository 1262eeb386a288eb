//! Puts the picture of the field together.

use visloc_core::geom::PlanarPose;

use super::{FieldPath, FieldPicture, Ground, GroundView, kidnap, paths};
use crate::{
    Color, Picture,
    header::{Header, LegendEntry, Symbol},
    svg::{Canvas, Paint},
};

const RIGHT_PX: f64 = 24.0;

/// A field or a building to scale from above, the paths of a run and where the robot was carried. Whatever lies beyond
/// is cut off.
pub fn field_picture<'a>(ground: impl Into<Ground<'a>>, input: &FieldPicture) -> Picture {
    let ground = ground.into();
    let rect = GroundView::of(&ground, 0.0).rect();
    let header = Header::new((rect.left, rect.right), &input.title, &input.subtitle, legend(input));
    let view = GroundView::of(&ground, header.height_px() + 8.0);
    let rect = view.rect();
    let mut canvas = Canvas::new(rect.right + RIGHT_PX, rect.bottom + GroundView::BELOW_PX);
    header.draw(&mut canvas);
    canvas.begin_clip(&rect);
    view.draw_ground(&mut canvas, &ground);
    canvas.begin_part("paths");
    // The truth is dashed, and above: so each shows where the other is.
    for path in input.estimates.iter().chain(&input.truth) {
        paths::draw_path(&mut canvas, &view, path, input.max_step_m);
    }
    canvas.end_group();
    kidnap::draw_kidnaps(&mut canvas, &view, &input.kidnaps);
    if let Some(start) = input.start.filter(PlanarPose::is_finite) {
        draw_start(&mut canvas, &view, &start);
    }
    canvas.end_group();
    view.draw_frame(&mut canvas);
    canvas.finish()
}

fn draw_start(canvas: &mut Canvas, view: &GroundView, start: &PlanarPose) {
    let arrow = Paint::fill(Color::BLACK).outlined(Color::WHITE, 1.2);
    paths::draw_pose_arrow(canvas, view, start, 24.0, &arrow);
    let ring = Paint::fill(Color::WHITE).outlined(Color::BLACK, 2.0);
    canvas.circle(view.px(start.x_m, start.y_m), 6.0, &ring);
}

fn legend(input: &FieldPicture) -> Vec<LegendEntry> {
    let has_points = |path: &&FieldPath| !path.points.is_empty();
    let mut entries: Vec<LegendEntry> = input
        .truth
        .iter()
        .chain(&input.estimates)
        .filter(has_points)
        .map(|path| LegendEntry::new(&path.label, Symbol::Line(path.color)))
        .collect();
    let is_faint = |path: &FieldPath| path.points.iter().any(|p| !p.is_localized && p.x_m.is_finite());
    for path in input.estimates.iter().filter(|path| is_faint(path)) {
        let label = match input.estimates.len() {
            1 => "not localized".to_owned(),
            _ => format!("{}, not localized", path.label),
        };
        entries.push(LegendEntry::new(&label, Symbol::FaintLine(path.color)));
    }
    if !input.kidnaps.is_empty() {
        entries.push(LegendEntry::new("carried", Symbol::DashedArrow(kidnap::COLOR)));
    }
    if input.start.is_some() {
        entries.push(LegendEntry::new("start", Symbol::Ring(Color::BLACK)));
    }
    entries
}
