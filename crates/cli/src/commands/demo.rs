//! `visloc demo`: watch a simulated robot find itself.

use anyhow::Result;

use crate::args::DemoArgs;

pub fn execute(_args: &DemoArgs) -> Result<()> {
    Ok(())
}
