//! The counts as tables.

use serde_json::json;
use visloc_locate::vision::FeatureKind;

use super::counts::{FILTERS, Found, KINDS, Kept, SceneResult};
use crate::{Table, percent, ratio};

/// The filters for lines (kind 0) or goals (kind 1).
pub(super) fn filter_table(scene: &SceneResult, kind: usize) -> Table {
    let objects = ["line", "goal"][kind];
    let title = format!("Filters for {objects} pixels, scene {:?}, {} images", scene.name, scene.num_images);
    let header = [
        "filter",
        "drops",
        "of these wrong",
        "alone: precision",
        "recall",
        "without it: precision",
        "recall",
    ];
    let mut table = Table::new(&format!("filters-{}-{objects}s", scene.name), &title, &header);
    let none = scene.none[kind];
    let whole = |name: &str, kept: Kept| {
        let all = kept.right + kept.wrong;
        [
            format!("{name}: {all} pixels"),
            String::new(),
            String::new(),
            percent(kept.precision()),
            percent(kept.recall(none)),
            String::new(),
            String::new(),
        ]
    };
    table.push(whole("no filter", none));
    for (i, filter) in FILTERS.iter().enumerate() {
        if !(if kind == 0 { filter.for_lines } else { filter.for_goals }) {
            continue;
        }
        let (dropped, alone, without) =
            (scene.dropped[i][kind], scene.alone[i][kind], scene.without[i][kind]);
        table.push([
            filter.name.to_owned(),
            (dropped.right + dropped.wrong).to_string(),
            percent(dropped.precision().map(|right| 1.0 - right)),
            percent(alone.precision()),
            percent(alone.recall(none)),
            percent(without.precision()),
            percent(without.recall(none)),
        ]);
    }
    table.push(whole("all filters", scene.chain[kind]));
    table.push(whole("and random discard", scene.few[kind]));
    table
}

/// Objects found and invented.
pub(super) fn object_table(scene: &SceneResult) -> Table {
    let title = format!("Objects, scene {:?}, {} images", scene.name, scene.num_images);
    let header = ["object", "images with it", "found", "images without it", "invented"];
    let mut table = Table::new(&format!("filters-{}-objects", scene.name), &title, &header);
    for ((_, name), found) in KINDS.iter().zip(&scene.objects) {
        table.push([
            (*name).to_owned(),
            found.visible.to_string(),
            percent(ratio(found.found, found.visible)),
            found.absent.to_string(),
            percent(ratio(found.invented, found.absent)),
        ]);
    }
    table
}

/// All numbers of a scene.
pub(super) fn scene_json(scene: &SceneResult) -> serde_json::Value {
    let kept = |kept: Kept, kind: usize| {
        json!({
            "pixels": kept.right + kept.wrong,
            "precision": kept.precision(),
            "recall": kept.recall(scene.none[kind]),
        })
    };
    let kind = |kind: usize| {
        let filters = FILTERS
            .iter()
            .enumerate()
            .filter(|(_, filter)| if kind == 0 { filter.for_lines } else { filter.for_goals });
        json!({
            "no_filter": kept(scene.none[kind], kind),
            "all_filters": kept(scene.chain[kind], kind),
            "with_random_discard": kept(scene.few[kind], kind),
            "filters": filters.map(|(i, filter)| json!({
                "filter": filter.name,
                "drops": scene.dropped[i][kind].right + scene.dropped[i][kind].wrong,
                "drops_wrong_share": scene.dropped[i][kind].precision().map(|right| 1.0 - right),
                "alone": kept(scene.alone[i][kind], kind),
                "without": kept(scene.without[i][kind], kind),
            })).collect::<Vec<_>>(),
        })
    };
    let object = |((_, name), found): (&(FeatureKind, &str), &Found)| {
        json!({
            "object": name,
            "images_with_it": found.visible,
            "found": ratio(found.found, found.visible),
            "images_without_it": found.absent,
            "invented": ratio(found.invented, found.absent),
        })
    };
    json!({
        "scene": scene.name,
        "images": scene.num_images,
        "lines": kind(0),
        "goals": kind(1),
        "objects": KINDS.iter().zip(&scene.objects).map(object).collect::<Vec<_>>(),
    })
}
