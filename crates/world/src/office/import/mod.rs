//! Plans in other formats.

mod list;

pub use list::read_list;
