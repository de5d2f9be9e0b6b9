//! Derivatives of the deflection by what moves the frames: joint variables and geometric parameters.
//!
//! An element carried along by a twist xi sees the wrench W through it change by -xi x* W, and its deformation t by
//! xi x t; unknown forces and motions need no derivative of their own, because the answer is stationary in them.

use nalgebra::{Matrix6, Point3, Vector3, Vector6};

use super::elements::{beam, screw};
use super::response::Response;
use super::spatial;
use super::statics::{ClosingKind, Elastics, Statics, wrenches};
use crate::description::robot::FrameIndex;
use crate::kinematics::Placements;
use crate::model::{Axes, Edge, Element, Law, Spot, VertexIndex};
use crate::parameter::Slot;

/// How a robot moves with a geometric parameter or a variable.
pub struct Motion<'a> {
    /// The parameter; none for a variable.
    pub by: Option<Slot>,
    /// Displacement of each frame's origin (m) and its rotation (rad), base axes.
    pub frames: &'a dyn Fn(FrameIndex) -> [f64; 6],
    /// How fast each joint's variable changes.
    pub joints: &'a dyn Fn(FrameIndex) -> f64,
}

/// How a point (m, base frame) of a frame moves: displacement and rotation, base axes.
type PointMotion<'a> = &'a dyn Fn(FrameIndex, &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>);

/// What of a response does not depend on the driver; made once a configuration.
#[derive(Debug, Clone, Default)]
pub struct MotionWork {
    /// Spatial wrench through each active tree element, and its deformation as a spatial twist, by the six unit wrenches.
    through: Vec<(Matrix6<f64>, Matrix6<f64>)>,
    /// The same of each closing: its force on its second end, and less the motion of that end against the first.
    closings: Vec<(Matrix6<f64>, Matrix6<f64>)>,
    /// The same under own weight.
    weight: Vec<(Vector6<f64>, Vector6<f64>)>,
    weight_closings: Vec<(Vector6<f64>, Vector6<f64>)>,
}

impl MotionWork {
    /// Gathers what the derivatives of a response share.
    pub fn prepare(&mut self, elastics: &Elastics, statics: &Statics, response: &Response) {
        self.through.clear();
        self.weight.clear();
        self.closings.clear();
        self.weight_closings.clear();
        for &vertex in &elastics.active {
            let local = &statics.local[vertex];
            let back = wrenches(local);
            self.through.push((back * response.forces[vertex], local.tr_mul(&response.strains[vertex])));
            self.weight.push(if statics.weight.active {
                (back * statics.weight.forces[vertex], local.tr_mul(&statics.weight.strains[vertex]))
            } else {
                Default::default()
            });
        }
        for (closing, state) in elastics.closings.iter().zip(&statics.closings) {
            let back = wrenches(&state.local);
            let (amounts, own) = (response.closing_forces(closing), statics.closing_forces(closing));
            let (mut gaps, mut gap) = (Matrix6::zeros(), Vector6::zeros());
            for (vertex, sign) in &closing.cycle {
                let at = elastics.active.binary_search(vertex).unwrap_or(0);
                gaps += self.through[at].1 * *sign;
                gap += self.weight[at].1 * *sign;
            }
            self.closings.push((back * amounts, -gaps));
            self.weight_closings.push((back * own, -gap));
        }
    }
}

/// Derivative, by one driver, of the spatial twist of the response's vertex under a spatial wrench that stays where it
/// is, beside own weight if asked.
#[allow(clippy::too_many_arguments)] // the whole state of one reading
pub fn by_motion(
    elastics: &Elastics,
    placements: &Placements,
    statics: &Statics,
    response: &Response,
    work: &MotionWork,
    wrench: &Vector6<f64>,
    weight: bool,
    motion: &Motion,
) -> Vector6<f64> {
    let structure = &elastics.model.structure;
    let weight = weight && statics.weight.active;
    let moving = |frame: FrameIndex, at: &Vector3<f64>| -> (Vector3<f64>, Vector3<f64>) {
        let column = (motion.frames)(frame);
        let turn = Vector3::new(column[3], column[4], column[5]);
        let origin = placements.frames[frame].translation.vector;
        (Vector3::new(column[0], column[1], column[2]) + turn.cross(&(at - origin)), turn)
    };
    let vertex_moves = |vertex: VertexIndex| vertex_motion(structure, vertex, statics, &moving);
    let mut change = Vector6::zeros();
    let pairs = |unit: &(Matrix6<f64>, Matrix6<f64>), own: &(Vector6<f64>, Vector6<f64>)| {
        let (mut through, mut strain) = (unit.0 * wrench, unit.1 * wrench);
        if weight {
            through += own.0;
            strain += own.1;
        }
        (through, strain)
    };
    for (at, &vertex) in elastics.active.iter().enumerate() {
        let unit = &work.through[at];
        let (through, strain) = pairs(unit, &work.weight[at]);
        let edge = &structure.tree[vertex];
        let (twist, stretch) = element_motion(elastics, placements, statics, edge, &moving, &vertex_moves, motion);
        change += unit.0.tr_mul(&crm(&twist, &strain)) - unit.1.tr_mul(&crf(&twist, &through));
        let forces = &response.forces[vertex];
        match &edge.element {
            Element::Beam(_) => {
                let Some(state) = elastics.beams[vertex] else { continue };
                let length = statics.lengths[vertex];
                let internal = statics.local[vertex] * through;
                change += forces.tr_mul(&beam::by_length(state.inverse, length).apply(&internal)) * stretch;
                if weight && state.mass != 0.0 {
                    let turn = Vector3::new(twist[3], twist[4], twist[5]);
                    let rotate = statics.local[vertex].fixed_view::<3, 3>(0, 0);
                    let q = rotate * structure.gravity * state.mass;
                    let dq = -(rotate * turn.cross(&structure.gravity)) * state.mass;
                    let bend = beam::under_own_load(state.inverse, length, &dq)
                        + beam::own_load_by_length(state.inverse, length, &q) * stretch;
                    change += forces.tr_mul(&bend);
                }
            }
            Element::Lumped(lumped) => {
                for (direction, law) in lumped.laws.iter().enumerate() {
                    if let Law::Driven { axial, actuator, .. } = *law
                        && elastics.values[axial] != 0.0
                    {
                        let (lever, rate) = lever_rate(elastics, placements, actuator, motion);
                        let by = -2.0 * rate / lever.powi(3);
                        let internal = (statics.local[vertex] * through)[direction];
                        change += forces.row(direction).transpose() * (elastics.values[axial] * by * internal);
                    }
                }
            }
            Element::Screw(_) => {}
        }
    }
    for (at, closing) in elastics.closings.iter().enumerate() {
        let unit = &work.closings[at];
        let (through, strain) = pairs(unit, &work.weight_closings[at]);
        match closing.kind {
            ClosingKind::Element(which) => {
                let index = structure.tree.len() + which;
                let edge = &structure.closures[which];
                let (twist, stretch) =
                    element_motion(elastics, placements, statics, edge, &moving, &vertex_moves, motion);
                change += unit.0.tr_mul(&crm(&twist, &strain)) - unit.1.tr_mul(&crf(&twist, &through));
                let state = &statics.closings[at];
                let virtual_forces = state.local * unit.0;
                let internal = state.local * through;
                match &edge.element {
                    Element::Beam(_) => {
                        if let Some(beam) = elastics.beams[index] {
                            let length = statics.lengths[index];
                            let by = beam::by_length(beam.inverse, length);
                            change += virtual_forces.tr_mul(&by.apply(&internal)) * stretch;
                            if weight && beam.mass != 0.0 {
                                let turn = Vector3::new(twist[3], twist[4], twist[5]);
                                let rotate = state.local.fixed_view::<3, 3>(0, 0);
                                let q = rotate * structure.gravity * beam.mass;
                                let dq = -(rotate * turn.cross(&structure.gravity)) * beam.mass;
                                let bend = beam::under_own_load(beam.inverse, length, &dq)
                                    + beam::own_load_by_length(beam.inverse, length, &q) * stretch;
                                change -= virtual_forces.tr_mul(&bend);
                            }
                        }
                    }
                    Element::Screw(of) if elastics.values[of.own] != 0.0 => {
                        let (lever, rate) = lever_rate(elastics, placements, of.actuator, motion);
                        let by = 2.0 * lever * rate;
                        change += virtual_forces.row(0).transpose() * (elastics.values[of.own] * by * internal[0]);
                    }
                    _ => {}
                }
            }
            ClosingKind::Spring(which) => {
                let (of, Some(spring)) = (&structure.springs[which], statics.closings[at].spring) else { continue };
                let b = spring.pivot + spring.arm;
                let a = b - spring.along * spring.length;
                let (moved_a, moved_b) = (moving(of.spring.bodies[0], &a).0, moving(of.spring.bodies[1], &b).0);
                let pivot = moving(of.pivot, &spring.pivot).0;
                let twist = Vector6::new(pivot.x, pivot.y, pivot.z, 0.0, 0.0, 0.0);
                change += unit.0.tr_mul(&crm(&twist, &strain)) - unit.1.tr_mul(&crf(&twist, &through));
                let (stiffness, preload) =
                    spring.by_motion(&(moved_b - moved_a), &(moved_b - pivot), of.spring.free_length.is_some());
                // Minus the motions: the pairs hold it with that sign.
                let at_pivot = wrenches(&statics.closings[at].local);
                let (virtual_gap, gap) = (at_pivot.tr_mul(&unit.1), at_pivot.tr_mul(&strain));
                change -= virtual_gap.tr_mul(&(stiffness * gap));
                if weight {
                    change -= virtual_gap.tr_mul(&preload);
                }
            }
        }
    }
    // Weights go along with their bodies.
    let carried = |vertex: VertexIndex, load: &Vector6<f64>| -> Vector6<f64> {
        structure
            .path(vertex)
            .filter_map(|v| elastics.active.binary_search(&v).ok())
            .map(|at| work.through[at].1.tr_mul(load))
            .sum()
    };
    let turned =
        |moved: &Vector3<f64>, force: &Vector3<f64>| spatial(&Vector3::zeros(), &Vector3::zeros(), &moved.cross(force));
    if weight {
        for mass in &structure.masses {
            let v = &elastics.values[mass.slot..mass.slot + 4];
            let at = (placements.frames[mass.frame] * Point3::new(v[1], v[2], v[3])).coords;
            change += carried(mass.vertex, &turned(&moving(mass.frame, &at).0, &(structure.gravity * v[0])));
        }
        for (index, edge) in structure.tree.iter().chain(&structure.closures).enumerate() {
            let Some(beam) = elastics.beams[index].filter(|beam| beam.mass != 0.0) else { continue };
            let [a, b] = edge.ends.map(|end| statics.points[end]);
            let [da, db] = edge.ends.map(&vertex_moves);
            let length = (b - a).norm();
            let stretch = (b - a).dot(&(db - da)) / length.max(f64::MIN_POSITIVE);
            let force = structure.gravity * beam.mass;
            let mut load = turned(&(0.5 * (da + db)), &(force * length));
            load += spatial(&(0.5 * (a + b)), &(force * stretch), &Vector3::zeros());
            change += carried(edge.ends[0], &load);
        }
    }
    change
}

/// Displacement of a vertex at rest.
fn vertex_motion(
    structure: &crate::model::Structure,
    vertex: VertexIndex,
    statics: &Statics,
    moving: PointMotion,
) -> Vector3<f64> {
    match structure.vertices[vertex].spot {
        Spot::At(frame, _) => moving(frame, &statics.points[vertex]).0,
        Spot::Between([a, b], share) => {
            vertex_motion(structure, a, statics, moving).lerp(&vertex_motion(structure, b, statics, moving), share)
        }
    }
}

/// Spatial twist of an element's local axes, and the stretch of a beam.
#[allow(clippy::too_many_arguments)] // the whole state of one reading
fn element_motion(
    elastics: &Elastics,
    placements: &Placements,
    statics: &Statics,
    edge: &Edge,
    moving: PointMotion,
    vertex_moves: &dyn Fn(VertexIndex) -> Vector3<f64>,
    motion: &Motion,
) -> (Vector6<f64>, f64) {
    let spatial_twist = |at: &Vector3<f64>, moved: Vector3<f64>, turn: Vector3<f64>| {
        let v = moved - turn.cross(at);
        Vector6::new(v.x, v.y, v.z, turn.x, turn.y, turn.z)
    };
    // How a beam's own axes turn, and how it stretches.
    let beam_turn = |ends: [VertexIndex; 2], normal: FrameIndex, axis: usize| {
        let [a, b] = ends.map(|end| statics.points[end]);
        let [da, db] = ends.map(vertex_moves);
        let length = (b - a).norm().max(f64::MIN_POSITIVE);
        let x = (b - a) / length;
        let across = x.cross(&(db - da)) / length;
        // About its own axis the beam turns so that its z stays in the plane of x and the normal.
        let turn = moving(normal, &b).1;
        let normal = placements.frames[normal].rotation.matrix().column(axis).into_owned();
        let moved = turn.cross(&normal) - across.cross(&normal);
        let z = normal - x * x.dot(&normal);
        let about = if z.norm() > 1e-6 { z.cross(&moved).dot(&x) / z.norm_squared() } else { turn.dot(&x) };
        (across + x * about, x.dot(&(db - da)))
    };
    match &edge.element {
        Element::Lumped(of) => {
            let Spot::At(frame, local) = of.spot else { return (Vector6::zeros(), 0.0) };
            let at = (placements.frames[frame] * Point3::from(local)).coords;
            let turn = match of.axes {
                Axes::Frame(axes) => moving(axes, &at).1,
                Axes::Beam { ends, normal, axis } => beam_turn(ends, normal, axis).0,
            };
            (spatial_twist(&at, moving(frame, &at).0, turn), 0.0)
        }
        Element::Beam(of) => {
            let (turn, stretch) = beam_turn(edge.ends, of.normal, of.axis);
            let [_, b] = edge.ends;
            (spatial_twist(&statics.points[b], vertex_moves(b), turn), stretch)
        }
        Element::Screw(of) => {
            let (model, values, joints) = (elastics.model, elastics.values(), &placements.joints);
            let joint = model.actuators[of.actuator].joint;
            let frame = &placements.frames[joint];
            let [a, b] = screw::pins(model, values, of.actuator, joints).map(|pin| (frame * Point3::from(pin)).coords);
            // The pins are laid out in the joint's frame, and move in it.
            let rate = screw::triangle_rate(model, of.actuator, motion.by, (motion.joints)(joint));
            let [own_a, own_b] = screw::pins_rate(model, values, of.actuator, joints, &rate);
            let (da, db) = (moving(joint, &a).0 + frame.rotation * own_a, moving(joint, &b).0 + frame.rotation * own_b);
            let along = b - a;
            let turn = along.cross(&(db - da)) / along.norm_squared().max(f64::MIN_POSITIVE);
            (spatial_twist(&b, db, turn), 0.0)
        }
    }
}

/// Lever of a screw, and how it changes.
fn lever_rate(elastics: &Elastics, placements: &Placements, actuator: usize, motion: &Motion) -> (f64, f64) {
    let (model, values, joints) = (elastics.model, elastics.values(), &placements.joints);
    let rate = (motion.joints)(model.actuators[actuator].joint);
    let rate = screw::triangle_rate(model, actuator, motion.by, rate);
    (screw::lever(model, values, actuator, joints), screw::lever_rate(model, values, actuator, joints, &rate))
}

/// Spatial cross product of twists.
fn crm(xi: &Vector6<f64>, t: &Vector6<f64>) -> Vector6<f64> {
    let (v, w) = (xi.fixed_rows::<3>(0), xi.fixed_rows::<3>(3));
    let (tv, tw) = (t.fixed_rows::<3>(0), t.fixed_rows::<3>(3));
    let (a, b) = (w.cross(&tv) + v.cross(&tw), w.cross(&tw));
    Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
}

/// Spatial cross product of a twist and a wrench.
fn crf(xi: &Vector6<f64>, f: &Vector6<f64>) -> Vector6<f64> {
    let (v, w) = (xi.fixed_rows::<3>(0), xi.fixed_rows::<3>(3));
    let (force, moment) = (f.fixed_rows::<3>(0), f.fixed_rows::<3>(3));
    let (a, b) = (w.cross(&force), w.cross(&moment) + v.cross(&force));
    Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
}
