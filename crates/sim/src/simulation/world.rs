//! From a scenario to a scene, and to the floor that is free in it.

use nalgebra::{Point2, Point3, Vector3};
use rand::RngExt as _;
use visloc_core::{Rng, RngTree, geom::PlanarPose};
use visloc_world::{Map, field::Field, office::Office};

use crate::{
    robot::{Floor, Orbit, find_orbits},
    scenario::{Scenario, ScenarioError},
    scene::{Color, Cuboid, Figure, Lamp, Scene, Shape, Surface, office_lamps, spots},
};

/// Floor kept free between robot and lines, meters: along x (goals) and along y.
const KEEP_OFF_M: (f64, f64) = (0.3, 0.1);
/// Panels are painted with this resolution.
const PANEL_PX_PER_M: f32 = 200.0;

/// What is seen and what is in the way.
#[derive(Debug)]
pub(super) struct World {
    pub(super) map: Map,
    pub(super) scene: Scene,
    pub(super) floor: Floor,
    resting: Vec<Surface>,
    people: Vec<(Figure, PlanarPose)>,
    walking: Vec<(Figure, Orbit)>,
    /// Other simulated robots, if there are any.
    company: Option<Figure>,
}

impl World {
    /// Everything but the walking robots, which need to know where the own robot goes.
    pub(super) fn new(scenario: &Scenario, random: &RngTree) -> Result<Self, ScenarioError> {
        let map = Map::load(&scenario.map)
            .map_err(|source| ScenarioError::Map { name: scenario.name.clone(), source })?;
        if let Map::Office(office) = &map {
            let (scene, floor) = building(office, scenario, random);
            return Ok(Self::furnished(map, scene, floor, scenario));
        }
        let half_field = half_field_m(&map);
        let rng = &mut random.stream("scene", 0);
        let lamps = lamps(scenario, half_field, rng);
        let half_floor = (half_field.0 as f32, half_field.1 as f32);
        let mut scene = Scene::new(lamps.clone(), scenario.light.ambient, half_floor);
        if let Some(room) = &scenario.room {
            scene.add_room(room, &lamps, rng);
        }
        let mut floor = Floor::new((half_field.0 - KEEP_OFF_M.0, half_field.1 - KEEP_OFF_M.1));
        add_things(&mut scene, scenario, rng);
        // Field, ball and robots have streams of their own, so that more furniture does not move them.
        if let Map::Field(field) = &map {
            scene.add_field(field, &scenario.carpet, &mut random.stream("field", 0));
            add_ball(&mut scene, &mut floor, field, scenario, &mut random.stream("ball", 0));
        }
        Ok(Self::furnished(map, scene, floor, scenario))
    }

    /// With everybody who stands around.
    fn furnished(map: Map, scene: Scene, floor: Floor, scenario: &Scenario) -> Self {
        let mut world = Self {
            map,
            scene,
            floor,
            resting: Vec::new(),
            people: Vec::new(),
            walking: Vec::new(),
            company: None,
        };
        world.add_figures(scenario);
        world
    }

    fn add_figures(&mut self, scenario: &Scenario) {
        for person in &scenario.people {
            let figure = self.scene.person_figure(person.height_m, person.shirt, person.trousers);
            self.people.push((figure, person.at.pose()));
            self.floor.add_obstacle(person.at.pose().position(), 0.4);
        }
        for robot in &scenario.robots {
            let Some(at) = &robot.at else { continue };
            let figure = self.scene.robot_figure(robot.jersey);
            figure.place(&self.scene, &at.pose(), (0.0, 0.0), &mut self.resting);
            self.floor.add_obstacle(at.pose().position(), 0.4);
        }
    }

    /// Lets the walking robots of a scenario walk for a time, clear of each other and of the own robot.
    pub(super) fn let_walk(
        &mut self,
        scenario: &Scenario,
        secs: f64,
        own_position: impl Fn(f64) -> Point2<f64>,
        random: &RngTree,
    ) -> Result<(), ScenarioError> {
        let walking = scenario.robots.iter().filter(|robot| robot.at.is_none());
        let jerseys: Vec<Color> = walking.map(|robot| robot.jersey).collect();
        let rng = &mut random.stream("robots", 0);
        let orbits = find_orbits(jerseys.len(), &self.floor, secs, own_position, rng);
        if orbits.len() < jerseys.len() {
            let name = scenario.name.clone();
            return Err(ScenarioError::NoSpace { name, what: "way for another robot", tries: 6000 });
        }
        for (jersey, orbit) in jerseys.into_iter().zip(orbits) {
            let figure = self.scene.robot_figure(jersey);
            self.walking.push((figure, orbit));
        }
        Ok(())
    }

    /// Other simulated robots will be in this world, with this jersey.
    pub(super) fn prepare_company(&mut self, jersey: Color) {
        self.company = Some(self.scene.robot_figure(jersey));
    }

    /// Surfaces of other simulated robots at their poses.
    pub(super) fn place_company(&self, poses: &[PlanarPose], secs: f64, out: &mut Vec<Surface>) {
        let Some(figure) = &self.company else { return };
        for (i, pose) in poses.iter().enumerate() {
            let stride_rad = (secs * 6.0 + i as f64).rem_euclid(std::f64::consts::TAU) as f32;
            figure.place(&self.scene, pose, (stride_rad, 1.0), out);
        }
    }

    /// Where the walking robots are, at a time since the start.
    pub(super) fn others(&self, secs: f64) -> Vec<PlanarPose> {
        self.walking.iter().map(|(_, orbit)| orbit.pose(secs)).collect()
    }

    /// Surfaces of everything that moves, at a time since the start.
    pub(super) fn moving(&self, secs: f64, out: &mut Vec<Surface>) {
        out.clear();
        out.extend(self.resting.iter().cloned());
        for (i, (person, pose)) in self.people.iter().enumerate() {
            // Nobody stands quite still.
            let beat = secs * 0.8 + i as f64 * 1.7;
            let sway =
                PlanarPose::new(0.04 * beat.sin(), 0.03 * (1.4 * beat).cos(), 0.25 * (0.5 * beat).sin());
            person.place(&self.scene, &pose.compose(&sway), (0.0, 0.0), out);
        }
        for (i, (robot, orbit)) in self.walking.iter().enumerate() {
            let stride_rad = (secs * 6.0 + i as f64).rem_euclid(std::f64::consts::TAU) as f32;
            robot.place(&self.scene, &orbit.pose(secs), (stride_rad, 1.0), out);
        }
    }
}

/// A building with the things that stand around in it.
fn building(office: &Office, scenario: &Scenario, random: &RngTree) -> (Scene, Floor) {
    /// The mean of the light is taken on a grid of this pitch, meters.
    const LIGHT_STEP_M: f64 = 0.5;
    let rng = &mut random.stream("scene", 0);
    let lamps = match scenario.lamps.is_empty() {
        true => office_lamps(office, scenario.light.unevenness, rng),
        false => scenario.lamps.clone(),
    };
    let spots: Vec<_> = spots(office, LIGHT_STEP_M)
        .into_iter()
        .map(|spot| Point3::new(spot.x as f32, spot.y as f32, 0.0))
        .collect();
    let mut scene = Scene::lit_over(lamps.clone(), scenario.light.ambient, &spots);
    scene.add_office(office, &lamps, &mut random.stream("office", 0));
    add_things(&mut scene, scenario, rng);
    let mut floor = Floor::of_building(office.free_space().clone());
    for piece in &scenario.boxes {
        let reach = 0.5 * f64::from(piece.size_m[0].hypot(piece.size_m[1]));
        floor.add_obstacle(piece.at.pose().position(), reach + 0.15);
    }
    (scene, floor)
}

/// Half of the field between the lines, meters.
fn half_field_m(map: &Map) -> (f64, f64) {
    match map {
        Map::Field(field) => (field.dimensions().length_m / 2.0, field.dimensions().width_m / 2.0),
        _ => (3.0, 2.0),
    }
}

fn lamps(scenario: &Scenario, half_field_m: (f64, f64), rng: &mut Rng) -> Vec<Lamp> {
    if !scenario.lamps.is_empty() {
        return scenario.lamps.clone();
    }
    let [columns, rows] = scenario.light.lamps;
    let (half_x, half_y) =
        scenario.room.as_ref().map_or((half_field_m.0 as f32, half_field_m.1 as f32), |room| {
            (room.length_m / 2.0, room.width_m / 2.0)
        });
    let z_m = scenario.room.as_ref().map_or(3.4, |room| room.height_m) - 0.02;
    let place = |i: u32, count: u32, half: f32| ((i as f32 + 0.5) / count as f32 * 2.0 - 1.0) * half;
    let mut lamps = Vec::new();
    for column in 0..columns {
        for row in 0..rows {
            let unevenness = scenario.light.unevenness;
            let power = 1.0 + rng.random_range(-1.0..=1.0) * unevenness;
            lamps.push(Lamp {
                x_m: place(column, columns, half_x),
                y_m: place(row, rows, half_y),
                z_m,
                power,
            });
        }
    }
    lamps
}

fn add_things(scene: &mut Scene, scenario: &Scenario, rng: &mut Rng) {
    for piece in &scenario.furniture {
        scene.add_furniture(piece.kind, &piece.at.pose(), rng);
    }
    for panel in &scenario.panels {
        let shape = Shape::upright(panel.from_m.into(), panel.to_m.into(), panel.bottom_m, panel.height_m);
        scene.add_painted(shape, &panel.paint, PANEL_PX_PER_M, rng);
    }
    for piece in &scenario.boxes {
        let pose = piece.at.pose();
        let cuboid = Cuboid {
            center: Point3::new(pose.x_m as f32, pose.y_m as f32, piece.bottom_m),
            size: Vector3::from(piece.size_m),
            yaw_rad: pose.yaw_rad as f32,
        };
        scene.add_cuboid(&cuboid, &piece.paint, &piece.paint, rng);
    }
}

fn add_ball(scene: &mut Scene, floor: &mut Floor, field: &Field, scenario: &Scenario, rng: &mut Rng) {
    if !scenario.ball.is_present {
        return;
    }
    let (half_x, half_y) = floor.half_m();
    let at = match scenario.ball.at_m {
        Some([x, y]) => Point2::new(x, y),
        None => Point2::new(rng.random_range(-0.55..0.55) * half_x, rng.random_range(-0.6..0.6) * half_y),
    };
    scene.add_ball(field, &at);
    floor.add_obstacle(at, 0.25);
}
