//! Scripts that stand in for other programs.

use std::{path::Path, process::Command};

/// Makes a script that other programs may start.
///
/// Another process writes the file: one that this process writes is also open in whatever another test starts meanwhile, until that
/// has become the other program, and a file that is open for writing cannot be started (`ETXTBSY`).
pub fn write_program(path: &Path, script: &str) {
    let written = Command::new("/bin/sh")
        .args(["-c", "printf %s \"$2\" >\"$1\" && chmod 755 \"$1\"", "sh"])
        .arg(path)
        .arg(script)
        .status();
    assert!(written.unwrap().success(), "{}", path.display());
}
