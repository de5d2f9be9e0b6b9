//! Own weight of bodies and beams, and preloads of springs.

use nalgebra::{Vector3, Vector6};

use super::compiled::Elastics;
use super::statics::Statics;
use crate::elements::{Configuration, PerLength, spatial};
use crate::model::MassElement;

impl Elastics<'_> {
    /// A mass: kg, and its centre in its frame, m.
    pub(super) fn mass(&self, of: &MassElement) -> (f64, Vector3<f64>) {
        let v = &self.values[of.slot..of.slot + 4];
        (v[0], Vector3::new(v[1], v[2], v[3]))
    }

    /// Deformations of a straight uniform element by its own weight, local axes.
    pub(super) fn sag(&self, member: usize, out: &Statics) -> Vector6<f64> {
        let of = self.distributed(member, out);
        of.map_or_else(Vector6::zeros, |(of, q)| of.under_load(out.placed[member].length, &q))
    }

    /// Strain energy of a straight uniform element under its own weight alone, J.
    pub(super) fn sag_energy(&self, member: usize, out: &Statics) -> f64 {
        let of = self.distributed(member, out);
        of.map_or(0.0, |(of, q)| of.energy_under_load(out.placed[member].length, &q))
    }

    /// A straight uniform element that has weight, and that weight, N/m in local axes.
    fn distributed(&self, member: usize, out: &Statics) -> Option<(PerLength, Vector3<f64>)> {
        let of = self.members[member].per_length.filter(|of| of.mass != 0.0)?;
        let axes = out.placed[member].local.fixed_view::<3, 3>(0, 0);
        Some((of, axes * self.model.structure.gravity * of.mass))
    }

    /// Own weight and preloads; where weight is not counted, only the defects of closures load the structure.
    pub(super) fn weigh(&self, at: &Configuration, out: &mut Statics) {
        let counted = out.counts_weight();
        out.weight.carried.clear();
        out.weight.carried.resize(self.model.structure.tree.len(), Vector6::zeros());
        if counted {
            self.gather(at, out);
        }
        out.weight.forces.clear();
        out.weight.strains.clear();
        for (member, of) in self.members[..self.in_tree].iter().enumerate() {
            let forces = out.placed[member].local * out.weight.carried[of.edge.ends[1]];
            let mut strains = out.placed[member].flexibility.apply(&forces);
            if counted {
                strains += self.sag(member, out);
            }
            out.weight.forces.push(forces);
            out.weight.strains.push(strains);
        }
        let mut unknowns = std::mem::take(&mut out.weight.unknowns);
        self.right_side(out, counted, &mut unknowns);
        out.elimination.solve(&mut unknowns);
        let weight = &mut out.weight;
        for (closing, state) in self.closings.iter().zip(&out.closings) {
            for (direction, unknown) in closing.unknowns() {
                for (at, (member, _)) in closing.cycle.iter().enumerate() {
                    weight.forces[*member] += state.forces[at].column(direction) * unknowns[unknown];
                    weight.strains[*member] += state.strains[at].column(direction) * unknowns[unknown];
                }
            }
        }
        for release in &self.releases {
            weight.strains[release.member][release.direction] += unknowns[release.unknown];
        }
        weight.unknowns = unknowns;
    }

    /// Weights on the vertices that carry them, and on all those that carry these.
    fn gather(&self, at: &Configuration, out: &mut Statics) {
        let structure = &self.model.structure;
        let carried = &mut out.weight.carried;
        for of in &structure.masses {
            let (mass, centre) = self.mass(of);
            let undeflected = (at.frames[of.frame] * nalgebra::Point3::from(centre)).coords;
            let point = at.carried(of.vertex, &undeflected);
            carried[of.vertex] += spatial(&point, &(structure.gravity * mass), &Vector3::zeros());
        }
        // A beam's weight is on its first node; what it bends in addition is its sag.
        for (ends, mass) in &self.heavy {
            let [a, b] = ends.map(|end| at.points[end]);
            let force = structure.gravity * *mass * (b - a).norm();
            carried[ends[0]] += spatial(&(0.5 * (a + b)), &force, &Vector3::zeros());
        }
        for (vertex, edge) in structure.tree.iter().enumerate().skip(1).rev() {
            let load = carried[vertex];
            carried[edge.ends[0]] += load;
        }
    }

    /// Right side of the unknowns' equations, into `right`.
    fn right_side(&self, out: &Statics, counted: bool, right: &mut Vec<f64>) {
        right.clear();
        right.resize(self.unknowns, 0.0);
        for (index, (closing, state)) in self.closings.iter().zip(&out.closings).enumerate() {
            let mut gap = out.defects.get(index).copied().unwrap_or_else(Vector6::zeros);
            for ((member, _), forces) in closing.cycle.iter().zip(&state.forces) {
                gap += forces.tr_mul(&out.weight.strains[*member]);
            }
            if counted {
                // The gap is what the tree opens less what the element itself reaches.
                gap -= self.sag(self.in_tree + index, out);
            }
            let rows = closing.rows(&state.held, &gap);
            for (direction, unknown) in closing.unknowns() {
                let preload = if counted { state.held.preload[direction] } else { 0.0 };
                right[unknown] = preload + state.drawn[direction] - rows[direction];
            }
        }
        for release in &self.releases {
            right[release.unknown] = -out.weight.forces[release.member][release.direction];
        }
    }
}
