//! URDF: reading one as a robot description, writing a description as one.
//!
//! A URDF joint becomes a frame of the joint's name, whose z axis lies along the joint's axis. Its origin and x axis are
//! placed on that axis as Khalil and Kleinfinger do, at the common normal with the next joint, so that most tables come
//! out with gamma = b = 0. Only `fixed` joints keep the URDF's own link frame. What hangs on a link (the next joints,
//! the centre of mass, the tool) is carried over from the link frame to this frame. A URDF that `export` has written says
//! so, and its link frames are taken as they are: every frame comes back where it was.
//!
//! In: `outline` guards against what is no URDF at all, `locate` finds faults in the elements, `tree` in how they hang
//! together, `import` makes the description. Out: `export`, with `follow` for joints that follow others and `xml`.

mod export;
mod follow;
mod import;
pub mod khalil_kleinfinger;
mod locate;
mod outline;
mod source;
mod tree;
mod xml;

pub use export::export;
pub use import::import;
