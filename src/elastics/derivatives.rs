//! Derivatives of the deflection by elastic parameters, by the adjoint: internal forces of unit loads at the output
//! against those of the load.

use nalgebra::{Vector3, Vector6};

use super::compiled::Elastics;
use super::load_case::{ByLoad, LoadCase};
use crate::elements::{Configuration, Direction, PerLength, Rate, spatial};
use crate::kinematics::Placements;
use crate::parameter::Slot;

/// Plan of the derivatives of deflections by elastic parameters; made once, evaluated for every reading.
#[derive(Debug, Clone)]
pub struct ElasticColumns {
    members: Vec<MemberColumns>,
    /// Masses: column, index, and which of mass, x, y, z.
    masses: Vec<(usize, usize, usize)>,
    /// Number of columns.
    pub columns: usize,
}

/// Parameters of one member, each with its column.
#[derive(Debug, Clone)]
struct MemberColumns {
    member: usize,
    parts: Vec<(usize, Part)>,
}

/// Where a parameter enters a member.
#[derive(Debug, Clone, Copy)]
enum Part {
    /// As the element says, by [`crate::elements::ParameterUse::part`].
    Element(usize),
    /// A straight uniform element: derivative per length.
    PerLength(PerLength),
    /// Stiffness of a released direction.
    Released(usize),
}

impl ElasticColumns {
    /// Columns by `slots`; what does not deform or load gets zeros. The elastics must have been made for these slots.
    pub fn new(elastics: &Elastics, slots: &[Slot]) -> Self {
        let column = |slot: Slot| slots.iter().position(|s| *s == slot);
        let members = elastics.members.iter().enumerate().map(|(member, of)| {
            let element = &of.edge.element;
            let own = element.parameters().into_iter().filter_map(|of| {
                let column = column(of.slot)?;
                let per_length = element.per_length_by(of.slot, &elastics.values);
                Some((column, per_length.map_or(Part::Element(of.part), Part::PerLength)))
            });
            let released = element.directions().into_iter().enumerate().filter_map(|(k, direction)| match direction {
                Direction::Released(Some(slot)) => Some((column(slot)?, Part::Released(k))),
                _ => None,
            });
            MemberColumns { member, parts: own.chain(released).collect() }
        });
        let members = members.filter(|of| !of.parts.is_empty()).collect();
        let masses = elastics.model.structure.masses.iter().enumerate();
        let masses = masses.flat_map(|(mass, of)| (0..4).map(move |which| (mass, which, of.slot + which)));
        let masses = masses.filter_map(|(mass, which, slot)| Some((column(slot)?, mass, which))).collect();
        Self { members, masses, columns: slots.len() }
    }

    /// Derivatives of the spatial twist of the loaded vertex by each slot's SI value.
    pub fn evaluate(&self, case: &LoadCase, placements: &Placements, out: &mut [Vector6<f64>]) {
        out.fill(Vector6::zeros());
        let at = case.elastics.configuration(placements, &case.statics.points, &case.statics.local, None);
        for member in &self.members {
            member.evaluate(case, &at, out);
        }
        if case.load.weight {
            for &(column, mass, which) in &self.masses {
                out[column] += by_mass(case, placements, mass, which);
            }
        }
    }
}

impl MemberColumns {
    /// Adds the derivatives by the member's parameters; what they share is computed once.
    fn evaluate(&self, case: &LoadCase, at: &Configuration, out: &mut [Vector6<f64>]) {
        let (mut forces, mut deformation, mut by_own_mass) = (None, None, None);
        for &(column, part) in &self.parts {
            out[column] += match part {
                Part::PerLength(rate) => {
                    let forces = forces.get_or_insert_with(|| case.forces(self.member));
                    let mut found = self.by_per_length(case, forces, &rate);
                    if case.load.weight && rate.mass != 0.0 {
                        found += *by_own_mass.get_or_insert_with(|| self.by_own_mass(case, forces)) * rate.mass;
                    }
                    found
                }
                Part::Released(direction) => {
                    let of = deformation.get_or_insert_with(|| case.deformation(self.member));
                    of.by_unit.row(direction).transpose() * -of.total[direction]
                }
                Part::Element(part) => match case.elastics.members[self.member].edge.element.by_parameter(part, at) {
                    Rate::Flexibility(rate) => {
                        let forces = forces.get_or_insert_with(|| case.forces(self.member));
                        rate.work(&forces.by_unit, &forces.total)
                    }
                    Rate::Held(rate) => {
                        let of = deformation.get_or_insert_with(|| case.deformation(self.member));
                        let preload = if case.load.weight { rate.preload } else { Vector6::zeros() };
                        of.by_unit.tr_mul(&(preload - rate.stiffness * of.total))
                    }
                },
            };
        }
    }

    fn by_per_length(&self, case: &LoadCase, forces: &ByLoad, rate: &PerLength) -> Vector6<f64> {
        let placed = &case.statics.placed[self.member];
        let mut strain = rate.flexibility(placed.length).apply(&forces.total);
        let own = case.elastics.members[self.member].per_length.map_or(0.0, |of| of.mass);
        if case.load.weight && own != 0.0 {
            let q = placed.local.fixed_view::<3, 3>(0, 0) * case.elastics.model.structure.gravity * own;
            strain += rate.under_load(placed.length, &q);
        }
        forces.by_unit.tr_mul(&strain)
    }

    /// What a kilogram per metre more does: it bends the element, and hangs on its first vertex.
    fn by_own_mass(&self, case: &LoadCase, forces: &ByLoad) -> Vector6<f64> {
        let (placed, member) = (&case.statics.placed[self.member], &case.elastics.members[self.member]);
        let gravity = &case.elastics.model.structure.gravity;
        let [a, b] = member.edge.ends.map(|end| case.statics.points[end]);
        let load = spatial(&(0.5 * (a + b)), &(gravity * placed.length), &Vector3::zeros());
        let bent = member.per_length.unwrap_or_default();
        let q = placed.local.fixed_view::<3, 3>(0, 0) * gravity;
        forces.by_unit.tr_mul(&bent.under_load(placed.length, &q)) + case.virtual_work(member.edge.ends[0], &load)
    }
}

/// By a mass (`which` 0) or a coordinate of its centre.
fn by_mass(case: &LoadCase, placements: &Placements, index: usize, which: usize) -> Vector6<f64> {
    let structure = &case.elastics.model.structure;
    let of = &structure.masses[index];
    let (mass, centre) = case.elastics.mass(of);
    let frame = &placements.frames[of.frame];
    let load = if which == 0 {
        spatial(&(frame * nalgebra::Point3::from(centre)).coords, &structure.gravity, &Vector3::zeros())
    } else {
        let axis = frame.rotation.matrix().column(which - 1).into_owned();
        spatial(&Vector3::zeros(), &Vector3::zeros(), &axis.cross(&(structure.gravity * mass)))
    };
    case.virtual_work(of.vertex, &load)
}
