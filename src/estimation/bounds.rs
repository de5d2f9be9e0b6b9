//! Between which values a fit may move a parameter.

use crate::least_squares::Bounds;
use crate::model::Model;
use crate::parameter::{Kind, Slot};

/// A spring that is so many times stiffer or softer than described is rigid or free to any instrument; beyond, a description
/// could not hold it. Four decades lie between plastic gears and steel blocks, for a description that is far off, and five
/// below that the deflection is less than an instrument of a robot's calibration resolves.
const MOST: f64 = 1e9;

/// Least and greatest value that a fit may give a parameter: its bounds, and of a spring that is described none that comes
/// to rigid or free.
pub fn bounds(model: &Model, slot: Slot) -> [f64; 2] {
    let parameter = &model.registry[slot];
    let [low, high] = parameter.bounds;
    let is_spring = matches!(
        parameter.kind,
        Kind::LinearCompliance | Kind::RotationalCompliance | Kind::LinearStiffness | Kind::RotationalStiffness
    );
    if !(is_spring && parameter.inverted && parameter.nominal > 0.0 && parameter.nominal.is_finite()) {
        return [low, high];
    }
    [low.max(parameter.nominal / MOST), high.min(parameter.nominal * MOST)]
}

/// Bounds of the changes of `slots` from `start`.
pub fn bounds_of(model: &Model, slots: &[Slot], start: &[f64]) -> Bounds {
    let side = |k: usize| slots.iter().map(|&slot| bounds(model, slot)[k] - start[slot]).collect();
    Bounds { lower: side(0), upper: side(1) }
}
