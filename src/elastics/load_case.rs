//! A load case: the structure at a configuration under a wrench on one vertex.

use nalgebra::{Matrix6, Vector6};

use super::compiled::Elastics;
use super::response::Response;
use super::statics::Statics;

/// A spatial wrench (N, N.m), and whether own weight and preloads are added to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Spatial wrench on the vertex.
    pub wrench: Vector6<f64>,
    /// Whether own weight and preloads are added.
    pub weight: bool,
}

/// The structure at a configuration under a load on one vertex.
#[derive(Debug, Clone, Copy)]
pub struct LoadCase<'a> {
    /// The structure.
    pub elastics: &'a Elastics<'a>,
    /// Its statics.
    pub statics: &'a Statics,
    /// Response of the loaded vertex.
    pub response: &'a Response,
    /// The load.
    pub load: Load,
}

/// A quantity of an element in its local axes: by each unit wrench on the vertex (a column), and in all.
#[derive(Debug, Clone, Copy)]
pub(super) struct ByLoad {
    pub by_unit: Matrix6<f64>,
    pub total: Vector6<f64>,
}

impl<'a> LoadCase<'a> {
    /// A load on the response's vertex.
    pub fn new(elastics: &'a Elastics<'a>, statics: &'a Statics, response: &'a Response, load: Load) -> Self {
        let load = Load { weight: load.weight && statics.weight.active, ..load };
        Self { elastics, statics, response, load }
    }

    fn by_load(&self, by_unit: Matrix6<f64>, own: impl Fn() -> Vector6<f64>) -> ByLoad {
        let mut total = by_unit * self.load.wrench;
        if self.load.weight {
            total += own();
        }
        ByLoad { by_unit, total }
    }

    /// Internal forces of a member: on its far side, as of a beam held at its first end.
    pub(super) fn forces(&self, member: usize) -> ByLoad {
        let (elastics, statics) = (self.elastics, self.statics);
        match member.checked_sub(elastics.in_tree) {
            None => self.by_load(self.response.forces[member], || statics.weight.forces[member]),
            // Unknowns are the forces on the tree.
            Some(closing) => self.by_load(-self.response.closing_forces(elastics, closing), || {
                -elastics.closing_forces_under_weight(statics, closing)
            }),
        }
    }

    /// Deformation of a member: motion of its second end against the first.
    pub(super) fn deformation(&self, member: usize) -> ByLoad {
        let (elastics, statics) = (self.elastics, self.statics);
        match member.checked_sub(elastics.in_tree) {
            None => self.by_load(self.response.strains[member], || statics.weight.strains[member]),
            Some(closing) => {
                let cycle = elastics.closings[closing].cycle.iter().zip(&statics.closings[closing].forces);
                let by_unit = cycle.clone().map(|((m, _), forces)| forces.tr_mul(&self.response.strains[*m])).sum();
                self.by_load(by_unit, || {
                    cycle.clone().map(|((m, _), forces)| forces.tr_mul(&statics.weight.strains[*m])).sum()
                })
            }
        }
    }

    /// Work of a spatial wrench on a vertex along its motions under the six unit wrenches.
    pub(super) fn virtual_work(&self, vertex: usize, wrench: &Vector6<f64>) -> Vector6<f64> {
        let path = self.elastics.paths[vertex].iter();
        path.map(|&m| self.response.strains[m].tr_mul(&(self.statics.placed[m].local * wrench))).sum()
    }
}

impl Elastics<'_> {
    /// Forces of a closing on the tree under own weight and preloads, by direction.
    pub(super) fn closing_forces_under_weight(&self, statics: &Statics, closing: usize) -> Vector6<f64> {
        let mut forces = Vector6::zeros();
        for (direction, unknown) in self.closings[closing].unknowns() {
            forces[direction] = statics.weight.unknowns[unknown];
        }
        forces
    }
}
