//! A RoboCup field: carpet with lines, goals, ball.

use nalgebra::{Point2, Point3, Vector3};
use rand::RngExt as _;
use serde::Deserialize;
use visloc_core::Rng;
use visloc_world::field::{BallColor, Field, Goal, GoalColor};

use super::{
    Canvas, Color, GroundMark, Label, Paint, Pattern, Scene, Shape, Surface, Texture, Wrap, noise::NoiseTile,
};

/// Texels per meter of the carpet: a line is 12 texels wide.
const CARPET_PX_PER_M: f32 = 250.0;
/// How far a goal reaches behind its line, meters.
const GOAL_DEPTH_M: f32 = 0.4;

visloc_core::with_defaults! {
    /// Colors of a field and how worn it is.
    /// By default a green carpet in good condition.
    #[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct FieldLook {
        /// Color of the carpet.
        pub carpet: Color = Color::from_hex(0x36_7c4a),
        /// Brightness noise of the carpet's fibers, 0 to 1.
        pub grain: f32 = 0.10,
        /// How much of the paint is worn off where it is thinnest, 0 to 1.
        pub wear: f32 = 0.15,
        /// How many times as bright the carpet is in patches of sun as beside them; 1 for no sun.
        pub sun: f32 = 1.0,
    }
}

impl Scene {
    /// Adds carpet, lines and goals of a field.
    pub fn add_field(&mut self, field: &Field, look: &FieldLook, rng: &mut Rng) {
        let (x, y) = field.half_carpet_m();
        let shape = Shape::level((0.0, 0.0), (2.0 * x as f32, 2.0 * y as f32), 0.0);
        let carpet = self.add_texture(Texture::new(&carpet(field, look, rng), Wrap::Clamp));
        self.add_labelled(shape, carpet, Label::Carpet);
        self.set_ground_marks(GroundMark::of_field(field));
        for goal in field.goals() {
            self.add_goal(goal, rng);
        }
    }

    /// Adds a resting ball at a point of the floor.
    pub fn add_ball(&mut self, field: &Field, at: &Point2<f64>) {
        let radius_m = (field.dimensions().ball_diameter_m / 2.0) as f32;
        let (x, y) = (at.x as f32, at.y as f32);
        let texture = match field.dimensions().ball_color {
            BallColor::Orange => self.add_color(Color::from_hex(0xe8_641c)),
            BallColor::BlackAndWhite => {
                let paint = Paint {
                    second_color: Color::from_hex(0x1c_1c20),
                    pitch_m: 0.06,
                    ..Paint::of(Pattern::Checker, Color::from_hex(0xea_eae8))
                };
                let no_noise = &mut visloc_core::RngTree::new(0).stream("ball", 0);
                let canvas = paint.canvas((0.48, 0.24), 200.0, no_noise);
                self.add_texture(Texture::new(&canvas, Wrap::Clamp))
            }
        };
        self.add_shadow((x, y), (radius_m * 5.0, radius_m * 5.0));
        self.add_labelled(
            Shape::Sphere { center: Point3::new(x, y, radius_m), radius_m },
            texture,
            Label::Ball,
        );
    }

    fn add_goal(&mut self, goal: &Goal, rng: &mut Rng) {
        let paint = self.add_color(goal_color(goal.color));
        let white = self.add_color(Color::from_hex(0xe4_e4e2));
        let label = goal_label(goal.color);
        let (x, post_y) = (goal.x_m as f32, goal.post_y_m as f32);
        let (radius_m, bar_z) = (goal.post_radius_m as f32, goal.crossbar_z_m as f32);
        let back = x + x.signum() * GOAL_DEPTH_M;
        let bar = |from: Point3<f32>, to: Point3<f32>, radius_m| Shape::Cylinder {
            base: from,
            axis: to - from,
            radius_m,
        };
        for y in [post_y, -post_y] {
            self.add_shadow((x, y), (radius_m * 7.0, radius_m * 7.0));
            let post = bar(Point3::new(x, y, 0.0), Point3::new(x, y, bar_z + radius_m), radius_m);
            self.add_labelled(post, paint, label);
            let base = bar(Point3::new(x, y, 0.02), Point3::new(back, y, 0.02), 0.02);
            self.add_labelled(base, paint, Label::GoalBack);
            let stay = bar(Point3::new(x, y, bar_z - 0.04), Point3::new(back, y, 0.03), 0.0125);
            self.add_labelled(stay, white, Label::GoalBack);
        }
        let across = |x, z, reach: f32| (Point3::new(x, -reach, z), Point3::new(x, reach, z));
        let (left, right) = across(x, bar_z, post_y + radius_m);
        self.add_labelled(bar(left, right, radius_m), paint, label);
        let (left, right) = across(back, 0.02, post_y);
        self.add_labelled(bar(left, right, 0.02), white, Label::GoalBack);
        self.add_net((x, bar_z - 0.05), (back, 0.04), post_y, rng);
    }

    /// The net hangs from the crossbar (x, z) to the bar at the back (x, z).
    fn add_net(&mut self, top: (f32, f32), bottom: (f32, f32), half_width_m: f32, rng: &mut Rng) {
        const MESH_M: f32 = 0.1;
        const THREAD_M: f32 = 0.006;
        const PX_PER_M: f32 = 320.0;
        let shape = Shape::Quad {
            corner: Point3::new(top.0, -half_width_m, top.1),
            right: Vector3::new(0.0, 2.0 * half_width_m, 0.0),
            down: Vector3::new(bottom.0 - top.0, 0.0, bottom.1 - top.1),
        };
        let (width_m, height_m) = shape.size_m();
        let size = ((width_m * PX_PER_M) as u32, (height_m * PX_PER_M) as u32);
        let mut canvas = Canvas::new(size, Color::from_hex(0xe8_e8e6));
        let sag = NoiseTile::new(4, 3, 0.5, rng);
        canvas.set_opacity(|x, y| {
            let (dx, dy) = (6.0 * sag.at(x, y), 6.0 * sag.at(y + 90, x));
            let on_thread = |px: f32| {
                let from_thread = ((px / PX_PER_M / MESH_M + 1.0).fract() - 0.5).abs() * MESH_M;
                (from_thread < THREAD_M / 2.0) as u8
            };
            0.9 * f32::from(on_thread(x as f32 + dx).max(on_thread(y as f32 + dy)))
        });
        let net = self.add_texture(Texture::new(&canvas, Wrap::Clamp));
        self.add_surface(Surface { is_overlay: true, ..self.surface(shape, net) });
    }
}

fn goal_color(color: GoalColor) -> Color {
    Color::from_hex(match color {
        GoalColor::Yellow => 0xdd_c414,
        GoalColor::Blue => 0x1f_4fb4,
        GoalColor::White => 0xe6_e6e4,
    })
}

fn goal_label(color: GoalColor) -> Label {
    match color {
        GoalColor::Yellow => Label::YellowGoal,
        GoalColor::Blue => Label::BlueGoal,
        GoalColor::White => Label::WhiteGoal,
    }
}

/// The carpet seen from above, +y up.
fn carpet(field: &Field, look: &FieldLook, rng: &mut Rng) -> Canvas {
    let (half_x, half_y) = field.half_carpet_m();
    let px = |length_m: f64| (length_m as f32 * CARPET_PX_PER_M).round() as u32;
    let mut canvas = Canvas::new((px(2.0 * half_x), px(2.0 * half_y)), look.carpet);
    let fibers = NoiseTile::new(64, 3, 0.9, rng);
    let tufts = NoiseTile::new(8, 4, 0.8, rng);
    canvas.modulate(|x, y| {
        // Fibers lie along x: the noise is stretched that way.
        let grain = fibers.at_scale(x, y * 2, 2.0) * 1.6 + tufts.at(x / 2, y / 2);
        1.0 + look.grain * 2.0 * grain + 0.12 * tufts.at_scale(x, y, 11.0)
    });
    let wear = NoiseTile::new(8, 5, 0.8, rng);
    let mut painter = LinePainter { canvas: &mut canvas, half_x, half_y, look, wear: &wear };
    for mark in GroundMark::of_field(field) {
        painter.paint(&mark);
    }
    if look.sun > 1.0 {
        shade_beside_sun(&mut canvas, look.sun, rng);
    }
    canvas
}

/// Leaves patches of sun as they are, which fell in through a row of windows, and darkens all beside them.
fn shade_beside_sun(canvas: &mut Canvas, sun: f32, rng: &mut Rng) {
    let (width, height) = canvas.size_px();
    let meters = |px: u32| px as f32 / CARPET_PX_PER_M;
    let (sin, cos) = rng.random_range(0.0..std::f32::consts::TAU).sin_cos();
    let (half_length_m, pitch_m) = (rng.random_range(0.6..1.8_f32), rng.random_range(0.5..1.5_f32));
    let (window, slant) = (rng.random_range(0.5..0.9_f32), rng.random_range(-0.8..0.8_f32));
    let middle =
        (meters(width) * rng.random_range(0.2..0.8_f32), meters(height) * rng.random_range(0.2..0.8_f32));
    canvas.modulate(|x, y| {
        let (x, y) = (meters(x) - middle.0, meters(y) - middle.1);
        let (along, across) = (x * cos + y * sin, y * cos - x * sin);
        let phase = (across + slant * along) / pitch_m;
        let is_sunny = along.abs() < half_length_m && phase.abs() < 3.0 && phase.rem_euclid(1.0) < window;
        if is_sunny { 1.0 } else { 1.0 / sun }
    });
}

struct LinePainter<'a> {
    canvas: &'a mut Canvas,
    half_x: f64,
    half_y: f64,
    look: &'a FieldLook,
    wear: &'a NoiseTile,
}

impl LinePainter<'_> {
    /// Paints a mark with soft edges, worn where the noise says so.
    fn paint(&mut self, mark: &GroundMark) {
        let (middle, half) = mark.bounds();
        let scale = f64::from(CARPET_PX_PER_M);
        let to_px = |x: f64, y: f64| ((x + self.half_x) * scale, (self.half_y - y) * scale);
        let (left, top) = to_px(middle.x - half.0, middle.y + half.1);
        let (right, bottom) = to_px(middle.x + half.0, middle.y - half.1);
        for y in top as i64 - 2..=bottom as i64 + 2 {
            for x in left as i64 - 2..=right as i64 + 2 {
                let point = Point2::new(
                    (x as f64 + 0.5) / scale - self.half_x,
                    self.half_y - (y as f64 + 0.5) / scale,
                );
                let cover = (0.5 - mark.distance_m(&point) * scale).clamp(0.0, 1.0) as f32;
                if cover > 0.0 && x >= 0 && y >= 0 {
                    let worn =
                        self.look.wear * (0.5 + 1.5 * self.wear.at(x as u32, y as u32)).clamp(0.0, 1.0);
                    let white = Color::from_hex(0xec_ecea);
                    self.canvas.blend(x, y, white, cover * (1.0 - worn));
                }
            }
        }
    }
}
