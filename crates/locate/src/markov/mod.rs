//! Markov localization on a grid of tiles and headings.
//!
//! A [`Belief`] over all states of a [`Grid`] is moved by [`Action`]s with measured outcomes and weighed by what is seen.
//! [`MarkovFilter`] is that loop with a remedy against many observations without a landmark; [`CaseTables`] are the
//! published observation tables, learned from captures, and [`ViewDensities`] the same captures without cases; [`Markov`] is the localizer for a robot that walks freely and
//! turns its head: [`OdometryCutter`] cuts its odometry into actions, and each state expects a view of the landmarks.
//!
//! Source: "Localización basada en métodos de Markov" for the goalkeeper of the Standard Platform League: grid, tables of
//! actions and observations, start and decision. Deviations are named where they are made.

mod actions;
mod belief;
mod cases;
mod config;
mod densities;
mod expected;
mod filter;
mod grid;
mod localizer;
mod odometry;
mod projection;
mod start;
mod table_text;

pub use actions::{Action, Outcomes};
pub use belief::Belief;
pub use cases::{BlobView, CaseLimits, CaseTables, NUM_CASES, TableError, learn_tables};
pub use config::{ExpectedViewConfig, KnownStart, MarkovConfig, Remedy};
pub use densities::{ViewDensities, ViewLikelihoods, learn_densities};
pub use filter::MarkovFilter;
pub use grid::{Direction, Grid, State};
pub use localizer::Markov;
pub use odometry::OdometryCutter;

#[cfg(test)]
mod tests;
