//! What a report shows in addition to what single commands find: residuals stage by stage, the pattern of the suspected
//! effects in them, stiffness over a slice of the workspace, shares of the strain energy, and the robot as it is drawn.

mod campaign;
mod readings;
mod repeats;
mod slice;
mod strain_energy;

pub use campaign::{Review, review, shot};
pub use readings::{Readings, Stage, StageKey, readings};
pub use repeats::{Direction, Figures, Repeated, repeated};
pub use slice::{Node, Slice, slice};
pub use strain_energy::{StrainEnergy, compliance, strain_energy, typical};
