//! Buildings of any size.

use rand::RngExt;
use visloc_core::RngTree;
use visloc_world::office::{CorridorPlan, DoorPlan, Office, OfficePlan, SurfaceColor};

/// A corridor that winds back and forth, with doors on both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WindingCorridor {
    /// Straight legs, one beside the other.
    pub num_legs: usize,
    /// Length of each leg, meters.
    pub leg_m: f64,
    /// From one leg to the next, meters.
    pub pitch_m: f64,
    /// Width of the corridor, meters.
    pub width_m: f64,
    /// Width of each door, meters.
    pub door_m: f64,
    /// Smallest and largest wall between two doors, meters. Legs with odd numbers have doors at equal distances that face
    /// each other, so that places there look alike.
    pub gap_m: [f64; 2],
}

impl Default for WindingCorridor {
    /// About 250 m of corridor with about 150 doors.
    fn default() -> Self {
        Self { num_legs: 10, leg_m: 20.0, pitch_m: 5.0, width_m: 2.0, door_m: 0.9, gap_m: [0.4, 2.0] }
    }
}

impl WindingCorridor {
    /// The plan of the building. `random` gives numbers of [0, 1).
    pub fn plan(&self, name: &str, mut random: impl FnMut() -> f64) -> OfficePlan {
        let path = self.path();
        let mut plan = OfficePlan::named(name);
        plan.corridors.push(CorridorPlan::closed(self.outline(&path)));
        for leg in 0..self.num_legs {
            let (from, to) = (path[2 * leg], path[2 * leg + 1]);
            let is_regular = leg % 2 == 1;
            for side in [1.0, -1.0] {
                self.add_doors(&mut plan, (from, to), side, is_regular, &mut random);
            }
        }
        plan
    }

    /// Length of the whole corridor along its middle, meters.
    pub fn length_m(&self) -> f64 {
        self.num_legs as f64 * self.leg_m + self.num_legs.saturating_sub(1) as f64 * self.pitch_m
    }

    /// Middle of the corridor from corner to corner.
    fn path(&self) -> Vec<[f64; 2]> {
        let mut path = Vec::with_capacity(2 * self.num_legs);
        for leg in 0..self.num_legs {
            let y = leg as f64 * self.pitch_m;
            let (from, to) = if leg % 2 == 0 { (0.0, self.leg_m) } else { (self.leg_m, 0.0) };
            path.extend([[from, y], [to, y]]);
        }
        path
    }

    /// The path's left side there and its right side back.
    fn outline(&self, path: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let half = self.width_m / 2.0;
        let direction = |a: [f64; 2], b: [f64; 2]| {
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            [(b[0] - a[0]) / length, (b[1] - a[1]) / length]
        };
        let corner = |i: usize, side: f64| {
            let after = path.get(i + 1).map(|next| direction(path[i], *next));
            let before = i.checked_sub(1).map(|last| direction(path[last], path[i]));
            // Both walls of a corner are moved to the side; an end is moved along the path as well.
            let [one, other] = match (before, after) {
                (Some(before), Some(after)) => [before, after],
                (None, Some(after)) => [after, [-after[1] * side, after[0] * side]],
                (Some(before), None) => [before, [before[1] * side, -before[0] * side]],
                (None, None) => [[0.0; 2]; 2],
            };
            [path[i][0] - side * half * (one[1] + other[1]), path[i][1] + side * half * (one[0] + other[0])]
        };
        let there = (0..path.len()).map(|i| corner(i, 1.0));
        let back = (0..path.len()).rev().map(|i| corner(i, -1.0));
        there.chain(back).collect()
    }

    fn add_doors(
        &self,
        plan: &mut OfficePlan,
        (from, to): ([f64; 2], [f64; 2]),
        side: f64,
        is_regular: bool,
        random: &mut impl FnMut() -> f64,
    ) {
        let direction = (to[0] - from[0]).signum();
        let (start, end) = (self.width_m, self.leg_m - self.width_m);
        let [least, most] = self.gap_m;
        let mean = f64::midpoint(least, most);
        let mut at = start + if is_regular { 0.0 } else { random() * mean };
        while at + self.door_m <= end {
            let y = from[1] + side * direction * self.width_m / 2.0;
            let x = |s: f64| to_millimeters(from[0] + direction * s);
            plan.doors.push(DoorPlan {
                from: [x(at), y],
                to: [x(at + self.door_m), y],
                height_m: 2.05,
                color: SurfaceColor::RED,
                is_open: false,
            });
            at += self.door_m + if is_regular { mean } else { least + random() * (most - least) };
        }
    }
}

fn to_millimeters(value_m: f64) -> f64 {
    (value_m * 1000.0).round() / 1000.0
}

#[test]
fn the_default_is_a_building_of_the_promised_size() {
    let (corridor, mut rng) = (WindingCorridor::default(), RngTree::new(7).stream("building", 0));
    let office = Office::new("large", corridor.plan("large", || rng.random_range(0.0..1.0))).unwrap();
    assert!((240.0..260.0).contains(&corridor.length_m()), "{}", corridor.length_m());
    assert!((130..170).contains(&office.doors().len()), "{}", office.doors().len());
    // two meters wide, the walls kept clear by 0.1 m
    let area = office.free_space().area_m2();
    assert!((area / (corridor.length_m() * 1.8) - 1.0).abs() < 0.03, "{area}");
}
