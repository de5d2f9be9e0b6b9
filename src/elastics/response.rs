//! What loads on one vertex do: its compliance, and the internal forces of all elements.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::at_point;
use super::statics::{Closing, Elastics, Statics};
use crate::model::VertexIndex;

/// Answer of the structure to spatial wrenches on one vertex. Reused between configurations.
#[derive(Debug, Clone)]
pub struct Response {
    /// The vertex.
    pub vertex: VertexIndex,
    /// Spatial twist of the vertex by spatial wrench.
    pub compliance: Matrix6<f64>,
    /// Spatial twist of the vertex under own weight and preloads.
    pub weight: Vector6<f64>,
    /// Internal forces and deformations of each tree element by the six unit wrenches, local axes.
    pub(super) forces: Vec<Matrix6<f64>>,
    pub(super) strains: Vec<Matrix6<f64>>,
    /// Unknowns by the six unit wrenches, row-major.
    pub(super) unknowns: Vec<f64>,
    path: Vec<VertexIndex>,
    column: Vec<f64>,
}

impl Response {
    /// Room for the answer of one vertex.
    pub fn new(elastics: &Elastics, vertex: VertexIndex) -> Self {
        let count = elastics.model.structure.tree.len();
        let is_active = |v: &VertexIndex| elastics.active.binary_search(v).is_ok();
        Self {
            vertex,
            compliance: Matrix6::zeros(),
            weight: Vector6::zeros(),
            forces: vec![Matrix6::zeros(); count],
            strains: vec![Matrix6::zeros(); count],
            unknowns: vec![0.0; 6 * elastics.unknowns],
            path: elastics.model.structure.path(vertex).filter(is_active).collect(),
            column: vec![0.0; elastics.unknowns],
        }
    }

    /// Evaluates at prepared statics.
    pub fn evaluate(&mut self, elastics: &Elastics, statics: &mut Statics) {
        for &vertex in &elastics.active {
            self.forces[vertex] = Matrix6::zeros();
            self.strains[vertex] = Matrix6::zeros();
        }
        self.compliance = Matrix6::zeros();
        self.weight = Vector6::zeros();
        for &vertex in &self.path {
            let local = &statics.local[vertex];
            self.forces[vertex] = *local;
            self.strains[vertex] = statics.flexibility[vertex].apply_all(local);
            self.compliance += local.tr_mul(&self.strains[vertex]);
            if statics.weight.active {
                self.weight += local.tr_mul(&statics.weight.strains[vertex]);
            }
        }
        if elastics.unknowns == 0 {
            return;
        }
        let gaps = |closing: usize| -> Matrix6<f64> {
            let state = &statics.closings[closing];
            let cycle = elastics.closings[closing].cycle.iter().zip(&state.strains);
            let on_path = cycle.filter(|((vertex, _), _)| self.path.contains(vertex));
            on_path.map(|((vertex, _), strains)| strains.tr_mul(&statics.local[*vertex])).sum()
        };
        let gaps: Vec<Matrix6<f64>> = (0..elastics.closings.len()).map(gaps).collect();
        for load in 0..6 {
            self.column.fill(0.0);
            for ((closing, state), gaps) in elastics.closings.iter().zip(&statics.closings).zip(&gaps) {
                let rows = elastics.rows_of(closing, state, &gaps.column(load).into_owned());
                for (k, &direction) in closing.directions.iter().enumerate() {
                    self.column[closing.first + k] = -rows[direction];
                }
            }
            for release in elastics.releases.iter().filter(|release| self.path.contains(&release.vertex)) {
                self.column[release.unknown] = -statics.local[release.vertex][(release.direction, load)];
            }
            statics.elimination.solve(&mut self.column);
            for (k, value) in self.column.iter().enumerate() {
                self.unknowns[k * 6 + load] = *value;
            }
        }
        for ((closing, state), gaps) in elastics.closings.iter().zip(&statics.closings).zip(&gaps) {
            let amounts = self.closing_forces(closing);
            self.compliance += gaps.tr_mul(&amounts);
            for (at, (vertex, _)) in closing.cycle.iter().enumerate() {
                self.forces[*vertex] += state.forces[at] * amounts;
                self.strains[*vertex] += state.strains[at] * amounts;
            }
        }
        for release in &elastics.releases {
            let on_path = self.path.contains(&release.vertex);
            for load in 0..6 {
                let turn = self.unknowns[release.unknown * 6 + load];
                self.strains[release.vertex][(release.direction, load)] += turn;
                if on_path {
                    for k in 0..6 {
                        self.compliance[(k, load)] += statics.local[release.vertex][(release.direction, k)] * turn;
                    }
                }
            }
        }
    }

    /// Forces of a closing by the six unit wrenches: a row for each of its directions, zero where it has no unknown.
    pub(super) fn closing_forces(&self, closing: &Closing) -> Matrix6<f64> {
        let mut forces = Matrix6::zeros();
        for (k, &direction) in closing.directions.iter().enumerate() {
            let first = (closing.first + k) * 6;
            forces.row_mut(direction).copy_from_slice(&self.unknowns[first..first + 6]);
        }
        forces
    }

    /// Spatial twist of the vertex under a spatial wrench on it, own weight added if asked.
    pub fn twist(&self, wrench: &Vector6<f64>, weight: bool) -> Vector6<f64> {
        let twist = self.compliance * wrench;
        if weight { twist + self.weight } else { twist }
    }

    /// Compliance at a point (m, base frame) of the vertex's body: displacement and rotation there by force and moment.
    pub fn compliance_at(&self, point: &Vector3<f64>) -> Matrix6<f64> {
        let mut to_point = Matrix6::identity();
        to_point.fixed_view_mut::<3, 3>(0, 3).copy_from(&-point.cross_matrix());
        to_point * self.compliance * to_point.transpose()
    }

    /// Displacement and rotation of a point of the vertex's body under a force and moment at it (base axes).
    pub fn displacement(
        &self,
        point: &Vector3<f64>,
        force: &Vector3<f64>,
        moment: &Vector3<f64>,
        weight: bool,
    ) -> (Vector3<f64>, Vector3<f64>) {
        at_point(&self.twist(&super::spatial(point, force, moment), weight), point)
    }
}

/// Spatial twist of any vertex: the deformations along its path.
pub(super) fn twist_of(
    elastics: &Elastics,
    statics: &Statics,
    vertex: VertexIndex,
    strain: impl Fn(VertexIndex) -> Vector6<f64>,
) -> Vector6<f64> {
    let is_active = |v: &VertexIndex| elastics.active.binary_search(v).is_ok();
    elastics.model.structure.path(vertex).filter(is_active).map(|v| statics.local[v].tr_mul(&strain(v))).sum()
}
