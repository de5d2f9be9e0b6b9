//! The structure with values put in, and its statics at one configuration.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::elements::beam::Inverse;
use super::elements::{Flexibility, beam, lumped, screw, spring};
use super::elimination::Elimination;
use super::reduction;
use super::slots::{asked, section_state};
use super::weight::WeightState;
use crate::kinematics::Placements;
use crate::model::{Axes, Edge, Element, Law, Model, Spot, VertexIndex};
use crate::parameter::Slot;

/// A structure that can move without any force.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct Mechanism(pub String);

/// The elastic structure of a model with one vector of values; immutable, shared between threads.
#[derive(Debug, Clone)]
pub struct Elastics<'m> {
    /// The model.
    pub model: &'m Model,
    pub(super) values: Vec<f64>,
    /// Vertices whose element gives, or whose derivative is asked for, in tree order.
    pub(super) active: Vec<VertexIndex>,
    /// Closures and springs.
    pub(super) closings: Vec<Closing>,
    /// Released directions of the tree.
    pub(super) releases: Vec<Release>,
    /// Number of unknowns.
    pub(super) unknowns: usize,
    /// What beams of the tree and of the closures give and weigh; by vertex, then by closure.
    pub(super) beams: Vec<Option<BeamState>>,
}

/// Inverse rigidities of a beam, and its mass per length, kg/m.
#[derive(Debug, Clone, Copy)]
pub(super) struct BeamState {
    pub inverse: Inverse,
    pub mass: f64,
}

/// A closure or spring: its cycle in the tree, its unknown forces.
#[derive(Debug, Clone)]
pub(super) struct Closing {
    /// Active tree vertices of its cycle, +1 towards its second end, -1 towards its first.
    pub cycle: Vec<(VertexIndex, f64)>,
    /// Its vertices.
    pub ends: [VertexIndex; 2],
    pub kind: ClosingKind,
    /// First of its unknowns, and the directions they stand for.
    pub first: usize,
    pub directions: Vec<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ClosingKind {
    /// By index in `Structure::closures`.
    Element(usize),
    /// By index in `Structure::springs`.
    Spring(usize),
}

/// A released direction of a tree element.
#[derive(Debug, Clone, Copy)]
pub(super) struct Release {
    pub vertex: VertexIndex,
    pub direction: usize,
    pub slot: Option<Slot>,
    pub unknown: usize,
}

/// Statics at one configuration. Reused between configurations: nothing is allocated after the first.
#[derive(Debug, Clone, Default)]
pub struct Statics {
    /// Positions of the vertices, m, base frame.
    pub points: Vec<Vector3<f64>>,
    /// Of each active element: matrix from spatial wrenches to its local axes; by vertex.
    pub(super) local: Vec<Matrix6<f64>>,
    pub(super) flexibility: Vec<Flexibility>,
    /// Lengths of beams, by vertex, then by closure.
    pub(super) lengths: Vec<f64>,
    pub(super) closings: Vec<ClosingState>,
    pub(super) elimination: Elimination,
    pub(super) matrix: Vec<f64>,
    /// Internal forces and deformations under own weight, by vertex; unknowns.
    pub(super) weight: WeightState,
    /// Own weight is to be left out.
    pub no_weight: bool,
    /// What the linear gaps of closures leave out at finite motions; empty where nothing has moved.
    pub(super) defects: Vec<Vector6<f64>>,
}

/// A closure at a configuration.
#[derive(Debug, Clone)]
pub(super) struct ClosingState {
    /// Matrix from spatial wrenches to its local axes.
    pub local: Matrix6<f64>,
    pub flexibility: Flexibility,
    pub spring: Option<spring::State>,
    /// Stiffness that turns the gap into a force, of springs and of closures' released directions.
    pub stiffness: Matrix6<f64>,
    /// Internal forces along its cycle by its unit forces, and the deformations they cause.
    pub forces: Vec<Matrix6<f64>>,
    pub strains: Vec<Matrix6<f64>>,
}

impl Statics {
    /// Room for statics with own weight and preloads, or without.
    pub fn new(weight: bool) -> Self {
        Self { no_weight: !weight, ..Self::default() }
    }

    /// Forces of a closing under own weight and preloads, by direction; zero where they were not counted.
    pub(super) fn closing_forces(&self, closing: &Closing) -> Vector6<f64> {
        let mut forces = Vector6::zeros();
        if self.weight.active {
            for (k, &direction) in closing.directions.iter().enumerate() {
                forces[direction] = self.weight.unknowns[closing.first + k];
            }
        }
        forces
    }

    /// Whether own weight or preloads were counted.
    pub fn is_loaded(&self) -> bool {
        self.weight.active
    }
}

impl<'m> Elastics<'m> {
    /// Puts `values` (by slot, SI) into the structure. Elements that give nothing are passed over, unless they have a
    /// parameter among `by`.
    pub fn new(model: &'m Model, values: &[f64], by: &[Slot]) -> Self {
        let structure = &model.structure;
        let mut elastics = Self {
            model,
            values: values.to_vec(),
            active: Vec::new(),
            closings: Vec::new(),
            releases: Vec::new(),
            unknowns: 0,
            beams: Vec::new(),
        };
        let all = structure.tree.iter().chain(&structure.closures);
        elastics.beams = all.map(|edge| elastics.beam_state(edge)).collect();
        for vertex in 1..structure.tree.len() {
            if elastics.gives(&structure.tree[vertex], vertex) || asked(&structure.tree[vertex].element, model, by) {
                elastics.active.push(vertex);
            }
        }
        let is_active = |vertex: &VertexIndex| elastics.active.binary_search(vertex).is_ok();
        let cycle = |[a, b]: [VertexIndex; 2]| -> Vec<(VertexIndex, f64)> {
            let (to_a, to_b): (Vec<_>, Vec<_>) = (structure.path(a).collect(), structure.path(b).collect());
            let own = |path: &[usize], other: &[usize], sign: f64| -> Vec<(usize, f64)> {
                path.iter().filter(|v| !other.contains(v) && is_active(v)).map(|&v| (v, sign)).collect()
            };
            [own(&to_b, &to_a, 1.0), own(&to_a, &to_b, -1.0)].concat()
        };
        let mut unknowns = 0;
        for (index, edge) in structure.closures.iter().enumerate() {
            let directions: Vec<usize> = match &edge.element {
                Element::Lumped(lumped) => (0..6)
                    .filter(|&k| match lumped.laws[k] {
                        Law::Released(None) => false,
                        Law::Released(Some(slot)) => values[slot] != 0.0 || by.contains(&slot),
                        _ => true,
                    })
                    .collect(),
                Element::Beam(_) => (0..6).collect(),
                Element::Screw(_) => vec![0],
            };
            let kind = ClosingKind::Element(index);
            let ends = edge.ends;
            let count = directions.len();
            elastics.closings.push(Closing { cycle: cycle(ends), ends, kind, first: unknowns, directions });
            unknowns += count;
        }
        for (index, spring) in structure.springs.iter().enumerate() {
            if values[spring.slots[0]] != 0.0 || spring.slots.iter().any(|slot| by.contains(slot)) {
                let (kind, ends, directions) = (ClosingKind::Spring(index), spring.ends, (0..6).collect());
                elastics.closings.push(Closing { cycle: cycle(ends), ends, kind, first: unknowns, directions });
                unknowns += 6;
            }
        }
        for &vertex in &elastics.active {
            let Element::Lumped(lumped) = &structure.tree[vertex].element else { continue };
            for (direction, law) in lumped.laws.iter().enumerate() {
                if let Law::Released(slot) = *law {
                    elastics.releases.push(Release { vertex, direction, slot, unknown: unknowns });
                    unknowns += 1;
                }
            }
        }
        elastics.unknowns = unknowns;
        elastics
    }

    /// Mass per length (kg/m) of a beam, by vertex, then by closure.
    pub fn mass_per_length(&self, index: usize) -> Option<f64> {
        self.beams.get(index).copied().flatten().map(|beam| beam.mass)
    }

    /// Values by slot.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether anything gives.
    pub fn gives_at_all(&self) -> bool {
        !self.active.is_empty()
    }

    fn gives(&self, edge: &Edge, index: usize) -> bool {
        let value = |slot: Slot| self.values[slot] != 0.0;
        match &edge.element {
            Element::Lumped(lumped) => lumped.laws.iter().any(|law| match *law {
                Law::Rigid => false,
                Law::Compliance(slot) => value(slot),
                Law::Driven { own, axial, .. } => value(own) || value(axial),
                Law::Released(_) => true,
            }),
            Element::Beam(_) => self.beams[index].is_some_and(|beam| beam.inverse.iter().any(|r| *r != 0.0)),
            Element::Screw(_) => true,
        }
    }

    fn beam_state(&self, edge: &Edge) -> Option<BeamState> {
        let Element::Beam(beam) = &edge.element else { return None };
        let (inverse, mass) = section_state(self.model, &beam.rigidity, &|slot| self.values[slot]);
        Some(BeamState { inverse, mass })
    }

    /// Prepares the statics of a placed configuration.
    ///
    /// # Errors
    /// [`Mechanism`] if a released direction can move without any force.
    pub fn prepare(&self, placements: &Placements, out: &mut Statics) -> Result<(), Mechanism> {
        let structure = &self.model.structure;
        let count = structure.vertices.len();
        out.points.resize(count, Vector3::zeros());
        for (point, vertex) in out.points.iter_mut().zip(&structure.vertices) {
            if let Spot::At(frame, local) = vertex.spot {
                *point = (placements.frames[frame] * nalgebra::Point3::from(local)).coords;
            }
        }
        for index in 0..count {
            if let Spot::Between([a, b], share) = structure.vertices[index].spot {
                out.points[index] = out.points[a].lerp(&out.points[b], share);
            }
        }
        self.prepare_at(placements, None, out)
    }

    /// As [`Elastics::prepare`], with the vertices where `out.points` says and the bodies turned by `turned` (by vertex).
    pub(super) fn prepare_at(
        &self,
        placements: &Placements,
        turned: Option<&[Matrix3<f64>]>,
        out: &mut Statics,
    ) -> Result<(), Mechanism> {
        let structure = &self.model.structure;
        out.local.resize(structure.tree.len(), Matrix6::zeros());
        out.flexibility.resize(structure.tree.len(), Flexibility::Rigid);
        out.lengths.resize(structure.tree.len() + structure.closures.len(), 0.0);
        for &vertex in &self.active {
            let edge = &structure.tree[vertex];
            let (local, flexibility, length) = self.element(edge, vertex, placements, turned, &out.points);
            (out.local[vertex], out.flexibility[vertex], out.lengths[vertex]) = (local, flexibility, length);
        }
        out.closings.truncate(self.closings.len());
        for (index, closing) in self.closings.iter().enumerate() {
            if out.closings.len() == index {
                out.closings.push(ClosingState::default());
            }
            let mut spring = None;
            let mut stiffness = Matrix6::zeros();
            let (local, flexibility) = match closing.kind {
                ClosingKind::Element(which) => {
                    let edge = &structure.closures[which];
                    let at = structure.tree.len() + which;
                    let (local, flexibility, length) = self.element(edge, at, placements, turned, &out.points);
                    out.lengths[at] = length;
                    if let Element::Lumped(lumped) = &edge.element {
                        for k in 0..6 {
                            if let Law::Released(Some(slot)) = lumped.laws[k] {
                                stiffness[(k, k)] = self.values[slot];
                            }
                        }
                    }
                    (local, flexibility)
                }
                ClosingKind::Spring(which) => {
                    let state = spring::State::new(&structure.springs[which], &self.values, placements);
                    stiffness = state.stiffness();
                    spring = Some(state);
                    (reduction(&Matrix3::identity(), &state.pivot), Flexibility::Rigid)
                }
            };
            let state = &mut out.closings[index];
            (state.local, state.flexibility, state.spring, state.stiffness) = (local, flexibility, spring, stiffness);
            // Columns: spatial wrench of each unit force; the transpose of the reduction, with the moments' arms turned.
            let unit = wrenches(&local);
            state.forces.clear();
            state.strains.clear();
            for &(vertex, sign) in &closing.cycle {
                let forces = out.local[vertex] * unit * sign;
                state.strains.push(out.flexibility[vertex].apply_all(&forces));
                state.forces.push(forces);
            }
        }
        self.equations(out);
        out.elimination.factor(self.unknowns, &out.matrix);
        if out.elimination.rank < self.unknowns {
            self.mechanism(&mut out.elimination)?;
        }
        out.weight.active = self.is_loaded() && !out.no_weight || !out.defects.is_empty();
        if out.weight.active {
            self.weigh(placements, turned, out);
        }
        Ok(())
    }

    /// Local axes, flexibility and length of an element.
    fn element(
        &self,
        edge: &Edge,
        index: usize,
        placements: &Placements,
        turned: Option<&[Matrix3<f64>]>,
        points: &[Vector3<f64>],
    ) -> (Matrix6<f64>, Flexibility, f64) {
        let turn = turned.map_or_else(Matrix3::identity, |turned| turned[edge.ends[0]]);
        match &edge.element {
            Element::Lumped(of) => {
                let rotation = turn * self.lumped_axes(of.axes, placements);
                let origin = match of.spot {
                    Spot::At(frame, local) if turned.is_some() => {
                        // A point of the first vertex's body, carried along with it.
                        let rest = (placements.frames[frame] * nalgebra::Point3::from(local)).coords;
                        self.carried(edge.ends[0], &rest, placements, &turn, points)
                    }
                    Spot::At(frame, local) => (placements.frames[frame] * nalgebra::Point3::from(local)).coords,
                    Spot::Between([a, b], share) => points[a].lerp(&points[b], share),
                };
                let flexibility = lumped::flexibility(self.model, &self.values, of, &placements.joints);
                (reduction(&rotation, &origin), flexibility, 0.0)
            }
            Element::Beam(of) => {
                let [a, b] = edge.ends.map(|end| points[end]);
                let normal = turn * placements.frames[of.normal].rotation.matrix().column(of.axis);
                let (rotation, length) = beam::axes(&a, &b, &normal.into_owned());
                let inverse = self.beams[index].map_or([0.0; 6], |beam| beam.inverse);
                (reduction(&rotation, &b), beam::flexibility(inverse, length), length)
            }
            Element::Screw(of) => {
                let (rotation, origin) = screw::axes(self.model, &self.values, placements, of);
                let mut along = [0.0; 6];
                along[0] = screw::compliance(self.model, &self.values, &placements.joints, of);
                (reduction(&rotation, &origin), Flexibility::Diagonal(along), 0.0)
            }
        }
    }

    /// Axes of a lumped element with nothing deflected.
    fn lumped_axes(&self, axes: Axes, placements: &Placements) -> Matrix3<f64> {
        match axes {
            Axes::Frame(frame) => *placements.frames[frame].rotation.matrix(),
            Axes::Beam { ends, normal, axis } => {
                let [a, b] = ends.map(|end| rest_of(self.model, end, placements));
                let normal = placements.frames[normal].rotation.matrix().column(axis).into_owned();
                beam::axes(&a, &b, &normal).0
            }
        }
    }

    /// Where a point at `rest` of a vertex's body is when the vertex has moved.
    pub(super) fn carried(
        &self,
        vertex: VertexIndex,
        rest: &Vector3<f64>,
        placements: &Placements,
        turn: &Matrix3<f64>,
        points: &[Vector3<f64>],
    ) -> Vector3<f64> {
        let from = rest_of(self.model, vertex, placements);
        points[vertex] + turn * (rest - from)
    }
}

impl Default for ClosingState {
    fn default() -> Self {
        Self {
            local: Matrix6::zeros(),
            flexibility: Flexibility::Rigid,
            spring: None,
            stiffness: Matrix6::zeros(),
            forces: Vec::new(),
            strains: Vec::new(),
        }
    }
}

/// Spatial wrenches of unit forces and moments in the local axes of a reduction, one a column.
pub(super) fn wrenches(local: &Matrix6<f64>) -> Matrix6<f64> {
    // The inverse of [R' 0; -R'o R'] is [R 0; oR R].
    let rotation: Matrix3<f64> = local.fixed_view::<3, 3>(0, 0).transpose();
    let arm = rotation * local.fixed_view::<3, 3>(3, 0) * rotation;
    let mut matrix = Matrix6::zeros();
    matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
    matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(&-arm);
    matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
    matrix
}

/// Position of a vertex with nothing deflected.
pub(super) fn rest_of(model: &Model, vertex: VertexIndex, placements: &Placements) -> Vector3<f64> {
    match model.structure.vertices[vertex].spot {
        Spot::At(frame, local) => (placements.frames[frame] * nalgebra::Point3::from(local)).coords,
        Spot::Between([a, b], share) => rest_of(model, a, placements).lerp(&rest_of(model, b, placements), share),
    }
}
