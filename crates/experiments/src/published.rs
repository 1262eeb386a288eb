//! What the documents publish: one list for all experiments, `data/published.md`.

use std::sync::LazyLock;

use visloc_plot::Table;

/// A table of published figures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PublishedTable {
    /// Experiment and table, as in `symmetry/static`.
    pub id: &'static str,
    /// Names of the columns.
    pub header: Vec<&'static str>,
    /// Rows of as many cells; the first names the row, `-` stands for nothing.
    pub rows: Vec<Vec<&'static str>>,
}

static TABLES: LazyLock<Vec<PublishedTable>> = LazyLock::new(|| parse(include_str!("../data/published.md")));

/// All published tables.
pub fn published_tables() -> &'static [PublishedTable] {
    &TABLES
}

/// The table of an experiment, if the documents have it.
pub(crate) fn table(id: &str) -> Option<&'static PublishedTable> {
    published_tables().iter().find(|table| table.id == id)
}

/// Puts what is published before what is here, `published | here`, in the cells of the same row and column of the experiment's
/// published table; published rows that are not here are added at the end.
pub(crate) fn beside(mut here: Table, experiment: &str) -> Table {
    let Some(published) = table(&format!("{experiment}/{}", here.name)) else { return here };
    for (name, column, value) in published.figures() {
        let Some(column) = here.header.iter().position(|header| header == column) else { continue };
        let place = here.rows.iter().position(|row| row.first().is_some_and(|first| first == name));
        let place = place.unwrap_or_else(|| {
            let mut row = vec!["-".to_owned(); here.header.len()];
            row[0] = name.to_owned();
            here.rows.push(row);
            here.rows.len() - 1
        });
        let cell = &mut here.rows[place][column];
        *cell = format!("{value} | {cell}");
    }
    here
}

/// A published figure as a number.
pub(crate) fn number(id: &str, row: &str, column: &str) -> Option<f64> {
    let figures = table(id)?.figures();
    figures.into_iter().find(|f| (f.0, f.1) == (row, column)).and_then(|figure| figure.2.parse().ok())
}

impl PublishedTable {
    /// Row, column and value of everything that is published.
    pub fn figures(&self) -> Vec<(&'static str, &'static str, &'static str)> {
        let of_row = |row: &Vec<&'static str>| {
            let name = row[0];
            let cells = self.header.iter().zip(row).skip(1).filter(|(_, value)| **value != "-");
            cells.map(move |(column, value)| (name, *column, *value)).collect::<Vec<_>>()
        };
        self.rows.iter().flat_map(of_row).collect()
    }
}

fn parse(text: &'static str) -> Vec<PublishedTable> {
    let mut tables: Vec<PublishedTable> = Vec::new();
    for line in text.lines() {
        if let Some(id) = line.strip_prefix("## ") {
            tables.push(PublishedTable { id, header: Vec::new(), rows: Vec::new() });
        }
        let inside = line.strip_prefix("| ").and_then(|rest| rest.strip_suffix(" |"));
        if let (Some(inside), Some(table)) = (inside, tables.last_mut()) {
            let cells = inside.split(" | ").collect();
            if table.header.is_empty() { table.header = cells } else { table.rows.push(cells) }
        }
    }
    tables
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_table_has_a_name_of_its_own_and_full_rows() {
        for (i, table) in published_tables().iter().enumerate() {
            assert!(published_tables()[..i].iter().all(|other| other.id != table.id), "{}", table.id);
            assert!(!table.rows.is_empty(), "{}", table.id);
            assert!(table.rows.iter().all(|row| row.len() == table.header.len()), "{}", table.id);
        }
        assert_eq!(number("symmetry/static", "MCAe, 500", "3 positions"), Some(47.0));
        assert_eq!(number("slam-compare/comparison", "MH01", "PTAM"), None, "not tracked");
    }
}
