//! `visloc`: tells a robot with one ordinary camera where it is.

use std::process::ExitCode;

fn main() -> ExitCode {
    visloc_cli::main()
}
