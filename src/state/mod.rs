//! The state of one configuration: where frames are, how they move, and how the structure deflects there.
//!
//! As in Pinocchio (`Model` and `Data`), what does not depend on the configuration is [`Mechanics`]: immutable, shared between
//! threads; what does is a [`State`], one for each thread, which a caller passes to the mechanics and reads. SI, base axes.
//!
//! ```
//! use elastogeo::state::{Loads, Mechanics};
//!
//! let robot = elastogeo::files::load_robot("kuka-ir663").unwrap();
//! let values = robot.model.registry.nominal();
//! let mechanics = Mechanics::new(&robot.model, &values, Loads { weight: true, wrench: true }, &[]).unwrap();
//! let mut state = mechanics.state();
//! mechanics.place(&[0.0, 0.85, 0.77, 0.0, 0.0, 0.0], &mut state).unwrap();
//! // 500 N downwards at the tool centre point, own weight included.
//! let point = mechanics.point(&state, None, &[0.0, 0.0, -500.0, 0.0, 0.0, 0.0]);
//! let sag = mechanics.deflection(&state, &point).displacement.z;
//! assert!(sag < 0.0);
//! ```

mod carried_loads;
mod frame_twists;
mod joint_loads;
mod mechanics;

pub use carried_loads::{CarriedLoadPlan, CarriedLoads};
pub use frame_twists::{FrameTwistPlan, FrameTwists};
pub(crate) use joint_loads::masses;
pub use joint_loads::{JointLoadPlan, JointLoads};
pub use mechanics::{ColumnMotion, LoadedPoint, Loads, Mechanics, PointOf, State, StateError};
