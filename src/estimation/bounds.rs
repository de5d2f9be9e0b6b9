//! Between which values a fit may move a parameter.

use std::f64::consts::PI;

use crate::description::raw::LoopKind;
use crate::description::robot::NEAR_PARALLEL;
use crate::least_squares::Bounds;
use crate::model::{Model, Stage, TILTS};
use crate::parameter::Slot;

/// A spring that is so many times stiffer or softer than described is rigid or free to any instrument; beyond, a description
/// could not hold it. Four decades lie between plastic gears and steel blocks, for a description that is far off, and five
/// below that the deflection is less than an instrument of a robot's calibration resolves.
const MOST: f64 = 1e9;

/// Part of the tilt at which axes no longer count as parallel that a fit may give them: what it ends at is to be read back.
const READ_BACK: f64 = 0.99;

/// Least and greatest value that a fit may give a parameter: its bounds, of a spring that is described none that comes
/// to rigid or free, and of a tilt in a planar loop none with which the loop is not planar.
pub fn bounds(model: &Model, slot: Slot) -> [f64; 2] {
    let parameter = &model.registry[slot];
    let [low, high] = parameter.bounds;
    if tilts_in_planar_loop(model, slot) {
        let parallel = (parameter.nominal / PI).round() * PI;
        let most = READ_BACK * NEAR_PARALLEL;
        return [low.max(parallel - most), high.min(parallel + most)];
    }
    if !(parameter.kind.is_spring() && parameter.inverted && parameter.nominal > 0.0 && parameter.nominal.is_finite()) {
        return [low, high];
    }
    [low.max(parameter.nominal / MOST), high.min(parameter.nominal * MOST)]
}

/// Whether a parameter tilts an axis of a planar loop against the one before it.
fn tilts_in_planar_loop(model: &Model, slot: Slot) -> bool {
    let loops =
        model.stages.iter().filter_map(|stage| if let Stage::Loops(group) = stage { Some(group) } else { None });
    let planar = loops.flat_map(|group| &group.loops).filter(|closed| closed.kind == LoopKind::Planar);
    let mut behind_first = planar.flat_map(|closed| &closed.branches).flat_map(|branch| branch.iter().skip(1));
    behind_first.any(|&frame| TILTS.iter().any(|&at| model.frames[frame].slots[at] == slot))
}

/// Bounds of the changes of `slots` from `start`.
pub fn bounds_of(model: &Model, slots: &[Slot], start: &[f64]) -> Bounds {
    let side = |k: usize| slots.iter().map(|&slot| bounds(model, slot)[k] - start[slot]).collect();
    Bounds { lower: side(0), upper: side(1) }
}
