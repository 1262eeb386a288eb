//! Colors and visibility: attributes, style sheets and `style` attributes, in this order.

use roxmltree::Node;
use simplecss::{AttributeOperator, Declaration, DeclarationTokenizer, Element, PseudoClass, StyleSheet};

use crate::office::SurfaceColor;

/// How an area or a line is painted.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) enum Paint {
    /// Nothing is said.
    #[default]
    Unsaid,
    None,
    Color(SurfaceColor),
    /// Gradients and patterns.
    Other,
}

impl Paint {
    /// Its color, unless it is gray.
    pub fn hue(self) -> Option<SurfaceColor> {
        if let Self::Color(color) = self { Some(color).filter(|color| !color.is_gray()) } else { None }
    }
}

/// What an element looks like.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Style {
    pub stroke: Paint,
    pub fill: Paint,
    /// `visibility`, which elements inside may change.
    pub is_invisible: bool,
    /// `display: none`, for all inside.
    pub is_hidden: bool,
    pub is_even_odd: bool,
}

/// The style of an element; what it does not say it has from around.
pub(super) fn style_of(node: Node<'_, '_>, around: &Style, sheet: &StyleSheet<'_>) -> Style {
    let mut style = Style { is_hidden: false, ..*around };
    for key in ["stroke", "fill", "fill-rule", "visibility", "display"] {
        if let Some(value) = node.attribute(key) {
            style.set(key, value, around);
        }
    }
    let rules = sheet.rules.iter().filter(|rule| rule.selector.matches(&Matched(node)));
    let ruled = rules.flat_map(|rule| rule.declarations.iter().copied());
    let own = DeclarationTokenizer::from(node.attribute("style").unwrap_or_default());
    let all: Vec<Declaration<'_>> = ruled.chain(own).collect();
    for is_important in [false, true] {
        for declaration in all.iter().filter(|declaration| declaration.important == is_important) {
            style.set(declaration.name, declaration.value, around);
        }
    }
    style
}

impl Style {
    fn set(&mut self, key: &str, value: &str, around: &Self) {
        match key {
            "stroke" => self.stroke = paint(value, around.stroke),
            "fill" => self.fill = paint(value, around.fill),
            "fill-rule" => self.is_even_odd = value.trim() == "evenodd",
            "visibility" => self.is_invisible = matches!(value.trim(), "hidden" | "collapse"),
            "display" => self.is_hidden = value.trim() == "none",
            _ => {}
        }
    }
}

fn paint(value: &str, inherited: Paint) -> Paint {
    let value = value.trim();
    if let Ok(color) = value.parse() {
        return Paint::Color(color);
    }
    match svgtypes::Paint::from_str(value) {
        Ok(svgtypes::Paint::None) => Paint::None,
        Ok(svgtypes::Paint::Inherit) => inherited,
        Ok(svgtypes::Paint::CurrentColor) => Paint::Color(SurfaceColor { rgb: [0, 0, 0] }),
        Ok(svgtypes::Paint::Color(color)) if color.alpha == 0 => Paint::None,
        Ok(svgtypes::Paint::Color(svgtypes::Color { red, green, blue, .. })) => {
            Paint::Color(SurfaceColor { rgb: [red, green, blue] })
        }
        Ok(_) => Paint::Other,
        // As a browser does with a value that it cannot read.
        Err(_) => inherited,
    }
}

/// An element for the selectors of style sheets.
struct Matched<'a, 'd>(Node<'a, 'd>);

impl Element for Matched<'_, '_> {
    fn parent_element(&self) -> Option<Self> {
        self.0.parent_element().map(Matched)
    }

    fn prev_sibling_element(&self) -> Option<Self> {
        self.0.prev_sibling_element().map(Matched)
    }

    fn has_local_name(&self, name: &str) -> bool {
        self.0.tag_name().name() == name
    }

    fn attribute_matches(&self, local_name: &str, operator: AttributeOperator<'_>) -> bool {
        self.0.attribute(local_name).is_some_and(|value| operator.matches(value))
    }

    fn pseudo_class_matches(&self, class: PseudoClass<'_>) -> bool {
        class == PseudoClass::FirstChild && self.prev_sibling_element().is_none()
    }
}
