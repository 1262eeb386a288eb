//! Plans as DXF, text or binary: lines, polylines, arcs and blocks on layers.
//!
//! Source: AutoCAD DXF reference, group codes. Only what a plan of walls and doors needs is read; what is passed over is
//! counted. The crates for DXF drop what they do not know without a word, so that nobody could say what is missing.

mod entity;
mod pairs;

use std::collections::{BTreeSet, HashMap};

use kurbo::{Affine, Vec2};

use self::{
    entity::Entity,
    pairs::{Failure, Pair, pairs},
};
use super::{
    Import,
    drawing::{Drawing, MAX_POINTS, Role, Stroke, plan_of, role_by_name},
    notes::Part,
};
use crate::{MapError, office::SurfaceColor};

/// Blocks inside of blocks, at most.
const MAX_DEPTH: usize = 16;
/// Entities with those of all copies of blocks, at most.
const MAX_ENTITIES: usize = 1_000_000;

/// Reads the plan of a DXF file; `name` is used in errors, and `title` becomes the name of the map. A layer whose name has
/// `wall`, `door` (`open` too: it stands open) or `corridor` in it says what its lines are; other layers are passed over.
/// What is on layer 0 of a block is on the layer of its `INSERT`; blocks whose name has `door` in it are doors. Lengths
/// follow `$INSUNITS`, without it they are meters. The frame is that of the drawing.
pub(crate) fn read_dxf(name: &str, title: &str, bytes: &[u8]) -> Result<Import, MapError> {
    let syntax = |(line, reason): Failure| MapError::Syntax { name: name.to_owned(), line, reason };
    if bytes.starts_with(b"AC10") {
        return Err(syntax((None, "expected a DXF, found a DWG: save the drawing as DXF".to_owned())));
    }
    let file = pairs(bytes).and_then(|pairs| File::read(&pairs)).map_err(syntax)?;
    let mut reader =
        Reader { file: &file, drawing: Drawing::default(), other_layers: BTreeSet::new(), num: [0; 3] };
    if !file.has_unit {
        let part = Part { what: "drawing without a unit ($INSUNITS)".to_owned(), ..Part::default() };
        reader.drawing.notes.taken(&part, "as meters");
    }
    let root = Around { to_map: Affine::scale(file.unit_m), ..Around::default() };
    for entity in &file.entities {
        reader.visit(entity, &root, 0).map_err(syntax)?;
    }
    if reader.drawing.strokes.is_empty() {
        let layers = found_layers(&reader.other_layers);
        let reason =
            format!("expected lines on layers whose names contain wall, corridor or door, found {layers}");
        return Err(syntax((None, reason)));
    }
    plan_of(title, reader.drawing).map_err(|reason| syntax((None, reason)))
}

/// The parts of a file that are read.
#[derive(Debug, Default)]
struct File {
    unit_m: f64,
    has_unit: bool,
    entities: Vec<Entity>,
    blocks: HashMap<String, Block>,
}

/// Entities that are shown together, with their base point.
#[derive(Debug, Default)]
struct Block {
    head: Entity,
    entities: Vec<Entity>,
}

impl File {
    fn read(pairs: &[Pair<'_>]) -> Result<Self, Failure> {
        let mut file = Self { unit_m: 1.0, ..Self::default() };
        let (mut section, mut variable) = ("", "");
        let mut entity: Option<Entity> = None;
        let mut block: Option<Block> = None;
        for pair in pairs {
            let fail = |reason: String| (pair.line.map(|line| line + 1), reason);
            match (pair.code, section) {
                (0, "ENTITIES" | "BLOCKS") => {
                    file.add(entity.take(), &mut block, section);
                    let kind = pair.text().to_owned();
                    entity = Some(Entity { kind, line: pair.line, ..Entity::default() });
                }
                (2, "") => section = pair.text(),
                (9, "HEADER") => variable = pair.text(),
                (70, "HEADER") if variable == "$INSUNITS" => {
                    let code = pair.number().map_err(fail)?;
                    let unit = unit(code).ok_or_else(|| fail(format!("unknown unit {code} of $INSUNITS")))?;
                    file.unit_m = unit.unwrap_or(1.0);
                    file.has_unit = unit.is_some();
                }
                (_, "ENTITIES" | "BLOCKS") => {
                    if let Some(entity) = &mut entity {
                        entity.take(pair).map_err(fail)?;
                    }
                }
                _ => {}
            }
            if pair.code == 0 && pair.text() == "ENDSEC" {
                section = "";
                entity = None;
            }
        }
        if section.is_empty() {
            return Ok(file);
        }
        let line = pairs.last().and_then(|pair| pair.line).map(|line| line + 1);
        Err((line, format!("expected ENDSEC, found the end in section {section}")))
    }

    /// Puts an entity that is complete where it belongs.
    fn add(&mut self, entity: Option<Entity>, block: &mut Option<Block>, section: &str) {
        let Some(entity) = entity else { return };
        match (entity.kind.as_str(), section) {
            ("BLOCK", "BLOCKS") => *block = Some(Block { head: entity, entities: Vec::new() }),
            ("ENDBLK", "BLOCKS") => {
                if let Some(block) = block.take() {
                    self.blocks.insert(block.head.block.clone(), block);
                }
            }
            (_, "BLOCKS") => {
                if let Some(block) = block {
                    push(&mut block.entities, entity);
                }
            }
            _ => push(&mut self.entities, entity),
        }
    }
}

/// Adds an entity; the vertices of an old polyline are entities of their own.
fn push(entities: &mut Vec<Entity>, entity: Entity) {
    match entities.last_mut() {
        Some(polyline) if polyline.kind == "POLYLINE" && entity.kind == "VERTEX" => {
            // What only shapes a spline is not a corner.
            if !entity.has_flag(4) {
                let place = entity.place();
                polyline.vertices.push([place.x, place.y, entity.or(42, 0.0)]);
            }
        }
        _ if entity.kind == "SEQEND" => {}
        _ => entities.push(entity),
    }
}

/// Where and as what the entities of a block are shown.
#[derive(Debug, Clone, Default)]
struct Around {
    to_map: Affine,
    /// The layer of what is on layer 0.
    layer: Option<String>,
    /// Whether a block around is a door by its name, or by its layer.
    door: Option<Role>,
    /// Number of the outermost door block, and how it is called in notes.
    block: Option<(usize, Part)>,
}

struct Reader<'a> {
    file: &'a File,
    drawing: Drawing,
    /// Layers with lines whose names say nothing.
    other_layers: BTreeSet<String>,
    /// Entities, points and door blocks so far.
    num: [usize; 3],
}

impl Reader<'_> {
    fn visit(&mut self, entity: &Entity, around: &Around, depth: usize) -> Result<(), Failure> {
        self.num[0] += 1;
        if self.num[0] > MAX_ENTITIES {
            return Err((
                entity.line,
                format!("expected at most {MAX_ENTITIES} entities in all copies of blocks"),
            ));
        }
        // Sheets of paper show the drawing again.
        if entity.or(67, 0.0) == 1.0 {
            return Ok(());
        }
        let own_layer = if entity.layer == "0" { around.layer.as_ref() } else { None };
        let layer = own_layer.unwrap_or(&entity.layer);
        let mut part = Part { what: entity.kind.clone(), layer: Some(layer.clone()), line: entity.line };
        let role = role_by_name([layer.as_str()]).or(around.door);
        if entity.kind == "INSERT" {
            part.what = format!("INSERT of block {:?}", entity.block);
            return self.insert(entity, around, part, depth);
        }
        let is_line = entity.kind.ends_with("LINE") && entity.is_read();
        let Some(mut role) = role else {
            if is_line {
                self.other_layers.insert(layer.clone());
            }
            self.drawing.notes.passed_over(&part, "its layer names neither wall, door nor corridor");
            return Ok(());
        };
        let is_mesh = entity.kind == "POLYLINE" && (entity.has_flag(4) || entity.has_flag(6));
        if !entity.is_read() || is_mesh {
            self.drawing.notes.passed_over(&part, "neither lines nor arcs");
            return Ok(());
        }
        let place = |reason| (entity.line, format!("{} on layer {layer}: {reason}", entity.kind));
        let lines = entity.lines(around.to_map).map_err(place)?;
        self.num[1] += lines.points.len();
        if self.num[1] > MAX_POINTS {
            return Err(place(format!("expected at most {MAX_POINTS} points in all, found more")));
        }
        if let Role::Door { color, .. } = &mut role {
            *color = entity.number(62).and_then(door_color);
        }
        let is_door = matches!(role, Role::Door { .. });
        let (block, part) = match &around.block {
            Some((number, part)) if is_door => (Some(*number), part.clone()),
            _ => (None, part),
        };
        self.drawing.strokes.push(Stroke { role, lines, block, part });
        Ok(())
    }

    /// Shows the entities of a block, as often as the `INSERT` says.
    fn insert(&mut self, entity: &Entity, around: &Around, part: Part, depth: usize) -> Result<(), Failure> {
        let place = |reason: &str| (entity.line, format!("{}: {reason}", part.what));
        if depth >= MAX_DEPTH {
            return Err(place(
                "expected at most 16 blocks inside of each other, found more; does it contain itself?",
            ));
        }
        let file = self.file;
        let Some(block) = file.blocks.get(&entity.block) else {
            self.drawing.notes.passed_over(&part, "the drawing has no such block");
            return Ok(());
        };
        let is_door = |role: &Role| matches!(role, Role::Door { .. });
        let layer = part.layer.clone();
        let by_name = role_by_name([entity.block.as_str()].into_iter().chain(layer.as_deref()));
        let door = by_name.filter(is_door).or(around.door);
        let base = block.head.place().to_vec2();
        let scale = Affine::scale_non_uniform(entity.or(41, 1.0), entity.or(42, 1.0));
        let turn = Affine::rotate(entity.or(50, 0.0).to_radians());
        let count = |code| entity.or(code, 1.0).clamp(1.0, 32_767.0);
        let [columns, rows] = [count(70), count(71)];
        if columns * rows > 10_000.0 {
            return Err(place("expected at most 10000 copies, found more"));
        }
        let mut row = 0.0;
        while row < rows {
            let mut column = 0.0;
            while column < columns {
                self.num[0] += 1;
                let step =
                    Affine::translate(Vec2::new(column * entity.or(44, 0.0), row * entity.or(45, 0.0)));
                let at = Affine::translate(entity.place().to_vec2())
                    * turn
                    * step
                    * scale
                    * Affine::translate(-base);
                let mut block_of = around.block.clone();
                if block_of.is_none() && door.is_some() {
                    self.num[2] += 1;
                    block_of = Some((self.num[2], part.clone()));
                }
                let to_map = around.to_map * entity.axes() * at;
                let inside = Around { to_map, layer: layer.clone(), door, block: block_of };
                for entity in &block.entities {
                    self.visit(entity, &inside, depth + 1)?;
                }
                column += 1.0;
            }
            row += 1.0;
        }
        Ok(())
    }
}

/// The layers that have lines, to be renamed in the drawing.
fn found_layers(layers: &BTreeSet<String>) -> String {
    const MAX_SHOWN: usize = 12;
    if layers.is_empty() {
        return "no lines".to_owned();
    }
    let names: Vec<&str> = layers.iter().take(MAX_SHOWN).map(String::as_str).collect();
    let rest = if layers.len() > MAX_SHOWN { ", ..." } else { "" };
    format!("lines on {}{rest}", names.join(", "))
}

/// Meters in a unit of `$INSUNITS`; inside, nothing if the drawing leaves it open.
fn unit(code: f64) -> Option<Option<f64>> {
    let units = [
        (0.0, None),
        (1.0, Some(0.0254)),
        (2.0, Some(0.3048)),
        (4.0, Some(0.001)),
        (5.0, Some(0.01)),
        (6.0, Some(1.0)),
        (10.0, Some(0.9144)),
        (14.0, Some(0.1)),
    ];
    units.iter().find(|unit| unit.0 == code).map(|unit| unit.1)
}

/// The first colors of the AutoCAD color index; the others are left to the default.
fn door_color(index: f64) -> Option<SurfaceColor> {
    let names =
        [(1.0, "red"), (2.0, "yellow"), (3.0, "green"), (4.0, "cyan"), (5.0, "blue"), (6.0, "purple")];
    names.iter().find(|name| name.0 == index).and_then(|name| name.1.parse().ok())
}
