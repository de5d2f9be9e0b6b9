//! The few equations of a structure: for forces of closures and springs, and motions of released directions.

use nalgebra::{Matrix6, Vector6};

use super::compiled::{Closing, Elastics};
use super::elimination::Elimination;
use super::statics::{Mechanism, Statics};
use crate::elements::{Direction, Held};

impl Closing {
    /// Its equations from its gaps: as they are, or turned into forces by its stiffness.
    pub fn rows(&self, held: &Held, gap: &Vector6<f64>) -> Vector6<f64> {
        if self.held == [Direction::Flexible; 6] {
            return *gap;
        }
        let forces = held.stiffness * gap;
        Vector6::from_fn(|k, _| if self.by_stiffness(k) { forces[k] } else { gap[k] })
    }
}

impl Elastics<'_> {
    /// The equations of the unknowns: gaps of closures close, springs follow their law, released directions carry
    /// nothing but their soft spring.
    pub(super) fn equations(&self, out: &mut Statics) {
        let n = self.unknowns;
        out.matrix.clear();
        out.matrix.resize(n * n, 0.0);
        for (i, closing) in self.closings.iter().enumerate() {
            let own = &out.closings[i];
            for ((other, state), shared) in self.closings.iter().zip(&out.closings).zip(&closing.shared) {
                if shared.is_empty() {
                    continue;
                }
                let gap: Matrix6<f64> =
                    shared.iter().map(|&(at, there)| own.forces[at].tr_mul(&state.strains[there])).sum();
                for (direction, column) in other.unknowns() {
                    let rows = closing.rows(&own.held, &gap.column(direction).into_owned());
                    for (direction, row) in closing.unknowns() {
                        out.matrix[row * n + column] += rows[direction];
                    }
                }
            }
            for &(at, release) in &closing.releases {
                let release = &self.releases[release];
                let force = own.forces[at].row(release.direction).transpose();
                let rows = closing.rows(&own.held, &force);
                for (direction, unknown) in closing.unknowns() {
                    out.matrix[unknown * n + release.unknown] += rows[direction];
                    out.matrix[release.unknown * n + unknown] += force[direction];
                }
            }
            let flexibility = &out.placed[self.in_tree + i].flexibility;
            for (direction, row) in closing.unknowns() {
                if closing.by_stiffness(direction) {
                    out.matrix[row * n + row] += 1.0;
                } else {
                    let deformed = flexibility.apply(&Vector6::ith(direction, 1.0));
                    for (other, column) in closing.unknowns() {
                        out.matrix[row * n + column] += deformed[other];
                    }
                }
            }
        }
        for release in &self.releases {
            let stiffness = release.slot.map_or(0.0, |slot| self.values[slot]);
            out.matrix[release.unknown * n + release.unknown] -= stiffness;
        }
    }

    /// Null motions among the unknowns; forces that only strain what is rigid against itself move nothing.
    pub(super) fn mechanism(&self, elimination: &mut Elimination) -> Result<(), Mechanism> {
        let structure = &self.model.structure;
        let mut names = Vec::new();
        for vector in elimination.null_vectors() {
            let most = self.releases.iter().max_by(|a, b| vector[a.unknown].abs().total_cmp(&vector[b.unknown].abs()));
            let Some(release) = most.filter(|release| vector[release.unknown].abs() > 1e-6) else { continue };
            let edge = self.members[release.member].edge;
            let name = &structure.vertices[edge.ends[1]].name;
            let motion = if release.direction < 3 { "slide along" } else { "spin about" };
            if let Some(beam) = edge.element.released_end_of() {
                let along = ["x", "y", "z"][release.direction % 3];
                names.push(format!(
                    "beam `{beam}` can {motion} its {along} axis at node `{name}`: it is released there and nothing else holds it"
                ));
                continue;
            }
            let what = edge.name.replace(':', " ");
            let through = |vertex: usize| self.paths[vertex].contains(&release.member);
            let closed = structure.closures.iter().any(|closure| {
                let [a, b] = closure.ends;
                closure.element.directions() != [Direction::Sprung; 6] && through(a) != through(b)
            });
            let why = if closed { "the loop through it does not hold it here" } else { "nothing closes it" };
            names.push(format!("node `{name}` can {motion} its axis: {what} is passive and {why}"));
        }
        names.dedup();
        if names.is_empty() { Ok(()) } else { Err(Mechanism::Moves(names.join("; "))) }
    }
}
