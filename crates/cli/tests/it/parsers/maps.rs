//! Maps in all formats.

use std::fs;

use visloc_core::GrayImage;
use visloc_io::image_codec::encode_gray_png;
use visloc_world::{BUILT_IN_MAPS, Map};

use super::{as_file, in_folder};

/// Loads a map; what was understood survives being written.
fn load(name: &str, bytes: &[u8]) {
    as_file(name, bytes, |path| {
        let Ok(map) = Map::load(path.to_str().unwrap()) else { return };
        let text = map.to_toml().unwrap();
        if let Err(error) = Map::parse("again", &text) {
            panic!("what is written is read back: {error}\n{text}");
        }
    });
}

pub fn toml_seeds() -> Vec<Vec<u8>> {
    BUILT_IN_MAPS
        .iter()
        .filter(|(name, _)| *name != "office-large")
        .map(|(_, text)| text.as_bytes().to_vec())
        .collect()
}

pub fn toml(bytes: &[u8]) {
    load("map.toml", bytes);
}

const SVG: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 800 300" data-meters-per-unit="0.01">
  <style>.wall { stroke: black; stroke-width: 2 }</style>
  <defs><g id="leaf"><path class="wall" d="M0 0h50v-20"/></g></defs>
  <g id="walls" transform="translate(100 0)">
    <polyline points="100,0 0,0 0,200 600,200 600,0 190,0"/>
    <rect x="250" y="80" width="20" height="20" fill="black"/>
  </g>
  <use href="#leaf" x="300" y="150"/>
  <g transform="translate(100,0) rotate(0) scale(1 1) matrix(1 0 0 1 0 0)">
    <path class="door" stroke="#2040c0" d="M100 0h90"/>
    <path class="wall" d="M 10,20 l 5,5 H 40 V 30 A 5 5 0 0 1 50 40 C 1 2 3 4 5 6 Q 1 2 3 4 Z"/>
    <line style="stroke: red" x1="300" y1="200" x2="390" y2="200"/>
    <text>not a wall</text>
  </g>
</svg>"##;

pub fn svg_seeds() -> Vec<Vec<u8>> {
    let straight: String =
        SVG.lines().filter(|line| !line.contains(" A 5 5") && !line.contains("use")).collect();
    vec![SVG.into(), straight.into()]
}

pub fn svg(bytes: &[u8]) {
    load("plan.svg", bytes);
}

/// Group codes and values.
fn pairs(text: &str) -> Vec<u8> {
    text.split_whitespace().flat_map(|part| [part.as_bytes(), b"\n"].concat()).collect()
}

pub fn dxf_seeds() -> Vec<Vec<u8>> {
    let head = "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC ";
    let blocks = "0 SECTION 2 BLOCKS 0 BLOCK 8 A-DOOR 2 D1 70 0 10 0 20 0 30 0 0 LINE 8 A-DOOR 10 0 20 0 11 900 21 0 0 ENDBLK 0 \
                  ENDSEC ";
    let walls = "0 SECTION 2 ENTITIES 0 LWPOLYLINE 8 A-WALL 90 4 70 1 10 0 20 0 10 6000 20 0 42 0 10 6000 20 2000 10 0 20 2000 ";
    let door = "0 LINE 8 A-DOOR 62 5 10 1000 20 2000 11 1900 21 2000 ";
    let old = "0 POLYLINE 8 A-WALL 66 1 70 0 10 0 20 0 0 VERTEX 8 A-WALL 10 7000 20 0 0 VERTEX 8 A-WALL 10 9000 20 0 0 SEQEND ";
    let arc = "0 ARC 8 A-WALL 10 0 20 0 40 900 50 0 51 90 0 CIRCLE 8 A-WALL 10 0 20 0 40 9 ";
    let insert = "0 INSERT 8 A-DOOR 2 D1 10 3000 20 0 41 1 42 1 50 90 ";
    let end = "0 ENDSEC 0 EOF";
    vec![
        pairs(&[head, walls, door, end].concat()),
        pairs(&[head, walls, old, end].concat()),
        pairs(&[head, blocks, walls, door, insert, arc, end].concat()),
        [b"AutoCAD Binary DXF\r\n\x1a\0".to_vec(), binary_pairs(&[head, walls, door, end].concat())].concat(),
    ]
}

/// The same as binary DXF: codes of 16 bits, numbers as doubles, words that end with a zero.
fn binary_pairs(text: &str) -> Vec<u8> {
    let parts: Vec<&str> = text.split_whitespace().collect();
    let mut bytes = Vec::new();
    for pair in parts.chunks_exact(2) {
        let code: i16 = pair[0].parse().unwrap();
        bytes.extend(code.to_le_bytes());
        match code {
            10..=59 => bytes.extend(pair[1].parse::<f64>().unwrap().to_le_bytes()),
            60..=79 => bytes.extend(pair[1].parse::<i16>().unwrap().to_le_bytes()),
            90..=99 => bytes.extend(pair[1].parse::<i32>().unwrap().to_le_bytes()),
            _ => bytes.extend([pair[1].as_bytes(), &[0]].concat()),
        }
    }
    bytes
}

pub fn dxf(bytes: &[u8]) {
    load("plan.dxf", bytes);
}

pub fn list_seeds() -> Vec<Vec<u8>> {
    let recorded = include_bytes!("../../../../../testdata/O1-map.yaml").to_vec();
    let alone = b"walls:\n- [0, 0, 5, 0]\n- [5, 0, 5, 5]\ndoors:\n- {x1: 1, y1: 0, x2: 2, y2: 0, open: true, color: blue}\n";
    let field = b"length: 6.0\nwidth: 4.0\nborder: 0.7\nline: 0.05\ncircle_diameter: 1.2\npenalty_depth: 0.6\npenalty_width: 2.2\n\
                  cross_from_goal_line: 1.8\ngoal_inner_width: 1.4\ngoal_inner_height: 0.8\npost_diameter: 0.1\nball_diameter: 0.065\n\
                  centre_mark: 0.1\nlines: [[-3.0, -2.0, 3.0, -2.0]]\ngoals:\n  - {color: yellow, x: 3.0}\n  - {color: blue, x: -3.0}\n";
    vec![recorded, alone.to_vec(), field.to_vec()]
}

pub fn list(bytes: &[u8]) {
    load("walls.yaml", bytes);
}

const GRID: &str = "image: grid.pgm\nresolution: 0.05\norigin: [-1.0, -2.0, 0.0]\noccupied_thresh: 0.65\nfree_thresh: 0.25\nnegate: 0\n";

/// A room with a pillar.
fn room() -> Vec<u8> {
    let is_free = |x: usize, y: usize| {
        (2..30).contains(&x) && (2..20).contains(&y) && !((10..14).contains(&x) && (8..12).contains(&y))
    };
    (0..24 * 32).map(|i| if is_free(i % 32, i / 32) { 254 } else { 0 }).collect()
}

fn pgm() -> Vec<u8> {
    [b"P5\n# made by hand\n32 24\n255\n".to_vec(), room()].concat()
}

pub fn grid_seeds() -> Vec<Vec<u8>> {
    let modes = ["trinary", "scale", "raw"].map(|mode| format!("{GRID}mode: {mode}\n").into_bytes());
    [vec![GRID.into()], modes.into()].concat()
}

pub fn grid(bytes: &[u8]) {
    in_folder(|folder| {
        let picture = folder.join("grid.pgm");
        if !picture.exists() {
            fs::write(picture, pgm()).unwrap();
        }
    });
    load("grid.yaml", bytes);
}

pub fn picture_seeds() -> Vec<Vec<u8>> {
    let words: Vec<String> = room().iter().map(u8::to_string).collect();
    let text = [b"P2 32 24 255\n".to_vec(), words.join(" ").into_bytes()].concat();
    let png = encode_gray_png(&GrayImage::from_raw(32, 24, room()).unwrap()).unwrap();
    vec![pgm(), text, png]
}

pub fn picture(bytes: &[u8]) {
    as_file("input.pgm", bytes, |_| load("picture.yaml", GRID.replace("grid.pgm", "input.pgm").as_bytes()));
}
