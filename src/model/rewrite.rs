//! A description with other values: calibrated robots go back to the file they came from.

use super::Model;
use crate::description::raw::{JointKind, RawRobot};
use crate::parameter::{Kind, Slot};

/// The description `raw` with every value that differs from the model's nominal one put in, in the file's units.
/// The zero of a joint goes to `offset`, so that couplings and loops see it when the file is read again.
#[must_use]
pub fn with_values(raw: &RawRobot, model: &Model, values: &[f64]) -> RawRobot {
    let mut raw = raw.clone();
    let (length, angle) = (raw.units.length.factor(), raw.units.angle.factor());
    for (slot, parameter) in model.registry.all().iter().enumerate() {
        let Some(&value) = values.get(slot) else { continue };
        if value == parameter.nominal {
            continue;
        }
        let unit = if parameter.kind == Kind::Angle { angle } else { length };
        let Some((owner, symbol)) = parameter.name.rsplit_once('.') else { continue };
        put(&mut raw, model, slot, owner, symbol, value, unit);
    }
    raw
}

fn put(raw: &mut RawRobot, model: &Model, slot: Slot, owner: &str, symbol: &str, value: f64, unit: f64) {
    let component = |first: Slot| (slot - first) % 3;
    let rotates = symbol.starts_with('r') && symbol.len() == 2;
    let written = value / unit;
    match owner {
        "base" => {
            let target = if rotates { &mut raw.base.rotation } else { &mut raw.base.at };
            target.get_or_insert_default()[component(model.base)] = written;
        }
        "tool" => {
            raw.tool.frame.get_or_insert_with(|| model.frames[model.tool.0].name.clone());
            let target = if rotates { &mut raw.tool.rotation } else { &mut raw.tool.at };
            target.get_or_insert_default()[component(model.tool.1)] = written;
        }
        _ => {
            if let (Some(marker), Some(raw)) = (model.marker(owner), raw.markers.get_mut(owner)) {
                raw.at.get_or_insert_default()[component(model.markers[marker].slot)] = written;
            } else if let Some(actuator) = raw.actuators.get_mut(owner) {
                let target = match symbol {
                    "stroke" => &mut actuator.stroke,
                    "kappa" => &mut actuator.kappa,
                    "lambda" => &mut actuator.lambda,
                    "l1" => &mut actuator.l1,
                    _ => &mut actuator.l3,
                };
                *target = Some(written);
            } else if let (Some(index), Some(frame)) = (model.frame(owner), raw.frames.get_mut(owner)) {
                let of = &model.frames[index];
                if of.moves() && of.moving_slot() == slot {
                    let joint_unit =
                        if frame.joint == Some(JointKind::Prismatic) { raw.units.length.factor() } else { unit };
                    frame.offset = Some((value - of.home) / joint_unit);
                    return;
                }
                let target = match symbol {
                    "beta" => &mut frame.beta,
                    "gamma" => &mut frame.gamma,
                    "b" => &mut frame.b,
                    "alpha" => &mut frame.alpha,
                    "d" => &mut frame.d,
                    "theta" => &mut frame.theta,
                    _ => &mut frame.r,
                };
                *target = Some(written);
            }
        }
    }
}
