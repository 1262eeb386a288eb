//! Maps that others made: every format, as it is meant, and damaged.

// Tables are long, and what takes too long is measured.
#![allow(clippy::unwrap_used, clippy::too_many_lines, clippy::type_complexity, clippy::disallowed_methods)]

use std::{
    f64::consts::FRAC_PI_2,
    time::{Duration, Instant},
};

use rand::{RngExt, SeedableRng};
use visloc_world::{Map, MapError, import::ImportNote, office::Office};

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

// ---- One plan in four forms

/// An L of 18 square meters with a door at the bottom and one at the left.
const LIST: &str = "\
walls:
  - [0, 0, 0, 5]
  - [0, 5, 2, 5]
  - [2, 5, 2, 2]
  - [2, 2, 6, 2]
  - [6, 2, 6, 0]
  - [6, 0, 0, 0]
doors:
  - {x1: 3.0, y1: 0, x2: 3.9, y2: 0}
  - {x1: 0, y1: 3.0, x2: 0, y2: 3.9}
";

/// The same in centimeters on a page with its origin at the upper left; the first door with its swing, its leaf open.
const SVG: &str = r##"<?xml version="1.0"?>
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">
<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 600 500" data-meters-per-unit="0.01">
  <style>.outer { stroke: #333; fill: none } .red { stroke: red }</style>
  <path class="outer" d="M0,500 V0 h200 v300 h400 l0,200 z"/>
  <g id="door-1"><path fill="none" d="M300,500 v-90 A90,90 0 0 1 390,500"/></g>
  <line class="red" x1="0" y1="200" x2="0" y2="110"/>
  <text x="3" y="3">Corridor</text>
</svg>"##;

/// Group codes and values in one line each.
fn dxf(pairs: &[(i32, &str)]) -> String {
    pairs.iter().map(|(code, value)| format!("{code:>3}\n{value}\n")).collect()
}

/// The pairs of the same plan in millimeters; both doors are copies of one block.
fn dxf_pairs() -> Vec<(i32, &'static str)> {
    let mut pairs = vec![(0, "SECTION"), (2, "HEADER"), (9, "$INSUNITS"), (70, "4"), (0, "ENDSEC")];
    pairs.extend([
        (0, "SECTION"),
        (2, "BLOCKS"),
        (0, "BLOCK"),
        (8, "0"),
        (2, "LEAF90"),
        (10, "50"),
        (20, "0"),
    ]);
    pairs.extend([(0, "ARC"), (8, "0"), (10, "50"), (20, "0"), (40, "900"), (50, "0"), (51, "90")]);
    pairs.extend([(0, "LINE"), (8, "0"), (10, "50"), (20, "0"), (11, "50"), (21, "900"), (0, "ENDBLK")]);
    pairs.extend([(0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES")]);
    pairs.extend([
        (0, "LWPOLYLINE"),
        (8, "A-WALL"),
        (90, "6"),
        (70, "1"),
        (10, "0"),
        (20, "0"),
        (10, "0"),
        (20, "5000"),
    ]);
    pairs.extend([(10, "2000"), (20, "5000"), (10, "2000"), (20, "2000"), (10, "6000"), (20, "2000")]);
    pairs.extend([
        (10, "6000"),
        (20, "0"),
        (0, "INSERT"),
        (8, "A-DOOR"),
        (2, "LEAF90"),
        (10, "3000"),
        (20, "0"),
    ]);
    // The other one is turned by a quarter and mirrored.
    pairs.extend([
        (0, "INSERT"),
        (8, "A-DOOR"),
        (2, "LEAF90"),
        (10, "0"),
        (20, "3900"),
        (41, "-1"),
        (50, "90"),
    ]);
    pairs.extend([
        (0, "TEXT"),
        (8, "A-DOOR"),
        (1, "T1"),
        (10, "0"),
        (20, "0"),
        (0, "LINE"),
        (8, "FURNITURE"),
    ]);
    pairs.extend([(10, "1"), (20, "1"), (11, "2"), (21, "2"), (0, "ENDSEC"), (0, "EOF")]);
    pairs
}

/// The same pairs as a binary file.
fn binary_dxf(pairs: &[(i32, &str)]) -> Vec<u8> {
    let mut bytes = b"AutoCAD Binary DXF\r\n\x1a\0".to_vec();
    for (code, value) in pairs {
        bytes.extend(i16::try_from(*code).unwrap().to_le_bytes());
        match code {
            10..=59 => bytes.extend(value.parse::<f64>().unwrap().to_le_bytes()),
            60..=79 => bytes.extend(value.parse::<i16>().unwrap().to_le_bytes()),
            90..=99 => bytes.extend(value.parse::<i32>().unwrap().to_le_bytes()),
            _ => bytes.extend([value.as_bytes(), b"\0"].concat()),
        }
    }
    bytes
}

const GRID: &str = "image: grid.pgm\nmode: trinary\nresolution: 0.05\norigin: [-0.5, -0.5, 0.0]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.25\n";

/// A picture with the value that each cell of 5 cm has; (x, y) in meters of its middle, from -0.5 m on.
fn pgm(value: impl Fn(f64, f64) -> u8) -> Vec<u8> {
    let mut picture = b"P5\n# CREATOR: map_saver\n140 120\n255\n".to_vec();
    let middle = |i: i32| f64::from(i) * 0.05 - 0.475;
    picture.extend(
        (0..120).rev().flat_map(|y| (0..140).map(move |x| (x, y))).map(|(x, y)| value(middle(x), middle(y))),
    );
    picture
}

/// Whether a place is in the L, grown by some meters.
fn is_in_l(x: f64, y: f64, grown_m: f64) -> bool {
    let is_in =
        |[right, top]: [f64; 2]| x > -grown_m && y > -grown_m && x < right + grown_m && y < top + grown_m;
    is_in([6.0, 2.0]) || is_in([2.0, 5.0])
}

/// The same as a grid as `map_saver` writes it: free, a wall of one cell, unknown.
fn l_shaped(x: f64, y: f64) -> u8 {
    if is_in_l(x, y, 0.0) {
        254
    } else if is_in_l(x, y, 0.05) {
        0
    } else {
        205
    }
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
        "2 INSERT of block \"LEAF90\" on layer A-DOOR (the first in line 91): taken as a door",
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

// ---- Grids

/// What becomes of a wide field of cells with one value, in a room whose other cells are surely free.
fn becomes(yaml: &str, picture: &[u8]) -> Result<&'static str, String> {
    let (map, _) = load_with("grid.yaml", yaml.as_bytes(), picture).map_err(|error| error.to_string())?;
    let Map::Office(office) = map else { panic!("a building") };
    if office.free_space().contains(1.0, 1.0) {
        return Ok("free");
    }
    // The field's border has walls if it is occupied.
    let middle = nalgebra::Point2::new(1.0, 1.0);
    let is_around =
        |wall: &visloc_world::office::Wall| (nalgebra::center(&wall.start, &wall.end) - middle).norm() < 1.0;
    Ok(if office.walls().iter().any(is_around) { "occupied" } else { "unknown" })
}

#[test]
fn cells_are_what_map_server_makes_of_them() {
    // Values by hand after the documentation: occ = (255 - value) / 255, or value / 255 with negate. Occupied above
    // occupied_thresh, free below free_thresh, else unknown; `scale` calls what rounds to 0 free and to 100 occupied; `raw`
    // takes the value as percent, above 100 unknown.
    let table: [(&str, &str, f64, f64, &[(u8, &str)]); 8] = [
        (
            "trinary",
            "0",
            0.65,
            0.196,
            &[(255, "free"), (206, "free"), (205, "unknown"), (90, "unknown"), (89, "occupied")],
        ),
        ("trinary", "0", 0.65, 0.25, &[(192, "free"), (191, "unknown"), (128, "unknown"), (0, "occupied")]),
        ("trinary", "0", 0.1, 0.05, &[(255, "free"), (243, "free"), (242, "unknown"), (229, "occupied")]),
        (
            "trinary",
            "1",
            0.65,
            0.25,
            &[(0, "free"), (63, "free"), (64, "unknown"), (165, "unknown"), (166, "occupied")],
        ),
        ("trinary", "true", 0.65, 0.25, &[(0, "free"), (255, "occupied")]),
        (
            "scale",
            "0",
            0.65,
            0.25,
            &[(255, "free"), (192, "free"), (191, "free"), (190, "unknown"), (0, "occupied")],
        ),
        ("scale", "0", 0.9, 0.1, &[(230, "free"), (128, "unknown"), (28, "unknown"), (26, "occupied")]),
        (
            "raw",
            "0",
            0.65,
            0.25,
            &[
                (0, "free"),
                (24, "free"),
                (25, "unknown"),
                (66, "occupied"),
                (100, "occupied"),
                (101, "unknown"),
                (255, "unknown"),
            ],
        ),
    ];
    for (mode, negate, occupied, free, cases) in table {
        let yaml = format!(
            "image: grid.pgm\nmode: {mode}\nresolution: 0.05\norigin: [-0.5, -0.5, 0]\nnegate: {negate}\n\
             occupied_thresh: {occupied}\nfree_thresh: {free}\n"
        );
        let (surely_free, surely_occupied) = match (mode, negate) {
            ("raw", _) => (0, 100),
            (_, "0") => (255, 0),
            _ => (0, 255),
        };
        for (value, expected) in cases {
            let picture = pgm(|x, y| match is_in_l(x, y, 0.0) {
                _ if (0.5..1.5).contains(&x) && (0.5..1.5).contains(&y) => *value,
                true => surely_free,
                false => surely_occupied,
            });
            let found = becomes(&yaml, &picture);
            assert_eq!(
                found.as_deref(),
                Ok(*expected),
                "{mode}, negate {negate}, {occupied}, {free}: {value}"
            );
        }
    }
}

/// A PNG of 140 x 120 cells with gray and opacity.
fn png(pixel: impl Fn(f64, f64) -> [u8; 2]) -> Vec<u8> {
    let middle = |i: u32| f64::from(i) * 0.05 - 0.475;
    let picture =
        image::GrayAlphaImage::from_fn(140, 120, |x, y| image::LumaA(pixel(middle(x), middle(119 - y))));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

#[test]
fn opacity_counts_as_map_server_counts_it() {
    let yaml = |mode: &str| GRID.replace("trinary", mode);
    // Occupied 0 + 0 + 0 + opacity: (0 + 0) / 4 is black, (3 * 100 + 255) / 4 is 139, which is unknown.
    for (mode, pixel, expected) in [
        ("trinary", [0, 0], "occupied"),
        ("trinary", [100, 255], "unknown"),
        ("trinary", [255, 0], "unknown"),
        ("scale", [255, 254], "unknown"),
        ("scale", [0, 0], "unknown"),
        ("scale", [255, 255], "free"),
    ] {
        let picture = png(|x, y| match is_in_l(x, y, 0.0) {
            _ if (0.5..1.5).contains(&x) && (0.5..1.5).contains(&y) => pixel,
            true => [255, 255],
            false => [0, 255],
        });
        assert_eq!(becomes(&yaml(mode), &picture).as_deref(), Ok(expected), "{mode} {pixel:?}");
    }
}

#[test]
fn unknown_is_neither_floor_nor_wall() {
    // The right end of the lower leg is not mapped.
    let picture = pgm(|x, y| if x > 4.0 && y > -0.3 { 205 } else { l_shaped(x, y) });
    let (office, notes) = office(load_with("grid.yaml", GRID.as_bytes(), &picture));
    assert!(office.free_space().contains(3.9, 1.0) && !office.free_space().contains(4.1, 1.0));
    let is_at_border =
        |wall: &visloc_world::office::Wall| (wall.start.x - 4.0).abs().max((wall.end.x - 4.0).abs()) < 0.1;
    assert!(!office.walls().iter().any(is_at_border), "nobody knows of a wall there: {:?}", office.walls());
    assert!(notes.contains("1 border from free to unknown"), "{notes}");
    assert!(notes.contains("taken 205 as unknown"), "{notes}");
    let map = Map::Office(office);
    assert_eq!(Map::parse("again", &map.to_toml().unwrap()).unwrap(), map);
}

#[test]
fn a_grid_lies_where_its_origin_and_yaw_say() {
    let turned = GRID.replace("[-0.5, -0.5, 0.0]", &format!("[10.0, 20.0, {FRAC_PI_2}]"));
    let (office, _) = office(load_with("grid.yaml", turned.as_bytes(), &pgm(l_shaped)));
    // (x, y) of the L, 0.5 m from the picture's corner, is (10 - (y + 0.5), 20 + (x + 0.5)) now.
    assert!(office.free_space().contains(8.5, 26.0) && office.free_space().contains(5.5, 21.0));
    assert!(!office.free_space().contains(6.5, 24.5));
}

#[test]
fn strange_values_of_a_grid_are_refused() {
    let picture = pgm(l_shaped);
    for (from, to, expected) in [
        ("trinary", "fuzzy", "fuzzy"),
        ("negate: 0", "negate: 7", "negate: expected 0, 1, false or true, found 7"),
        ("resolution: 0.05", "resolution: 0", "resolution: expected meters a cell"),
        (
            "occupied_thresh: 0.65",
            "occupied_thresh: 0.1",
            "occupied_thresh: expected at least free_thresh, found 0.1",
        ),
        ("occupied_thresh: 0.65", "occupied_thresh: 65", "occupied_thresh: expected above 0, at most 1"),
        ("free_thresh: 0.25", "free_thresh: .nan", "free_thresh: expected above 0"),
        ("[-0.5, -0.5, 0.0]", "[-0.5, -0.5]", "line 4"),
        ("resolution: 0.05", "resolution: 9", "is the unit right?"),
    ] {
        let yaml = GRID.replace(from, to);
        let error = load_with("grid.yaml", yaml.as_bytes(), &picture).unwrap_err().to_string();
        assert!(error.contains(expected), "{to}: {error}");
    }
    let huge = load_with("grid.yaml", GRID.as_bytes(), b"P5\n99999 99999\n255\n").unwrap_err().to_string();
    assert!(huge.contains("99999 x 99999 cells, more than"), "{huge}");
    let empty = load_with("grid.yaml", GRID.as_bytes(), b"P5\n00 24\n255\n").unwrap_err().to_string();
    assert!(empty.contains("grid.pgm: 0 x 24 cells: it is empty"), "{empty}");
    let other = load_with("grid.yaml", GRID.as_bytes(), b"\xff\xd8\xff\xe0 JFIF").unwrap_err().to_string();
    assert!(other.contains("image: expected a PGM, PNG or BMP picture, found grid.pgm: Jpeg"), "{other}");
}

// ---- Drawings

/// What a drawing becomes: walls in the plan, doors, square meters of floor, and a part of the notes.
type Expected = Result<(usize, usize, f64, &'static str), &'static str>;

/// What is wrong with a drawing; empty if it becomes what is expected.
fn check(name: &str, what: &str, bytes: &[u8], expected: &Expected) -> String {
    let (num_walls, num_doors, area_m2, note) = match (load(name, bytes), expected) {
        (Err(error), Err(part)) if error.to_string().contains(part) => return String::new(),
        (Err(error), _) => return format!("{what}: {error}\n"),
        (Ok(_), Err(part)) => return format!("{what}: expected {part:?}\n"),
        (Ok(_), Ok(expected)) => *expected,
    };
    let (office, notes) = office(load(name, bytes));
    let (plan, area) = (office.plan(), office.free_space().area_m2());
    let is_same = (plan.walls.len(), plan.doors.len()) == (num_walls, num_doors);
    // Without the 10 cm beside the walls.
    let is_as_large = (area - area_m2).abs() < 0.04 * area_m2 + 0.1;
    if is_same && is_as_large && notes.contains(note) {
        return String::new();
    }
    let found = format!("{} walls, {} doors, {area:.2} m2", plan.walls.len(), plan.doors.len());
    format!("{what}: {found}, expected {expected:?}; {notes}\n")
}

#[test]
fn drawings_as_svg() {
    // A room of 4 x 3 m inside; 3.8 x 2.8 m without the clearance.
    const ROOM: f64 = 3.8 * 2.8;
    let line_room = r##"<g stroke="black" fill="none"><path d="M0 0h4v3h-4z"/></g>"##;
    let cases: [(&str, String, Expected); 24] = [
        ("lines", line_room.to_owned(), Ok((4, 0, ROOM, ""))),
        ("a frame of filled rectangles", r##"<g id="walls"><rect x="-.2" y="-.2" width="4.4" height=".2" fill="#222"/>
            <rect x="-.2" y="3" width="4.4" height=".2" fill="#222"/><rect x="-.2" y="-.2" width=".2" height="3.4" fill="#222"/>
            <rect x="4" y="-.2" width=".2" height="3.4" fill="#222"/></g>"##.to_owned(), Ok((8, 0, ROOM, ""))),
        ("a filled frame with a hole", r##"<path fill="black" fill-rule="evenodd" d="M-.3-.3H4.3V3.3H-.3ZM0 0H4V3H0Z"/>"##.to_owned(),
            Ok((8, 0, ROOM, ""))),
        ("a filled pillar", format!(r##"{line_room}<rect class="wall" fill="gray" x="1" y="1" width="1" height="1"/>"##),
            Ok((8, 0, ROOM - 1.44, ""))),
        ("a thick wall drawn with two lines", format!(r##"{line_room}<path id="wall" d="M-.3-.3h4.6v3.6h-4.6z"/>"##),
            Ok((8, 0, ROOM, ""))),
        ("a style sheet", r##"<style>.w { stroke: #444 } #d { stroke: rgb(200, 0, 0) } .gone { display: none }</style>
            <rect class="w" width="4" height="3" fill="none"/><line id="d" x1="1" x2="1.9" y1="0"/>
            <rect class="w gone" width="9" height="9"/>"##.to_owned(), Ok((4, 1, ROOM, "display is none"))),
        ("a style attribute", r##"<rect style="stroke:#000;fill:none" width="4" height="3"/>"##.to_owned(), Ok((4, 0, ROOM, ""))),
        ("transforms", r##"<g transform="rotate(90) scale(2)"><g transform="matrix(.5 0 0 .5 0 0) skewX(0)" stroke="black">
            <path d="M0 0l4 0 0 3-4 0z" fill="none"/></g></g>"##.to_owned(), Ok((4, 0, ROOM, ""))),
        ("a copy", r##"<defs><path id="room" d="M0 0h4v3h-4z" stroke="black" fill="none"/></defs>
            <use href="#room" x="3" y="2"/><use href="#nowhere"/>"##.to_owned(), Ok((4, 0, ROOM, "what it shows is not in the file"))),
        ("a symbol", r##"<symbol id="room"><path d="M0 0h4v3h-4z" stroke="black" fill="none"/></symbol>
            <use xlink:href="#room" xmlns:xlink="http://www.w3.org/1999/xlink"/>"##.to_owned(), Ok((4, 0, ROOM, ""))),
        ("a round room", r##"<circle class="wall" fill="none" r="2"/>"##.to_owned(), Ok((48, 0, 3.15 * 1.9 * 1.9, ""))),
        ("a bay", r##"<path id="wall" fill="none" d="M0 0H4V3H3A1 1 0 0 1 1 3H0Z"/>"##.to_owned(), Ok((23, 0, ROOM + 1.3, ""))),
        ("a swing in a gap", r##"<g id="wall" stroke="black" fill="none"><path d="M1 0H0V3H4V0H1.9"/></g>
            <g id="door"><path d="M1 0v.9"/><path d="M1 .9C1.5.9 1.9.5 1.9 0"/></g>"##.to_owned(),
            Ok((6, 1, ROOM, "passed over, no wall within 5 cm of both ends"))),
        ("a door in a filled wall", r##"<g id="wall"><path fill="black" d="M1 0V-.2H-.2V3.2H4.2V-.2H1.9V0H4V3H0V0Z"/></g>
            <rect class="door" fill="blue" x="1" y="-.2" width=".9" height=".2"/>"##.to_owned(), Ok((13, 1, ROOM, ""))),
        ("lines over each other", format!(r##"{line_room}<path stroke="black" d="M-1 0H5"/><path stroke="black" d="M0 0H4"/>"##),
            Ok((4, 0, ROOM, ""))),
        ("colored areas and texts", format!(r##"{line_room}<rect fill="green" width="1" height="1"/><text>x</text><image/>"##),
            Ok((4, 0, ROOM, "1 <rect> (in line 3): passed over, neither named"))),
        ("a hidden room", r##"<g visibility="hidden"><rect stroke="black" width="4" height="3"/></g>"##.to_owned(), Err("not visible")),
        ("nothing", "<text/>".to_owned(), Err("found none; 1 <text>")),
        ("a broken path", r##"<path id="wall" d="M0 0 L1"/>"##.to_owned(), Err("line 3: <path> \"wall\": d: expected a path")),
        ("a place nowhere", r##"<path id="wall" d="M0 0 C1e300 0 1 1 2 2"/>"##.to_owned(), Err("at most 10000 m from the origin")),
        ("percent", r##"<rect id="wall" width="50%" height="3"/>"##.to_owned(), Err("width: expected a number, found \"50%\"")),
        ("a copy of itself", r##"<g id="wall"><use href="#wall"/></g>"##.to_owned(), Err("at most 200 elements inside of each other")),
        ("deep", "<g>".repeat(1000) + &"</g>".repeat(1000), Err("at most 200 elements inside of each other")),
        ("an unknown entity", "&lol;".to_owned(), Err("map plan.svg, line 3")),
    ];
    let mut wrong = String::new();
    for (what, inside, expected) in cases {
        let text =
            format!("<svg xmlns=\"http://www.w3.org/2000/svg\" \n viewBox=\"0 0 10 10\">\n{inside}</svg>");
        wrong += &check("plan.svg", what, text.as_bytes(), &expected);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Sections around entities and blocks.
fn drawing(blocks: &[(i32, &str)], entities: &[(i32, &str)]) -> String {
    let mut pairs = vec![(0, "SECTION"), (2, "BLOCKS")];
    pairs.extend(blocks);
    pairs.extend([(0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES")]);
    pairs.extend(entities);
    pairs.extend([(0, "ENDSEC"), (0, "EOF")]);
    dxf(&pairs)
}

#[test]
fn drawings_as_dxf() {
    const ROOM: f64 = 3.8 * 2.8;
    let room = [
        (0, "POLYLINE"),
        (8, "WALLS"),
        (10, "0"),
        (20, "0"),
        (70, "1"),
        (0, "VERTEX"),
        (8, "WALLS"),
        (10, "0"),
        (20, "0"),
        (0, "VERTEX"),
        (8, "WALLS"),
        (10, "4"),
        (20, "0"),
        (0, "VERTEX"),
        (8, "WALLS"),
        (10, "4"),
        (20, "3"),
        (0, "VERTEX"),
        (8, "WALLS"),
        (10, "0"),
        (20, "3"),
        (0, "SEQEND"),
        (8, "WALLS"),
    ];
    let with = |more: &[(i32, &'static str)]| [&room[..], more].concat();
    let wall = [
        (0, "BLOCK"),
        (2, "SIDE"),
        (10, "1"),
        (20, "1"),
        (0, "LINE"),
        (8, "0"),
        (10, "1"),
        (20, "1"),
        (11, "2"),
        (21, "1"),
        (0, "ENDBLK"),
    ];
    let side = |x, y, scale, turn| {
        [(0, "INSERT"), (8, "WALLS"), (2, "SIDE"), (10, x), (20, y), (41, scale), (50, turn)]
    };
    let sides = [
        side("0", "0", "4", "0"),
        side("0", "3", "4", "0"),
        side("0", "0", "3", "90"),
        side("4", "0", "3", "90"),
    ]
    .concat();
    let array = [
        (0, "INSERT"),
        (8, "WALLS"),
        (2, "SIDE"),
        (10, "0.5"),
        (20, "0.5"),
        (41, "0.2"),
        (70, "2"),
        (71, "3"),
        (44, "2"),
        (45, "1"),
    ];
    let itself = [(0, "BLOCK"), (2, "A"), (0, "INSERT"), (2, "A"), (0, "ENDBLK")];
    let nested = [
        &wall[..],
        &[
            (0, "BLOCK"),
            (2, "TWO"),
            (0, "INSERT"),
            (8, "0"),
            (2, "SIDE"),
            (10, "1"),
            (20, "1"),
            (0, "ENDBLK"),
        ],
    ]
    .concat();
    let bulge = [
        (0, "LWPOLYLINE"),
        (8, "WALLS"),
        (70, "1"),
        (10, "0"),
        (20, "0"),
        (10, "4"),
        (20, "0"),
        (10, "4"),
        (20, "3"),
        (42, "1"),
        (10, "0"),
        (20, "3"),
    ];
    let mirrored = [
        (0, "LWPOLYLINE"),
        (8, "WALLS"),
        (70, "1"),
        (230, "-1"),
        (10, "0"),
        (20, "0"),
        (10, "-4"),
        (20, "0"),
        (10, "-4"),
        (20, "3"),
        (10, "0"),
        (20, "3"),
    ];
    let cases: [(&str, String, Expected); 16] = [
        ("an old closed polyline", drawing(&[], &room), Ok((4, 0, ROOM, "without a unit"))),
        ("blocks, scaled and turned", drawing(&wall, &sides), Ok((4, 0, ROOM, ""))),
        ("an array of blocks", drawing(&wall, &with(&array)), Ok((10, 0, ROOM - 6.0 * 0.075, ""))),
        (
            "a block in a block",
            drawing(&nested, &with(&[(0, "INSERT"), (8, "WALLS"), (2, "TWO"), (10, "1"), (20, "1")])),
            Ok((5, 0, ROOM - 0.2, "")),
        ),
        ("a mirrored polyline", drawing(&[], &mirrored), Ok((4, 0, ROOM, ""))),
        ("a half circle", drawing(&[], &bulge), Ok((26, 0, ROOM + 6.2, ""))),
        (
            "a column",
            drawing(&[], &with(&[(0, "CIRCLE"), (8, "WALLS"), (10, "2"), (20, "1.5"), (40, "0.3")])),
            Ok((22, 0, ROOM - 0.5, "")),
        ),
        (
            "a door as a line",
            drawing(
                &[],
                &with(&[(0, "LINE"), (8, "Door"), (62, "5"), (10, "1"), (20, "3"), (11, "1.9"), (21, "3")]),
            ),
            Ok((4, 1, ROOM, "")),
        ),
        (
            "a door off the walls",
            drawing(&[], &with(&[(0, "LINE"), (8, "Door"), (10, "1"), (20, "2"), (11, "1.9"), (21, "2")])),
            Ok((4, 0, ROOM, "1 LINE on layer Door (in line 57): passed over, no wall")),
        ),
        (
            "a spline and a hatch",
            drawing(&[], &with(&[(0, "SPLINE"), (8, "WALLS"), (0, "HATCH"), (8, "WALLS")])),
            Ok((4, 0, ROOM, "1 SPLINE on layer WALLS")),
        ),
        (
            "a block that is not there",
            drawing(&[], &with(&[(0, "INSERT"), (8, "A-DOOR"), (2, "X")])),
            Ok((4, 0, ROOM, "no such block")),
        ),
        (
            "a sheet of paper",
            drawing(&[], &with(&[(0, "LINE"), (8, "WALLS"), (67, "1"), (11, "9"), (21, "9")])),
            Ok((4, 0, ROOM, "")),
        ),
        (
            "a block in itself",
            drawing(&itself, &with(&[(0, "INSERT"), (2, "A")])),
            Err("at most 16 blocks inside of each other"),
        ),
        (
            "many copies",
            drawing(&wall, &with(&[(0, "INSERT"), (2, "SIDE"), (70, "30000"), (71, "30000")])),
            Err("at most 10000 copies"),
        ),
        (
            "far away",
            drawing(&[], &with(&[(0, "ARC"), (8, "WALLS"), (10, "1e12"), (40, "1e300")])),
            Err("at most 10000 m from the origin"),
        ),
        (
            "other layers",
            drawing(&[], &[(0, "LINE"), (8, "OUTER"), (11, "9"), (21, "9")]),
            Err("found lines on OUTER"),
        ),
    ];
    let mut wrong = String::new();
    for (what, text, expected) in cases {
        wrong += &check("plan.dxf", what, text.as_bytes(), &expected);
    }
    let umlauts = drawing(&[], &room).replace("WALLS", "WALL-T\u{dc}R");
    let latin: Vec<u8> = umlauts.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    wrong += &check("plan.dxf", "an old code page", &latin, &Ok((4, 0, ROOM, "")));
    assert!(wrong.is_empty(), "{wrong}");
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

// ---- Limits and damages

#[test]
fn large_files_are_refused_or_read_in_time() {
    let svg = |inside: String| format!("<svg viewBox=\"0 0 1 1\">{inside}</svg>");
    let lines = |count: usize, of: &dyn Fn(usize) -> String| (0..count).map(of).collect::<String>();
    let wall = |i: usize| {
        format!("<path id=\"wall\" d=\"M{} {}h1\"/>", (i % 200) as f64 * 2.0, (i / 200) as f64 * 2.0)
    };
    let rules = format!("<style>{}</style>", lines(20_000, &|i| format!(".a{i} g > b {{fill:red}}")));
    let list =
        |count: usize| format!("walls:\n{}", lines(count, &|i| format!(" - [0, {i}.0, 0.1, {i}.0]\n")));
    let cases: [(&str, &str, String, Option<&str>); 8] = [
        (
            "200,000 groups in each other",
            "a.svg",
            svg("<g>".repeat(200_000) + &"</g>".repeat(200_000)),
            Some("at most 200"),
        ),
        ("50,000 walls", "a.svg", svg(lines(50_000, &wall)), Some("at most 40000")),
        ("18,000 walls", "a.svg", svg(lines(18_000, &wall)), None),
        ("many rules", "a.svg", svg(rules + &"<g/>".repeat(10_000)), Some("at most 128 kB")),
        ("walls one upon the other", "a.svg", svg("<path id=\"wall\" d=\"M0 0h9\"/>".repeat(15_000)), None),
        ("30,000 walls in a list", "a.yaml", list(30_000), Some("at most 20000")),
        ("9,000 walls in a list", "a.yaml", list(9_000), None),
        (
            "a huge building",
            "a.yaml",
            "walls:\n - [0, 0, 9000, 0]\n - [9000, 0, 9000, 9000]\n".into(),
            Some("is the unit right?"),
        ),
    ];
    for (what, name, text, expected) in cases {
        let begin = Instant::now();
        match (load(name, &text), expected) {
            (Ok(_), None) => {}
            (Err(error), Some(part)) => assert!(error.to_string().contains(part), "{what}: {error}"),
            (other, _) => panic!("{what}: {:?}", other.map(|_| ())),
        }
        let limit = if cfg!(debug_assertions) { 30 } else { 5 };
        assert!(begin.elapsed() < Duration::from_secs(limit), "{what}: {:?}", begin.elapsed());
    }
}

#[test]
fn damaged_files_are_read_or_refused_with_a_sentence() {
    let picture = pgm(l_shaped);
    let files: [(&str, Vec<u8>); 5] = [
        ("plan.svg", SVG.into()),
        ("plan.dxf", dxf(&dxf_pairs()).into_bytes()),
        ("binary.dxf", binary_dxf(&dxf_pairs())),
        ("plan.yaml", LIST.into()),
        ("grid.yaml", GRID.into()),
    ];
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let try_one = |name: &str, bytes: &[u8], picture: &[u8]| {
        let begin = Instant::now();
        let loaded = load_with(name, bytes, picture);
        assert!(begin.elapsed() < Duration::from_secs(1), "{name}: {:?}", begin.elapsed());
        match loaded {
            Ok((map, _)) => drop(map.what_hinders_localization()),
            Err(error) => {
                let text = error.to_string();
                assert!(text.starts_with("map ") && text.len() < 2000, "{text}");
            }
        }
    };
    for (name, bytes) in &files {
        for part in 0..20 {
            try_one(name, &bytes[..bytes.len() * part / 20], &picture);
        }
        for _ in 0..100 {
            let mut damaged = bytes.clone();
            for _ in 0..rng.random_range(1..6) {
                let at = rng.random_range(0..damaged.len());
                damaged[at] = if rng.random_bool(0.5) {
                    rng.random()
                } else {
                    b"0123456789-.eE <>/\n"[rng.random_range(0..19)]
                };
            }
            try_one(name, &damaged, &picture);
        }
    }
    for _ in 0..300 {
        let letter = |_| char::from(b".#*{}:;,>@/[]()\"'ab 0-!+~|=\\"[rng.random_range(0..28)]);
        let sheet: String = (0..40).map(letter).collect();
        try_one(
            "plan.svg",
            format!("<svg><style><![CDATA[{sheet}]]></style><g/></svg>").as_bytes(),
            &picture,
        );
    }
    for part in 0..20 {
        try_one("grid.yaml", GRID.as_bytes(), &picture[..picture.len() * part / 20]);
    }
    for _ in 0..50 {
        let mut damaged = picture.clone();
        let at = rng.random_range(0..40);
        damaged[at] = rng.random();
        try_one("grid.yaml", GRID.as_bytes(), &damaged);
    }
}
