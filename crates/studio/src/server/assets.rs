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

/// Files of a folder of the page by their names.
macro_rules! files {
    ($folder:literal, $ending:literal, $kind:expr, $($name:ident)*) => {
        &[$(Asset {
            path: concat!("/", $folder, stringify!($name), $ending),
            kind: $kind,
            bytes: include_bytes!(concat!("../../page/", $folder, stringify!($name), $ending)),
        }),*]
    };
}

/// The page by hand, which the command line writes as one file.
const BY_HAND: &[Asset] = &[
    shared!("/by-hand.html", HTML, BY_HAND_PAGE),
    shared!("/by-hand.css", CSS, BY_HAND_STYLE),
    shared!("/by-hand.js", SCRIPT, BY_HAND_SCRIPT),
];

const PAGE: Asset = Asset { path: "/", kind: HTML, bytes: include_bytes!("../../page/index.html") };
const ICONS: &[Asset] = files!("", ".svg", SVG, icon);
const STYLES: &[Asset] = files!("", ".css", CSS, style panels screens editor team);
#[rustfmt::skip]
const SCRIPTS: &[Asset] = files!("js/", ".js", SCRIPT,
    actors aim announcer bar by_hand camera3d cards dom drive_panel editor export files freshness
    icons image_view lanes main mesh message parameters permalink plan plan_pointer plan_view
    plot_tools plots renderer_canvas renderer_webgl run_controls socket space_actors store tabs
    teach_panel team_actors team_panel theme time timeline veil view3d world_mesh world_panel
);

/// All files of the folder.
fn all() -> impl Iterator<Item = &'static Asset> {
    [&PAGE].into_iter().chain(ICONS).chain(STYLES).chain(SCRIPTS)
}

/// The file of a path; there are no others.
pub(super) fn find(path: &str) -> Option<&'static Asset> {
    all().chain(BY_HAND).find(|asset| asset.path == path)
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
        assert_eq!(num_files, all().count());
        for path in ["/../Cargo.toml", "/page/index.html", "//", "/etc/passwd", "/%2e%2e/Cargo.toml", ""] {
            assert!(find(path).is_none(), "{path}");
        }
    }
}
