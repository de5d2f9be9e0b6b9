//! Statics of a placed configuration.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::compiled::Elastics;
use super::statics::{ClosingStatics, Mechanism, Statics};
use crate::elements::{Configuration, Deflected, Placed};
use crate::kinematics::Placements;
use crate::model::{Boom, Spot};

impl Elastics<'_> {
    /// Prepares the statics of a placed configuration.
    ///
    /// # Errors
    /// [`Mechanism`] if a released direction can move without any force, or a boom is drawn into its sleeve.
    pub fn prepare(&self, placements: &Placements, out: &mut Statics) -> Result<(), Mechanism> {
        self.undeflected(placements, &mut out.points);
        self.are_out(placements, &out.points)?;
        self.prepare_at(placements, None, out)
    }

    /// Whether something of every boom is out of its sleeve.
    fn are_out(&self, placements: &Placements, points: &[Vector3<f64>]) -> Result<(), Mechanism> {
        let is_out = |boom: &&Boom| {
            let along = points[boom.ends[1]] - points[boom.ends[0]];
            let out = (placements.frames[boom.frame].rotation * Vector3::z()).dot(&along);
            if boom.is_along { out > 0.0 } else { out < 0.0 }
        };
        match self.model.structure.booms.iter().find(|boom| !is_out(boom)) {
            Some(boom) => Err(Mechanism::DrawnIn { beam: boom.name.clone() }),
            None => Ok(()),
        }
    }

    /// Positions of the vertices with nothing deflected, m, base frame.
    pub(super) fn undeflected(&self, placements: &Placements, points: &mut Vec<Vector3<f64>>) {
        let vertices = &self.model.structure.vertices;
        points.resize(vertices.len(), Vector3::zeros());
        for (point, vertex) in points.iter_mut().zip(vertices) {
            if let Spot::At(frame, local) = vertex.spot {
                *point = (placements.frames[frame] * nalgebra::Point3::from(local)).coords;
            }
        }
        for (index, vertex) in vertices.iter().enumerate() {
            if let Spot::Between([a, b], share) = vertex.spot {
                points[index] = points[a].lerp(&points[b], share);
            }
        }
    }

    /// As [`Elastics::prepare`], with the vertices where `out.points` says and the bodies turned as `deflected` says.
    pub(super) fn prepare_at(
        &self,
        placements: &Placements,
        deflected: Option<Deflected>,
        out: &mut Statics,
    ) -> Result<(), Mechanism> {
        let points = std::mem::take(&mut out.points);
        let mut local = std::mem::take(&mut out.local);
        self.local_values(placements, &mut out.inputs, &mut local);
        let at = self.configuration(placements, &points, &local, deflected);
        self.place_members(&at, out);
        self.equations(out);
        self.release_undetermined(out);
        out.elimination.factor(self.unknowns, &out.matrix);
        let mechanism =
            if out.elimination.rank < self.unknowns { self.mechanism(&mut out.elimination) } else { Ok(()) };
        out.weight.active = self.is_loaded() && out.counts_weight() || !out.defects.is_empty();
        if mechanism.is_ok() && out.weight.active {
            self.weigh(&at, out);
        }
        (out.points, out.local) = (points, local);
        mechanism
    }

    fn place_members(&self, at: &Configuration, out: &mut Statics) {
        out.placed.resize(self.members.len(), Placed::default());
        for (placed, member) in out.placed.iter_mut().zip(&self.members) {
            let per_length = member.per_length.unwrap_or_default();
            *placed = member.edge.element.place(at, member.edge.ends, &per_length);
        }
        out.closings.resize_with(self.closings.len(), ClosingStatics::default);
        for (index, (closing, state)) in self.closings.iter().zip(&mut out.closings).enumerate() {
            let member = self.in_tree + index;
            let edge = self.members[member].edge;
            state.held = edge.element.held(at, edge.ends);
            state.drawn = edge.element.drawn(at, edge.ends);
            let unit = wrenches(&out.placed[member].local);
            state.forces.clear();
            state.strains.clear();
            for &(member, sign) in &closing.cycle {
                let forces = out.placed[member].local * unit * sign;
                state.strains.push(out.placed[member].flexibility.apply_all(&forces));
                state.forces.push(forces);
            }
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
