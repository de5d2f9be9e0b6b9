//! URDF: reading one as a robot description, writing a description as one.
//!
//! A URDF joint becomes a frame of the joint's name, whose z axis lies along the joint's axis. Its origin and x axis are
//! placed on that axis as Khalil and Kleinfinger do, at the common normal with the next joint, so that most tables come
//! out with gamma = b = 0. Only `fixed` joints keep the URDF's own link frame. What hangs on a link (the next joints,
//! the centre of mass, the tool) is carried over from the link frame to this frame. A URDF that `export` has written says
//! so, and its link frames are taken as they are: every frame comes back where it was.
//!
//! In: `source` reads the XML, `elements` what it declares, `tree` how that hangs together, `chain` which part of it is
//! the robot, `import` makes the description (with `motion`). Out: `export` writes a URDF, with `follow` for joints that
//! follow others and `xml`.

mod chain;
mod elements;
mod export;
mod follow;
mod import;
mod into;
mod motion;
mod source;
mod tree;
mod xml;

pub use chain::Request;
pub use export::export;
pub use import::{Imported, import, import_chain};
pub use into::export_into;
#[cfg(feature = "cli")]
pub(crate) use xml::escaped;
