//! Tables as text and as CSV.

use std::fmt::Write as _;

/// A table: a header and rows of as many cells.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    /// Names its file.
    pub name: String,
    /// Above it.
    pub title: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// From top to bottom.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(name: &str, title: &str, header: &[&str]) -> Self {
        let header = header.iter().map(|&name| name.to_owned()).collect();
        Self { name: name.to_owned(), title: title.to_owned(), header, rows: Vec::new() }
    }

    /// Appends a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = impl Into<String>>) {
        self.rows.push(row.into_iter().map(Into::into).collect());
    }

    /// The table for people: title, columns below each other, the first to the left and the others to the right.
    pub fn text(&self) -> String {
        let lines: Vec<&Vec<String>> = std::iter::once(&self.header).chain(&self.rows).collect();
        let width = |i: usize| lines.iter().filter_map(|l| l.get(i)).map(|c| c.chars().count()).max();
        let widths: Vec<usize> = (0..self.header.len()).filter_map(width).collect();
        let mut text = format!("{}\n\n", self.title);
        for line in lines {
            let cells = line.iter().zip(&widths).enumerate().map(|(i, (cell, width))| match i {
                0 => format!("{cell:<width$}"),
                _ => format!("{cell:>width$}"),
            });
            let _ = writeln!(text, "  {}", cells.collect::<Vec<_>>().join("   ").trim_end());
        }
        text
    }

    /// The table in Markdown.
    pub fn markdown(&self) -> String {
        let line = |cells: &Vec<String>| {
            let cells = cells.iter().map(|cell| cell.replace('|', "\\|").replace('\n', " "));
            format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "))
        };
        let rule = format!("|{}\n", "---|".repeat(self.header.len()));
        std::iter::once(line(&self.header)).chain([rule]).chain(self.rows.iter().map(line)).collect()
    }

    /// The table in HTML.
    pub fn html(&self) -> String {
        let line = |cells: &Vec<String>, tag: &str| {
            let cells = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell)));
            format!("<tr>{}</tr>\n", cells.collect::<String>())
        };
        let rows: String = self.rows.iter().map(|row| line(row, "td")).collect();
        format!("<table>\n<thead>{}</thead>\n<tbody>\n{rows}</tbody>\n</table>\n", line(&self.header, "th"))
    }

    /// The table for programs. Cells with commas, quotes or line ends are quoted.
    pub fn csv(&self) -> String {
        let cell = |cell: &String| {
            if cell.contains([',', '"', '\n']) {
                format!("\"{}\"", cell.replace('"', "\"\""))
            } else {
                cell.clone()
            }
        };
        let line = |cells: &Vec<String>| cells.iter().map(cell).collect::<Vec<_>>().join(",") + "\n";
        std::iter::once(&self.header).chain(&self.rows).map(line).collect()
    }
}

/// Text as HTML shows it.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_aligned_and_csv_is_quoted() {
        let mut table = Table::new("t", "Title", &["name", "value"]);
        table.push(["a, b", "1"]);
        table.push(["c", "12345"]);
        assert_eq!(table.text(), "Title\n\n  name   value\n  a, b       1\n  c      12345\n");
        assert_eq!(table.csv(), "name,value\n\"a, b\",1\nc,12345\n");
    }
    #[test]
    fn markdown_and_html_keep_what_is_in_a_cell() {
        let mut table = Table::new("t", "Title", &["name", "value"]);
        table.push(["a | b", "<1"]);
        assert_eq!(table.markdown(), "| name | value |\n|---|---|\n| a \\| b | <1 |\n");
        assert!(table.html().contains("<tr><td>a | b</td><td>&lt;1</td></tr>"), "{}", table.html());
    }
}
