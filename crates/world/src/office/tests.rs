use super::Office;
use crate::{Map, MapError, import::read_list};

const GOOD: &str = r#"
kind = "office"
name = "small"

[[corridors]]
outline = [[0.0, 1.0], [6.0, 1.0], [6.0, -1.0], [0.0, -1.0]]

[[doors]]
from = [1.0, 1.0]
to = [1.9, 1.0]

[[doors]]
from = [3.9, -1.0]
to = [3.0, -1.0]
color = "blue"
"#;

fn load(text: &str) -> Result<Office, MapError> {
    match Map::parse("m.toml", text)? {
        Map::Office(office) => Ok(office),
        other => panic!("a building, not {}", other.name()),
    }
}

fn error(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "{from}");
    load(&GOOD.replace(from, to)).unwrap_err().to_string()
}

#[test]
fn a_door_is_seen_from_the_corridor_with_its_left_edge_at_the_left() {
    let office = load(GOOD).unwrap();
    // In the wall at y = 1, seen from below: left is at smaller x. In the wall at y = -1 it is the other way around.
    assert!((office.doors()[0].left.x - 1.0).abs() < 1e-9 && (office.doors()[0].right.x - 1.9).abs() < 1e-9);
    assert!((office.doors()[1].left.x - 3.9).abs() < 1e-9 && (office.doors()[1].right.x - 3.0).abs() < 1e-9);
    assert_eq!(office.door_colors().len(), 2);
}

#[test]
fn a_plan_of_another_kind_is_refused() {
    let mut plan = load(GOOD).unwrap().plan().clone();
    plan.kind = "ofFice".to_owned();
    let error = Office::new("drawn", plan).unwrap_err().to_string();
    assert!(error.contains("kind: expected \"office\"") && error.contains("ofFice"), "{error}");
}

#[test]
fn outlines_may_go_around_either_way() {
    let turned = "[[0.0, -1.0], [6.0, -1.0], [6.0, 1.0], [0.0, 1.0]]";
    let other = load(&GOOD.replace("[[0.0, 1.0], [6.0, 1.0], [6.0, -1.0], [0.0, -1.0]]", turned)).unwrap();
    let office = load(GOOD).unwrap();
    assert!((other.doors()[0].left - office.doors()[0].left).norm() < 1e-9);
    for wall in other.walls().iter().chain(office.walls()) {
        let beside = nalgebra::center(&wall.start, &wall.end) + wall.normal() * 0.2;
        assert!(office.free_space().contains(beside.x, beside.y), "{wall:?}");
    }
}

#[test]
fn a_robot_stays_off_the_walls() {
    let space = load(GOOD).unwrap().free_space().clone();
    assert!(space.contains(3.0, 0.0) && !space.contains(3.0, 0.97) && !space.contains(3.0, 1.5));
    assert!(!space.contains(f64::NAN, 0.0));
    for i in 0..100 {
        let place = space.place(f64::from(i) / 100.0, [0.3, 0.7]).unwrap();
        assert!(space.contains(place.x, place.y));
    }
}

#[test]
fn a_pillar_is_not_floor() {
    let pillar = "\n[[corridors]]\noutline = [[4.0, 0.3], [4.6, 0.3], [4.6, -0.3], [4.0, -0.3]]\n";
    let office = load(&format!("{GOOD}{pillar}")).unwrap();
    assert!(!office.free_space().contains(4.3, 0.0) && office.free_space().contains(3.5, 0.0));
    let pillar_wall = &office.walls()[4];
    let beside = nalgebra::center(&pillar_wall.start, &pillar_wall.end) + pillar_wall.normal() * 0.2;
    assert!(office.free_space().contains(beside.x, beside.y), "seen from the corridor");
}

#[test]
fn a_single_wall_is_seen_from_both_sides() {
    let wall =
        "\n[[walls]]\nfrom = [4.0, 1.0]\nto = [4.0, 0.2]\n\n[[doors]]\nfrom = [4.0, 0.9]\nto = [4.0, 0.3]\n";
    let office = load(&format!("{GOOD}{wall}")).unwrap();
    assert_eq!((office.walls().len(), office.doors().len()), (6, 4));
    let [one, other] = [&office.doors()[2], &office.doors()[3]];
    assert!((one.left - other.right).norm() < 1e-9 && (one.right - other.left).norm() < 1e-9);
}

#[test]
fn errors_name_the_element() {
    assert_eq!(
        error("from = [1.0, 1.0]", "from = [1.0, 0.5]"),
        "map m.toml: doors[0]: expected both edges on one wall, found (1, 0.5) to (1.9, 1), 0.50 m off the nearest wall, corridors[0] side 0"
    );
    assert_eq!(
        error("to = [1.9, 1.0]", "to = [6.5, 1.0]"),
        "map m.toml: doors[0]: expected both edges on one wall, found (1, 1) to (6.5, 1), 0.50 m beyond the end of corridors[0] side 0"
    );
    assert_eq!(
        error("to = [1.9, 1.0]", "to = [1.0, 1.0]"),
        "map m.toml: doors[0]: expected a width of at least 0.05 m, found 0.000 m"
    );
    let twice = "[[doors]]\nfrom = [1.5, 1.0]\nto = [2.4, 1.0]\n\n[[doors]]\nfrom = [3.9, -1.0]";
    assert!(
        error("[[doors]]\nfrom = [3.9, -1.0]", twice).contains("doors[1]: expected a door that overlaps")
    );
    let wall = "name = \"small\"\n[[walls]]\nfrom = [2.0, 1.0]\nto = [5.0, 1.0]\n";
    let overlapping = error("name = \"small\"\n", wall);
    assert!(overlapping.contains("corridors[0] side 0") && overlapping.contains("walls[0]"), "{overlapping}");
    assert!(
        error("[6.0, 1.0], [6.0, -1.0], ", "").contains("corridors[0].outline: expected at least 3 corners")
    );
    assert!(error("[6.0, 1.0], ", "[6.0, 1.0], [6.0, 1.0], ").contains("corridors[0] side 1"));
    assert!(error("color = \"blue\"", "color = \"gray\"").contains("doors[1].color: expected a color that"));
    assert!(error("color = \"blue\"", "color = \"bleu\"").contains("bleu"));
    assert!(error("color = \"blue\"", "height_m = 9.0").contains("doors[1].height_m"));
    assert!(error("[6.0, 1.0]", "[inf, 1.0]").contains("corridors[0].outline"));
    assert!(error("name = \"small\"", "name = \"small\"\nnmae = 1").contains("line 4"));
    let not_a_number = error("from = [1.0, 1.0]", "from = [nan, 1.0]");
    assert!(not_a_number.contains("doors[0].from: expected coordinates in meters"), "{not_a_number}");
    let with_z = error("to = [1.9, 1.0]", "to = [1.9, 1.0, 0.0]");
    assert!(with_z.contains("line 10: expected x and y in meters, found 3 numbers"), "{with_z}");
    let with_z = error("[6.0, 1.0], ", "[6.0, 1.0, 0.0], ");
    assert!(with_z.contains("line 6: expected x and y in meters, found 3 numbers"), "{with_z}");
    let empty = load("kind = \"office\"\nname = \"empty\"\n").unwrap_err().to_string();
    assert!(empty.contains("at least one wall"), "{empty}");
}

#[test]
fn outlines_that_cross_are_refused() {
    let crossed = "[[0.0, 1.0], [6.0, -1.0], [6.0, 1.0], [0.0, -1.0]]";
    let itself = error("[[0.0, 1.0], [6.0, 1.0], [6.0, -1.0], [0.0, -1.0]]", crossed);
    assert_eq!(
        itself,
        "map m.toml: corridors[0] side 0: expected an outline that crosses neither itself nor another one, \
         found it crosses corridors[0] side 2"
    );
    let second = "\n[[corridors]]\noutline = [[4.0, 0.5], [9.0, 0.5], [9.0, -0.5], [4.0, -0.5]]\n";
    let other = load(&format!("{GOOD}{second}")).unwrap_err().to_string();
    assert!(other.contains("corridors[0] side 1") && other.contains("corridors[1] side"), "{other}");
    // Walls that stand by themselves may stand across each other.
    let walls =
        "\n[[walls]]\nfrom = [3.0, 0.0]\nto = [5.0, 0.0]\n[[walls]]\nfrom = [4.0, -0.5]\nto = [4.0, 0.5]\n";
    assert_eq!(load(&format!("{GOOD}{walls}")).unwrap().walls().len(), 8);
}

#[test]
fn what_is_written_is_read_again() {
    let office = load(GOOD).unwrap();
    assert_eq!(load(&office.plan().to_toml().unwrap()).unwrap(), office);
}

const LIST: &str = "\
ceiling_height: 2.6
wall_color: white
floor_color: yellow
walls:
  - [0.0, 1.0, 6.0, 1.0]
  - [6.0, 1.0, 6.0, -1.0]
  - [6.0, -1.0, 0.0, -1.0]
  - [0.0, -1.0, 0.0, 1.0]
doors:
  - {wall: 0, x1: 1.0, y1: 1.0, x2: 1.9, y2: 1.0, width: 0.9, height: 2.05}
";

#[test]
fn a_list_of_walls_becomes_a_corridor() {
    let office = Office::new("map.yaml", read_list("map.yaml", "map", LIST).unwrap().plan).unwrap();
    assert_eq!((office.walls().len(), office.doors().len()), (4, 1));
    assert!((office.free_space().area_m2() - 5.8 * 1.8).abs() < 0.3);
}

#[test]
fn errors_in_a_list_name_file_and_line() {
    let broken = LIST.replace("[6.0, 1.0, 6.0, -1.0]", "[6.0, east, 6.0, -1.0]");
    let error = read_list("map.yaml", "map", &broken).unwrap_err().to_string();
    assert!(error.starts_with("map map.yaml, line 6:"), "{error}");
    let off_wall = LIST.replace("y1: 1.0", "y1: 0.4");
    let error = Office::new("map.yaml", read_list("map.yaml", "map", &off_wall).unwrap().plan).unwrap_err();
    assert!(error.to_string().contains("map map.yaml: doors[0]"), "{error}");
}
