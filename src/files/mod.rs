//! Robots, campaigns, paths and processes from disk or from the bundled set: the one place that opens files.

mod allowed;
mod calibrated;
mod campaign;
mod change;
mod design;
mod journal;
mod path;
mod place;
mod reader;
mod readings;
mod robot;
mod schema_line;
#[cfg(feature = "cli")]
mod signals;
mod start;
mod tables;
#[cfg(feature = "cli")]
mod write;

pub use allowed::{cannot_stand, not_allowed};
pub use campaign::{LoadedCampaign, load_campaign};
pub use design::Design;
pub use journal::settle;
pub use place::bundled_robots;
pub use reader::Reader;
pub use robot::{LoadedRobot, load_robot};
pub use schema_line::schema_line;
#[cfg(feature = "cli")]
pub use signals::leave_signals;
pub use start::{moved_to, source_urdf};
#[cfg(feature = "cli")]
pub use write::{is_device, named_twice, writable, writable_table, write_whole};
