//! Grids: cells, origins, values.

use std::f64::consts::FRAC_PI_2;

use visloc_world::Map;

use super::{
    load_with, office,
    plan::{GRID, is_in_l, l_shaped, pgm},
};

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
        ("[-0.5, -0.5, 0.0]", "[-0.5, -0.5, 90]", "an angle in radians, found [-0.5, -0.5, 90.0]"),
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
