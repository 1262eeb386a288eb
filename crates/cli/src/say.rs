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

/// Prints a line, as `println!` but without a panic at a closed pipe.
macro_rules! line {
    () => { $crate::say::text(format_args!("\n")) };
    ($($arg:tt)*) => { $crate::say::text(format_args!("{}\n", format_args!($($arg)*))) };
}

pub(crate) use line;
