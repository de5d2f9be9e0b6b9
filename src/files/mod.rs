//! Robots, campaigns, paths and processes from disk or from the bundled set: the one place that opens files.

mod campaign;
mod change;
mod path;
mod place;
mod robot;
mod schema_line;
mod write;

pub use campaign::{LoadedCampaign, load_campaign, load_campaign_with};
pub use path::{load_commands, load_path, load_process};
pub use place::{bundled_robots, table_file, text_of_file, was_read};
pub use robot::{LoadedRobot, load_robot, load_robot_leaving_out, load_robot_text, load_robot_with};
pub use schema_line::schema_line;
pub use write::{writable, write_whole};
