//! `visloc benchmark`: everything that is claimed, measured on recordings with a truth, beside the figures of others.
//!
//! `find` looks for recordings below folders. `plan` makes one run of each recording, setting and seed; `accuracy` does the runs in
//! parallel, `times` does some of them again, one program at a time. What a run finds is a file of its own (`store`), so that an
//! interrupted benchmark goes on and a later one can be compared with it. `table` makes rows of the runs, `compare` looks what
//! has changed since an earlier benchmark, and `report` writes all of it.

mod accuracy;
mod claims;
mod compare;
mod find;
mod pictures;
mod plan;
mod quantities;
mod report;
mod store;
mod table;
mod times;

pub use accuracy::measure_accuracy;
pub use claims::{Claims, Kind};
pub use compare::compare;
pub use find::{Recording, find, sequence_in};
pub use plan::{Limits, Plan};
pub use report::{Account, report_again, save};
pub use store::{Store, program};
pub use table::{Row, for_screens};
pub use times::measure_times;
