//! What a report shows beyond what single commands find: residuals stage by stage, the pattern of the suspected effects in
//! them, and how the robot gives over its workspace.

mod readings;
mod slice;
mod yielding;

pub use readings::{Readings, Stage, readings};
pub use slice::{Node, Slice, slice};
pub use yielding::{Yielding, compliance, typical, yielding};
