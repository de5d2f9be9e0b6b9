//! The few equations of a structure: for forces of closures and springs, and motions of released directions.

use nalgebra::{Matrix6, Vector6};

use super::elimination::Elimination;
use super::statics::{Closing, ClosingKind, ClosingState, Elastics, Mechanism, Statics};
use crate::model::{Edge, Element, Law};

impl Elastics<'_> {
    /// The equations of the unknowns: gaps of closures close, springs follow their law, released directions carry
    /// nothing but their soft spring.
    pub(super) fn equations(&self, out: &mut Statics) {
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
    pub(super) fn mechanism(&self, elimination: &mut Elimination) -> Result<(), Mechanism> {
        let structure = &self.model.structure;
        let mut names = Vec::new();
        for vector in elimination.null_vectors() {
            let most = self.releases.iter().max_by(|a, b| vector[a.unknown].abs().total_cmp(&vector[b.unknown].abs()));
            let Some(release) = most.filter(|release| vector[release.unknown].abs() > 1e-6) else { continue };
            let edge = &structure.tree[release.vertex];
            let name = &structure.vertices[release.vertex].name;
            let motion = if release.direction < 3 { "slide along" } else { "spin about" };
            if let Some(beam) = released_beam(edge) {
                let along = ["x", "y", "z"][release.direction % 3];
                names.push(format!(
                    "beam `{beam}` can {motion} its {along} axis at node `{name}`: it is released there and nothing else holds it"
                ));
                continue;
            }
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
}

/// The beam of which an element is a released end.
fn released_beam(edge: &Edge) -> Option<&str> {
    edge.released_end()?;
    edge.name.strip_prefix("release:")?.rsplit_once('.').map(|(beam, _)| beam)
}
