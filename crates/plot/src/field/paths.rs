//! Paths and arrows on the ground.

use visloc_core::geom::PlanarPose;

use super::{FieldPath, GroundView, PathPoint};
use crate::{
    Color, line_style,
    svg::{Canvas, Paint, Point},
};

const PATH_PX: f64 = 2.2;
const HALO_PX: f64 = 4.4;
const FAINT_PX: f64 = 1.6;
const FAINT_OPACITY: f64 = 0.6;

/// A connected piece of a path, all of it localized or all of it not.
#[derive(Debug, PartialEq)]
struct Piece {
    points: Vec<Point>,
    is_localized: bool,
}

pub(super) fn draw_path(canvas: &mut Canvas, view: &GroundView, path: &FieldPath, max_step_m: f64) {
    let pieces = pieces(view, &path.points, max_step_m);
    let has_halo = !line_style::is_above(path.color);
    for piece in pieces.iter().filter(|piece| piece.is_localized && has_halo) {
        canvas.polyline(&piece.points, &Paint::stroke(Color::WHITE, HALO_PX).opacity(0.55));
    }
    for piece in &pieces {
        let (width_px, opacity) = if piece.is_localized { (PATH_PX, 1.0) } else { (FAINT_PX, FAINT_OPACITY) };
        match piece.points[..] {
            [point] => {
                canvas.circle(point, 0.6 * width_px, &Paint::fill(path.color).opacity(opacity));
            }
            _ => {
                canvas.polyline(&piece.points, &line_style::stroke(path.color, width_px).opacity(opacity));
                line_style::draw_marks(canvas, path.color, &piece.points);
            }
        }
    }
}

/// A step belongs to the piece of the point that it leads to.
fn pieces(view: &GroundView, points: &[PathPoint], max_step_m: f64) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut last: Option<&PathPoint> = None;
    for point in points {
        if !(point.x_m.is_finite() && point.y_m.is_finite()) {
            last = None;
            continue;
        }
        let at = view.px(point.x_m, point.y_m);
        let before = last.filter(|last| (last.x_m - point.x_m).hypot(last.y_m - point.y_m) <= max_step_m);
        match (before, pieces.last_mut()) {
            (Some(_), Some(piece)) if piece.is_localized == point.is_localized => piece.points.push(at),
            (Some(before), _) => {
                let points = vec![view.px(before.x_m, before.y_m), at];
                pieces.push(Piece { points, is_localized: point.is_localized });
            }
            (None, _) => pieces.push(Piece { points: vec![at], is_localized: point.is_localized }),
        }
        last = Some(point);
    }
    pieces
}

/// A slim arrow head from a position into its heading.
pub(crate) fn draw_pose_arrow(
    canvas: &mut Canvas,
    view: &GroundView,
    pose: &PlanarPose,
    length_px: f64,
    paint: &Paint,
) {
    let (x, y) = view.px(pose.x_m, pose.y_m);
    let (sin, cos) = pose.yaw_rad.sin_cos();
    let corner = |along: f64, left: f64| {
        (x + length_px * (cos * along - sin * left), y - length_px * (sin * along + cos * left))
    };
    canvas.polygon(&[corner(1.0, 0.0), corner(0.0, 0.28), corner(0.2, 0.0), corner(0.0, -0.28)], paint);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> GroundView {
        GroundView::new((-3.0, 3.0), (-2.0, 2.0), 0.0)
    }

    fn at(x_m: f64) -> PathPoint {
        PathPoint::localized(&PlanarPose::new(x_m, 0.0, 0.0))
    }

    #[test]
    fn jumps_and_gaps_break_a_path() {
        let points = [at(0.0), at(0.1), at(2.0), at(2.1), PathPoint::gap(), at(2.2)];
        let lengths: Vec<usize> = pieces(&view(), &points, 0.5).iter().map(|p| p.points.len()).collect();
        assert_eq!(lengths, [2, 2, 1]);
    }

    #[test]
    fn faint_pieces_stay_connected() {
        let faint = PathPoint { is_localized: false, ..at(0.2) };
        let pieces = pieces(&view(), &[at(0.0), at(0.1), faint, at(0.3)], 0.5);
        assert_eq!(pieces.iter().map(|p| p.is_localized).collect::<Vec<_>>(), [true, false, true]);
        assert_eq!(pieces[0].points.last(), pieces[1].points.first());
        assert_eq!(pieces[1].points.last(), pieces[2].points.first());
    }
}
