//! Standard output. If nobody reads it any more (`visloc ... | head`), the run goes on to write its files.

use std::{
    fmt::Arguments,
    io::{self, Write},
};

/// Prints text without an end of line.
pub fn text(text: Arguments<'_>) {
    let mut output = io::stdout().lock();
    let _ = output.write_fmt(text).and_then(|()| output.flush());
}

/// The message with its causes. A cause that the message before already quotes is not said twice.
pub fn one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if !line.contains(&cause) {
            let separator = if line.is_empty() { "" } else { ": " };
            line = line + separator + &cause;
        }
    }
    visloc_settings::plain_words(&line.replace('\n', " "))
}

/// Prints a line, as `println!` but without a panic at a closed pipe.
macro_rules! line {
    () => { $crate::say::text(format_args!("\n")) };
    ($($arg:tt)*) => { $crate::say::text(format_args!("{}\n", format_args!($($arg)*))) };
}

pub(crate) use line;

#[cfg(test)]
mod tests {
    use anyhow::anyhow;

    use super::one_line;

    #[test]
    fn a_quoted_cause_is_said_once() {
        let error = anyhow!("no such file").context("x.mcap: no such file").context("cannot start");
        assert_eq!(one_line(&error), "cannot start: x.mcap: no such file");
    }
}
