//! Loads on the joints of the coordinates, variables and what follows them, by virtual work: torques (N.m) and forces (N).

use nalgebra::Vector3;

use super::frame_twists::{FrameTwistPlan, FrameTwists};
use super::mechanics::{LoadedPoint, Mechanics, State};
use crate::description::raw::JointKind;
use crate::description::robot::FrameIndex;
use crate::elastics::Elastics;
use crate::elements::VertexIndex;
use crate::kinematics::{By, shift};
use crate::model::{Model, Spot, Structure};
use crate::parameter::Slot;

/// Masses and frames whose motions the loads are computed from.
#[derive(Debug, Clone)]
pub struct JointLoadPlan {
    twists: FrameTwistPlan,
    /// Frame, kg, centre in the frame.
    masses: Vec<(FrameIndex, f64, Vector3<f64>)>,
    /// For each coordinate the joint that it drives; none of those that follow others, whose load is that of the joint.
    driven: Vec<Option<FrameIndex>>,
    /// Columns of variables from which those of followers are taken, times a factor: the controller couples these, and an error of the
    /// joint does not move them.
    apart: Vec<(usize, usize, f64)>,
}

/// Loads on the joints at one configuration. Reused between configurations: nothing is allocated.
#[derive(Debug, Clone, Default)]
pub struct JointLoads {
    /// How measured frames and those with masses move with the coordinates, then with the parameters asked for.
    pub twists: FrameTwists,
    /// Under own weight alone, by coordinate.
    pub own: Vec<f64>,
    /// Under own weight and the wrench of [`JointLoadPlan::load`], by coordinate.
    pub total: Vec<f64>,
    /// Joint per coordinate: +1 or -1, or the turn of a joint per stroke of its screw.
    pub joint_rate: Vec<f64>,
}

impl JointLoadPlan {
    /// Loads of wrenches on `frames`; their columns are made by `slots` too.
    pub fn new(mechanics: &Mechanics, mut frames: Vec<FrameIndex>, slots: &[Slot]) -> Self {
        let model = mechanics.geometry.model;
        let variables = model.variables.len();
        let masses = masses(model, mechanics.geometry.values());
        frames.extend(masses.iter().map(|(frame, ..)| *frame));
        let all = model.followers();
        let apart = all
            .iter()
            .enumerate()
            .flat_map(|(k, own)| own.only_commanded().map(move |(factor, variable)| (variable, variables + k, factor)));
        let apart = apart.collect();
        let followers: Vec<Slot> = all.iter().map(|own| model.frames[own.joint].moving_slot()).collect();
        let slots = followers.iter().chain(slots).map(|&slot| By::Slot(slot));
        let by: Vec<By> = (0..variables).map(By::Variable).chain(slots).collect();
        let mut driven: Vec<Option<FrameIndex>> = (0..variables).map(|variable| model.joint_of(variable)).collect();
        driven.resize(variables + followers.len(), None);
        Self { twists: mechanics.twist_plan(frames, &by), masses, driven, apart }
    }

    /// Workspace for one thread.
    pub fn loads(&self) -> JointLoads {
        let zeros = vec![0.0; self.driven.len()];
        JointLoads { twists: self.twists.twists(), own: zeros.clone(), total: zeros.clone(), joint_rate: zeros }
    }

    /// Loads under own weight at a placed configuration.
    pub fn place(&self, mechanics: &Mechanics, state: &mut State, out: &mut JointLoads) {
        mechanics.evaluate_rates(state);
        mechanics.evaluate_twists(state, &self.twists, None, &mut out.twists);
        self.apart.iter().for_each(|&(own, other, factor)| out.twists.take_from(own, other, factor));
        out.own.fill(0.0);
        let gravity = mechanics.geometry.model.structure.gravity;
        for &(frame, mass, centre) in &self.masses {
            let arm = state.placements.frames[frame].rotation * centre;
            for (load, column) in out.own.iter_mut().zip(out.twists.of(frame)) {
                *load += shift(column, &arm).dot(&gravity) * mass;
            }
        }
        // Loads as torques of the joints: a screw's variable is its length.
        for (variable, driven) in self.driven.iter().enumerate() {
            let rate = driven.map_or(1.0, |joint| state.rates().rate(joint, variable));
            out.joint_rate[variable] = if rate.abs() > 1e-9 { rate } else { 1.0 };
            out.own[variable] /= out.joint_rate[variable];
        }
    }

    /// Adds the wrench on a point to the loads under own weight.
    pub fn load(&self, state: &State, point: &LoadedPoint, out: &mut JointLoads) {
        let arm = state.placements.frames[point.at.frame].rotation * point.at.point;
        for (variable, column) in out.twists.of(point.at.frame).iter().take(self.driven.len()).enumerate() {
            let turn = Vector3::new(column[3], column[4], column[5]);
            let applied = shift(column, &arm).dot(&point.force) + turn.dot(&point.moment);
            out.total[variable] = out.own[variable] + applied / out.joint_rate[variable];
        }
    }
}

/// A mass as frame, kg and point in the frame.
pub(super) type Mass = (FrameIndex, f64, Vector3<f64>);

/// Masses as frame, kg and point in the frame: bodies, and beams at their middles; a boom that slides at its two ends, as heavy
/// as it is in the middle of its way.
pub(crate) fn masses(model: &Model, values: &[f64]) -> Vec<(FrameIndex, f64, Vector3<f64>)> {
    let structure = &model.structure;
    let bodies = structure.masses.iter().map(|mass| {
        let v = &values[mass.slot..mass.slot + 4];
        (mass.frame, v[0], Vector3::new(v[1], v[2], v[3]))
    });
    let elastics = Elastics::new(model, values, &[]);
    let body = |mut frame: FrameIndex| {
        while frame != 0 && model.frames[frame].joint == JointKind::Fixed {
            frame = model.frames[frame].antecedent;
        }
        frame
    };
    let beams = elastics.masses_per_length().iter().flat_map(|(ends, per_length)| {
        let [a, b] = ends.map(|end| structure.at_home(end));
        let mass = per_length * (b - a).norm();
        let parts: Vec<Mass> = ends.iter().flat_map(|&end| at_ends(structure, end, 0.5 * mass)).collect();
        let alike = parts.iter().all(|part| parts.first().is_some_and(|first| body(first.0) == body(part.0)));
        match structure.frame_of(*ends).filter(|_| alike) {
            Some(frame) => {
                let middle = structure.home[frame].inverse() * nalgebra::Point3::from(0.5 * (a + b));
                vec![(frame, mass, middle.coords)]
            }
            None if alike => Vec::new(),
            None => parts,
        }
    });
    bodies.chain(beams).filter(|(_, mass, _)| *mass != 0.0).collect()
}

/// A mass at a vertex, shared out to the frames with which it moves.
fn at_ends(structure: &Structure, vertex: VertexIndex, mass: f64) -> Vec<Mass> {
    match structure.vertices[vertex].spot {
        Spot::At(frame, point) => vec![(frame, mass, point)],
        Spot::Between([a, b], share) => {
            let mut all = at_ends(structure, a, (1.0 - share) * mass);
            all.extend(at_ends(structure, b, share * mass));
            all
        }
    }
}
