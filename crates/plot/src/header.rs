//! Title, subtitle and legend above a picture, broken into as many lines as they need.

use crate::{
    Color,
    font::{self, Weight},
    line_style,
    svg::{Canvas, Paint, TextStyle},
};

const TITLE_PX: f64 = 18.0;
const SUBTITLE_PX: f64 = 13.0;
const LEGEND_PX: f64 = 12.5;
const LEGEND_LINE_PX: f64 = 21.0;
const SYMBOL_PX: f64 = 26.0;
const SYMBOL_GAP_PX: f64 = 7.0;
const ENTRY_GAP_PX: f64 = 22.0;
const TOP_PX: f64 = 16.0;

/// What stands for an entry in the legend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Symbol {
    Line(Color),
    DashedArrow(Color),
    FaintLine(Color),
    Patch(Color, f64),
    Dot(Color),
    RimmedDot(Color),
    Ring(Color),
}

/// One entry of the legend.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LegendEntry {
    pub(crate) label: String,
    pub(crate) symbol: Symbol,
}

impl LegendEntry {
    pub(crate) fn new(label: &str, symbol: Symbol) -> Self {
        Self { label: label.to_owned(), symbol }
    }
}

/// Title, subtitle and legend, laid out for a width.
#[derive(Debug)]
pub(crate) struct Header {
    left_px: f64,
    title: Vec<String>,
    subtitle: Vec<String>,
    legend: Vec<Vec<LegendEntry>>,
}

impl Header {
    /// Lays out for the space from `left_px` to `right_px`. Repeated and empty entries of the legend are left out.
    pub(crate) fn new(
        (left_px, right_px): (f64, f64),
        title: &str,
        subtitle: &str,
        entries: Vec<LegendEntry>,
    ) -> Self {
        let width_px = right_px - left_px;
        let mut rows: Vec<Vec<LegendEntry>> = Vec::new();
        let mut used_px = f64::INFINITY;
        let mut seen: Vec<LegendEntry> = Vec::new();
        for entry in entries {
            if entry.label.is_empty() || seen.contains(&entry) {
                continue;
            }
            seen.push(entry.clone());
            let entry_px = entry_width_px(&entry);
            if used_px + entry_px > width_px {
                rows.push(Vec::new());
                used_px = 0.0;
            }
            used_px += entry_px + ENTRY_GAP_PX;
            if let Some(row) = rows.last_mut() {
                row.push(entry);
            }
        }
        Self {
            left_px,
            title: font::wrap(title, TITLE_PX, Weight::Bold, width_px),
            subtitle: font::wrap(subtitle, SUBTITLE_PX, Weight::Regular, width_px),
            legend: rows,
        }
    }

    /// Space from the top of the picture to the end of the legend, pixels.
    pub(crate) fn height_px(&self) -> f64 {
        let lines = |count: usize, line_px: f64| count as f64 * line_px;
        let legend_px = lines(self.legend.len(), LEGEND_LINE_PX);
        TOP_PX
            + lines(self.title.len(), TITLE_PX * 1.3)
            + lines(self.subtitle.len(), SUBTITLE_PX * 1.4)
            + if self.legend.is_empty() { 0.0 } else { legend_px + 6.0 }
    }

    pub(crate) fn draw(&self, canvas: &mut Canvas) {
        let mut y = TOP_PX;
        for line in &self.title {
            y += TITLE_PX * 1.3;
            let style = TextStyle::new(TITLE_PX, Color::BLACK).bold();
            canvas.text((self.left_px, y - 0.4 * TITLE_PX), line, &style);
        }
        for line in &self.subtitle {
            y += SUBTITLE_PX * 1.4;
            let style = TextStyle::new(SUBTITLE_PX, Color::GRAY);
            canvas.text((self.left_px, y - 0.4 * SUBTITLE_PX), line, &style);
        }
        canvas.begin_part("legend");
        y += 6.0;
        for row in &self.legend {
            let mut x = self.left_px;
            for entry in row {
                let middle = y + LEGEND_LINE_PX / 2.0;
                draw_symbol(canvas, entry.symbol, x, middle);
                let baseline = middle + 0.36 * LEGEND_PX;
                let style = TextStyle::new(LEGEND_PX, Color::BLACK);
                canvas.text((x + SYMBOL_PX + SYMBOL_GAP_PX, baseline), &entry.label, &style);
                x += entry_width_px(entry) + ENTRY_GAP_PX;
            }
            y += LEGEND_LINE_PX;
        }
        canvas.end_group();
    }
}

fn entry_width_px(entry: &LegendEntry) -> f64 {
    SYMBOL_PX + SYMBOL_GAP_PX + font::width_px(&entry.label, LEGEND_PX, Weight::Regular)
}

fn draw_symbol(canvas: &mut Canvas, symbol: Symbol, left: f64, y: f64) {
    let (right, middle) = (left + SYMBOL_PX, left + SYMBOL_PX / 2.0);
    match symbol {
        Symbol::Line(color) => {
            canvas.line((left, y), (right, y), &line_style::stroke(color, 2.8));
            line_style::draw_mark(canvas, color, (middle, y));
        }
        Symbol::FaintLine(color) => {
            canvas.line((left, y), (right, y), &Paint::stroke(color, 2.0).opacity(0.45));
        }
        Symbol::DashedArrow(color) => {
            canvas.line((left, y), (right - 6.0, y), &Paint::stroke(color, 1.8).dashed());
            let head = [(right, y), (right - 8.0, y - 4.5), (right - 8.0, y + 4.5)];
            canvas.polygon(&head, &Paint::fill(color));
        }
        Symbol::Patch(color, opacity) => {
            let data = format!("M{left} {}H{right}V{}H{left}Z", y - 6.0, y + 6.0);
            canvas.path(&data, &Paint::fill(color).opacity(opacity));
        }
        Symbol::Dot(color) => canvas.circle((middle, y), 5.0, &Paint::fill(color)),
        Symbol::RimmedDot(color) => {
            canvas.circle((middle, y), 5.0, &Paint::fill(color).outlined(Color::BLACK, 0.8));
        }
        Symbol::Ring(color) => canvas.circle((middle, y), 5.5, &Paint::stroke(color, 2.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legend_breaks_into_rows_and_drops_repetitions() {
        let entry = |i: usize| LegendEntry::new(&format!("series {i}"), Symbol::Line(Color::series(i)));
        let entries =
            vec![entry(0), entry(1), entry(0), LegendEntry::new("", Symbol::Dot(Color::BLUE)), entry(2)];
        let header = Header::new((0.0, 250.0), "", "", entries);
        assert_eq!(header.legend.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
    }

    #[test]
    fn long_title_makes_the_header_taller() {
        let height_px = |title: &str| Header::new((0.0, 300.0), title, "", Vec::new()).height_px();
        assert!(height_px("a title that is far too long for one line") > height_px("short"));
        assert!(height_px("short") > height_px(""));
    }
}
