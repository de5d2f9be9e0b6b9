//! The structure with values put in, and its statics at one configuration.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::elements::beam::Inverse;
use super::elements::{Flexibility, beam, lumped, screw, spring};
use super::elimination::Elimination;
use super::section::properties;
use super::{reduction, spatial};
use crate::kinematics::Placements;
use crate::model::{Edge, Element, Law, Model, Rigidity, Spot, VertexIndex};
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
    matrix: Vec<f64>,
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

/// Statics under own weight and preloads.
#[derive(Debug, Clone, Default)]
pub(super) struct WeightState {
    pub active: bool,
    /// Spatial wrench of each vertex and all it carries.
    pub carried: Vec<Vector6<f64>>,
    /// Internal forces by vertex, the unknowns' share included.
    pub forces: Vec<Vector6<f64>>,
    /// Deformations by vertex, those of distributed loads and of released directions included.
    pub strains: Vec<Vector6<f64>>,
    pub unknowns: Vec<f64>,
}

impl Statics {
    /// Room for statics with own weight and preloads, or without.
    pub fn new(weight: bool) -> Self {
        Self { no_weight: !weight, ..Self::default() }
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

    /// Whether own weight or preloads load the structure.
    pub fn is_loaded(&self) -> bool {
        let structure = &self.model.structure;
        structure.gravity.norm() > 0.0
            && (structure.masses.iter().any(|mass| self.values[mass.slot] != 0.0)
                || self.beams.iter().flatten().any(|beam| beam.mass != 0.0))
            || structure.springs.iter().any(|spring| {
                spring.spring.acts == crate::description::raw::SpringAction::Full && spring.spring.free_length.is_some()
            })
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
        Some(self.beam_by(&beam.rigidity, |slot| self.values[slot]))
    }

    /// Inverse rigidities and mass per length, with numbers of any kind (to differentiate).
    fn beam_by(&self, rigidity: &Rigidity, value: impl Fn(Slot) -> f64) -> BeamState {
        match rigidity {
            Rigidity::Inverse([y, z, t]) => {
                BeamState { inverse: [0.0, 0.0, 0.0, value(*y), value(*z), value(*t)], mass: 0.0 }
            }
            section => {
                let (inverse, mass) = section_state(self.model, section, &|slot| value(slot));
                BeamState { inverse, mass }
            }
        }
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
                let rotation = turn * placements.frames[of.axes].rotation.matrix();
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

    /// The equations of the unknowns: gaps of closures close, springs follow their law, released directions carry
    /// nothing but their soft spring.
    fn equations(&self, out: &mut Statics) {
        let n = self.unknowns;
        out.matrix.clear();
        out.matrix.resize(n * n, 0.0);
        for (i, closing) in self.closings.iter().enumerate() {
            let own = &out.closings[i];
            for (j, other) in self.closings.iter().enumerate() {
                let gap = if i == j {
                    own.forces.iter().zip(&own.strains).map(|(f, s)| f.tr_mul(s)).sum::<Matrix6<f64>>()
                } else {
                    let strains = &out.closings[j].strains;
                    let shared = closing.cycle.iter().zip(&own.forces).filter_map(|((vertex, _), f)| {
                        let at = other.cycle.iter().position(|(v, _)| v == vertex)?;
                        Some(f.tr_mul(&strains[at]))
                    });
                    shared.sum()
                };
                self.put(closing, own, &gap, &mut out.matrix, |k| {
                    other.directions.iter().position(|d| *d == k).map(|at| other.first + at)
                });
            }
            for release in &self.releases {
                let Some(at) = closing.cycle.iter().position(|(v, _)| *v == release.vertex) else { continue };
                let force = own.forces[at].row(release.direction).transpose();
                let row = self.rows_of(closing, own, &force);
                for (k, &direction) in closing.directions.iter().enumerate() {
                    out.matrix[(closing.first + k) * n + release.unknown] += row[direction];
                    out.matrix[release.unknown * n + closing.first + k] += force[direction];
                }
            }
            for (k, &direction) in closing.directions.iter().enumerate() {
                let at = (closing.first + k) * n;
                if self.by_stiffness(closing, direction) {
                    out.matrix[at + closing.first + k] += 1.0;
                } else {
                    let mut unit = Vector6::zeros();
                    unit[direction] = 1.0;
                    let give = own.flexibility.apply(&unit);
                    for (m, &other) in closing.directions.iter().enumerate() {
                        out.matrix[at + closing.first + m] += give[other];
                    }
                }
            }
        }
        for release in &self.releases {
            let stiffness = release.slot.map_or(0.0, |slot| self.values[slot]);
            out.matrix[release.unknown * n + release.unknown] -= stiffness;
        }
    }

    /// Whether a direction of a closure is a spring (force by gap) rather than a compliance (gap by force).
    pub(super) fn by_stiffness(&self, closing: &Closing, direction: usize) -> bool {
        match closing.kind {
            ClosingKind::Spring(_) => true,
            ClosingKind::Element(which) => match &self.model.structure.closures[which].element {
                Element::Lumped(lumped) => matches!(lumped.laws[direction], Law::Released(_)),
                _ => false,
            },
        }
    }

    /// A closure's equations from its gaps: as they are, or turned into forces by its stiffness.
    pub(super) fn rows_of(&self, closing: &Closing, state: &ClosingState, gap: &Vector6<f64>) -> Vector6<f64> {
        match closing.kind {
            ClosingKind::Spring(_) => state.stiffness * gap,
            ClosingKind::Element(_) => {
                Vector6::from_fn(
                    |k, _| {
                        if self.by_stiffness(closing, k) { state.stiffness[(k, k)] * gap[k] } else { gap[k] }
                    },
                )
            }
        }
    }

    fn put(
        &self,
        closing: &Closing,
        state: &ClosingState,
        gap: &Matrix6<f64>,
        matrix: &mut [f64],
        unknown: impl Fn(usize) -> Option<usize>,
    ) {
        for k in 0..6 {
            let Some(column) = unknown(k) else { continue };
            let rows = self.rows_of(closing, state, &gap.column(k).into_owned());
            for (m, &direction) in closing.directions.iter().enumerate() {
                matrix[(closing.first + m) * self.unknowns + column] += rows[direction];
            }
        }
    }

    /// Null motions among the unknowns; forces that only strain what is rigid against itself move nothing.
    fn mechanism(&self, elimination: &mut Elimination) -> Result<(), Mechanism> {
        let structure = &self.model.structure;
        let mut names = Vec::new();
        for vector in elimination.null_vectors() {
            let most = self.releases.iter().max_by(|a, b| vector[a.unknown].abs().total_cmp(&vector[b.unknown].abs()));
            let Some(release) = most.filter(|release| vector[release.unknown].abs() > 1e-6) else { continue };
            let edge = &structure.tree[release.vertex];
            let name = &structure.vertices[release.vertex].name;
            let motion = if release.direction < 3 { "slide along" } else { "spin about" };
            let what = edge.name.replace(':', " ");
            let closed = structure.closures.iter().any(|closure| {
                let [a, b] = closure.ends;
                structure.path(a).any(|v| v == release.vertex) != structure.path(b).any(|v| v == release.vertex)
            });
            let why = if closed { "the loop through it does not hold it here" } else { "nothing closes it" };
            names.push(format!("node `{name}` can {motion} its axis: {what} is passive and {why}"));
        }
        names.dedup();
        if names.is_empty() { Ok(()) } else { Err(Mechanism(names.join("; "))) }
    }

    /// Own weight and preloads.
    fn weigh(&self, placements: &Placements, turned: Option<&[Matrix3<f64>]>, out: &mut Statics) {
        let structure = &self.model.structure;
        let gravity = &structure.gravity;
        let weight = &mut out.weight;
        weight.carried.clear();
        weight.carried.resize(structure.tree.len(), Vector6::zeros());
        weight.forces.resize(structure.tree.len(), Vector6::zeros());
        weight.strains.resize(structure.tree.len(), Vector6::zeros());
        let unloaded = out.no_weight;
        for mass in structure.masses.iter().filter(|_| !unloaded) {
            let v = &self.values[mass.slot..mass.slot + 4];
            let rest = (placements.frames[mass.frame] * nalgebra::Point3::new(v[1], v[2], v[3])).coords;
            let at = match turned {
                Some(turned) => self.carried(mass.vertex, &rest, placements, &turned[mass.vertex], &out.points),
                None => rest,
            };
            weight.carried[mass.vertex] += spatial(&at, &(gravity * v[0]), &Vector3::zeros());
        }
        // A beam rests on its first node; under its own weight it bends beside what its end carries.
        let rows = structure.tree.iter().chain(&structure.closures).enumerate();
        for (index, edge) in rows {
            if let Some(beam) = self.beams[index].filter(|beam| beam.mass != 0.0 && !unloaded) {
                let [a, b] = edge.ends.map(|end| out.points[end]);
                let force = gravity * beam.mass * (b - a).norm();
                weight.carried[edge.ends[0]] += spatial(&(0.5 * (a + b)), &force, &Vector3::zeros());
            }
        }
        for vertex in (1..structure.tree.len()).rev() {
            let parent = structure.tree[vertex].ends[0];
            let carried = weight.carried[vertex];
            weight.carried[parent] += carried;
        }
        for &vertex in &self.active {
            weight.forces[vertex] = out.local[vertex] * weight.carried[vertex];
            weight.strains[vertex] = out.flexibility[vertex].apply(&weight.forces[vertex]);
            if let Some(beam) = self.beams[vertex].filter(|_| !unloaded) {
                let q = out.local[vertex].fixed_view::<3, 3>(0, 0) * gravity * beam.mass;
                weight.strains[vertex] += beam::under_own_load(beam.inverse, out.lengths[vertex], &q);
            }
        }
        let right = &mut weight.unknowns;
        right.clear();
        right.resize(self.unknowns, 0.0);
        for (index, (closing, state)) in self.closings.iter().zip(&out.closings).enumerate() {
            let mut gap = out.defects.get(index).copied().unwrap_or_else(Vector6::zeros);
            for ((vertex, _), forces) in closing.cycle.iter().zip(&state.forces) {
                gap += forces.tr_mul(&weight.strains[*vertex]);
            }
            if let ClosingKind::Element(which) = closing.kind
                && let Some(beam) = self.beams[structure.tree.len() + which].filter(|_| !unloaded)
            {
                let q = state.local.fixed_view::<3, 3>(0, 0) * gravity * beam.mass;
                // The gap is what the tree opens less what the beam itself reaches.
                gap -= beam::under_own_load(beam.inverse, out.lengths[structure.tree.len() + which], &q);
            }
            let rows = self.rows_of(closing, state, &gap);
            let preload = state.spring.filter(|_| !unloaded).map_or_else(Vector6::zeros, |spring| spring.wrench());
            for (k, &direction) in closing.directions.iter().enumerate() {
                right[closing.first + k] = -rows[direction] + preload[direction];
            }
        }
        for release in &self.releases {
            right[release.unknown] = -weight.forces[release.vertex][release.direction];
        }
        out.elimination.solve(right);
        for (closing, state) in self.closings.iter().zip(&out.closings) {
            for (k, &direction) in closing.directions.iter().enumerate() {
                let amount = weight.unknowns[closing.first + k];
                for (at, (vertex, _)) in closing.cycle.iter().enumerate() {
                    weight.forces[*vertex] += state.forces[at].column(direction) * amount;
                    weight.strains[*vertex] += state.strains[at].column(direction) * amount;
                }
            }
        }
        for release in &self.releases {
            weight.strains[release.vertex][release.direction] += weight.unknowns[release.unknown];
        }
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
fn asked(element: &Element, model: &Model, by: &[Slot]) -> bool {
    slots_of(element, model).iter().any(|slot| by.contains(slot))
}

/// Slots of an element.
pub(super) fn slots_of(element: &Element, model: &Model) -> Vec<Slot> {
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
        Element::Beam(beam) => match &beam.rigidity {
            Rigidity::Inverse(slots) => slots.to_vec(),
            Rigidity::Section { sections, material, .. } => {
                let material = &model.structure.materials[*material];
                let mut slots = vec![material.young, material.shear, material.density];
                for &section in sections {
                    slots.extend(model.structure.sections[section].slots.iter().map(|(_, slot)| *slot));
                }
                slots
            }
        },
    }
}
