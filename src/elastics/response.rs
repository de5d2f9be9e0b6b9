//! What loads on one vertex do: its compliance, and the internal forces of all elements.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::compiled::Elastics;
use super::statics::Statics;
use crate::elements::{VertexIndex, spatial};

/// Answer of the structure to spatial wrenches on one vertex. Reused between configurations.
#[derive(Debug, Clone)]
pub struct Response {
    /// The vertex.
    pub vertex: VertexIndex,
    /// Spatial twist of the vertex by spatial wrench.
    pub compliance: Matrix6<f64>,
    /// Spatial twist of the vertex under own weight and preloads.
    pub weight: Vector6<f64>,
    /// Internal forces and deformations of each tree member by the six unit wrenches, local axes.
    pub(super) forces: Vec<Matrix6<f64>>,
    pub(super) strains: Vec<Matrix6<f64>>,
    /// Unknowns by the six unit wrenches.
    unknowns: Vec<[f64; 6]>,
    /// Whether each tree member lies between the vertex and the ground.
    on_path: Vec<bool>,
    column: Vec<f64>,
    gaps: Vec<Matrix6<f64>>,
}

impl Response {
    /// Workspace for the answer of one vertex.
    pub fn new(elastics: &Elastics, vertex: VertexIndex) -> Self {
        let count = elastics.in_tree;
        let mut on_path = vec![false; count];
        elastics.paths[vertex].iter().for_each(|&member| on_path[member] = true);
        Self {
            vertex,
            compliance: Matrix6::zeros(),
            weight: Vector6::zeros(),
            forces: vec![Matrix6::zeros(); count],
            strains: vec![Matrix6::zeros(); count],
            unknowns: vec![[0.0; 6]; elastics.unknowns],
            on_path,
            column: vec![0.0; elastics.unknowns],
            gaps: vec![Matrix6::zeros(); elastics.closings.len()],
        }
    }

    /// Evaluates at prepared statics.
    pub fn evaluate(&mut self, elastics: &Elastics, statics: &mut Statics) {
        self.forces.fill(Matrix6::zeros());
        self.strains.fill(Matrix6::zeros());
        self.compliance = Matrix6::zeros();
        self.weight = Vector6::zeros();
        for &member in &elastics.paths[self.vertex] {
            let placed = &statics.placed[member];
            self.forces[member] = placed.local;
            self.strains[member] = placed.flexibility.apply_all(&placed.local);
            self.compliance += placed.local.tr_mul(&self.strains[member]);
            if statics.weight.active {
                self.weight += placed.local.tr_mul(&statics.weight.strains[member]);
            }
        }
        if elastics.unknowns > 0 {
            self.solve(elastics, statics);
            self.add_unknowns(elastics, statics);
        }
    }

    /// Unknowns by the six unit wrenches.
    fn solve(&mut self, elastics: &Elastics, statics: &mut Statics) {
        for ((gaps, closing), state) in self.gaps.iter_mut().zip(&elastics.closings).zip(&statics.closings) {
            let cycle = closing.cycle.iter().zip(&state.strains);
            let on_path = cycle.filter(|((member, _), _)| self.on_path[*member]);
            *gaps = on_path.map(|((member, _), strains)| strains.tr_mul(&statics.placed[*member].local)).sum();
        }
        for load in 0..6 {
            self.column.fill(0.0);
            for ((closing, state), gaps) in elastics.closings.iter().zip(&statics.closings).zip(&self.gaps) {
                let rows = closing.rows(&state.held, &gaps.column(load).into_owned());
                for (direction, unknown) in closing.unknowns() {
                    self.column[unknown] = -rows[direction];
                }
            }
            for release in elastics.releases.iter().filter(|release| self.on_path[release.member]) {
                self.column[release.unknown] = -statics.placed[release.member].local[(release.direction, load)];
            }
            statics.elimination.solve(&mut self.column);
            for (unknown, value) in self.unknowns.iter_mut().zip(&self.column) {
                unknown[load] = *value;
            }
        }
    }

    /// What the unknowns add to forces, deformations and compliance.
    fn add_unknowns(&mut self, elastics: &Elastics, statics: &Statics) {
        for (index, (closing, state)) in elastics.closings.iter().zip(&statics.closings).enumerate() {
            let amounts = self.closing_forces(elastics, index);
            self.compliance += self.gaps[index].tr_mul(&amounts);
            for (at, (member, _)) in closing.cycle.iter().enumerate() {
                self.forces[*member] += state.forces[at] * amounts;
                self.strains[*member] += state.strains[at] * amounts;
            }
        }
        for release in &elastics.releases {
            let local = statics.placed[release.member].local;
            for (load, turn) in self.unknowns[release.unknown].into_iter().enumerate() {
                self.strains[release.member][(release.direction, load)] += turn;
                if self.on_path[release.member] {
                    for k in 0..6 {
                        self.compliance[(k, load)] += local[(release.direction, k)] * turn;
                    }
                }
            }
        }
    }

    /// Forces of a closing on the tree by the six unit wrenches: a row for each of its directions, zero where it has no
    /// unknown.
    pub(super) fn closing_forces(&self, elastics: &Elastics, closing: usize) -> Matrix6<f64> {
        let mut forces = Matrix6::zeros();
        for (direction, unknown) in elastics.closings[closing].unknowns() {
            forces.row_mut(direction).copy_from_slice(&self.unknowns[unknown]);
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
        at_point(&self.twist(&spatial(point, force, moment), weight), point)
    }
}

/// Displacement and rotation, at a point, of the body that moves by a spatial twist.
pub fn at_point(twist: &Vector6<f64>, point: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let (v, w) = (Vector3::new(twist[0], twist[1], twist[2]), Vector3::new(twist[3], twist[4], twist[5]));
    (v + w.cross(point), w)
}
