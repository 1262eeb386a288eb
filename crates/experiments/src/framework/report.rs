//! What an experiment shows at its end.

use std::path::Path;

use serde_json::Value;
use visloc_core::files;
use visloc_plot::{Picture, Table};

use super::ExperimentError;

/// Tables, numbers and pictures of an experiment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// Above the tables: what was done, with which seed and how many runs.
    pub heading: String,
    /// From top to bottom.
    pub tables: Vec<Table>,
    /// Below the tables: what they mean, and which figures fall short of the published ones and why.
    pub notes: Vec<String>,
    /// All numbers.
    pub json: Value,
    /// Pictures with the names of their files.
    pub pictures: Vec<(String, Picture)>,
}

impl Report {
    /// The report for people.
    pub fn text(&self) -> String {
        let tables = self.tables.iter().map(Table::text);
        let notes = self.notes.join("\n");
        let parts = std::iter::once(self.heading.clone() + "\n").chain(tables);
        let parts = parts.chain((!notes.is_empty()).then(|| notes + "\n"));
        parts.collect::<Vec<_>>().join("\n")
    }

    /// Writes the text, every table as CSV, the numbers as JSON and every picture as SVG and PNG into a folder.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn save(&self, folder: &Path) -> Result<(), ExperimentError> {
        let write = |name: String, text: &str| {
            let path = folder.join(name);
            files::write(&path, text).map_err(ExperimentError::file(&path))
        };
        write("report.txt".to_owned(), &self.text())?;
        write("report.json".to_owned(), &format!("{:#}\n", self.json))?;
        for table in &self.tables {
            write(format!("{}.csv", table.name), &table.csv())?;
        }
        for (name, picture) in &self.pictures {
            picture.save(folder, name)?;
        }
        Ok(())
    }
}
