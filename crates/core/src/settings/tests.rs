use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::*;

/// How something is done.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Way {
    /// Round the hill.
    LongWay,
    /// Over it.
    ShortWay,
}

/// A color.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Color {
    /// Start, degrees.
    from_deg: f64,
    /// End, degrees.
    #[schemars(range(max = 360.0), extend("exclusiveMinimum" = 0.0))]
    to_deg: f64,
}

/// Everything.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Example {
    /// The grass.
    green: Color,
    /// Rounds until
    /// it is done.
    #[schemars(range(min = 1, max = 1000))]
    iterations: u32,
    /// Which way.
    way: Way,
    /// Frame of the camera.
    camera_frame: Option<String>,
    /// Factors.
    #[schemars(extend("x-only-if" = "way = short-way"))]
    factors: [f64; 2],
    /// Pace.
    #[schemars(extend("x-only-if" = "green.from_deg > 80"))]
    pace: u32,
}

fn example() -> Example {
    Example {
        green: Color { from_deg: 85.0, to_deg: 185.0 },
        iterations: 300,
        way: Way::LongWay,
        camera_frame: None,
        factors: [1.0, 0.5],
        pace: 4,
    }
}

#[test]
fn a_text_changes_only_what_it_names() {
    let changed = overlay(&example(), "way = \"short-way\"\n[green]\nto_deg = 170\n").unwrap();
    let green = Color { from_deg: 85.0, to_deg: 170.0 };
    assert_eq!(changed, Example { way: Way::ShortWay, green, ..example() });
    assert_eq!(overlay(&example(), "").unwrap(), example());
    let named = overlay(&example(), "camera_frame = \"eye\"").unwrap();
    assert_eq!(named.camera_frame.as_deref(), Some("eye"), "a key without a default is known, too");
}

#[test]
fn mistakes_have_a_line_and_the_nearest_key() {
    let error = |text: &str| overlay(&example(), text).unwrap_err().to_string();
    assert_eq!(error("\niteratons = 3"), "line 2: unknown key `iteratons`, did you mean `iterations`?");
    assert_eq!(
        error("[green]\n\nto_degrees = 3"),
        "line 3: unknown key `to_degrees` in [green], did you mean `to_deg`?"
    );
    assert_eq!(error("to_deg = 3"), "line 1: unknown key `to_deg`, did you mean `green.to_deg`?");
    assert!(error("zzz = 1").contains("known: ") && error("zzz = 1").contains("camera_frame"));
    assert!(error("\n\niterations = \"many\"").starts_with("line 3: "));
    assert!(error("\n[green]\nfrom_deg = true").starts_with("line 3: "));
    assert!(error("way = \"detour\"").starts_with("line 1: "));
    assert!(error("way = ").starts_with("line 1: "));
    assert!(error("\ngreen = 3").starts_with("line 2: "));
}

#[test]
fn numbers_out_of_range_are_refused() {
    let error = |text: &str| overlay(&example(), text).unwrap_err().to_string();
    assert_eq!(error("\niterations = 0"), "line 2: iterations: expected 1 to 1000, found 0");
    assert_eq!(error("iterations = 1_001"), "line 1: iterations: expected 1 to 1000, found 1_001");
    assert_eq!(overlay(&example(), "iterations = 1000").unwrap().iterations, 1000);
    assert!(check_ranges(&example()).is_ok());
    let error = check_ranges(&Example { iterations: 2000, ..example() }).unwrap_err().to_string();
    assert_eq!(error, "iterations: expected 1 to 1000, found 2000");
    let with_end = |to_deg| Example { green: Color { from_deg: 85.0, to_deg }, ..example() };
    assert!(check_ranges(&with_end(360.0)).is_ok());
    for (to_deg, found) in [(0.0, "0.0"), (361.0, "361.0"), (f64::NAN, "NaN"), (f64::INFINITY, "NaN")] {
        let error = check_ranges(&with_end(to_deg)).unwrap_err().to_string();
        assert_eq!(error, format!("green.to_deg: expected above 0, at most 360, found {found}"));
    }
}

#[test]
fn what_counts_for_nothing_is_refused_unless_it_is_the_default() {
    let error = |text: &str| overlay(&example(), text).unwrap_err().to_string();
    let refused = |path: &str, condition: &str| {
        format!("{path}: it would change nothing: it counts only with {condition}")
    };
    assert_eq!(error("\nfactors = [1, 2]"), format!("line 2: {}", refused("factors", "way = short-way")));
    assert_eq!(
        error("pace = 5\ngreen.from_deg = 80"),
        format!("line 1: {}", refused("pace", "green.from_deg > 80"))
    );
    assert_eq!(overlay(&example(), "factors = [1, 0.5]").unwrap(), example());
    let counts = overlay(&example(), "factors = [1, 2]\nway = \"short-way\"\npace = 5").unwrap();
    assert_eq!((counts.factors, counts.pace), ([1.0, 2.0], 5));
    let layer = lay(&example(), "factors = [1, 2]").unwrap();
    assert_eq!(idle(&example(), &layer).unwrap().unwrap().path, "factors");
    assert_eq!(idle(&layer, &layer).unwrap(), None);
    assert_eq!(idle_at(&layer, "factors").unwrap().unwrap().path, "factors");
    assert_eq!(idle_at(&layer, "pace").unwrap(), None);
    assert_eq!(idle(&counts, &lay(&counts, "way = \"long-way\"").unwrap()).unwrap(), None);
}

#[test]
fn every_key_is_shown_with_its_meaning_and_the_text_reads_back() {
    let text = commented_toml(&example()).unwrap();
    assert!(text.starts_with("# Everything.\n"), "{text}");
    assert!(text.contains("# Rounds until it is done. Range: 1 to 1000.\niterations = 300\n"), "{text}");
    assert!(text.contains("# The grass.\n[green]\n# Start, degrees.\nfrom_deg = 85.0\n"), "{text}");
    assert!(text.contains("# Which way.\n# - \"long-way\": Round the hill.\n"), "{text}");
    assert!(text.contains("# Factors. Counts only with way = short-way.\nfactors"), "{text}");
    assert!(text.contains("# Frame of the camera.\n# camera_frame =\n"), "{text}");
    assert_eq!(overlay(&example(), &text).unwrap(), example());
}
