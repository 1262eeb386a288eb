//! Parameters that count for nothing beside others.

use toml::{Table, Value};

use crate::settings::{
    Settings, SettingsError,
    schema::{Node, Schema},
};

/// A parameter that counts for nothing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Idle {
    /// Its key with the tables around it.
    pub path: String,
    /// What would have to hold.
    pub reason: String,
}

/// The first value that differs from `defaults` and counts for nothing with the other `values`, since what its type names for it
/// (`#[schemars(extend("x-only-if" = "kind = grid"))]`, a value of the same table) does not hold.
///
/// # Errors
/// If the values cannot be written as TOML.
pub fn idle<T: Settings>(defaults: &T, values: &T) -> Result<Option<Idle>, SettingsError> {
    let (defaults, values) = (table(defaults)?, table(values)?);
    Ok(first_idle(&values, Schema::of::<T>().root(), "", &|path, value| find(&defaults, path) != Some(value)))
}

/// Whether the value at a path counts for nothing with the other `values`, as in [`idle`].
///
/// # Errors
/// If the values cannot be written as TOML.
pub fn idle_at<T: Settings>(values: &T, path: &str) -> Result<Option<Idle>, SettingsError> {
    Ok(first_idle(&table(values)?, Schema::of::<T>().root(), "", &|found, _| found == path))
}

fn table<T: Settings>(values: &T) -> Result<Table, SettingsError> {
    Table::try_from(values).map_err(|error| SettingsError { line: None, reason: error.to_string() })
}

/// The value at a path.
pub(crate) fn find<'t>(table: &'t Table, path: &str) -> Option<&'t Value> {
    let mut steps = path.split('.');
    let first = steps.next().and_then(|key| table.get(key));
    steps.fold(first, |value, key| value?.get(key))
}

fn first_idle(
    values: &Table,
    node: Node<'_>,
    path: &str,
    is_meant: &impl Fn(&str, &Value) -> bool,
) -> Option<Idle> {
    values.iter().find_map(|(key, value)| {
        let inner = node.get(key)?;
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        let condition = inner.only_if().filter(|condition| !condition.holds_in(values));
        if let Some(condition) = condition.filter(|_| is_meant(&path, value)) {
            let reason = format!("it would change nothing: it counts only with {condition}");
            return Some(Idle { path, reason });
        }
        first_idle(value.as_table()?, inner, &path, is_meant)
    })
}
