//! Derivatives of the deflection by elastic parameters, by the adjoint: internal forces of unit loads at the output
//! against those of the load.

use nalgebra::{Matrix6, Vector3, Vector6};
use num_dual::Dual64;

use super::elements::beam::{self, Inverse};
use super::elements::screw;
use super::response::Response;
use super::slots::{beam_slots, section_state};
use super::spatial;
use super::statics::{ClosingKind, Elastics, Statics};
use crate::kinematics::Placements;
use crate::model::{Element, Law, Rigidity};
use crate::parameter::Slot;

/// Where a parameter enters.
#[derive(Debug, Clone)]
enum Part {
    /// Compliance of directions of a tree element.
    Tree { vertex: usize, direction: usize, through: Through },
    /// The same of a closure.
    Closing { closing: usize, direction: usize, through: Through },
    /// Stiffness of a released direction of the tree, by index.
    Release(usize),
    /// Stiffness of a released direction of a closure.
    Soft { closing: usize, direction: usize },
    /// A spring's rate, free length or anchor coordinate.
    Spring { closing: usize, which: usize },
    /// A mass, or a coordinate of its centre.
    Mass { mass: usize, which: usize },
}

/// A beam of the tree (by vertex) or a closure, and what its parameters change.
#[derive(Debug, Clone)]
struct BeamPart {
    vertex: Option<usize>,
    closing: usize,
    index: usize,
    /// Column, and how inverse rigidities and mass per length change by its parameter.
    changes: Vec<(usize, Inverse, f64)>,
}

/// By what a compliance grows per unit of the parameter.
#[derive(Debug, Clone, Copy)]
enum Through {
    One,
    /// 1 / lever^2 of an actuator.
    InverseLever(usize),
    /// lever^2 of an actuator.
    Lever(usize),
}

impl Through {
    fn factor(self, elastics: &Elastics, placements: &Placements) -> f64 {
        let lever = |actuator| screw::lever(elastics.model, elastics.values(), actuator, &placements.joints).powi(2);
        match self {
            Self::One => 1.0,
            Self::InverseLever(actuator) => 1.0 / lever(actuator),
            Self::Lever(actuator) => lever(actuator),
        }
    }
}

/// Plan of the derivatives of deflections by elastic parameters; made once, evaluated for every reading.
#[derive(Debug, Clone)]
pub struct ElasticColumns {
    parts: Vec<(usize, Part)>,
    beams: Vec<BeamPart>,
    /// Number of columns.
    pub columns: usize,
}

impl ElasticColumns {
    /// Columns by `slots`; what does not give or load gets zeros. The elastics must have been made for these slots.
    pub fn new(elastics: &Elastics, slots: &[Slot]) -> Self {
        let structure = &elastics.model.structure;
        let (mut parts, mut beams) = (Vec::new(), Vec::new());
        let column = |slot: Slot| slots.iter().position(|s| *s == slot);
        let mut beam = |rigidity: &Rigidity, vertex: Option<usize>, closing: usize, index: usize| {
            let changes = beam_derivatives(elastics, rigidity, slots);
            let changes: Vec<_> =
                changes.into_iter().filter_map(|(slot, inverse, mass)| Some((column(slot)?, inverse, mass))).collect();
            if !changes.is_empty() {
                beams.push(BeamPart { vertex, closing, index, changes });
            }
        };
        let mut add = |slot: Slot, part: Part| {
            if let Some(column) = column(slot) {
                parts.push((column, part));
            }
        };
        for &vertex in &elastics.active {
            match &structure.tree[vertex].element {
                Element::Lumped(lumped) => {
                    for (direction, law) in lumped.laws.iter().enumerate() {
                        let tree = |through| Part::Tree { vertex, direction, through };
                        match *law {
                            Law::Compliance(slot) => add(slot, tree(Through::One)),
                            Law::Driven { own, axial, actuator } => {
                                add(own, tree(Through::One));
                                add(axial, tree(Through::InverseLever(actuator)));
                            }
                            _ => {}
                        }
                    }
                }
                Element::Beam(of) => beam(&of.rigidity, Some(vertex), 0, vertex),
                Element::Screw(_) => {}
            }
        }
        for (closing, of) in elastics.closings.iter().enumerate() {
            match of.kind {
                ClosingKind::Element(which) => match &structure.closures[which].element {
                    Element::Lumped(lumped) => {
                        for (direction, law) in lumped.laws.iter().enumerate() {
                            let through = |through| Part::Closing { closing, direction, through };
                            match *law {
                                Law::Compliance(slot) => add(slot, through(Through::One)),
                                Law::Driven { own, axial, actuator } => {
                                    add(own, through(Through::One));
                                    add(axial, through(Through::InverseLever(actuator)));
                                }
                                Law::Released(Some(slot)) => add(slot, Part::Soft { closing, direction }),
                                _ => {}
                            }
                        }
                    }
                    Element::Screw(of) => {
                        add(of.axial, Part::Closing { closing, direction: 0, through: Through::One });
                        add(of.own, Part::Closing { closing, direction: 0, through: Through::Lever(of.actuator) });
                    }
                    Element::Beam(of) => beam(&of.rigidity, None, closing, structure.tree.len() + which),
                },
                ClosingKind::Spring(spring) => {
                    for (which, &slot) in structure.springs[spring].slots.iter().enumerate() {
                        add(slot, Part::Spring { closing, which });
                    }
                }
            }
        }
        for (index, release) in elastics.releases.iter().enumerate() {
            if let Some(slot) = release.slot {
                add(slot, Part::Release(index));
            }
        }
        for (mass, of) in structure.masses.iter().enumerate() {
            (0..4).for_each(|which| add(of.slot + which, Part::Mass { mass, which }));
        }
        Self { parts, beams, columns: slots.len() }
    }

    /// Derivatives of the spatial twist of the response's vertex under a spatial wrench on it (and own weight, if
    /// asked), by each slot's SI value.
    #[allow(clippy::too_many_arguments)] // the whole state of one reading
    pub fn evaluate(
        &self,
        elastics: &Elastics,
        placements: &Placements,
        statics: &Statics,
        response: &Response,
        wrench: &Vector6<f64>,
        weight: bool,
        out: &mut [Vector6<f64>],
    ) {
        out.fill(Vector6::zeros());
        let weight = weight && statics.weight.active;
        for (column, part) in &self.parts {
            out[*column] += self.part(elastics, placements, statics, response, wrench, weight, part);
        }
        for beam in &self.beams {
            beam.evaluate(elastics, statics, response, wrench, weight, out);
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn part(
        &self,
        elastics: &Elastics,
        placements: &Placements,
        statics: &Statics,
        response: &Response,
        wrench: &Vector6<f64>,
        weight: bool,
        part: &Part,
    ) -> Vector6<f64> {
        let structure = &elastics.model.structure;
        match *part {
            Part::Tree { vertex, direction, through } => {
                let force = response.forces[vertex].row(direction).dot(&wrench.transpose())
                    + if weight { statics.weight.forces[vertex][direction] } else { 0.0 };
                response.forces[vertex].row(direction).transpose() * (through.factor(elastics, placements) * force)
            }
            Part::Closing { closing, direction, through } => {
                let (by_unit, forces) = closing_forces(elastics, statics, response, wrench, weight, closing);
                by_unit.row(direction).transpose() * (through.factor(elastics, placements) * forces[direction])
            }
            Part::Release(index) => {
                let release = &elastics.releases[index];
                let turns = response.strains[release.vertex].row(release.direction).transpose();
                let turn = turns.dot(wrench)
                    + if weight { statics.weight.strains[release.vertex][release.direction] } else { 0.0 };
                turns * -turn
            }
            Part::Soft { closing, direction } => {
                let (gaps, gap) = gaps(elastics, statics, response, wrench, weight, closing);
                gaps.row(direction).transpose() * -gap[direction]
            }
            Part::Spring { closing, which } => {
                let Some(spring) = statics.closings[closing].spring else { return Vector6::zeros() };
                let ClosingKind::Spring(index) = elastics.closings[closing].kind else { return Vector6::zeros() };
                let (gaps, gap) = gaps(elastics, statics, response, wrench, weight, closing);
                let (stiffness, load) = match which {
                    0 | 1 => spring.by_rate_and_length()[which],
                    _ => {
                        let anchor = (which - 2) / 3;
                        let frame = structure.springs[index].spring.bodies[anchor];
                        let axis = placements.frames[frame].rotation.matrix().column((which - 2) % 3).into_owned();
                        let held = structure.springs[index].spring.free_length.is_some();
                        spring.by_anchor(anchor, &axis, held)
                    }
                };
                let mut found = gaps.tr_mul(&(stiffness * gap)) * -1.0;
                if weight {
                    found += gaps.tr_mul(&load);
                }
                found
            }
            Part::Mass { mass, which } => {
                if !weight {
                    return Vector6::zeros();
                }
                let of = &structure.masses[mass];
                let v = &elastics.values[of.slot..of.slot + 4];
                let frame = &placements.frames[of.frame];
                let load = if which == 0 {
                    let at = (frame * nalgebra::Point3::new(v[1], v[2], v[3])).coords;
                    spatial(&at, &structure.gravity, &Vector3::zeros())
                } else {
                    let axis = frame.rotation.matrix().column(which - 1).into_owned();
                    spatial(&Vector3::zeros(), &Vector3::zeros(), &axis.cross(&(structure.gravity * v[0])))
                };
                virtual_work(elastics, statics, response, of.vertex, &load)
            }
        }
    }
}

impl BeamPart {
    /// Adds the derivatives by the beam's parameters; what they share is computed once.
    fn evaluate(
        &self,
        elastics: &Elastics,
        statics: &Statics,
        response: &Response,
        wrench: &Vector6<f64>,
        weight: bool,
        out: &mut [Vector6<f64>],
    ) {
        let structure = &elastics.model.structure;
        let length = statics.lengths[self.index];
        let (by_unit, forces, local, sign) = match self.vertex {
            Some(vertex) => {
                let mut forces = response.forces[vertex] * wrench;
                if weight {
                    forces += statics.weight.forces[vertex];
                }
                (response.forces[vertex], forces, &statics.local[vertex], 1.0)
            }
            None => {
                let (by_unit, forces) = closing_forces(elastics, statics, response, wrench, weight, self.closing);
                (by_unit, forces, &statics.closings[self.closing].local, -1.0)
            }
        };
        let (own, state) = elastics.beams[self.index].map_or((0.0, [0.0; 6]), |beam| (beam.mass, beam.inverse));
        let gravity = local.fixed_view::<3, 3>(0, 0) * structure.gravity;
        let heavier = weight && self.changes.iter().any(|(_, _, mass)| *mass != 0.0);
        // What a kilogram per metre more does: it bends the beam, and hangs on its first node.
        let by_mass = if heavier {
            let edge = structure.tree.iter().chain(&structure.closures).nth(self.index);
            let carried = edge.map_or_else(Vector6::zeros, |edge| {
                let [a, b] = edge.ends.map(|end| statics.points[end]);
                let load = spatial(&(0.5 * (a + b)), &(structure.gravity * length), &Vector3::zeros());
                virtual_work(elastics, statics, response, edge.ends[0], &load)
            });
            by_unit.tr_mul(&beam::under_own_load(state, length, &gravity)) * sign + carried
        } else {
            Vector6::zeros()
        };
        for &(column, inverse, mass) in &self.changes {
            let mut strain = beam::flexibility(inverse, length).apply(&forces);
            if weight && own != 0.0 {
                strain += beam::under_own_load(inverse, length, &(gravity * own)) * sign;
            }
            out[column] += by_unit.tr_mul(&strain) + by_mass * mass;
        }
    }
}

/// Work of a load on a vertex along its motions under the six unit wrenches of the response.
fn virtual_work(
    elastics: &Elastics,
    statics: &Statics,
    response: &Response,
    vertex: usize,
    load: &Vector6<f64>,
) -> Vector6<f64> {
    let active = elastics.model.structure.path(vertex).filter(|v| elastics.active.binary_search(v).is_ok());
    active.map(|v| response.strains[v].tr_mul(&(statics.local[v] * load))).sum()
}

/// Motion of a closure's second end against its first, by the six unit wrenches and under the load.
fn gaps(
    elastics: &Elastics,
    statics: &Statics,
    response: &Response,
    wrench: &Vector6<f64>,
    weight: bool,
    closing: usize,
) -> (Matrix6<f64>, Vector6<f64>) {
    let state = &statics.closings[closing];
    let (mut by_unit, mut own) = (Matrix6::zeros(), Vector6::zeros());
    for ((vertex, _), forces) in elastics.closings[closing].cycle.iter().zip(&state.forces) {
        by_unit += forces.tr_mul(&response.strains[*vertex]);
        if weight {
            own += forces.tr_mul(&statics.weight.strains[*vertex]);
        }
    }
    (by_unit, by_unit * wrench + own)
}

/// Forces of a closure by the six unit wrenches (a row for each direction), and under the load.
fn closing_forces(
    elastics: &Elastics,
    statics: &Statics,
    response: &Response,
    wrench: &Vector6<f64>,
    weight: bool,
    closing: usize,
) -> (Matrix6<f64>, Vector6<f64>) {
    let of = &elastics.closings[closing];
    let by_unit = response.closing_forces(of);
    let own = if weight { statics.closing_forces(of) } else { Vector6::zeros() };
    (by_unit, by_unit * wrench + own)
}

/// How a beam's inverse rigidities and mass per length change with each of its slots that is asked for.
fn beam_derivatives(elastics: &Elastics, rigidity: &Rigidity, slots: &[Slot]) -> Vec<(Slot, Inverse, f64)> {
    let mut own = beam_slots(rigidity, elastics.model);
    own.sort_unstable();
    own.dedup();
    own.into_iter()
        .filter(|slot| slots.contains(slot))
        .map(|slot| {
            let value = |s: Slot| {
                let at = Dual64::from(elastics.values[s]);
                if s == slot { at.derivative() } else { at }
            };
            let (inverse, mass) = section_state(elastics.model, rigidity, &value);
            (slot, inverse.map(|r| r.eps), mass.eps)
        })
        .collect()
}
