//! What the types say about themselves.

use std::fmt;

use schemars::{JsonSchema, schema_for};
use serde_json::{Map, Value};

use super::idle::find;

/// The schema of a type, with the types that it is made of.
pub(crate) struct Schema(Value);

impl Schema {
    pub fn of<T: JsonSchema>() -> Self {
        Self(schema_for!(T).to_value())
    }

    /// The whole.
    pub fn root(&self) -> Node<'_> {
        self.node(&self.0)
    }

    fn node<'a>(&'a self, value: &'a Value) -> Node<'a> {
        Node { schema: self, outer: value, inner: self.resolve(value) }
    }

    /// Follows a reference to the type that it names. An optional value is what it is if it is there.
    fn resolve<'a>(&'a self, value: &'a Value) -> &'a Value {
        let one_of = value.get("anyOf").and_then(Value::as_array);
        let is_null = |v: &&Value| v.get("type").is_some_and(|kind| kind == "null");
        let value = one_of.and_then(|all| all.iter().find(|v| !is_null(v))).unwrap_or(value);
        let Some(reference) = value.get("$ref").and_then(Value::as_str) else { return value };
        self.0.pointer(reference.trim_start_matches('#')).unwrap_or(value)
    }
}

/// One value in a schema.
#[derive(Clone, Copy)]
pub(crate) struct Node<'a> {
    schema: &'a Schema,
    /// Where the value is used.
    outer: &'a Value,
    /// Its type.
    inner: &'a Value,
}

impl<'a> Node<'a> {
    /// What is said where the value is used, or else of its type.
    pub fn meaning(&self) -> Option<String> {
        description(self.outer).or_else(|| description(self.inner))
    }

    /// Names that the value can have, with what they mean.
    pub fn choices(&self) -> Vec<(&'a str, Option<String>)> {
        let values = self.inner.get("enum").and_then(Value::as_array).into_iter().flatten();
        let plain = values.filter_map(|value| Some((value.as_str()?, None)));
        let variants = self.inner.get("oneOf").and_then(Value::as_array).into_iter().flatten();
        let described = variants.filter_map(|v| Some((v.get("const")?.as_str()?, description(v))));
        plain.chain(described).collect()
    }

    /// Names of the keys below this one; none if it is not a table.
    pub fn keys(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.properties().into_iter().flat_map(|all| all.keys().map(String::as_str))
    }

    /// The value of a key below this one.
    pub fn get(&self, key: &str) -> Option<Self> {
        Some(self.schema.node(self.properties()?.get(key)?))
    }

    /// Whether the value is always a number: one that need not be there is not.
    pub fn is_number(&self) -> bool {
        self.inner.get("type").is_some_and(|kind| kind == "number")
    }

    /// Least and largest value, if the type says both: `#[schemars(range(min = .., max = ..))]`, or
    /// `#[schemars(extend("exclusiveMinimum" = ..))]` and `"exclusiveMaximum"` for bounds that are no values themselves.
    pub fn range(&self) -> Option<Range> {
        let number = |key| self.outer.get(key).or_else(|| self.inner.get(key)).and_then(Value::as_f64);
        let (above, below) = (number("exclusiveMinimum"), number("exclusiveMaximum"));
        Some(Range {
            least: above.or_else(|| number("minimum"))?,
            most: below.or_else(|| number("maximum"))?,
            is_above: above.is_some(),
            is_below: below.is_some(),
        })
    }

    /// Why a key that one might expect below this one is none: `#[schemars(extend("x-no-keys" = {"key": "reason"}))]`.
    pub fn no_key(&self, key: &str) -> Option<&'a str> {
        self.inner.get("x-no-keys")?.get(key)?.as_str()
    }

    /// What must hold for the value to count: `#[schemars(extend("x-only-if" = "kind = grid"))]`.
    pub fn only_if(&self) -> Option<Condition<'a>> {
        Some(Condition::parse(self.outer.get("x-only-if")?.as_str()?))
    }

    fn properties(&self) -> Option<&'a Map<String, Value>> {
        self.inner.get("properties")?.as_object()
    }
}

/// What another value of the same table, or of a table below it, must be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Condition<'a> {
    /// Where the other value is, from the table in which both are.
    path: &'a str,
    wanted: Wanted<'a>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Wanted<'a> {
    /// A word, a number or a truth value.
    Is(&'a str),
    /// A number above this.
    Above(f64),
}

impl<'a> Condition<'a> {
    /// `PATH = VALUE` or `PATH > NUMBER`. What is neither never holds, so that the parameter is of no use and a test finds it.
    fn parse(text: &'a str) -> Self {
        let is = text.split_once(" = ").map(|(path, value)| Self { path, wanted: Wanted::Is(value) });
        let above = || {
            let (path, least) = text.split_once(" > ")?;
            Some(Self { path, wanted: Wanted::Above(least.parse().ok()?) })
        };
        is.or_else(above).unwrap_or(Self { path: text, wanted: Wanted::Above(f64::INFINITY) })
    }

    /// Whether it holds in a table. Without the other value it does not.
    pub fn holds_in(&self, table: &toml::Table) -> bool {
        let Some(found) = find(table, self.path) else { return false };
        match self.wanted {
            Wanted::Is(wanted) => {
                found.as_str().map_or_else(|| found.to_string() == wanted, |it| it == wanted)
            }
            Wanted::Above(least) => {
                let number = found.as_float().or_else(|| found.as_integer().map(|whole| whole as f64));
                number.is_some_and(|number| number > least)
            }
        }
    }
}

impl fmt::Display for Condition<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.wanted {
            Wanted::Is(value) => write!(f, "{} = {value}", self.path),
            Wanted::Above(least) => write!(f, "{} > {least}", self.path),
        }
    }
}

/// Numbers that a value can be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Range {
    pub least: f64,
    pub most: f64,
    /// Whether the least is none of them.
    is_above: bool,
    /// Whether the largest is none of them.
    is_below: bool,
}

impl Range {
    /// Whether a value is inside; NaN is not.
    pub fn contains(self, value: f64) -> bool {
        let is_inside = (self.least..=self.most).contains(&value);
        is_inside && !(self.is_above && value == self.least) && !(self.is_below && value == self.most)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { least, most, .. } = self;
        match (self.is_above, self.is_below) {
            (false, false) => write!(f, "{least} to {most}"),
            (true, false) => write!(f, "above {least}, at most {most}"),
            (false, true) => write!(f, "at least {least}, below {most}"),
            (true, true) => write!(f, "above {least} and below {most}"),
        }
    }
}

fn description(value: &Value) -> Option<String> {
    let text = value.get("description")?.as_str()?;
    Some(text.split_whitespace().collect::<Vec<_>>().join(" "))
}
