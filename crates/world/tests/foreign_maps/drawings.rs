//! What drawings become.

use super::{load, office, plan::dxf};

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
    let cases: [(&str, String, Expected); 17] = [
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
        (
            "a door among walls on another layer",
            drawing(
                &[],
                &[
                    (0, "LINE"),
                    (8, "A"),
                    (11, "9"),
                    (21, "9"),
                    (0, "LINE"),
                    (8, "DOOR"),
                    (10, "0"),
                    (20, "0"),
                    (11, "0.9"),
                    (21, "0"),
                ],
            ),
            Err("expected at least one wall, found none; 1 LINE on layer A (in line "),
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
