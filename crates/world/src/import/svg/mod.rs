//! Plans as SVG: everything that draws lines or areas, with styles, transforms and copies.

mod geometry;
mod style;

use std::collections::HashMap;

use kurbo::Affine;
use roxmltree::{Document, Node, NodeId, ParsingOptions};
use simplecss::StyleSheet;

use self::{
    geometry::{Page, drawn, shape, transform},
    style::{Paint, Style, style_of},
};
use super::{
    Import,
    drawing::{Drawing, Lines, MAX_POINTS, Role, Solid, Stroke, plan_of, role_by_name},
    found_nothing,
    notes::Part,
};
use crate::MapError;

/// Deeper nesting is no drawing.
const MAX_DEPTH: usize = 200;
/// More elements, copies included, are no plan of a building.
const MAX_ELEMENTS: usize = 500_000;
/// More style sheets take too long: reading them is not linear.
const MAX_STYLE_BYTES: usize = 1 << 17;
/// Rules of style sheets times elements.
const MAX_MATCHES: usize = 5_000_000;

/// Elements that draw nothing where they are.
const NOT_DRAWN: [&str; 13] = [
    "clipPath",
    "defs",
    "desc",
    "filter",
    "linearGradient",
    "marker",
    "mask",
    "metadata",
    "pattern",
    "radialGradient",
    "script",
    "style",
    "title",
];

/// Reads the plan of an SVG file; `name` is used in errors, and `title` becomes the name of the map.
///
/// What a stroke is, its `id`, `class` or Inkscape's layer name says, or that of the nearest group around it: `wall`,
/// `corridor` or `door` (`open` too: it stands open) as a part of the name. Strokes without such a name are doors if their
/// stroke has a hue, and walls if it is gray or black. Walls that are filled are solid. One unit is a meter, unless the
/// root element has an attribute `data-meters-per-unit`, or a view box and a size in m, cm, mm or in. The origin is the lower left corner of the page, unless
/// `data-origin` says where that corner is; y points up.
pub(crate) fn read_svg(name: &str, title: &str, text: &str) -> Result<Import, MapError> {
    let syntax =
        |line: Option<usize>, reason: String| MapError::Syntax { name: name.to_owned(), line, reason };
    let options =
        ParsingOptions { nodes_limit: 4 * MAX_ELEMENTS as u32, allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        syntax(Some(error.pos().row as usize), format!("expected a plan as SVG: {error}"))
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        let reason = format!("expected a plan as SVG, found <{}>", root.tag_name().name());
        return Err(syntax(Some(1), reason));
    }
    let mut reader = Reader::new(&document).map_err(|reason| syntax(None, reason))?;
    reader.note_scale();
    let root = Inherited { to_map: reader.page.to_map(), ..Inherited::default() };
    reader.visit(document.root_element(), &root, 0).map_err(|(node, reason)| {
        let id = node.attribute("id").map(|id| format!(" {id:?}")).unwrap_or_default();
        let element = format!("<{}>{id}: {reason}", node.tag_name().name());
        syntax(Some(reader.line_of(node)), element)
    })?;
    if reader.drawing.strokes.is_empty() && reader.drawing.solids.is_empty() {
        let expected =
            "expected strokes with wall, corridor or door in their id, class or layer, or with a color";
        return Err(syntax(None, found_nothing(expected, reader.drawing.notes)));
    }
    plan_of(title, reader.drawing).map_err(|reason| syntax(None, reason))
}

/// What an element has from the groups around it.
#[derive(Debug, Clone, Default)]
struct Inherited {
    to_map: Affine,
    style: Style,
    role: Option<Role>,
    /// Whether it is there by `use`.
    is_copy: bool,
}

type Failure<'a, 'd> = (Node<'a, 'd>, String);

struct Reader<'a, 'd> {
    line_starts: Vec<usize>,
    by_id: HashMap<&'a str, NodeId>,
    document: &'a Document<'d>,
    sheet: StyleSheet<'a>,
    page: Page,
    drawing: Drawing,
    num_elements: usize,
    num_points: usize,
}

impl<'a, 'd: 'a> Reader<'a, 'd> {
    fn new(document: &'a Document<'d>) -> Result<Self, String> {
        let (mut styles, mut by_id) = (Vec::new(), HashMap::new());
        for node in document.descendants().filter(Node::is_element) {
            if let Some(id) = node.attribute("id") {
                by_id.entry(id).or_insert(node.id());
            }
            if node.tag_name().name() == "style" {
                styles.extend(node.children().filter_map(|child| child.text()));
            }
        }
        if styles.iter().map(|text| text.len()).sum::<usize>() > MAX_STYLE_BYTES {
            return Err("<style>: expected at most 128 kB of style sheets, found more".to_owned());
        }
        let mut sheet = StyleSheet::new();
        styles.iter().for_each(|text| sheet.parse_more(text));
        let ends = document.input_text().match_indices('\n').map(|(end, _)| end + 1);
        Ok(Self {
            line_starts: std::iter::once(0).chain(ends).collect(),
            by_id,
            document,
            sheet,
            page: Page::of(&document.root_element())?,
            drawing: Drawing::default(),
            num_elements: 0,
            num_points: 0,
        })
    }

    /// Says which scale was taken, if the file does not say it in so many words.
    fn note_scale(&mut self) {
        let root = self.document.root_element();
        if root.has_attribute("data-meters-per-unit") {
            return;
        }
        let unit_m = self.page.unit_m();
        let from = if unit_m == 1.0 { "" } else { ", by its size and its viewBox" };
        let rounded = unit_m as f32;
        let reason = format!("for {rounded} m a unit{from}; data-meters-per-unit says another scale");
        self.drawing.notes.taken(&self.part(root), &reason);
    }

    fn line_of(&self, node: Node<'_, '_>) -> usize {
        self.line_starts.partition_point(|start| *start <= node.range().start)
    }

    fn part(&self, node: Node<'_, '_>) -> Part {
        Part { what: format!("<{}>", node.tag_name().name()), layer: None, line: Some(self.line_of(node)) }
    }

    /// Reads an element with all that is inside it.
    fn visit(&mut self, node: Node<'a, 'd>, around: &Inherited, depth: usize) -> Result<(), Failure<'a, 'd>> {
        self.num_elements += 1;
        if depth > MAX_DEPTH {
            return Err((
                node,
                format!("expected at most {MAX_DEPTH} elements inside of each other, found more"),
            ));
        }
        if self.num_elements > MAX_ELEMENTS || self.num_elements * self.sheet.rules.len() > MAX_MATCHES {
            let rules = self.sheet.rules.len();
            return Err((
                node,
                format!("expected a simpler drawing, found too many elements, copies or rules ({rules})"),
            ));
        }
        let tag = node.tag_name().name();
        let is_svg = node.tag_name().namespace().is_none_or(|space| space == "http://www.w3.org/2000/svg");
        if !is_svg || NOT_DRAWN.contains(&tag) || (tag == "symbol" && !around.is_copy) {
            return Ok(());
        }
        let fail = |reason: String| (node, reason);
        let style = style_of(node, &around.style, &self.sheet);
        if style.is_hidden {
            self.drawing.notes.passed_over(&self.part(node), "display is none");
            return Ok(());
        }
        let label = node.attributes().find(|a| a.name() == "label").map(|a| a.value());
        let names = [node.attribute("id"), node.attribute("class"), label];
        let own = role_by_name(names.into_iter().flatten()).filter(|_| tag != "svg");
        let mut here = Inherited {
            to_map: around.to_map * transform(&node).map_err(fail)?,
            style,
            role: own.or(around.role),
            is_copy: tag == "use",
        };
        match tag {
            "svg" | "symbol" if depth > 0 && node.has_attribute("viewBox") => {
                self.drawing
                    .notes
                    .passed_over(&self.part(node), "a page in the page, with a scale of its own");
            }
            "svg" | "g" | "a" | "switch" | "symbol" => {
                if tag == "svg" && depth > 0 {
                    here.to_map *= geometry::offset(&node).map_err(fail)?;
                }
                for child in node.children().filter(Node::is_element) {
                    self.visit(child, &here, depth + 1)?;
                }
            }
            "use" => {
                here.to_map *= geometry::offset(&node).map_err(fail)?;
                let target =
                    node.attributes().find(|a| a.name() == "href").and_then(|a| a.value().strip_prefix('#'));
                match target.and_then(|id| self.by_id.get(id)).and_then(|id| self.document.get_node(*id)) {
                    Some(target) => self.visit(target, &here, depth + 1)?,
                    None => {
                        self.drawing.notes.passed_over(&self.part(node), "what it shows is not in the file")
                    }
                }
            }
            _ => match shape(&node).map_err(fail)? {
                Some(path) => {
                    let drawn = drawn(&path, here.to_map).map_err(fail)?;
                    self.add(node, &here, drawn).map_err(fail)?;
                }
                None => self.drawing.notes.passed_over(&self.part(node), "not a line or an area"),
            },
        }
        Ok(())
    }

    /// Says what a nameless element is by its color.
    fn taken_for(&mut self, part: &Part, role: Role) -> Role {
        let what = match role {
            Role::Door { .. } => "a door, since it has a color",
            _ => "a wall, since it is gray or black",
        };
        self.drawing.notes.taken(part, &format!("for {what}; no name in id, class or layer says what it is"));
        role
    }

    /// Adds what an element draws to the drawing.
    fn add(&mut self, node: Node<'_, '_>, here: &Inherited, drawn: Vec<Lines>) -> Result<(), String> {
        let part = self.part(node);
        let drawn: Vec<Lines> = drawn.into_iter().filter(|d| d.points.len() >= 2).collect();
        self.num_points += drawn.iter().map(|d| d.points.len()).sum::<usize>();
        if self.num_points > MAX_POINTS {
            return Err(format!("expected at most {MAX_POINTS} points in all, found more"));
        }
        let Style { stroke, fill, is_invisible, is_even_odd, .. } = here.style;
        let reason = if drawn.is_empty() {
            Some("without length")
        } else if is_invisible || (stroke == Paint::None && fill == Paint::None) {
            Some("not visible")
        } else {
            None
        };
        if let Some(reason) = reason {
            self.drawing.notes.passed_over(&part, reason);
            return Ok(());
        }
        let role = match (here.role, stroke, fill) {
            (Some(Role::Door { is_open, .. }), ..) => {
                let color = stroke.hue().or(fill.hue());
                Role::Door { color, is_open }
            }
            (Some(role), ..) => role,
            (None, Paint::Color(color), _) if color.is_gray() => self.taken_for(&part, Role::Wall),
            (None, Paint::Color(color), _) => {
                self.taken_for(&part, Role::Door { color: Some(color), is_open: false })
            }
            (None, _, Paint::Color(color)) if color.is_gray() && color.rgb[1] < 0x90 => {
                self.taken_for(&part, Role::Wall)
            }
            _ => {
                let reason =
                    "neither named wall, corridor or door, nor with a stroke of a color or a dark fill";
                self.drawing.notes.passed_over(&part, reason);
                return Ok(());
            }
        };
        let is_filled =
            matches!(fill, Paint::Color(_)) && (stroke == fill || !matches!(stroke, Paint::Color(_)));
        if role == Role::Wall && is_filled && drawn.iter().any(|d| d.points.len() > 2) {
            let contours = drawn.into_iter().map(|d| d.points).filter(|points| points.len() > 2).collect();
            self.drawing.solids.push(Solid { contours, is_even_odd });
            return Ok(());
        }
        let stroke = |lines| Stroke { role, lines, block: None, part: part.clone() };
        self.drawing.strokes.extend(drawn.into_iter().map(stroke));
        Ok(())
    }
}
