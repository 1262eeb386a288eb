//! Messages of parsers in words that need no knowledge of Rust.

/// Names of types as parsers write them after "expected", and what they mean. Longer ones first.
const TYPES: [(&str, &str); 21] = [
    ("usize", "a whole number from 0 on"),
    ("u64", "a whole number from 0 on"),
    ("u32", "a whole number from 0 to 4294967295"),
    ("u16", "a whole number from 0 to 65535"),
    ("u8", "a whole number from 0 to 255"),
    ("i64", "a whole number"),
    ("i32", "a whole number"),
    ("isize", "a whole number"),
    ("f64", "a number"),
    ("f32", "a number"),
    ("bool", "true or false"),
    ("a boolean", "true or false"),
    ("a string", "a text"),
    ("a borrowed string", "a text"),
    ("a sequence", "a list"),
    ("a map", "a table"),
    ("tuple struct", "a list"),
    ("struct variant", "a table"),
    ("internally tagged enum", "a table"),
    ("struct", "a table"),
    ("enum", "one of its names"),
];
/// What parsers call the things that they find.
const FOUND: [(&str, &str); 6] = [
    ("floating point ", ""),
    ("integer ", ""),
    ("boolean ", ""),
    ("string ", ""),
    ("map", "a table"),
    ("sequence", "a list"),
];

/// The message of a parser with "invalid type: integer `3`, expected struct Foo" in plain words: "expected a table, found 3".
/// Other text stays as it is.
pub fn plain_words(message: &str) -> String {
    let mut text = message.to_owned();
    for start in ["invalid type: ", "invalid value: "] {
        while let Some(replaced) = replaced(&text, start) {
            text = replaced;
        }
    }
    while let Some(replaced) = of_choice(&text) {
        text = replaced;
    }
    // What the parser of YAML says, without a word of what it found.
    for (name, meaning) in TYPES {
        if let Some((before, after)) = text.split_once(&format!("invalid {name}"))
            && !after.starts_with(|c: char| c.is_ascii_alphanumeric())
        {
            text = format!("{before}expected {meaning}{after}");
        }
    }
    text
}

/// "unknown variant `red`, expected `a` or `b`" as "expected a or b, found red".
fn of_choice(text: &str) -> Option<String> {
    let (before, rest) = text.split_once("unknown variant `")?;
    let (found, rest) = rest.split_once("`, expected ")?;
    let end = rest.find([';', '\n']).unwrap_or(rest.len());
    let choices = rest[..end].trim_end().replace('`', "");
    Some(format!("{before}expected {choices}, found {found}{}", &rest[end..]))
}

fn replaced(text: &str, start: &str) -> Option<String> {
    let (before, rest) = text.split_once(start)?;
    let (found, rest) = rest.split_once(", expected ")?;
    let (meaning, after) = TYPES
        .iter()
        .find_map(|(name, meaning)| Some((*meaning, after_name(rest, name)?)))
        .unwrap_or(("", rest));
    let found = FOUND
        .iter()
        .find_map(|(name, meaning)| Some(format!("{meaning}{}", found.strip_prefix(name)?)))
        .unwrap_or_else(|| found.to_owned());
    let found = found.replace('`', "");
    if meaning.is_empty() {
        // The parser's own words are kept: they end at the end of the line or at a bracket or semicolon.
        let end = rest.find([';', '\n']).unwrap_or(rest.len());
        return Some(format!("{before}expected {}, found {found}{}", &rest[..end], &rest[end..]));
    }
    Some(format!("{before}expected {meaning}, found {found}{after}"))
}

/// What follows a type's name, and for a kind of type also the name of the very type.
fn after_name<'t>(text: &'t str, name: &str) -> Option<&'t str> {
    let rest = text.strip_prefix(name)?;
    if rest.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_') {
        return None;
    }
    let is_kind = ["struct", "enum", "variant"].iter().any(|kind| name.ends_with(kind));
    if !is_kind {
        return Some(rest);
    }
    let rest = rest.trim_start();
    Some(&rest[rest.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(rest.len())..])
}

#[cfg(test)]
mod tests {
    use super::plain_words;

    #[test]
    fn types_become_words() {
        for (message, plain) in [
            (
                "line 3: invalid type: string \"many\", expected usize",
                "line 3: expected a whole number from 0 on, found \"many\"",
            ),
            (
                "invalid type: floating point `1.5`, expected u8",
                "expected a whole number from 0 to 255, found 1.5",
            ),
            ("invalid value: integer `-5`, expected usize", "expected a whole number from 0 on, found -5"),
            ("invalid type: integer `3`, expected struct FieldAnalysisConfig", "expected a table, found 3"),
            (
                "a: invalid type: map, expected struct variant Motion::Stand; b",
                "a: expected a table, found a table; b",
            ),
            ("invalid type: sequence, expected f64", "expected a number, found a list"),
            (
                "invalid type: boolean `true`, expected an array of length 3",
                "expected an array of length 3, found true",
            ),
            ("expected a lens, found a cat", "expected a lens, found a cat"),
            ("unknown variant `red`, expected `a` or `b`", "expected a or b, found red"),
            (
                "kind: unknown variant `red`, expected one of `a`, `b`, `c`; d",
                "kind: expected one of a, b, c, found red; d",
            ),
        ] {
            assert_eq!(plain_words(message), plain);
            assert_eq!(plain_words(plain), plain, "said once more");
        }
    }
}
