use std::{fs, path::PathBuf};

use rand::RngExt as _;
use visloc_core::{Rng, RngTree};

use super::{Import, ImportNote, grid, list, read_dxf, read_svg};
use crate::{
    Map,
    office::{Office, SurfaceColor},
};

/// A corridor of 6 x 2 m whose upper wall is interrupted by a door, in centimeters, moved by a group.
const SVG: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" data-meters-per-unit="0.01">
  <g id="walls" transform="translate(100 0)">
    <polyline points="100,0 0,0 0,200 600,200 600,0 190,0"/>
  </g>
  <g transform="translate(100,0)">
    <path class="door" stroke="#2040c0" d="M100 0h90"/>
    <line style="stroke: red" x1="300" y1="200" x2="390" y2="200"/>
    <text>not a wall</text>
  </g>
</svg>"##;

fn office(name: &str, import: Result<Import, crate::MapError>) -> Office {
    Office::new(name, import.unwrap().plan).unwrap()
}

#[test]
fn an_svg_names_walls_and_doors_by_group_class_or_color() {
    let office = office("plan.svg", read_svg("plan.svg", "plan", SVG));
    assert_eq!(office.plan().walls.len(), 6, "five and the one behind the door");
    let doors = &office.plan().doors;
    assert_eq!(doors.len(), 2);
    assert_eq!((doors[0].from, doors[0].to), ([2.0, 0.0], [2.9, 0.0]));
    assert_eq!(doors[0].color.rgb, [0x20, 0x40, 0xc0]);
    // y points down in the image.
    assert_eq!((doors[1].from, doors[1].to), ([4.0, -2.0], [4.9, -2.0]));
    assert_eq!(doors[1].color, SurfaceColor::RED);
    assert!(office.free_space().contains(4.0, -1.0) && !office.free_space().contains(4.0, -2.0));
}

#[test]
fn a_drawing_smaller_than_a_room_has_a_wrong_unit() {
    let small = SVG.replace("per-unit=\"0.01\"", "per-unit=\"0.0001\"");
    let error = read_svg("plan.svg", "plan", &small).unwrap_err().to_string();
    assert!(error.contains("at least 1 m, found a drawing of 60.0 x 20.0 mm; is its unit right?"), "{error}");
}

#[test]
fn doors_without_walls_are_no_plan_and_say_what_else_there_is() {
    let text = "<svg xmlns=\"http://www.w3.org/2000/svg\"><text x=\"1\" y=\"1\">lab</text>\
                <line id=\"door-1\" x1=\"0\" y1=\"0\" x2=\"2\" y2=\"0\" stroke=\"red\"/></svg>";
    let error = read_svg("plan.svg", "plan", text).unwrap_err().to_string();
    assert!(error.contains("expected at least one wall") && error.contains("<text>"), "{error}");
}

#[test]
fn filled_walls_may_share_a_side() {
    let wall = |x: f64, y: f64, width: f64, height: f64| {
        format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"black\"/>")
    };
    let walls = [
        wall(0.0, 0.0, 10.0, 0.2),
        wall(0.0, 4.8, 10.0, 0.2),
        wall(0.0, 0.2, 0.2, 4.6),
        wall(9.8, 0.2, 0.2, 4.6),
    ];
    let text = format!("<svg xmlns=\"http://www.w3.org/2000/svg\">{}</svg>", walls.concat());
    let office = office("rect.svg", read_svg("rect.svg", "rect", &text));
    assert_eq!(office.plan().walls.len(), 8, "outside and inside");
    assert!(office.free_space().contains(5.0, -2.5));
}

#[test]
fn svg_errors_name_the_element() {
    let error = |from: &str, to: &str| {
        assert!(SVG.contains(from), "{from}");
        read_svg("plan.svg", "plan", &SVG.replace(from, to)).unwrap_err().to_string()
    };
    assert_eq!(
        error("x1=\"300\"", "x1=\"3m\""),
        "map plan.svg, line 7: <line>: x1: expected a number, found \"3m\""
    );
    assert!(error("M100 0h90", "M100 0h90X3").contains("line 6: <path>: d: expected a path"));
    assert!(error("translate(100 0)", "turn(1)").contains("<g> \"walls\": transform: expected"));
    assert!(error("\"0.01\"", "\"0\"").contains("data-meters-per-unit"));
    assert!(read_svg("a.svg", "a", "<svg>").unwrap_err().to_string().contains("map a.svg, line 1"));
    assert!(read_svg("a.svg", "a", "<svg/>").unwrap_err().to_string().contains("found none"));
}

/// Group codes and values in one line each.
fn dxf(pairs: &[(i32, &str)]) -> String {
    pairs.iter().map(|(code, value)| format!("{code:>3}\n{value}\n")).collect()
}

fn dxf_plan(bulge: &str) -> String {
    dxf(&[
        (0, "SECTION"),
        (2, "HEADER"),
        (9, "$INSUNITS"),
        (70, "4"),
        (0, "ENDSEC"),
        (0, "SECTION"),
        (2, "ENTITIES"),
        (0, "LWPOLYLINE"),
        (8, "A-WALL"),
        (70, "1"),
        (10, "0"),
        (20, "0"),
        (10, "6000"),
        (20, "0"),
        (42, bulge),
        (10, "6000"),
        (20, "2000"),
        (10, "0"),
        (20, "2000"),
        (0, "LINE"),
        (8, "A-DOOR"),
        (62, "5"),
        (10, "1000"),
        (20, "2000"),
        (11, "1900"),
        (21, "2000"),
        (0, "LINE"),
        (8, "DIMENSIONS"),
        (10, "1"),
        (20, "2"),
        (11, "3"),
        (21, "4"),
        (0, "ENDSEC"),
        (0, "EOF"),
    ])
}

#[test]
fn a_dxf_names_walls_and_doors_by_layer() {
    let office = office("plan.dxf", read_dxf("plan.dxf", "plan", dxf_plan("0").as_bytes()));
    assert_eq!((office.plan().walls.len(), office.plan().doors.len()), (4, 1));
    assert_eq!(office.plan().doors[0].to, [1.9, 2.0], "millimeters");
    assert_eq!(office.plan().doors[0].color, "blue".parse().unwrap());
}

#[test]
fn dxf_errors_name_the_entity() {
    let error = |text: &str| read_dxf("p.dxf", "p", text.as_bytes()).unwrap_err().to_string();
    assert!(error("AutoCAD Binary\n1\n").contains("line 1: expected a group code"));
    assert!(error(&dxf_plan("x")).contains("expected a number, found \"x\""));
    assert!(error(&dxf(&[(0, "EOF")])).contains("expected lines on layers"));
    assert!(error("AC1027 and so on").contains("found a DWG"));
    let by_name = Map::from_bytes("p.dwg", b"AC1027 and so on", |_| unreachable!()).unwrap_err();
    assert!(by_name.to_string().contains("found a DWG"), "{by_name}");
    let open_street = Map::from_bytes("p.osm", b"<osm version='0.6'/>", |_| unreachable!()).unwrap_err();
    assert!(open_street.to_string().contains("expected a plan as SVG, found <osm>"), "{open_street}");
    let elsewhere = dxf_plan("0").replace("A-WALL", "OUTER").replace("A-DOOR", "INNER");
    assert!(error(&elsewhere).ends_with("found lines on DIMENSIONS, INNER, OUTER"), "{}", error(&elsewhere));
    let whole = dxf_plan("0");
    let cut = &whole[..whole.find("  8\nDIM").unwrap()];
    assert!(error(cut).contains("expected ENDSEC, found the end in section ENTITIES"), "{}", error(cut));
    let open_ended = dxf_plan("0").replace(" 11\n1900\n", "");
    assert!(
        error(&open_ended).contains("line 39: LINE on layer A-DOOR: expected two ends"),
        "{}",
        error(&open_ended)
    );
}

/// A folder that is gone after the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("visloc-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn load(&self, yaml: &str) -> Result<Map, crate::MapError> {
        let path = self.0.join("grid.yaml");
        fs::write(&path, yaml).unwrap();
        Map::load(path.to_str().unwrap())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const GRID: &str = "image: grid.pgm\nresolution: 0.05\norigin: [-1.0, -2.0, 0.0]\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.25\nnegate: 0\n";

/// An L of free cells, 6 x 3 m, with a pillar and a speck, in unknown cells.
fn l_shaped() -> Vec<u8> {
    let mut picture = b"P5\n# made by hand\n130 80\n255\n".to_vec();
    for y in 0..80 {
        for x in 0..130 {
            let is_l = (5..125).contains(&x) && (10..70).contains(&y) && (x < 45 || y >= 30);
            let is_pillar = (60..70).contains(&x) && (45..55).contains(&y);
            let is_speck = (80..82).contains(&x) && (50..52).contains(&y);
            picture.push(if is_l && !is_pillar && !is_speck { 254 } else { 0 });
        }
    }
    picture
}

#[test]
fn an_occupancy_grid_becomes_outlines() {
    let folder = Folder::new("grid");
    fs::write(folder.0.join("grid.pgm"), l_shaped()).unwrap();
    let Map::Office(office) = folder.load(GRID).unwrap() else { panic!("a building") };
    let corridors = &office.plan().corridors;
    assert_eq!(corridors.iter().map(|c| c.outline.len()).collect::<Vec<_>>(), [6, 4], "an L and a pillar");
    // The L's lower left corner: 5 cells from the left, 10 from below.
    assert!(corridors[0].outline.contains(&[-0.75, -1.5]), "{:?}", corridors[0]);
    let turned = folder.load(&GRID.replace("-2.0, 0.0]", "-2.0, 0.3]")).unwrap();
    let Map::Office(turned) = turned else { panic!("a building") };
    let is_short = |v: &f64| v.to_string().len() <= "-0.1234".len();
    assert!(
        turned.plan().corridors[0].outline.iter().flatten().all(is_short),
        "{:?}",
        turned.plan().corridors
    );
    let space = office.free_space();
    assert!(space.contains(0.0, 1.0) && space.contains(4.0, -1.2));
    assert!(!space.contains(4.0, 1.0), "outside of the L");
    assert!(!space.contains(2.25, -0.5), "inside of the pillar");
}

#[test]
fn errors_of_a_grid_name_key_and_picture() {
    let folder = Folder::new("bad-grid");
    let error = |yaml: &str| folder.load(yaml).unwrap_err().to_string();
    assert!(error(GRID).contains("image: expected a PGM, PNG or BMP picture, found"));
    fs::write(folder.0.join("grid.pgm"), &l_shaped()[..500]).unwrap();
    assert!(error(GRID).contains("130 x 80 cells, but"));
    fs::write(folder.0.join("grid.pgm"), b"P5\n4 4\n255\n0000000000000000").unwrap();
    assert!(error(&GRID.replace("0.05", "0.5")).contains("free cells"));
    assert!(
        error(&GRID.replace("0.05", "0.005"))
            .contains("of a building of at least 1 m, found 0.005, with 4 x 4 cells")
    );
    assert!(error(&GRID.replace("0.05", "-1")).contains("resolution: expected meters a cell"));
    assert!(error(&GRID.replace("[-1.0", "[x")).contains("grid.yaml, line 3"));
    assert!(error(&GRID.replace("[-1.0", "[.nan")).contains("origin: expected x and y in meters"));
    assert!(
        error(&GRID.replace("0.25", "25")).contains("free_thresh: expected above 0, at most 1, found 25")
    );
    let no_resolution = error(&GRID.replace("resolution: 0.05\n", ""));
    assert!(no_resolution.contains("missing field `resolution`"), "{no_resolution}");
    assert!(!no_resolution.contains("column"), "the place is told once: {no_resolution}");
}

/// A key that is misspelled would be the default without a word.
#[test]
fn keys_without_a_meaning_are_told() {
    let told = |notes: &[ImportNote]| -> Vec<String> {
        notes.iter().map(|note| note.what.clone()).filter(|what| what.starts_with("key ")).collect()
    };
    let misspelled = GRID.replace("free_thresh", "free_tresh") + "MODE: raw\n";
    let picture = |_: &str| Ok(l_shaped());
    let import = grid::read_grid("g.yaml", "g", &misspelled, picture).unwrap();
    assert_eq!(told(&import.notes), ["key \"MODE\"", "key \"free_tresh\""]);
    assert!(told(&grid::read_grid("g.yaml", "g", GRID, picture).unwrap().notes).is_empty());
    let doors = "walls: [[0, 0, 4, 0], [4, 0, 4, 3], [4, 3, 0, 3], [0, 3, 0, 0]]\n\
                 doors: [{x1: 1, y1: 0, x2: 1.9, y2: 0, hieght: 1.5}, {x1: 2, y1: 3, x2: 1, y2: 3, height: 2}]\n";
    let import = list::read_list("l.yaml", "l", doors).unwrap();
    assert_eq!(told(&import.notes), ["key \"hieght\""]);
}

/// A room whose mapping looked through its windows: strips of free cells in every direction, as narrow as one cell, each with an occupied
/// one at its end.
fn with_rays(rng: &mut Rng) -> Vec<u8> {
    const SIZE: (usize, usize) = (120, 90);
    let mut cells = [205; SIZE.0 * SIZE.1];
    for (x, y) in (20..100).flat_map(|x| (19..71).map(move |y| (x, y))) {
        cells[y * SIZE.0 + x] = if y == 19 || y == 70 { 0 } else { 254 };
    }
    for _ in 0..30 {
        let (sin, cos) = rng.random_range(0.0..std::f64::consts::TAU).sin_cos();
        let length = rng.random_range(30.0..70.0);
        let mut last = 0;
        for step in 0..140 {
            let ahead = 0.5 * f64::from(step);
            let (x, y) = (60.5 + ahead * cos, 45.5 + ahead * sin);
            if ahead < length && (0.0..SIZE.0 as f64).contains(&x) && (0.0..SIZE.1 as f64).contains(&y) {
                last = y as usize * SIZE.0 + x as usize;
                cells[last] = 254;
            }
        }
        cells[last] = 0;
    }
    [format!("P5\n{} {}\n255\n", SIZE.0, SIZE.1).as_bytes(), &cells].concat()
}

#[test]
fn grids_with_ragged_borders_are_maps() {
    let folder = Folder::new("ragged");
    for seed in 0..60 {
        let mut rng = RngTree::new(seed).stream("rays", 0);
        fs::write(folder.0.join("grid.pgm"), with_rays(&mut rng)).unwrap();
        let map = folder.load(GRID).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let Map::Office(office) = map else { panic!("a building") };
        assert!(office.free_space().contains(1.0, 0.0), "seed {seed}: the room is free");
        let back = Map::parse("written", &Map::Office(office).to_toml().unwrap());
        assert!(back.is_ok(), "seed {seed}: {back:?}");
    }
}
