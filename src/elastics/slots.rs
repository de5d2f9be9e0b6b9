//! Parameters of elements, and what beams make of theirs.

use super::elements::beam;
use super::section::properties;
use crate::model::{Element, Law, Model, Rigidity};
use crate::parameter::Slot;

/// Inverse rigidities and mass per length of a beam's section, for numbers of any kind.
pub(super) fn section_state<D: num_dual::DualNum<Primitive = f64> + Copy>(
    model: &Model,
    rigidity: &Rigidity,
    value: &dyn Fn(Slot) -> D,
) -> ([D; 6], D) {
    let zero = D::from(0.0);
    match rigidity {
        Rigidity::Inverse([y, z, t]) => ([zero, zero, zero, value(*y), value(*z), value(*t)], zero),
        Rigidity::Section { sections: [a, b], share, material, shear } => {
            let (first, last) = (&model.structure.sections[*a], &model.structure.sections[*b]);
            let middle = 0.5 * (share[0] + share[1]);
            let symbol = |symbol: &str| {
                let of = |slots: &[(&'static str, Slot)]| {
                    slots.iter().find(|(known, _)| *known == symbol).map(|&(_, slot)| value(slot))
                };
                let own = of(&first.slots)?;
                Some(if a == b { own } else { own * (1.0 - middle) + of(&last.slots).unwrap_or(own) * middle })
            };
            let section = properties(first.shape, symbol);
            let material = &model.structure.materials[*material];
            let young = value(material.young);
            let modulus = value(material.shear);
            let g = if material.is_poisson { young / ((modulus + 1.0) * 2.0) } else { modulus };
            (beam::inverse(&section, young, g, *shear), value(material.density) * section.area)
        }
    }
}

/// Whether an element has a parameter among those asked for.
pub(super) fn asked(element: &Element, model: &Model, by: &[Slot]) -> bool {
    slots_of(element, model).iter().any(|slot| by.contains(slot))
}

/// Slots of an element.
fn slots_of(element: &Element, model: &Model) -> Vec<Slot> {
    match element {
        Element::Lumped(lumped) => lumped
            .laws
            .iter()
            .flat_map(|law| match *law {
                Law::Rigid | Law::Released(None) => vec![],
                Law::Compliance(slot) | Law::Released(Some(slot)) => vec![slot],
                Law::Driven { own, axial, .. } => vec![own, axial],
            })
            .collect(),
        Element::Screw(screw) => vec![screw.own, screw.axial],
        Element::Beam(beam) => beam_slots(&beam.rigidity, model),
    }
}

/// Slots of a beam's sections and material; some may come twice.
pub(super) fn beam_slots(rigidity: &Rigidity, model: &Model) -> Vec<Slot> {
    match rigidity {
        Rigidity::Inverse(slots) => slots.to_vec(),
        Rigidity::Section { sections, material, .. } => {
            let material = &model.structure.materials[*material];
            let mut slots = vec![material.young, material.shear, material.density];
            for &section in sections {
                slots.extend(model.structure.sections[section].slots.iter().map(|(_, slot)| *slot));
            }
            slots
        }
    }
}
