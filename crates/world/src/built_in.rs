//! The texts of the maps that are part of the program.

/// Maps that are part of the program: name and text.
pub const BUILT_IN_MAPS: [(&str, &str); 7] = [
    ("robocup-spl-2010", include_str!("../../../maps/robocup-spl-2010.toml")),
    ("robocup-spl-2024", include_str!("../../../maps/robocup-spl-2024.toml")),
    ("robocup-humanoid-kid", include_str!("../../../maps/robocup-humanoid-kid.toml")),
    ("robocup-humanoid-adult", include_str!("../../../maps/robocup-humanoid-adult.toml")),
    ("office", include_str!("../../../maps/office.toml")),
    ("office-large", include_str!("../../../maps/office-large.toml")),
    ("office-repeated", include_str!("../../../maps/office-repeated.toml")),
];
