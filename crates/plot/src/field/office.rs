//! Floor, walls and doors of a building.

use visloc_world::office::{Door, Office, SurfaceColor};

use super::GroundView;
use crate::{
    Color,
    svg::{Canvas, Paint, Point},
};

const OUTSIDE: Color = Color::rgb(0xdd, 0xdd, 0xdd);
const WALL: Color = Color::rgb(0x3a, 0x3a, 0x3a);
/// Floors are drawn paler than they are, so that paths stand out.
const FLOOR_OPACITY: f64 = 0.4;
const WALL_PX: f64 = 2.0;
const DOOR_PX: f64 = 5.0;

impl GroundView {
    pub(super) fn draw_office(&self, canvas: &mut Canvas, office: &Office) {
        canvas.rect(&self.rect(), &Paint::fill(OUTSIDE));
        self.draw_floor(canvas, office);
        self.draw_walls(canvas, office, 1.0);
    }

    /// Outlines in the order of the file: what lies inside another one is drawn over it.
    fn draw_floor(&self, canvas: &mut Canvas, office: &Office) {
        let floor = color(office.plan().floor_color);
        if office.plan().corridors.is_empty() {
            // What the walls enclose, as far as a robot can be there.
            for [low, high] in office.free_space().strips_m() {
                let corners = [
                    self.px(low.x, low.y),
                    self.px(high.x, low.y),
                    self.px(high.x, high.y),
                    self.px(low.x, high.y),
                ];
                canvas.polygon(&corners, &Paint::fill(Color::WHITE));
                canvas.polygon(&corners, &Paint::fill(floor).opacity(FLOOR_OPACITY));
            }
        }
        for corridor in &office.plan().corridors {
            let corners: Vec<Point> = corridor.outline.iter().map(|[x, y]| self.px(*x, *y)).collect();
            canvas.polygon(&corners, &Paint::fill(Color::WHITE));
            canvas.polygon(&corners, &Paint::fill(floor).opacity(FLOOR_OPACITY));
        }
    }

    /// Walls as dark lines, doors in their colors, open doors as gaps.
    pub(crate) fn draw_walls(&self, canvas: &mut Canvas, office: &Office, opacity: f64) {
        canvas.begin_faded(opacity);

        for wall in office.walls() {
            canvas.line(
                self.px(wall.start.x, wall.start.y),
                self.px(wall.end.x, wall.end.y),
                &Paint::stroke(WALL, WALL_PX),
            );
        }
        let paint = |door: &Door| match office.door_colors().get(usize::from(door.paint)) {
            Some(known) if !door.is_open => color(*known),
            _ => Color::WHITE,
        };
        for door in office.doors() {
            let (left, right) = (self.px(door.left.x, door.left.y), self.px(door.right.x, door.right.y));
            canvas.line(left, right, &Paint::stroke(paint(door), DOOR_PX));
        }
        canvas.end_group();
    }
}

fn color(color: SurfaceColor) -> Color {
    let [r, g, b] = color.rgb;
    Color::rgb(r, g, b)
}
