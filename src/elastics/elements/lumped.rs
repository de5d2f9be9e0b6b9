//! Springs concentrated at a point: joints ka, kr, kar, krr in the joint's frame, the pedestal, supports, pins.

use super::{Flexibility, screw};
use crate::model::{Law, Lumped, Model};

/// Compliance of one direction; what is released has none.
pub fn compliance(model: &Model, values: &[f64], law: Law, joints: &[f64]) -> f64 {
    match law {
        Law::Rigid | Law::Released(_) => 0.0,
        Law::Compliance(slot) => values[slot],
        Law::Driven { own, axial, actuator } => {
            let stiff = values[axial] == 0.0;
            values[own]
                + if stiff { 0.0 } else { values[axial] / screw::lever(model, values, actuator, joints).powi(2) }
        }
    }
}

/// Flexibility of all six directions.
pub fn flexibility(model: &Model, values: &[f64], lumped: &Lumped, joints: &[f64]) -> Flexibility {
    let all = lumped.laws.map(|law| compliance(model, values, law, joints));
    if all.iter().all(|c| *c == 0.0) { Flexibility::Rigid } else { Flexibility::Diagonal(all) }
}
