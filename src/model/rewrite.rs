//! A description with other values: calibrated robots go back to the file they came from.

use super::Model;
use crate::description::raw::{JointKind, RawFuzzy, RawFuzzyComponent, RawRobot, RawStiffness};
use crate::parameter::{Group, Slot};

/// The description `raw` with every value that differs from the model's nominal one put in, in the file's units.
/// The zero of a joint goes to `offset`, so that couplings and loops see it when the file is read again.
#[must_use]
pub fn with_values(raw: &RawRobot, model: &Model, values: &[f64]) -> RawRobot {
    let mut raw = raw.clone();
    for (slot, parameter) in model.registry.all().iter().enumerate() {
        let Some(&value) = values.get(slot) else { continue };
        if value == parameter.nominal {
            continue;
        }
        if parameter.group == Group::Effect {
            let found = model.effects.iter().enumerate().find_map(|(k, effect)| {
                let at = effect.slots.iter().position(|known| *known == Some(slot))?;
                Some((k, effect.parameters[at].symbol.clone()))
            });
            if let Some((k, symbol)) = found
                && let Some(raw) = raw.effects.get_mut(k)
            {
                raw.parameters.insert(symbol, value.into());
            }
            continue;
        }
        let Some((owner, symbol)) = parameter.name.rsplit_once('.') else { continue };
        if parameter.group == Group::Elastic {
            let shown = parameter.shown(value) / raw.units.of(parameter.shown_kind());
            put_elastic(&mut raw, owner, symbol, shown, parameter.inverted);
            continue;
        }
        let unit = raw.units.of(parameter.kind);
        put(&mut raw, model, slot, owner, symbol, value, unit);
    }
    raw
}

/// The description with the model's fuzzy compliance put in, in the file's units.
#[must_use]
pub fn with_fuzzy(raw: &RawRobot, model: &Model) -> RawRobot {
    use crate::description::fuzzy::{Component, Input};
    let mut raw = raw.clone();
    let units = &raw.units;
    let size = |angle: bool| if angle { units.angle.factor() } else { units.length.factor() };
    raw.fuzzy = model.fuzzy.as_ref().map(|fuzzy| {
        let named = |input: &Input| match *input {
            Input::Variable(k) => (model.variables[k].name.clone(), size(model.variables[k].is_angle)),
            Input::Joint(k) => (model.frames[k].name.clone(), size(model.frames[k].joint == JointKind::Revolute)),
        };
        let inputs: Vec<(String, f64)> = fuzzy.inputs.iter().map(named).collect();
        let component = |component: &Component| {
            let unit = |k: usize, first: f64, second: f64| if k < 3 { first } else { second };
            let [row, column] = component.at;
            let factor = unit(row, units.length.factor(), units.angle.factor())
                / unit(column, units.force.factor(), units.torque.factor());
            let modes = component.modes.iter().zip(&inputs);
            let raw = RawFuzzyComponent {
                modes: modes.map(|(list, (_, size))| list.iter().map(|mode| mode / size).collect()).collect(),
                conclusions: component.conclusions.iter().map(|value| value / factor).collect(),
            };
            (Component::name(component.at), raw)
        };
        RawFuzzy {
            file: None,
            inputs: inputs.iter().map(|(name, _)| name.clone()).collect(),
            at: fuzzy.at.map(|marker| model.markers[marker].name.clone()),
            adds: fuzzy.adds,
            components: fuzzy.components.iter().map(component).collect(),
        }
    });
    raw
}

/// Puts a value of what gives or loads, in the file's units, where it is declared.
fn put_elastic(raw: &mut RawRobot, owner: &str, symbol: &str, value: f64, inverted: bool) {
    // What is computed as a compliance and declared as a stiffness is inverted; springs and free axes the other way.
    let set = |target: &mut Option<RawStiffness>, as_value: bool| {
        let target = target.get_or_insert_default();
        (target.value, target.compliance) = if as_value { (Some(value), None) } else { (None, Some(value)) };
    };
    if let Some(joint) = owner.strip_prefix("joint")
        && matches!(symbol, "ka" | "kr" | "kar" | "krr")
        && raw.frames.contains_key(joint)
    {
        let springs = raw.joint_stiffness.entry(joint.into()).or_default();
        let passive = raw.frames.get(joint).is_some_and(|frame| frame.passive);
        let target = match symbol {
            "ka" => &mut springs.ka,
            "kr" => &mut springs.kr,
            "kar" => &mut springs.kar,
            _ => &mut springs.krr,
        };
        let soft = passive && matches!(symbol, "ka" | "kar") && target.is_some();
        set(target, inverted != soft);
    } else if owner == "base" {
        let base = raw.base_stiffness.get_or_insert_default();
        let target = match symbol {
            "kx" => &mut base.kx,
            "ky" => &mut base.ky,
            "kz" => &mut base.kz,
            "krx" => &mut base.krx,
            "kry" => &mut base.kry,
            _ => &mut base.krz,
        };
        set(target, inverted);
    } else if let Some(actuator) = raw.actuators.get_mut(owner) {
        set(&mut actuator.axial, inverted);
    } else if let Some(spring) = raw.springs.get_mut(owner) {
        match symbol {
            "stiffness" => set(&mut spring.rate, !inverted),
            "free_length" => (spring.free_length, spring.preload, spring.preload_length) = (Some(value), None, None),
            anchor => {
                let body = usize::from(anchor.ends_with('2'));
                let axis = ["x", "y", "z"].iter().position(|axis| anchor.starts_with(axis)).unwrap_or(0);
                spring.anchors.get_or_insert_default()[body][axis] = value;
            }
        }
    } else if let Some(material) = raw.materials.get_mut(owner) {
        let target = match symbol {
            "young" => &mut material.young,
            "poisson" => &mut material.poisson,
            "shear" => &mut material.shear,
            _ => &mut material.density,
        };
        *target = Some(value);
    } else if let Some(section) = raw.sections.get_mut(owner) {
        let target = match symbol {
            "width" => &mut section.width,
            "height" => &mut section.height,
            "wall" => &mut section.wall,
            "flange" => &mut section.flange,
            "diameter" => &mut section.diameter,
            "area" => &mut section.area,
            "iy" => &mut section.iy,
            "iz" => &mut section.iz,
            "j" => &mut section.j,
            "shear_y" => &mut section.shear_y,
            _ => &mut section.shear_z,
        };
        *target = Some(value);
    } else if let Some(body) = owner.strip_prefix("body").and_then(|frame| raw.bodies.get_mut(frame)) {
        match symbol {
            "mass" => body.mass = Some(value),
            axis => {
                let axis = ["x", "y", "z"].iter().position(|known| *known == axis).unwrap_or(0);
                body.com.get_or_insert_default()[axis] = value;
            }
        }
    }
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
