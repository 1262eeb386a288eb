//! Checks buildings that somebody draws on a page, by the code of `visloc map check`. Nothing is kept here.

use axum::{
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use serde::Deserialize;
use serde_json::{Value, json};
use visloc_world::{
    Map, MapError,
    office::{Office, OfficePlan},
};

/// Longest plan that is taken, bytes: a thousand walls and doors.
pub(super) const MAX_BYTES: usize = 256 * 1024;

/// What a page asks about: what it has drawn, or the text of a map file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Question {
    plan: Option<OfficePlan>,
    #[serde(default)]
    name: String,
    #[serde(default)]
    text: String,
}

/// Answers with the plan, its text as a map file and what is wrong with it.
pub(super) async fn check_building(body: String) -> Response {
    // A large building takes a moment, for which the other pages do not wait.
    let checked = tokio::task::spawn_blocking(move || answer_to(&body)).await;
    match checked {
        Ok(Err(expected)) => (StatusCode::BAD_REQUEST, expected).into_response(),
        Ok(Ok(answer)) => ([(header::CONTENT_TYPE, "application/json")], answer.to_string()).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}

/// What a page is told of what somebody has drawn on it.
///
/// # Errors
/// If it asks about something else.
pub fn answer_to(body: &str) -> Result<Value, String> {
    let question = serde_json::from_str(body);
    question.map(answer).map_err(|error| format!("expected a plan, or name and text of a map file: {error}"))
}

fn answer(question: Question) -> Value {
    let office = match question.plan {
        Some(plan) => Office::new(&plan.name.clone(), plan),
        None => building(&question.name, &question.text),
    };
    let map = match office {
        Ok(office) => Map::Office(office),
        Err(error) => return json!({ "error": error.to_string(), "hindrances": [] }),
    };
    let hindrances: Vec<Value> = map
        .what_hinders_localization()
        .iter()
        .map(|hindrance| json!({ "text": hindrance.to_string(), "detail": hindrance }))
        .collect();
    let text = map.to_toml();
    let Map::Office(office) = map else { return json!({}) };
    json!({
        "error": text.as_ref().err().map(ToString::to_string),
        "hindrances": hindrances,
        "plan": office.plan(),
        "toml": text.unwrap_or_default(),
        "floor_m2": office.free_space().area_m2(),
        "num_doors": office.plan().doors.len(),
    })
}

fn building(name: &str, text: &str) -> Result<Office, MapError> {
    match Map::parse(name, text)? {
        Map::Office(office) => Ok(office),
        _ => Err(MapError::Value {
            name: name.to_owned(),
            key: "kind".to_owned(),
            expected: "\"office\", a building",
            found: "a field".to_owned(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(question: &Value) -> Value {
        answer(serde_json::from_value(question.clone()).unwrap())
    }

    fn drawn(doors: &Value) -> Value {
        let wall = |from: [f64; 2], to: [f64; 2]| json!({ "from": from, "to": to });
        let walls = [
            wall([0.0, 0.0], [8.0, 0.0]),
            wall([8.0, 0.0], [8.0, 2.0]),
            wall([8.0, 2.0], [0.0, 2.0]),
            wall([0.0, 2.0], [0.0, 0.0]),
        ];
        json!({ "plan": { "kind": "office", "name": "drawn", "walls": walls, "doors": doors } })
    }

    #[test]
    fn what_is_drawn_becomes_a_map_file_that_is_read_again() {
        let door = json!({ "from": [1.0, 0.0], "to": [1.9, 0.0], "color": "red" });
        let answer = asked(&drawn(&json!([door])));
        assert_eq!((&answer["error"], &answer["hindrances"]), (&Value::Null, &json!([])), "{answer}");
        assert!(answer["floor_m2"].as_f64().unwrap() > 12.0 && answer["num_doors"] == 1, "{answer}");
        let again = asked(&json!({ "name": "drawn.toml", "text": answer["toml"] }));
        assert_eq!(again["plan"], answer["plan"]);
        assert_eq!(again["toml"], answer["toml"]);
    }

    #[test]
    fn what_is_wrong_is_said_as_by_map_check() {
        let answer = asked(&drawn(&json!([])));
        assert!(answer["hindrances"][0]["text"].as_str().unwrap().starts_with("no doors"), "{answer}");
        let off = json!({ "from": [1.0, 0.5], "to": [1.9, 0.5] });
        let answer = asked(&drawn(&json!([off])));
        assert!(
            answer["error"].as_str().unwrap().contains("doors[0]: expected both edges on one wall"),
            "{answer}"
        );
        let field = Map::built_in("robocup-spl-2010").unwrap().to_toml().unwrap();
        let answer = asked(&json!({ "name": "f.toml", "text": field }));
        assert!(answer["error"].as_str().unwrap().contains("a building"), "{answer}");
    }
}
