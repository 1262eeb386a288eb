//! Parameters one by one, for programs that let people change them.

use serde::Serialize;
use serde_json::Value;

use crate::settings::{
    Settings, SettingsError,
    schema::{Node, Schema},
};

/// One value that can be set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Its key with the tables around it, as TOML writes it: `motion.noise_m_per_m`.
    pub path: String,
    /// Its value; null if it is not set.
    pub value: Value,
    /// What it means.
    pub meaning: String,
    /// Its unit, if it has one, from the suffix of the key.
    pub unit: Option<String>,
    /// Least and largest value, if the type names them.
    pub range: Option<(f64, f64)>,
    /// Names that it can have; empty if it is not a choice.
    pub choices: Vec<Choice>,
    /// What another value of its table must be for this one to count, as in `kind = grid` and `growth > 0`.
    pub only_if: Option<String>,
}

/// One of several names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// The name.
    pub name: String,
    /// What it means.
    pub meaning: String,
}

/// All parameters in the order in which [`crate::settings::commented_toml`] writes them: values first, then tables.
///
/// # Errors
/// If the values cannot be written.
pub fn parameters<T: Settings>(values: &T) -> Result<Vec<Parameter>, SettingsError> {
    let values = serde_json::to_value(values)
        .map_err(|error| SettingsError { line: None, reason: error.to_string() })?;
    let schema = Schema::of::<T>();
    let mut out = Vec::new();
    collect(&mut out, &values, schema.root(), "");
    Ok(out)
}

fn collect(out: &mut Vec<Parameter>, values: &Value, node: Node<'_>, path: &str) {
    let is_table = |key: &str| values.get(key).is_some_and(Value::is_object);
    let joined = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    for key in node.keys().filter(|key| !is_table(key)) {
        let Some(inner) = node.get(key) else { continue };
        let value = values.get(key).cloned().unwrap_or(Value::Null);
        out.push(parameter(key, joined(key), value, inner));
    }
    for key in node.keys().filter(|key| is_table(key)) {
        if let (Some(inner), Some(below)) = (node.get(key), values.get(key)) {
            collect(out, below, inner, &joined(key));
        }
    }
}

fn parameter(key: &str, path: String, value: Value, node: Node<'_>) -> Parameter {
    let choices = node
        .choices()
        .into_iter()
        .map(|(name, meaning)| Choice { name: name.to_owned(), meaning: meaning.unwrap_or_default() });
    Parameter {
        unit: unit(key),
        path,
        value,
        meaning: node.meaning().unwrap_or_default(),
        range: node.range().map(|range| (range.least, range.most)),
        choices: choices.collect(),
        only_if: node.only_if().map(|condition| condition.to_string()),
    }
}

/// The unit that the end of a key names: `noise_m_per_m` is in m/m.
fn unit(key: &str) -> Option<String> {
    let (above, below) = key.split_once("_per_").map_or((key, None), |(above, below)| (above, Some(below)));
    let symbol = |word: &str| match word {
        "m" | "rad" | "px" | "ms" | "s" => Some(word.to_owned()),
        "deg" => Some("\u{b0}".to_owned()),
        "secs" => Some("s".to_owned()),
        "sec" => Some("s".to_owned()),
        "n" => Some("N".to_owned()),
        _ => None,
    };
    let above = above.rsplit_once('_').and_then(|(_, word)| symbol(word));
    match below.map(|word| symbol(word).unwrap_or_else(|| word.to_owned())) {
        Some(below) => Some(format!("{}/{below}", above.as_deref().unwrap_or("1"))),
        None => above,
    }
}

#[cfg(test)]
mod tests {
    use schemars::JsonSchema;
    use serde::Deserialize;

    use super::*;

    /// What a test needs.
    #[derive(Serialize, Deserialize, JsonSchema)]
    struct Whole {
        /// How many.
        #[schemars(range(min = 1.0, max = 9.0))]
        count: u32,
        /// How it goes.
        way: Way,
        /// The motion.
        motion: Motion,
    }

    /// Ways.
    #[derive(Serialize, Deserialize, JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    enum Way {
        /// Fast.
        ByAir,
        /// Slow.
        ByLand,
    }

    /// Motion.
    #[derive(Serialize, Deserialize, JsonSchema)]
    struct Motion {
        /// Noise.
        noise_m_per_m: f64,
    }

    #[test]
    fn every_value_has_path_meaning_unit_range_and_choices() {
        let values = Whole { count: 3, way: Way::ByAir, motion: Motion { noise_m_per_m: 0.1 } };
        let all = parameters(&values).unwrap();
        let paths: Vec<&str> = all.iter().map(|parameter| parameter.path.as_str()).collect();
        assert_eq!(paths, ["count", "way", "motion.noise_m_per_m"]);
        assert_eq!((all[0].range, all[0].meaning.as_str()), (Some((1.0, 9.0)), "How many."));
        assert_eq!(all[1].choices[1], Choice { name: "by-land".to_owned(), meaning: "Slow.".to_owned() });
        assert_eq!(all[2].unit.as_deref(), Some("m/m"));
        assert_eq!(all[2].value, Value::from(0.1));
    }

    #[test]
    fn units_come_from_the_ends_of_keys() {
        let units = [
            ("max_distance_px", Some("px")),
            ("spread_m", Some("m")),
            ("settle_secs", Some("s")),
            ("speed_deg_per_s", Some("\u{b0}/s")),
            ("num_particles", None),
            ("bins_per_m", Some("1/m")),
            ("m", None),
        ];
        for (key, expected) in units {
            assert_eq!(unit(key).as_deref(), expected, "{key}");
        }
    }
}
