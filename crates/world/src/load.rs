//! Maps by name and from their text.

use std::io::ErrorKind;

use serde::Deserialize;

use crate::{
    MapError,
    built_in::BUILT_IN_MAPS,
    error::{HOW_TO_BEGIN, syntax_error},
    field::Field,
    office::Office,
};

/// A world that a localizer can work in.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Map {
    /// A RoboCup field.
    Field(Field),
    /// A building from inside.
    Office(Office),
}

#[derive(Deserialize)]
struct Kind {
    kind: Option<String>,
}

impl Map {
    /// A map that is part of the program ([`BUILT_IN_MAPS`]).
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn built_in(name: &str) -> Result<Self, MapError> {
        match BUILT_IN_MAPS.iter().find(|(built_in, _)| *built_in == name) {
            Some((name, text)) => Self::parse(name, text),
            None => Err(MapError::Unreadable { name: name.to_owned(), source: ErrorKind::NotFound.into() }),
        }
    }

    /// A map from its text; `name` is used in errors.
    ///
    /// # Errors
    /// As [`Map::load`].
    pub fn parse(name: &str, text: &str) -> Result<Self, MapError> {
        let kind: Kind = toml::from_str(text).map_err(|e| syntax_error(name, text, &e))?;
        match kind.kind.as_deref() {
            Some("robocup-field") => Ok(Self::Field(Field::parse(name, text)?)),
            Some("office") => Ok(Self::Office(Office::parse(name, text)?)),
            other => Err(MapError::Value {
                name: name.to_owned(),
                key: "kind".to_owned(),
                expected: "\"robocup-field\" or \"office\"",
                found: other.map_or_else(|| format!("nothing; {HOW_TO_BEGIN}"), |other| format!("{other:?}")),
            }),
        }
    }

    /// The map as text that [`Map::parse`] reads back to the same map.
    ///
    /// # Errors
    /// If it cannot be written; never for a map that was read.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        match self {
            Self::Field(field) => toml::to_string(field.dimensions()),
            Self::Office(office) => office.plan().to_toml(),
        }
    }

    /// The name that the map gives itself.
    pub fn name(&self) -> &str {
        match self {
            Self::Field(field) => &field.dimensions().name,
            Self::Office(office) => &office.plan().name,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_maps_load() {
        for (name, _) in BUILT_IN_MAPS {
            let map = Map::built_in(name).unwrap();
            assert_eq!(map.name(), name);
            assert_eq!(Map::parse("again", &map.to_toml().unwrap()).unwrap(), map);
        }
    }

    #[test]
    fn dimensions_made_in_code_say_that_they_are_a_field() {
        let Ok(Map::Field(field)) = Map::built_in("robocup-spl-2010") else { panic!("a field") };
        let dimensions =
            crate::field::FieldDimensions { kind: "field".to_owned(), ..field.dimensions().clone() };
        let error = Field::new("mine", dimensions).unwrap_err().to_string();
        assert_eq!(error, "map mine: kind: expected \"robocup-field\", found \"field\"");
    }

    #[test]
    fn errors_name_the_place() {
        let (_, good) = BUILT_IN_MAPS[0];
        let error = |from: &str, to: &str| {
            assert!(good.contains(from));
            Map::parse("m.toml", &good.replace(from, to)).unwrap_err().to_string()
        };
        assert_eq!(
            error("width_m = 4.0", "width_m = -4.0"),
            "map m.toml: width_m: expected a length above 0, found -4"
        );
        assert!(error("border_m = 0.7", "").contains("missing field `border_m`"));
        assert!(error("border_m", "boarder_m").contains("line 10"));
        assert!(error("\"robocup-field\"", "\"moon\"").contains("kind: expected \"robocup-field\""));
        let two_lengths = "length_m = 9.0\nwidth_m = 6.0\n";
        assert_eq!(
            Map::parse("m.toml", two_lengths).unwrap_err().to_string(),
            format!(
                "map m.toml: kind: expected \"robocup-field\" or \"office\", found nothing; {HOW_TO_BEGIN}"
            )
        );
        let with_kind = format!("kind = \"robocup-field\"\n{two_lengths}");
        assert_eq!(
            Map::parse("m.toml", &with_kind).unwrap_err().to_string(),
            format!(
                "map m.toml: expected also ball_color, ball_diameter_m, border_m, boxes, center_circle_diameter_m, center_mark_size_m, \
                 goals, line_width_m, name, penalty_mark_from_goal_line_m, penalty_mark_size_m, found only kind, length_m, \
                 width_m; {HOW_TO_BEGIN}"
            )
        );
        assert!(error("inner_width_m = 1.4", "inner_width_m = 5.0").contains("goals.inner_width_m"));
        assert!(error("depth_m = 0.6", "depth_m = 3.5").contains("boxes[0].depth_m"));
        assert!(Map::built_in("no-such-map").unwrap_err().to_string().contains("robocup-spl-2010"));
    }
}
