//! The page, which is part of the program.

use visloc_plot::{BY_HAND_PAGE, BY_HAND_SCRIPT, BY_HAND_STYLE};

/// A file of the page.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asset {
    path: &'static str,
    /// Its media type.
    pub kind: &'static str,
    /// Its content.
    pub bytes: &'static [u8],
}

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const SVG: &str = "image/svg+xml";

macro_rules! shared {
    ($path:literal, $kind:expr, $text:expr) => {
        Asset { path: $path, kind: $kind, bytes: $text.as_bytes() }
    };
}

macro_rules! asset {
    ($path:literal, $kind:expr, $file:literal) => {
        Asset { path: $path, kind: $kind, bytes: include_bytes!(concat!("../../page/", $file)) }
    };
}

/// The page by hand, which the command line writes as one file.
const BY_HAND: &[Asset] = &[
    shared!("/by-hand.html", HTML, BY_HAND_PAGE),
    shared!("/by-hand.css", CSS, BY_HAND_STYLE),
    shared!("/by-hand.js", SCRIPT, BY_HAND_SCRIPT),
];

/// All files of the folder.
const ASSETS: &[Asset] = &[
    asset!("/", HTML, "index.html"),
    asset!("/icon.svg", SVG, "icon.svg"),
    asset!("/style.css", CSS, "style.css"),
    asset!("/panels.css", CSS, "panels.css"),
    asset!("/screens.css", CSS, "screens.css"),
    asset!("/editor.css", CSS, "editor.css"),
    asset!("/team.css", CSS, "team.css"),
    asset!("/js/actors.js", SCRIPT, "js/actors.js"),
    asset!("/js/aim.js", SCRIPT, "js/aim.js"),
    asset!("/js/announcer.js", SCRIPT, "js/announcer.js"),
    asset!("/js/bar.js", SCRIPT, "js/bar.js"),
    asset!("/js/by_hand.js", SCRIPT, "js/by_hand.js"),
    asset!("/js/camera3d.js", SCRIPT, "js/camera3d.js"),
    asset!("/js/cards.js", SCRIPT, "js/cards.js"),
    asset!("/js/dom.js", SCRIPT, "js/dom.js"),
    asset!("/js/drive_panel.js", SCRIPT, "js/drive_panel.js"),
    asset!("/js/editor.js", SCRIPT, "js/editor.js"),
    asset!("/js/export.js", SCRIPT, "js/export.js"),
    asset!("/js/files.js", SCRIPT, "js/files.js"),
    asset!("/js/freshness.js", SCRIPT, "js/freshness.js"),
    asset!("/js/icons.js", SCRIPT, "js/icons.js"),
    asset!("/js/image_view.js", SCRIPT, "js/image_view.js"),
    asset!("/js/lanes.js", SCRIPT, "js/lanes.js"),
    asset!("/js/main.js", SCRIPT, "js/main.js"),
    asset!("/js/mesh.js", SCRIPT, "js/mesh.js"),
    asset!("/js/message.js", SCRIPT, "js/message.js"),
    asset!("/js/parameters.js", SCRIPT, "js/parameters.js"),
    asset!("/js/permalink.js", SCRIPT, "js/permalink.js"),
    asset!("/js/plan.js", SCRIPT, "js/plan.js"),
    asset!("/js/plan_pointer.js", SCRIPT, "js/plan_pointer.js"),
    asset!("/js/plan_view.js", SCRIPT, "js/plan_view.js"),
    asset!("/js/plot_tools.js", SCRIPT, "js/plot_tools.js"),
    asset!("/js/plots.js", SCRIPT, "js/plots.js"),
    asset!("/js/renderer_canvas.js", SCRIPT, "js/renderer_canvas.js"),
    asset!("/js/renderer_webgl.js", SCRIPT, "js/renderer_webgl.js"),
    asset!("/js/run_controls.js", SCRIPT, "js/run_controls.js"),
    asset!("/js/socket.js", SCRIPT, "js/socket.js"),
    asset!("/js/space_actors.js", SCRIPT, "js/space_actors.js"),
    asset!("/js/store.js", SCRIPT, "js/store.js"),
    asset!("/js/tabs.js", SCRIPT, "js/tabs.js"),
    asset!("/js/teach_panel.js", SCRIPT, "js/teach_panel.js"),
    asset!("/js/team_actors.js", SCRIPT, "js/team_actors.js"),
    asset!("/js/team_panel.js", SCRIPT, "js/team_panel.js"),
    asset!("/js/theme.js", SCRIPT, "js/theme.js"),
    asset!("/js/time.js", SCRIPT, "js/time.js"),
    asset!("/js/timeline.js", SCRIPT, "js/timeline.js"),
    asset!("/js/veil.js", SCRIPT, "js/veil.js"),
    asset!("/js/view3d.js", SCRIPT, "js/view3d.js"),
    asset!("/js/world_mesh.js", SCRIPT, "js/world_mesh.js"),
    asset!("/js/world_panel.js", SCRIPT, "js/world_panel.js"),
];

/// The file of a path; there are no others.
pub(super) fn find(path: &str) -> Option<&'static Asset> {
    ASSETS.iter().chain(BY_HAND).find(|asset| asset.path == path)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn every_file_of_the_page_is_served_and_nothing_else() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("page");
        let mut folders = vec![folder.clone()];
        let mut num_files = 0;
        while let Some(next) = folders.pop() {
            for entry in std::fs::read_dir(next).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                num_files += 1;
                let name = format!("/{}", path.strip_prefix(&folder).unwrap().display());
                let name = if name == "/index.html" { "/".to_owned() } else { name };
                assert!(find(&name).is_some(), "{name} is not served");
            }
        }
        assert_eq!(num_files, ASSETS.len());
        for path in ["/../Cargo.toml", "/page/index.html", "//", "/etc/passwd", "/%2e%2e/Cargo.toml", ""] {
            assert!(find(path).is_none(), "{path}");
        }
    }
}
