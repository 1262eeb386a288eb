//! Words that stand for values of a library.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Parser of one of some words; each comes with its value and with what the help says of it.
pub(super) fn named<T: Copy + Send + Sync + 'static>(
    words: &'static [(&'static str, T, &'static str)],
) -> impl TypedValueParser<Value = T> {
    let possible = words.iter().map(|(word, _, help)| PossibleValue::new(*word).help(*help));
    PossibleValuesParser::new(possible).try_map(move |typed| {
        let known = words.iter().find(|(word, ..)| *word == typed);
        known.map(|(_, value, _)| *value).ok_or("expected one of the words")
    })
}
