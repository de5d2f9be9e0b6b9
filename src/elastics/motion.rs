//! Derivatives of the deflection by what moves the frames: joint variables and geometric parameters.
//!
//! An element carried along by a twist xi sees the wrench W through it change by -xi x* W, and its deformation t by
//! xi x t; unknown forces and motions need no derivative of their own, because the answer is stationary in them.

use nalgebra::{Matrix6, Point3, Vector3, Vector6};

use super::load_case::LoadCase;
use super::prepare::wrenches;
use crate::elements::{Motion, MotionRate, Placed, Rate, VertexIndex, VertexMotion, spatial};
use crate::kinematics::Placements;
use crate::model::Spot;

/// What of a response does not depend on the motion; gathered once a configuration, reused between configurations.
#[derive(Debug, Clone, Default)]
pub struct MotionWorkspace {
    /// By member.
    carried: Vec<Carried>,
    /// Displacements of the vertices by the motion.
    vertices: Vec<Vector3<f64>>,
}

/// Spatial wrench through a member and its deformation as a spatial twist: by the six unit wrenches, and under own weight.
#[derive(Debug, Clone, Copy, Default)]
struct Carried {
    wrench: Matrix6<f64>,
    twist: Matrix6<f64>,
    /// The wrench in local axes.
    forces: Matrix6<f64>,
    own_wrench: Vector6<f64>,
    own_twist: Vector6<f64>,
}

impl MotionWorkspace {
    /// Gathers what the derivatives of a response share; of the case's load only whether own weight counts enters.
    pub fn prepare(&mut self, case: &LoadCase) {
        let (elastics, statics) = (case.elastics, case.statics);
        self.carried.clear();
        for (member, placed) in statics.placed.iter().enumerate() {
            let back = wrenches(&placed.local);
            let (forces, own) = match member.checked_sub(elastics.in_tree) {
                None => (case.response.forces[member], statics.weight.forces.get(member).copied()),
                Some(closing) => {
                    let weight = statics.weight.active.then(|| -elastics.closing_forces_under_weight(statics, closing));
                    (-case.response.closing_forces(elastics, closing), weight)
                }
            };
            let own = own.filter(|_| statics.weight.active).unwrap_or_default();
            let mut found = Carried { wrench: back * forces, forces, own_wrench: back * own, ..Carried::default() };
            if let Some(closing) = member.checked_sub(elastics.in_tree) {
                for (other, sign) in &elastics.closings[closing].cycle {
                    found.twist += self.carried[*other].twist * *sign;
                    found.own_twist += self.carried[*other].own_twist * *sign;
                }
            } else {
                found.twist = placed.local.tr_mul(&case.response.strains[member]);
                if statics.weight.active {
                    found.own_twist = placed.local.tr_mul(&statics.weight.strains[member]);
                }
            }
            self.carried.push(found);
        }
    }

    /// Derivative, by one motion, of the spatial twist of the response's vertex under a spatial wrench that stays where it
    /// is, and own weight if it counts.
    pub fn by_motion(&mut self, case: &LoadCase, placements: &Placements, motion: &Motion) -> Vector6<f64> {
        let mut vertices = std::mem::take(&mut self.vertices);
        move_vertices(case, placements, motion, &mut vertices);
        let moves = VertexMotion { motion, frames: &placements.frames, vertices: &vertices };
        let at = case.elastics.configuration(placements, &case.statics.points, &case.statics.local, None);
        let mut change = Vector6::zeros();
        for ((member, of), placed) in case.elastics.members.iter().zip(&self.carried).zip(&case.statics.placed) {
            let rate = member.edge.element.by_motion(&at, member.edge.ends, &moves);
            let (mut through, mut strain) = (of.wrench * case.load.wrench, of.twist * case.load.wrench);
            if case.load.weight {
                through += of.own_wrench;
                strain += of.own_twist;
            }
            let twist = &rate.twist;
            if twist.iter().any(|v| *v != 0.0) {
                change += of.wrench.tr_mul(&cross(twist, &strain)) - of.twist.tr_mul(&cross_wrench(twist, &through));
            }
            change += match rate.rate {
                Rate::Flexibility(rate) => rate.work(&of.forces, &(placed.local * through)),
                Rate::Held(rate) => {
                    let to_local = wrenches(&placed.local);
                    let (by_unit, gap) = (to_local.tr_mul(&of.twist), to_local.tr_mul(&strain));
                    let preload = if case.load.weight { rate.preload } else { Vector6::zeros() };
                    by_unit.tr_mul(&(preload - rate.stiffness * gap))
                }
            };
            if let Some(per_length) = &member.per_length {
                let mut bend =
                    per_length.flexibility_by_length(placed.length).apply(&(placed.local * through)) * rate.stretch;
                if case.load.weight && per_length.mass != 0.0 {
                    let gravity = case.elastics.model.structure.gravity * per_length.mass;
                    let [q, dq] = moved_gravity(placed, &rate, &gravity);
                    bend += per_length.under_load(placed.length, &dq)
                        + per_length.under_load_by_length(placed.length, &q) * rate.stretch;
                }
                change += of.forces.tr_mul(&bend);
            }
        }
        if case.load.weight {
            change += self.by_moved_weights(case, &moves);
        }
        self.vertices = vertices;
        change
    }

    /// Weights go along with their bodies.
    fn by_moved_weights(&self, case: &LoadCase, moves: &VertexMotion) -> Vector6<f64> {
        let structure = &case.elastics.model.structure;
        let carried = |vertex: VertexIndex, load: &Vector6<f64>| -> Vector6<f64> {
            case.elastics.paths[vertex].iter().map(|&member| self.carried[member].twist.tr_mul(load)).sum()
        };
        let turned = |moved: &Vector3<f64>, force: &Vector3<f64>| {
            spatial(&Vector3::zeros(), &Vector3::zeros(), &moved.cross(force))
        };
        let mut change = Vector6::zeros();
        for of in &structure.masses {
            let (mass, centre) = case.elastics.mass(of);
            let at = (moves.frames[of.frame] * Point3::from(centre)).coords;
            change += carried(of.vertex, &turned(&moves.point(of.frame, &at).0, &(structure.gravity * mass)));
        }
        for (ends, mass) in case.elastics.masses_per_length() {
            let [a, b] = ends.map(|end| case.statics.points[end]);
            let [da, db] = ends.map(|end| moves.vertices[end]);
            let length = (b - a).norm();
            let stretch = (b - a).dot(&(db - da)) / length.max(f64::MIN_POSITIVE);
            let force = structure.gravity * *mass;
            let mut load = turned(&(0.5 * (da + db)), &(force * length));
            load += spatial(&(0.5 * (a + b)), &(force * stretch), &Vector3::zeros());
            change += carried(ends[0], &load);
        }
        change
    }
}

/// Displacements of all vertices, nothing deflected.
fn move_vertices(case: &LoadCase, placements: &Placements, motion: &Motion, out: &mut Vec<Vector3<f64>>) {
    let vertices = &case.elastics.model.structure.vertices;
    out.resize(vertices.len(), Vector3::zeros());
    for (index, vertex) in vertices.iter().enumerate() {
        if let Spot::At(frame, _) = vertex.spot {
            out[index] = motion.point(&placements.frames, frame, &case.statics.points[index]).0;
        }
    }
    for (index, vertex) in vertices.iter().enumerate() {
        if let Spot::Between([a, b], share) = vertex.spot {
            out[index] = out[a].lerp(&out[b], share);
        }
    }
}

/// Gravity (times a mass per length) in an element's local axes, and its derivative as these turn.
fn moved_gravity(placed: &Placed, rate: &MotionRate, gravity: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let turn = Vector3::new(rate.twist[3], rate.twist[4], rate.twist[5]);
    let rotate = placed.local.fixed_view::<3, 3>(0, 0);
    [rotate * gravity, -(rotate * turn.cross(gravity))]
}

/// Spatial cross product of twists.
fn cross(xi: &Vector6<f64>, t: &Vector6<f64>) -> Vector6<f64> {
    let (v, w) = (xi.fixed_rows::<3>(0), xi.fixed_rows::<3>(3));
    let (tv, tw) = (t.fixed_rows::<3>(0), t.fixed_rows::<3>(3));
    let (a, b) = (w.cross(&tv) + v.cross(&tw), w.cross(&tw));
    Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
}

/// Spatial cross product of a twist and a wrench.
fn cross_wrench(xi: &Vector6<f64>, f: &Vector6<f64>) -> Vector6<f64> {
    let (v, w) = (xi.fixed_rows::<3>(0), xi.fixed_rows::<3>(3));
    let (force, moment) = (f.fixed_rows::<3>(0), f.fixed_rows::<3>(3));
    let (a, b) = (w.cross(&force), w.cross(&moment) + v.cross(&force));
    Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
}
