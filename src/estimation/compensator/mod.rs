//! Gravity compensator of a heavy robot: where its spring is hung, and what it adds to the joint it unloads (joint 2 of the paper).
//!
//! Source: KR-270 paper (Wu, Klimchik and co-authors), sec. III.C-E. The spring acts between P0 on link 1 and P1 on
//! link 2, which turns about P2, the axis of joint 2. With L = |P1 P2|, a = |P0 P2| its length obeys
//! s^2 = a^2 + L^2 + 2 a L cos(alpha), alpha = phi + q, and it adds (eq. (10), (11))
//!
//! ```text
//! K2 = K0 + Kc a L eta,  eta = (s0 / s) (a L / s^2 sin(alpha)^2 + cos(alpha)) - cos(alpha)
//! ```
//!
//! to the stiffness of the joint. Angles are counted as the joint's own; the plane of motion is read from the measured
//! circle: `along` is the direction from P2 to P1 at q = 0, `across` that at q = 90 deg. The paper's ax is counted
//! against `across`, its ay against `along`, so that phi = -atan2(ax, ay): its -79.81 deg, and no other reading of its
//! drawing, returns its Table IX.

mod deflections;
mod law;
mod mounting;
mod value;

pub use deflections::{AtAngle, FromDeflections, TOGETHER, Way, from_deflections};
pub use law::{Elasticity, JointCompliance, Misfit, Triangle, elasticity, elasticity_within};
pub use mounting::{Circle, Mounting, anchor, circle, mounting};
pub use value::{CompensatorError, Value};
