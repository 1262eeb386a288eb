//! Parameters that somebody has changed, by their paths.

use std::collections::BTreeMap;

use serde_json::Value;

use super::{Parameter, SettingsError};

/// Changed parameters.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    values: BTreeMap<String, Value>,
}

impl Overrides {
    /// The same with one more.
    #[must_use]
    pub fn with(&self, path: &str, value: &Value) -> Self {
        let mut values = self.values.clone();
        values.insert(path.to_owned(), value.clone());
        Self { values }
    }

    /// All paths.
    pub fn paths(&self) -> Vec<&str> {
        self.values.keys().map(String::as_str).collect()
    }

    /// What a text of TOML changes.
    ///
    /// # Errors
    /// If it is no TOML, or has a value that JSON lacks.
    pub fn from_toml(text: &str) -> Result<Self, SettingsError> {
        let table: toml::Table =
            toml::from_str(text).map_err(|error| SettingsError::at(text, error.span(), error.message()))?;
        let root = serde_json::to_value(table).map_err(|error| SettingsError::of("parameters", error))?;
        let mut values = BTreeMap::new();
        flatten(&root, "", &mut values);
        Ok(Self { values })
    }

    /// What is different in `values` from `defaults`.
    pub fn between(defaults: &[Parameter], values: Vec<Parameter>) -> Self {
        let is_default = |it: &Parameter| {
            defaults.iter().any(|default| default.path == it.path && default.value == it.value)
        };
        let changed = values.into_iter().filter(|it| !it.value.is_null() && !is_default(it));
        Self { values: changed.map(|it| (it.path, it.value)).collect() }
    }

    /// As TOML, to be laid over defaults.
    ///
    /// # Errors
    /// If a path is no path or a value no value of TOML.
    pub fn toml(&self) -> Result<String, SettingsError> {
        let mut root = toml::Table::new();
        for (path, value) in &self.values {
            let value = toml::Value::try_from(value).map_err(|_| {
                // JSON has neither of these numbers.
                let found = if value.is_null() { "nan or inf".to_owned() } else { value.to_string() };
                SettingsError::of(path, format!("expected a number, a word or a list, found {found}"))
            })?;
            insert(&mut root, path, value)?;
        }
        toml::to_string(&root).map_err(|error| SettingsError::of("parameters", error))
    }
}

fn flatten(value: &Value, path: &str, out: &mut BTreeMap<String, Value>) {
    let Some(table) = value.as_object() else {
        out.insert(path.to_owned(), value.clone());
        return;
    };
    for (key, below) in table {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        flatten(below, &path, out);
    }
}

fn insert(root: &mut toml::Table, path: &str, value: toml::Value) -> Result<(), SettingsError> {
    let (tables, key) = path.rsplit_once('.').map_or((None, path), |(tables, key)| (Some(tables), key));
    let mut table = root;
    for name in tables.into_iter().flat_map(|tables| tables.split('.')) {
        let below = table.entry(name).or_insert_with(|| toml::Value::Table(toml::Table::new()));
        table = below
            .as_table_mut()
            .ok_or_else(|| SettingsError::of(path, format!("expected a table, found {name}")))?;
    }
    table.insert(key.to_owned(), value);
    Ok(())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn paths_become_tables() {
        let overrides = Overrides::default()
            .with("num_particles", &json!(500))
            .with("motion.noise_m_per_m", &json!(0.5))
            .with("num_particles", &json!(600));
        assert_eq!(overrides.toml().unwrap(), "num_particles = 600\n\n[motion]\nnoise_m_per_m = 0.5\n");
        assert_eq!(Overrides::from_toml(&overrides.toml().unwrap()).unwrap(), overrides);
        assert!(Overrides::from_toml("= 3").is_err());
        assert!(Overrides::default().with("a", &json!(null)).toml().is_err());
        assert!(Overrides::default().with("a", &json!(1)).with("a.b", &json!(1)).toml().is_err());
    }
}
