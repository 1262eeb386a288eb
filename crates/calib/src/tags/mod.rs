//! AprilTags of the family tag36h11 on a grid: outlines of dark squares between saddle points, and their codes.
//!
//! Sources: Olson, "AprilTag: a robust and flexible visual fiducial system", ICRA 2011; Wang and Olson, "AprilTag 2: efficient
//! and robust fiducial detection", IROS 2016 (codes). Deviation: on a grid each corner of a tag touches a black square, so it is
//! a saddle point of the brightness. Outlines are looked for between saddle points instead of in a binary image: nothing has
//! to be torn apart where dark squares touch, and the light may be as uneven as it likes.

mod decode;
mod quads;

pub use decode::read_tag;
pub use quads::find_quads;
