//! The numbers beside the field.

use visloc_core::Truth;

use super::{Event, dots::Rgb};
use crate::run::{FrameView, Runner};

/// Width of the panel, characters.
pub const PANEL_COLUMNS: usize = 40;

const BAR_COLUMNS: usize = 20;
const GRAY: Rgb = [140, 140, 140];
const PINK: Rgb = [255, 90, 160];

/// Color of an algorithm: as in the pictures, but brighter, for dark backgrounds.
pub fn algorithm_color(index: usize) -> Rgb {
    const COLORS: [Rgb; 4] = [[80, 180, 255], [255, 150, 50], [220, 130, 200], [90, 220, 170]];
    COLORS[index % COLORS.len()]
}

/// Everything above the events.
pub fn status_lines(view: &FrameView<'_>, real_time_factor: f64) -> Vec<String> {
    let is_carried = view.truth.is_some_and(|truth| truth.height_m > 0.02);
    let robot = if is_carried { paint("carried away", PINK) } else { "on the field".to_owned() };
    let mut lines = vec![
        format!("{:6.1} s   {real_time_factor:.1} x real time", view.secs),
        format!("\u{25cf} robot, {robot}"),
    ];
    for (i, runner) in view.runners.iter().enumerate() {
        lines.extend(algorithm_lines(i, runner, view.truth.as_ref()));
    }
    lines
}

fn algorithm_lines(index: usize, runner: &Runner, truth: Option<&Truth>) -> Vec<String> {
    let Some(record) = runner.records().latest() else { return Vec::new() };
    let state = if record.is_localized() { "localized".to_owned() } else { paint("searching", GRAY) };
    let error = truth.map_or_else(String::new, |truth| {
        let (estimate, truth) = (record.world_from_robot, truth.world_from_robot);
        let heading_deg = estimate.heading_difference_rad(&truth).to_degrees();
        format!("{:5.2} m {heading_deg:5.1} deg", estimate.distance_m(&truth))
    });
    let ms = record.analysis_ms + record.localizer_ms;
    let color = algorithm_color(index);
    vec![
        format!("{} {:<18} {state}", paint("\u{25ef}", color), runner.name()),
        format!("  error {error}   {ms:5.2} ms"),
        format!("  trust {} {:.2}", bar(record.reliability, color), record.reliability),
    ]
}

/// The last events that fit as a whole, the newest at the bottom.
pub fn event_lines(events: &[Event], max_lines: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for event in events.iter().rev() {
        let color = event.runner.map_or(PINK, algorithm_color);
        let text = format!("{:5.1} s {}", event.secs, event.text);
        let parts = wrap(&text, PANEL_COLUMNS);
        if lines.len() + parts.len() > max_lines {
            break;
        }
        lines.splice(0..0, parts.iter().map(|part| paint(part, color)));
    }
    lines
}

/// Breaks at spaces and indents what follows the first line.
fn wrap(text: &str, max: usize) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    for word in text.split(' ') {
        let indent = if parts.is_empty() { "" } else { "        " };
        match parts.last_mut().filter(|part| part.len() + 1 + word.len() <= max) {
            Some(part) => *part = format!("{part} {word}"),
            None => parts.push(format!("{indent}{word}")),
        }
    }
    parts
}

fn bar(share: f64, color: Rgb) -> String {
    let filled = ((share.clamp(0.0, 1.0) * BAR_COLUMNS as f64).round() as usize).min(BAR_COLUMNS);
    let (full, empty) = ("\u{2588}".repeat(filled), "\u{2591}".repeat(BAR_COLUMNS - filled));
    format!("{}{}", paint(&full, color), paint(&empty, GRAY))
}

fn paint(text: &str, [r, g, b]: Rgb) -> String {
    format!("\x1b[38;2;{r};{g};{b}m{text}\x1b[0m")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_events_are_broken_and_old_ones_scroll_away() {
        let event = |secs: f64| Event {
            secs,
            text: "a robot with a long name found it in 12.3 s".to_owned(),
            runner: None,
        };
        let lines = event_lines(&[event(1.0), event(12.0)], 3);
        assert_eq!(lines.len(), 2, "no half event");
        assert!(lines.iter().all(|line| console::measure_text_width(line) <= PANEL_COLUMNS));
        assert!(lines[0].contains("12.0 s a robot"));
    }
}
