//! Maps that others made: every format, as it is meant, and damaged.

// Tables are long, and what takes too long is measured.
#![allow(clippy::unwrap_used, clippy::too_many_lines, clippy::type_complexity, clippy::disallowed_methods)]

mod damages;
mod drawings;
mod grids;
mod plan;

use visloc_world::{ImportNote, Map, MapError, office::Office};

use plan::{GRID, LIST, SVG, binary_dxf, dxf, dxf_pairs, l_shaped, pgm};

type Loaded = Result<(Map, Vec<ImportNote>), MapError>;

/// A map from text or bytes; grids have `picture`.
fn load_with(name: &str, bytes: &[u8], picture: &[u8]) -> Loaded {
    Map::from_bytes(name, bytes, |_| Ok(picture.to_vec()))
}

fn load(name: &str, bytes: impl AsRef<[u8]>) -> Loaded {
    load_with(name, bytes.as_ref(), &[])
}

fn office(loaded: Loaded) -> (Office, String) {
    let (map, notes) = loaded.unwrap();
    let Map::Office(office) = map else { panic!("a building, not {}", map.name()) };
    (office, notes.iter().map(|note| format!("{note}\n")).collect())
}

/// Walls that are seen from the floor: their ends in the order in which they sort.
fn seen_walls(office: &Office) -> Vec<[[f64; 2]; 2]> {
    let is_seen = |wall: &&visloc_world::office::Wall| {
        let beside = nalgebra::center(&wall.start, &wall.end) + wall.normal() * 0.2;
        office.free_space().contains(beside.x, beside.y)
    };
    let ends = |wall: &visloc_world::office::Wall| [[wall.start.x, wall.start.y], [wall.end.x, wall.end.y]];
    let mut walls: Vec<_> = office.walls().iter().filter(is_seen).map(ends).collect();
    walls.sort_by(|a, b| a.partial_cmp(b).unwrap());
    walls
}

fn seen_doors(office: &Office) -> Vec<[f64; 4]> {
    let is_seen = |door: &&visloc_world::office::Door| {
        let beside = nalgebra::center(&door.left, &door.right) + office.walls()[door.wall].normal() * 0.2;
        office.free_space().contains(beside.x, beside.y)
    };
    let ends = |door: &visloc_world::office::Door| [door.left.x, door.left.y, door.right.x, door.right.y];
    let mut doors: Vec<_> = office.doors().iter().filter(is_seen).map(ends).collect();
    doors.sort_by(|a, b| a.partial_cmp(b).unwrap());
    doors
}

#[test]
fn one_plan_is_the_same_map_in_every_format() {
    let (list, _) = office(load("plan.yaml", LIST));
    assert_eq!((seen_walls(&list).len(), seen_doors(&list).len()), (6, 2));
    let forms = [
        ("plan.svg", office(load("plan.svg", SVG)), 0.01),
        ("plan.dxf", office(load("plan.dxf", dxf(&dxf_pairs()))), 0.01),
        ("binary.dxf", office(load("binary.dxf", binary_dxf(&dxf_pairs()))), 0.01),
        ("grid.yaml", office(load_with("grid.yaml", GRID.as_bytes(), &pgm(l_shaped))), 0.05),
    ];
    for (name, (office, notes), tolerance_m) in forms {
        let (walls, expected) = (seen_walls(&office), seen_walls(&list));
        assert_eq!(walls.len(), expected.len(), "{name}: {walls:?}");
        for (wall, other) in walls.as_flattened().iter().zip(expected.as_flattened()) {
            let off_m = (wall[0] - other[0]).hypot(wall[1] - other[1]);
            assert!(off_m < tolerance_m, "{name}: {wall:?} is not {other:?}");
        }
        if name != "grid.yaml" {
            let (doors, expected) = (seen_doors(&office), seen_doors(&list));
            assert_eq!(doors.len(), 2, "{name}: {doors:?}\n{notes}");
            for (edge, other) in doors.as_flattened().iter().zip(expected.as_flattened()) {
                assert!((edge - other).abs() < tolerance_m, "{name}: {doors:?} are not {expected:?}");
            }
        }
        let area_m2 = office.free_space().area_m2();
        assert!((area_m2 - list.free_space().area_m2()).abs() < 0.25, "{name}: {area_m2} m2");
        for (x, y) in [(1.0, 4.5), (5.5, 1.0), (0.3, 0.3)] {
            assert!(office.free_space().contains(x, y), "{name}: ({x}, {y}) is floor");
        }
        for (x, y) in [(4.0, 4.0), (2.5, 2.5), (-0.2, 1.0)] {
            assert!(!office.free_space().contains(x, y), "{name}: ({x}, {y}) is not floor");
        }
    }
}

#[test]
fn what_was_passed_over_is_counted() {
    let (_, notes) = office(load("plan.dxf", dxf(&dxf_pairs())));
    for expected in [
        "2 x INSERT of block \"LEAF90\" on layer A-DOOR (the first in line 91): taken as a door",
        "1 LINE on layer FURNITURE (in line ",
        "passed over, its layer names neither wall, door nor corridor",
        "1 TEXT on layer A-DOOR",
    ] {
        assert!(notes.contains(expected), "{expected}\n{notes}");
    }
    let (_, notes) = office(load("plan.svg", SVG));
    assert!(notes.contains("1 <text> (in line 8): passed over, not a line or an area"), "{notes}");
    assert!(notes.contains("1 <path> (in line 6): taken as a door"), "{notes}");
}

#[test]
fn a_format_is_known_by_its_content() {
    let (_, text) = visloc_world::BUILT_IN_MAPS[0];
    assert!(matches!(load("field.yaml", text).unwrap().0, Map::Field(_)), "TOML under another name");
    assert!(load("plan", SVG).is_ok() && load("plan.bin", binary_dxf(&dxf_pairs())).is_ok());
    let other =
        load("field.yaml", "length: 6.0\nwidth: 4.0\nlines:\n - [0, 0, 1, 1]\n").unwrap_err().to_string();
    assert!(other.contains("expected walls") && other.contains("found only length, lines, width"), "{other}");
    assert!(other.contains("TOML"), "{other}");
    let picture = load("grid.pgm", pgm(l_shaped)).unwrap_err().to_string();
    assert!(picture.contains("give the YAML file"), "{picture}");
    assert!(load("a.toml", b"\xff\xfe\0").unwrap_err().to_string().contains("found other data"));
    #[cfg(unix)]
    assert!(Map::load("/dev/zero").unwrap_err().to_string().contains("may never end"));
}

#[test]
fn what_hinders_localization_is_told() {
    let hints = |loaded: Loaded| {
        let hindrances = loaded.unwrap().0.what_hinders_localization();
        hindrances.iter().map(|hindrance| format!("{hindrance}\n")).collect::<String>()
    };
    let list = |from: &str, to: &str| {
        assert!(LIST.contains(from));
        hints(load("plan.yaml", LIST.replace(from, to)))
    };
    assert_eq!(hints(load("plan.yaml", LIST)), "");
    let without_doors = &LIST[..LIST.find("doors").unwrap()];
    assert!(hints(load("plan.yaml", without_doors)).starts_with("no doors: "));
    assert!(list("y2: 0}", "y2: 0, open: true}").is_empty());
    assert!(list("[6, 2, 6, 0]", "[6, 2, 6, 0.4]").contains("they end freely at (6.00, 0.40), (6.00, 0.00)"));
    let large: String = LIST.replace("walls:", "walls:\n  - [20, 20, 2000, 20]");
    assert!(hints(load("plan.yaml", large)).contains("is the unit right?"));
    let field = visloc_world::BUILT_IN_MAPS.iter().find(|(name, _)| *name == "robocup-spl-2010").unwrap().1;
    let long = field.replace("length_m = 6", "length_m = 160");
    assert!(field != long);
    assert!(hints(load("field.toml", long)).starts_with("it is 160.00 x 4.00 m large; is the unit right?"));
    assert_eq!(hints(load("field.toml", field)), "");
    let symmetric = "walls:\n  - [0, 0, 0, 2]\n  - [0, 2, 6, 2]\n  - [6, 2, 6, 0]\n  - [6, 0, 0, 0]\ndoors:\n  \
                     - {x1: 1, y1: 0, x2: 2, y2: 0}\n  - {x1: 4, y1: 2, x2: 5, y2: 2}\n";
    assert!(hints(load("plan.yaml", symmetric)).contains("looks the same from 2 poses"));
    let apart = "walls:\n  - [10, 0, 10, 2]\n  - [10, 2, 13, 2]\n  - [13, 2, 13, 0]\n  - [13, 0, 10, 0]";
    assert!(hints(load("plan.yaml", LIST.replace("walls:", apart))).contains("the floor has 2 parts"));
    for (name, _) in visloc_world::BUILT_IN_MAPS.iter().filter(|(name, _)| name.starts_with("office")) {
        assert_eq!(hints(Ok((Map::load(name).unwrap(), Vec::new()))), "", "{name}");
    }
}

#[test]
fn a_drawing_has_the_scale_that_it_says() {
    let svg = |size: &str| {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" {size} viewBox=\"0 0 200 50\"><path id=\"wall\" d=\"M0 0H200V25H0Z\"/></svg>"
        );
        let (Map::Office(office), notes) = load("plan.svg", text).unwrap() else { panic!("no building") };
        let [min, max] = office.free_space().bounds_m();
        ((max - min).x.round(), notes.iter().map(|note| format!("{note}\n")).collect::<String>())
    };
    for (size, length_m, said) in [
        ("", 200.0, "taken for 1 m a unit; data-meters-per-unit"),
        ("width=\"200\" height=\"50\"", 200.0, "taken for 1 m a unit;"),
        ("width=\"20m\"", 20.0, "taken for 0.1 m a unit, by its size and its viewBox;"),
        ("width=\"20000mm\" height=\"5000mm\"", 20.0, "taken for 0.1 m a unit"),
        ("height=\"500cm\"", 20.0, "taken for 0.1 m a unit"),
        ("width=\"20m\" data-meters-per-unit=\"0.5\"", 100.0, ""),
    ] {
        let (found_m, notes) = svg(size);
        assert!(found_m == length_m && notes.contains(said), "{size}: {found_m} m, {notes}");
        assert_eq!(notes.is_empty(), said.is_empty(), "{size}: {notes}");
    }
}
