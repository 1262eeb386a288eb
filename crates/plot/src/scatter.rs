//! Points on plain ground.

use crate::{
    Color, Picture,
    field::GroundView,
    header::{Header, LegendEntry, Symbol},
    line_style,
    svg::{Canvas, Paint},
};

const RIGHT_PX: f64 = 24.0;
const DOT_PX: f64 = 3.2;

/// Points on plain ground, seen from above: +x to the right, +y up, the same scale along both.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScatterPicture {
    /// Large, at the top.
    pub title: String,
    /// Below the title.
    pub subtitle: String,
    /// Shown range of x, meters.
    pub x_m: (f64, f64),
    /// Shown range of y, meters.
    pub y_m: (f64, f64),
    /// What stands at the axis to the right and at the one upwards; x and y in meters if empty.
    pub axes: [String; 2],
    /// Later ones are drawn over earlier ones.
    pub series: Vec<ScatterSeries>,
}

/// Points of one kind.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScatterSeries {
    /// In the legend.
    pub label: String,
    /// Of the points.
    pub color: Color,
    /// A ring of this radius around each point, meters; without it a dot.
    pub radius_m: Option<f64>,
    /// Whether the points are joined by a line instead of drawn; not a number interrupts it.
    pub is_line: bool,
    /// x and y, meters. Not a number and points outside are left out.
    pub points: Vec<(f64, f64)>,
    /// A color of its own for each point; may be empty.
    pub colors: Vec<Color>,
}

/// Points on plain ground.
pub fn scatter(input: &ScatterPicture) -> Picture {
    let rect = GroundView::new(input.x_m, input.y_m, 0.0).rect();
    let entries = input.series.iter().map(|series| {
        let symbol = match (series.is_line, series.radius_m) {
            (true, _) => Symbol::Line,
            (false, Some(_)) => Symbol::Ring,
            (false, None) => Symbol::Dot,
        };
        LegendEntry::new(&series.label, symbol(series.color))
    });
    let header = Header::new((rect.left, rect.right), &input.title, &input.subtitle, entries.collect());
    let view = GroundView::new(input.x_m, input.y_m, header.height_px() + 8.0);
    let rect = view.rect();
    let mut canvas = Canvas::new(rect.right + RIGHT_PX, rect.bottom + GroundView::BELOW_PX);
    header.draw(&mut canvas);
    canvas.begin_clip(&rect);
    canvas.rect(&rect, &Paint::fill(Color::WHITE));
    let is_above = |series: &&ScatterSeries| series.is_line && line_style::is_above(series.color);
    let below = input.series.iter().filter(|series| !is_above(series));
    for series in below.chain(input.series.iter().filter(is_above)) {
        if series.is_line {
            let is_point = |(x, y): &(f64, f64)| x.is_finite() && y.is_finite();
            for piece in series.points.split(|point| !is_point(point)) {
                let line: Vec<_> = piece.iter().map(|(x, y)| view.px(*x, *y)).collect();
                canvas.polyline(&line, &line_style::stroke(series.color, 2.0));
                line_style::draw_marks(&mut canvas, series.color, &line);
            }
            continue;
        }
        for (i, &(x_m, y_m)) in series.points.iter().enumerate() {
            if !(x_m.is_finite() && y_m.is_finite()) {
                continue;
            }
            let at = view.px(x_m, y_m);
            let color = series.colors.get(i).copied().unwrap_or(series.color);
            match series.radius_m {
                Some(radius_m) => {
                    canvas.circle(at, radius_m * view.px_per_m(), &Paint::stroke(series.color, 2.0));
                    canvas.circle(at, 1.5, &Paint::fill(series.color));
                }
                None => canvas.circle(at, DOT_PX, &Paint::fill(color).opacity(0.6)),
            }
        }
    }
    canvas.end_group();
    let [right, up] = [(&input.axes[0], "x [m]"), (&input.axes[1], "y [m]")]
        .map(|(text, usual)| if text.is_empty() { usual } else { text });
    view.draw_frame_with(&mut canvas, [right, up]);
    canvas.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_finite_point_is_drawn() {
        let series = |radius_m| ScatterSeries {
            radius_m,
            points: vec![(0.0, 0.0), (f64::NAN, 1.0), (1.0, -1.0)],
            ..ScatterSeries::default()
        };
        let picture = |series| {
            let input = ScatterPicture {
                x_m: (-2.0, 2.0),
                y_m: (-2.0, 2.0),
                series: vec![series],
                ..ScatterPicture::default()
            };
            scatter(&input).svg().matches("<circle").count()
        };
        assert_eq!(picture(series(None)), 2);
        assert_eq!(picture(series(Some(0.5))), 4, "a ring and its center");
        let line = ScatterSeries { is_line: true, ..series(None) };
        assert_eq!(picture(line), 0);
    }
}
