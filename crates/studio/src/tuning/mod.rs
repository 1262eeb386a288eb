//! Algorithms and their parameters, as people change them while a run goes on.
//!
//! `settings` is everything that decides about a run besides its input, `contender` one algorithm, `lineup` all of them: it takes
//! commands from pages. The playground, runs that are published, and recordings that are recomputed use the same code.

mod contender;
mod lineup;
mod overrides;
mod settings;

pub use contender::Contender;
pub use lineup::{Lineup, MAX_ALGORITHMS};
pub use overrides::Overrides;
pub use settings::RunSettings;
pub(crate) use settings::with_defaults;
