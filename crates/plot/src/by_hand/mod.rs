//! The page on which map and image are laid over each other by hand: a file of its own, or a part of a page that is served.

macro_rules! head {
    () => {
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>visloc: camera by hand</title>\n"
    };
}

/// The page as it is served, with style and script beside it; what it shows it asks of the page that has opened it.
pub const BY_HAND_PAGE: &str = concat!(
    head!(),
    "<link rel=\"stylesheet\" href=\"/by-hand.css\">\n",
    include_str!("body.html"),
    "<script src=\"/by-hand.js\"></script>\n</html>\n"
);
/// Its style, `/by-hand.css`.
pub const BY_HAND_STYLE: &str = include_str!("by_hand.css");
/// Its script, `/by-hand.js`.
pub const BY_HAND_SCRIPT: &str = include_str!("by_hand.js");

/// The page as one file that needs nothing else. `input` is JSON: `name`, `image` (an address, or the image as `data:`), `camera` as in a
/// camera file, `pose` (x, y, height in meters; heading, pitch down, roll clockwise in degrees) and `lines` of the map, each a list of
/// points of the world, meters.
pub fn by_hand_page(input: &str) -> String {
    // A tag in a name must not end the script.
    let input = input.replace('<', "\\u003c");
    let (head, body) = (head!(), include_str!("body.html"));
    format!(
        "{head}<style>\n{BY_HAND_STYLE}</style>\n{body}<script id=\"input\" type=\"application/json\">{input}</script>\n\
         <script>\n{BY_HAND_SCRIPT}</script>\n</html>\n"
    )
}
