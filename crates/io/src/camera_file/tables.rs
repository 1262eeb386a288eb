//! Files of tables, YAML, JSON or TOML: their values, and the table of the camera.

use std::collections::BTreeMap;

use serde::{Deserialize, de::IgnoredAny};

use super::yaml_forms::camera_matrix;
use crate::text::{parse_number, yaml_reason};

/// A value of a file of which only a camera is wanted.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum Value {
    Number(f64),
    Text(String),
    List(Vec<Value>),
    Table(Table),
    Other(IgnoredAny),
}

impl Value {
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Text(text) => parse_number(text).ok(),
            _ => None,
        }
    }

    /// The numbers of a list, of the rows of a matrix one after the other, or of a matrix with `data`; NaN for what is none.
    pub(super) fn numbers(&self) -> Option<Vec<f64>> {
        match self {
            Self::List(values) => {
                let numbers = values.iter().map(|value| match value {
                    Self::List(_) => value.numbers().unwrap_or_default(),
                    value => vec![value.number().unwrap_or(f64::NAN)],
                });
                Some(numbers.collect::<Vec<_>>().concat())
            }
            Self::Table(table) => table.get("data")?.numbers(),
            _ => None,
        }
    }
}

/// Values by their names.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(transparent)]
pub(super) struct Table(BTreeMap<String, Value>);

/// A value with its name.
type Entry<'a> = (&'a str, &'a Value);

/// A camera with its name, and what stands around it, the nearest first.
type Found<'a> = (&'a str, &'a Table, Vec<Entry<'a>>);

/// A name without what is written in one way or the other.
pub(super) fn plain(key: &str) -> String {
    key.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase()
}

impl Table {
    /// # Errors
    /// If the text is not YAML; OpenCV's is not quite, and is read.
    pub(super) fn read(text: &str) -> Result<Self, String> {
        let yaml: String = text
            .lines()
            .filter(|line| !line.starts_with('%'))
            .map(|line| line.replace("!!opencv-matrix", "") + "\n")
            .collect();
        serde_saphyr::from_str(&yaml).map_err(|error| yaml_reason(&error))
    }

    /// A table of TOML, if it has a camera by keys that are not those of our own form.
    pub(super) fn of_foreign_toml(text: &str) -> Option<Self> {
        let table: Self = toml::from_str(text).ok()?;
        let is_ours = ["size_px", "focal_px", "center_px"].iter().any(|key| table.get(key).is_some());
        let has_camera = || !matches!(table.clone().of_camera(), Ok(None));
        (!is_ours && has_camera()).then_some(table)
    }

    pub(super) fn get(&self, key: &str) -> Option<&Value> {
        self.0.get(key)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.0.iter().map(|(key, value)| (key.as_str(), value))
    }

    /// The lists of numbers and the matrices in it.
    pub(super) fn lists(&self) -> Vec<(&str, Vec<f64>)> {
        self.iter().filter_map(|(key, value)| Some((key, value.numbers()?))).collect()
    }

    /// Whether it has a focal length as a number of its own, not in a matrix.
    pub(super) fn has_numbers(&self) -> bool {
        let is_number = |key: &str| self.get(key).is_some_and(|value| !matches!(value, Value::Table(_)));
        let is_list = self.get("intrinsics").and_then(Value::numbers).is_some_and(|list| list.len() != 9);
        is_list || ["fx", "Camera.fx", "Camera1.fx", "fl_x", "focal_px"].iter().any(|key| is_number(key))
    }

    fn is_camera(&self) -> bool {
        self.has_numbers() || matches!(camera_matrix(&self.lists()), Ok(Some(_)))
    }

    /// The table of the only camera: this one, or one inside of it, with what stands around that and holds for it.
    ///
    /// # Errors
    /// If there are several.
    pub(super) fn of_camera(self) -> Result<Option<Self>, String> {
        let mut found = Vec::new();
        self.collect_cameras("", &[], &mut found);
        match &found[..] {
            [] => Ok(None),
            [(_, camera, around)] => {
                let mut camera = (*camera).clone();
                for (key, value) in around {
                    camera.0.entry((*key).to_owned()).or_insert_with(|| (*value).clone());
                }
                Ok(Some(camera.with_parts()))
            }
            [(first, ..), (second, ..), ..] => Err(format!(
                "expected one camera, found {} ({first}, {second}{}): keep that of yours in a file of its own",
                found.len(),
                if found.len() > 2 { ", ..." } else { "" }
            )),
        }
    }

    fn collect_cameras<'a>(&'a self, name: &'a str, around: &[Entry<'a>], found: &mut Vec<Found<'a>>) {
        if self.is_camera() {
            // Only that of an only one is asked for.
            let around = if found.is_empty() { around.to_vec() } else { Vec::new() };
            return found.push((name, self, around));
        }
        let holds = |(key, _): &Entry<'_>| {
            is_part(key) || ["width", "height", "fps"].iter().any(|end| key.ends_with(end))
        };
        let around: Vec<Entry<'a>> = self.iter().filter(holds).chain(around.iter().copied()).collect();
        for (key, value) in self.iter().filter(|(key, _)| !is_part(key)) {
            let values =
                if let Value::List(values) = value { &values[..] } else { std::slice::from_ref(value) };
            for value in values {
                if let Value::Table(table) = value {
                    table.collect_cameras(key, &around, found);
                }
            }
        }
    }

    /// With what tables for the size and the lens say, as if it stood beside them.
    fn with_parts(mut self) -> Self {
        let parts: Vec<Self> = self
            .iter()
            .filter_map(|(key, value)| match value {
                Value::Table(part) if is_part(key) && part.get("data").is_none() => Some(part.clone()),
                _ => None,
            })
            .collect();
        for (key, value) in parts.into_iter().flat_map(|part| part.0) {
            self.0.entry(key).or_insert(value);
        }
        self
    }
}

/// Whether something of this name is a part of a camera: the size of its images, or its lens.
fn is_part(key: &str) -> bool {
    ["dist", "lens", "size", "imagesize", "resolution"].iter().any(|start| plain(key).starts_with(start))
}
