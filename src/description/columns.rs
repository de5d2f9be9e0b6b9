//! Names of the columns that tables of measurements have of themselves: no variable can be called so.

use crate::observation::{CONTACT_COLUMN, FAMILY, Observes};

/// Columns of the applied wrench: force and moment, base axes.
pub const WRENCH: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

/// The column, and the key of an entry, that says where the wrench is applied.
pub const LOAD_POINT: &str = "load_point";

/// What a table says of a reading in addition to joints, wrench and values.
const ABOUT: [&str; 13] = [
    "pose",
    "marker",
    "set",
    "temperature",
    "time",
    "order",
    "session",
    "station",
    CONTACT_COLUMN,
    "payload",
    LOAD_POINT,
    "sigma",
    "U95",
];

/// Owners of parameters that are no element's: the base, the tool and the instrument; no element may have their names.
pub const OWNERS: [&str; 3] = ["base", "tool", "instrument"];
/// What tables of measurements call the tool's own point, which is no marker.
pub const TOOL_POINT: [&str; 3] = ["TCP", "tcp", "tool"];

/// First parts of columns that name a variable, frame or coordinate after a dot.
const PREFIXES: [&str; 6] = ["approach.", "temperature.", "commanded.", "recorded.", "torque.", "sigma."];

/// Whether a table of measurements may have a column of this name that is no joint's, or a parameter of no element has it.
pub fn is_reserved(name: &str) -> bool {
    let is_of = |kind: Observes| {
        kind.columns().iter().map(|column| column.name).chain(kind.target_column()).any(|known| known == name)
    };
    ABOUT.iter().chain(&WRENCH).any(|known| *known == name)
        || FAMILY.into_iter().any(is_of)
        || PREFIXES.iter().any(|prefix| name.starts_with(prefix))
        || name.split_once('.').is_some_and(|(owner, _)| OWNERS.contains(&owner))
}
