//! A field as a list of its measures in YAML, as recordings come with it.

use serde::Deserialize;

use super::yaml_error;
use crate::{
    MapError,
    field::{BallColor, BoxDimensions, Field, FieldDimensions, GoalColor, GoalDimensions},
};

/// The file; lengths in meters between line centers. What it says beyond this (each line, the ball's place) follows from it or is
/// no part of a map.
#[derive(Deserialize)]
struct List {
    length: f64,
    width: f64,
    border: f64,
    line: f64,
    circle_diameter: f64,
    penalty_depth: f64,
    penalty_width: f64,
    cross_from_goal_line: f64,
    goal_inner_width: f64,
    goal_inner_height: f64,
    post_diameter: f64,
    ball_diameter: f64,
    centre_mark: f64,
    goals: Vec<ListGoal>,
}

#[derive(Deserialize)]
struct ListGoal {
    color: GoalColor,
    x: f64,
}

/// Whether a text in YAML lists the measures of a field.
pub(crate) fn is_field_list(text: &str) -> bool {
    let has_key =
        |key: &str| text.lines().any(|line| line.strip_prefix(key).is_some_and(|rest| rest.starts_with(':')));
    has_key("circle_diameter") && has_key("goals")
}

/// Reads a list of measures; `name` is used in errors, and `title` becomes the name of the map.
pub(crate) fn read_field_list(name: &str, title: &str, text: &str) -> Result<Field, MapError> {
    let list: List = serde_saphyr::from_str(text).map_err(|error| yaml_error(name, &error))?;
    let color_at =
        |is_ahead: bool| list.goals.iter().find(|goal| (goal.x > 0.0) == is_ahead).map(|goal| goal.color);
    let (Some(ahead), Some(behind)) = (color_at(true), color_at(false)) else {
        let reason =
            format!("goals: expected one at positive and one at negative x, found {}", list.goals.len());
        return Err(MapError::Syntax { name: name.to_owned(), line: None, reason });
    };
    let dimensions = FieldDimensions {
        kind: "robocup-field".to_owned(),
        name: title.to_owned(),
        length_m: list.length,
        width_m: list.width,
        border_m: list.border,
        line_width_m: list.line,
        center_circle_diameter_m: list.circle_diameter,
        penalty_mark_from_goal_line_m: list.cross_from_goal_line,
        penalty_mark_size_m: list.centre_mark,
        center_mark_size_m: list.centre_mark,
        ball_diameter_m: list.ball_diameter,
        ball_color: BallColor::Orange,
        boxes: vec![BoxDimensions { depth_m: list.penalty_depth, width_m: list.penalty_width }],
        goals: GoalDimensions {
            colors: [ahead, behind],
            inner_width_m: list.goal_inner_width,
            inner_height_m: list.goal_inner_height,
            post_diameter_m: list.post_diameter,
        },
    };
    Field::new(name, dimensions)
}

#[cfg(test)]
mod tests {
    use crate::{Map, MapError};

    const TEXT: &str = "length: 6.0\nwidth: 4.0\nborder: 0.7\nline: 0.05\ncircle_diameter: 1.2\npenalty_depth: 0.6\n\
        penalty_width: 2.2\ncross_from_goal_line: 1.8\ngoal_inner_width: 1.4\ngoal_inner_height: 0.8\npost_diameter: 0.1\n\
        ball_diameter: 0.065\ncentre_mark: 0.1\nlines: [[-3.0, -2.0, 3.0, -2.0]]\n\
        goals:\n  - {color: yellow, x: 3.0, height: 0.9}\n  - {color: blue, x: -3.0, height: 0.9}\n";

    fn read(text: &str) -> Result<Map, MapError> {
        Map::from_bytes("field.yaml", text.as_bytes(), |_| Err(String::new())).map(|(map, _)| map)
    }

    #[test]
    fn a_list_of_measures_is_the_field_with_these_measures() {
        let (Ok(Map::Field(read)), Ok(Map::Field(built_in))) = (read(TEXT), Map::load("robocup-spl-2010"))
        else {
            panic!("two fields")
        };
        let mut expected = built_in.dimensions().clone();
        expected.name = "field".to_owned();
        assert_eq!(*read.dimensions(), expected);
    }

    #[test]
    fn what_is_wrong_is_told() {
        for (from, to, expected) in [
            ("length: 6.0", "length: -6.0", "length_m"),
            ("x: -3.0", "x: 3.0", "negative x"),
            ("color: blue", "color: pink", "pink"),
            ("width: 4.0", "breadth: 4.0", "width"),
        ] {
            let error = read(&TEXT.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(error.contains("field.yaml") && error.contains(expected), "{to}: {error}");
        }
    }
}
