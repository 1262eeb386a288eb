//! What people read, on standard output. If nobody reads it any more (`visloc ... | head`) or its disk is full, the run goes on to write its files.

use std::{
    borrow::Cow,
    fmt::Arguments,
    io::{self, ErrorKind, Write},
    sync::{
        OnceLock,
        atomic::{AtomicBool, Ordering},
    },
};

/// The first text that could not be printed.
static FAULT: OnceLock<io::Error> = OnceLock::new();

/// Whether standard output belongs to a result.
static IS_ASIDE: AtomicBool = AtomicBool::new(false);

/// Says everything on standard error from now on: what a program reads from standard output is a result then, and nothing else.
pub fn aside() {
    IS_ASIDE.store(true, Ordering::Relaxed);
}

/// Prints text without an end of line.
pub fn text(text: Arguments<'_>) {
    if IS_ASIDE.load(Ordering::Relaxed) {
        let _ = io::stderr().write_fmt(text);
        return;
    }
    let mut output = io::stdout().lock();
    if let Err(error) = output.write_fmt(text).and_then(|()| output.flush())
        && error.kind() != ErrorKind::BrokenPipe
    {
        let _ = FAULT.set(error);
    }
}

/// Why something could not be printed. That nobody reads any more is no fault.
pub fn fault() -> Option<anyhow::Error> {
    FAULT.get().map(|error| anyhow::anyhow!("standard output: {error}"))
}

/// A number of things, of which the word is given for one.
pub fn count(num: usize, what: &str) -> String {
    let plural = if num == 1 { "" } else { "s" };
    format!("{num} {what}{plural}")
}

/// A name as it is typed in a shell: between quotes where it has letters that mean something else there.
pub fn typed(name: &str) -> Cow<'_, str> {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./:+,@%=".contains(c);
    if !name.is_empty() && name.chars().all(is_plain) {
        return name.into();
    }
    format!("'{}'", name.replace('\'', r"'\''")).into()
}

/// Behind an error: what was `done`, `written` or `used` before it; nothing if nothing was.
pub fn before(num: usize, what: &str, done: &str) -> String {
    match num {
        0 => String::new(),
        1 => format!(" (the {what} before is {done})"),
        _ => format!(" (the {num} {what}s before are {done})"),
    }
}

/// The message with its causes. A cause that the message before already quotes is not said twice, nor is a place that the cause names too.
pub fn one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if !line.is_empty() && cause.starts_with(&format!("{line}: ")) {
            line = cause;
        } else if !line.contains(&cause) {
            let separator = if line.is_empty() { "" } else { ": " };
            line = line + separator + &cause;
        }
    }
    let line = visloc_core::settings::plain_words(&without_numbers_of_errors(&line.replace('\n', " ")));
    short(&with_short_numbers(&line)).into_owned()
}

/// The text without ` (os error 13)` behind what the system says in words.
pub fn without_numbers_of_errors(text: &str) -> String {
    let mut parts = text.split(" (os error ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |out, part| out + part.split_once(')').map_or("", |(_, behind)| behind))
}

/// The text with numbers of hundreds of digits in their short form: 1e300.
fn with_short_numbers(text: &str) -> String {
    const MAX_DIGITS: usize = 25;
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let mut out = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let kind = is_part(first);
        let end = rest.find(|c: char| is_part(c) != kind).unwrap_or(rest.len());
        let (word, behind) = rest.split_at(end);
        rest = behind;
        match word.parse::<f64>() {
            Ok(number) if word.len() > MAX_DIGITS => out += &format!("{number:e}"),
            _ => out += word,
        }
    }
    out
}

/// A message that may quote what a file holds, short enough to be read: its beginning says where, its end what to do.
pub fn short(message: &str) -> Cow<'_, str> {
    const START: usize = 500;
    const END: usize = 300;
    let num_letters = message.chars().count();
    if num_letters <= START + END {
        return Cow::Borrowed(message);
    }
    let start: String = message.chars().take(START).collect();
    let end: String = message.chars().skip(num_letters - END).collect();
    Cow::Owned(format!("{start} ... {end}"))
}

/// Prints a line, as `println!` but without a panic at a closed pipe.
macro_rules! line {
    () => { $crate::say::text(format_args!("\n")) };
    ($($arg:tt)*) => { $crate::say::text(format_args!("{}\n", format_args!($($arg)*))) };
}

/// Prints a line that begins with `note:`, for what the user should know although the run goes on.
macro_rules! note {
    ($($arg:tt)*) => { $crate::say::line!("note: {}", $crate::say::short(&format!($($arg)*))) };
}

pub(crate) use line;
pub(crate) use note;

#[cfg(test)]
mod tests {
    use anyhow::anyhow;

    use super::{one_line, short, typed};

    #[test]
    fn names_are_printed_as_a_shell_takes_them() {
        assert_eq!(typed("out/tür+sun.mcap"), "out/tür+sun.mcap");
        assert_eq!(typed("my run/a.mcap"), "'my run/a.mcap'");
        assert_eq!(typed("it's"), r"'it'\''s'");
    }

    #[test]
    fn a_quoted_cause_is_said_once() {
        let error = anyhow!("no such file").context("x.mcap: no such file").context("cannot start");
        assert_eq!(one_line(&error), "cannot start: x.mcap: no such file");
        let error = anyhow!("photos: expected a file").context("photos");
        assert_eq!(one_line(&error), "photos: expected a file");
    }

    #[test]
    fn numbers_are_short() {
        let error = anyhow!("a.toml: expected 0 to 1000, found {}; and 0.25 at 1700000000.033333333", 1e300);
        assert_eq!(
            one_line(&error),
            "a.toml: expected 0 to 1000, found 1e300; and 0.25 at 1700000000.033333333"
        );
    }

    #[test]
    fn what_the_system_says_has_no_number() {
        let error = anyhow!("Permission denied (os error 13)").context("a.toml: cannot read it");
        assert_eq!(one_line(&error), "a.toml: cannot read it: Permission denied");
        let error = anyhow!("a: no space (os error 28); b: none (os error 2); c");
        assert_eq!(one_line(&error), "a: no space; b: none; c");
    }

    #[test]
    fn a_long_quotation_is_cut_in_the_middle() {
        let error = anyhow!("a.toml: found '{}'; leave it out", "[".repeat(100_000));
        let line = one_line(&error);
        assert!(line.starts_with("a.toml: found '[[[") && line.ends_with("[[['; leave it out"), "{line}");
        assert!(line.len() < 1000);
        assert_eq!(short("\u{e9}".repeat(800).as_str()).chars().count(), 800);
    }
}
