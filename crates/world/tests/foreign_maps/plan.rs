//! One plan in four forms.

/// An L of 18 square meters with a door at the bottom and one at the left.
pub const LIST: &str = "\
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
pub const SVG: &str = r##"<?xml version="1.0"?>
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">
<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 600 500" data-meters-per-unit="0.01">
  <style>.outer { stroke: #333; fill: none } .red { stroke: red }</style>
  <path class="outer" d="M0,500 V0 h200 v300 h400 l0,200 z"/>
  <g id="door-1"><path fill="none" d="M300,500 v-90 A90,90 0 0 1 390,500"/></g>
  <line class="red" x1="0" y1="200" x2="0" y2="110"/>
  <text x="3" y="3">Corridor</text>
</svg>"##;

/// Group codes and values in one line each.
pub fn dxf(pairs: &[(i32, &str)]) -> String {
    pairs.iter().map(|(code, value)| format!("{code:>3}\n{value}\n")).collect()
}

/// The pairs of the same plan in millimeters; both doors are copies of one block.
pub fn dxf_pairs() -> Vec<(i32, &'static str)> {
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
pub fn binary_dxf(pairs: &[(i32, &str)]) -> Vec<u8> {
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

pub const GRID: &str = "image: grid.pgm\nmode: trinary\nresolution: 0.05\norigin: [-0.5, -0.5, 0.0]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.25\n";

/// A picture with the value that each cell of 5 cm has; (x, y) in meters of its middle, from -0.5 m on.
pub fn pgm(value: impl Fn(f64, f64) -> u8) -> Vec<u8> {
    let mut picture = b"P5\n# CREATOR: map_saver\n140 120\n255\n".to_vec();
    let middle = |i: i32| f64::from(i) * 0.05 - 0.475;
    picture.extend(
        (0..120).rev().flat_map(|y| (0..140).map(move |x| (x, y))).map(|(x, y)| value(middle(x), middle(y))),
    );
    picture
}

/// Whether a place is in the L, grown by some meters.
pub fn is_in_l(x: f64, y: f64, grown_m: f64) -> bool {
    let is_in =
        |[right, top]: [f64; 2]| x > -grown_m && y > -grown_m && x < right + grown_m && y < top + grown_m;
    is_in([6.0, 2.0]) || is_in([2.0, 5.0])
}

/// The same as a grid as `map_saver` writes it: free, a wall of one cell, unknown.
pub fn l_shaped(x: f64, y: f64) -> u8 {
    if is_in_l(x, y, 0.0) {
        254
    } else if is_in_l(x, y, 0.05) {
        0
    } else {
        205
    }
}
