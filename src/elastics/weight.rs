//! Own weight of bodies and beams, and preloads of springs.

use nalgebra::{Matrix3, Vector3, Vector6};

use super::elements::beam;
use super::spatial;
use super::statics::{ClosingKind, Elastics, Statics};
use crate::description::raw::SpringAction;
use crate::kinematics::Placements;

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

impl Elastics<'_> {
    /// Whether own weight or preloads load the structure.
    pub fn is_loaded(&self) -> bool {
        let structure = &self.model.structure;
        structure.gravity.norm() > 0.0
            && (structure.masses.iter().any(|mass| self.values[mass.slot] != 0.0)
                || self.beams.iter().flatten().any(|beam| beam.mass != 0.0))
            || structure
                .springs
                .iter()
                .any(|spring| spring.spring.acts == SpringAction::Full && spring.spring.free_length.is_some())
    }

    /// Own weight and preloads.
    pub(super) fn weigh(&self, placements: &Placements, turned: Option<&[Matrix3<f64>]>, out: &mut Statics) {
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
