//! Springs of a description, and how stiff and heavy a simulation makes what has neither stiffness nor inertia.
//!
//! What moves or gives has an inertia of its own of TIME^2 times its stiffness (MuJoCo's `armature`, which weighs
//! nothing and leaves statics as they are), and is damped critically with it. Then nothing in the model is faster than `TIME`,
//! explicit steps of `STEP` are stable whatever the stiffness, and constraints, whose softness MuJoCo scales with
//! inertias, hold links that have no mass. Vibrations slower than 1 / (2 pi TIME) = 32 Hz are little changed.

use crate::description::elastic::{JointStiffness, Spring, Stiffness, own_axis};
use crate::description::frame::{FrameIndex, Motion};
use crate::description::raw::{JointKind, SpringAction};
use crate::description::robot::{Robot, SliderCrank};
use crate::parameter::Kind;

/// Time of the fastest motion, s.
pub(super) const TIME: f64 = 0.005;
/// Time step, s.
pub(super) const STEP: f64 = 0.001;
/// How much stiffer a position actuator is than the stiffest spring.
const STIFFER: f64 = 1e4;
/// Stiffness that stands for springs where the robot has none, N.m/rad (N/m).
const RIGID: f64 = 1e8;

/// Stiffness of springs of a robot.
pub(super) struct Scale {
    /// Least of all.
    softest: f64,
    /// Greatest of those along, and about, an axis.
    stiffest: [f64; 2],
}

/// A position actuator.
#[derive(Clone, Copy)]
pub(super) struct Servo {
    /// N.m/rad, N/m
    pub gain: f64,
    /// N.m.s/rad, N.s/m
    pub damping: f64,
    /// Inertia of its joint, kg.m2 (kg).
    pub armature: f64,
}

impl Servo {
    /// Of a gain, on a joint that moves it by `lever`, m/rad (1).
    fn new(gain: f64, lever: f64) -> Self {
        Self { gain, damping: 2.0 * TIME * gain, armature: TIME * TIME * gain * lever * lever }
    }
}

impl Scale {
    pub fn of(robot: &Robot) -> Self {
        let joints = robot.elastic.joints.iter().flat_map(|joint| directions(robot, joint));
        let mut scale = Self { softest: f64::INFINITY, stiffest: [0.0; 2] };
        for (direction, _, stiffness) in joints.chain(pedestal(robot)) {
            let greatest = &mut scale.stiffest[usize::from(direction >= 3)];
            *greatest = greatest.max(stiffness);
            scale.softest = scale.softest.min(stiffness);
        }
        if !scale.softest.is_finite() {
            scale.softest = RIGID;
        }
        scale.stiffest.iter_mut().filter(|stiffness| **stiffness == 0.0).for_each(|none| *none = RIGID);
        scale
    }

    /// Inertia of a joint that nothing drives, kg.m2 (kg).
    pub fn passive(&self) -> f64 {
        TIME * TIME * self.softest
    }

    /// What drives a joint of this kind.
    pub fn servo(&self, joint: JointKind) -> Servo {
        let [along, about] = self.stiffest;
        Servo::new(STIFFER * if joint == JointKind::Prismatic { along } else { about }, 1.0)
    }

    /// What drives a screw: its axial spring if it has one. Its lever is at most the shorter of its two arms.
    pub fn screw(&self, robot: &Robot, which: usize, screw: &SliderCrank) -> Servo {
        let [_, _, _, l1, l3] = screw.constants;
        let lever = l1.min(l3);
        let axial = robot.elastic.screws.get(&which).filter(|own| is_soft(&own.axial));
        let rigid = STIFFER * self.stiffest[1] / (lever * lever);
        Servo::new(axial.map_or(rigid, |own| stiffness(&own.axial)), lever)
    }
}

/// Direction (along x, y, z, about x, y, z), symbol and stiffness of the springs in series with a joint.
pub(super) fn directions(robot: &Robot, joint: &JointStiffness) -> Vec<(usize, String, f64)> {
    let held = crate::description::parameters::joint_directions(|spring| joint.springs[spring].is_some());
    let own = held.into_iter().enumerate().filter_map(|(direction, spring)| {
        let across = ["x", "y", "", "x", "y", ""][direction];
        let symbol = ["ka", "kr", "kar", "krr", "kr", "kr", "krr", "krr"][spring];
        let given = joint.springs[spring].filter(is_soft)?;
        (parallel(robot, joint.frame) != Some(spring))
            .then(|| (direction, format!("{symbol}{across}"), stiffness(&given)))
    });
    own.collect()
}

/// The spring of a passive joint that acts in parallel, not in series: without force wherever the loop puts the joint.
pub(super) fn parallel(robot: &Robot, joint: FrameIndex) -> Option<usize> {
    let frame = robot.frames.get(joint).filter(|frame| frame.motion == Motion::Passive)?;
    Some(own_axis(frame.joint))
}

/// The same of the pedestal.
pub(super) fn pedestal(robot: &Robot) -> Vec<(usize, String, f64)> {
    let own = robot.elastic.base.iter().zip(crate::description::elastic::BASE_SYMBOLS).enumerate();
    let own =
        own.filter_map(|(k, (spring, symbol))| Some((k, symbol.to_string(), stiffness(&(*spring).filter(is_soft)?))));
    own.collect()
}

/// Whether MuJoCo can hold a spring between bodies: one that has a length without force.
pub(super) fn is_held(spring: &Spring) -> bool {
    spring.acts == SpringAction::Full && spring.free_length.is_some() && is_soft(&spring.rate)
}

/// Neither rigid nor absent.
pub(super) fn is_soft(spring: &Stiffness) -> bool {
    let stiffness = stiffness(spring);
    stiffness > 0.0 && stiffness.is_finite()
}

/// N/m or N.m/rad.
pub(super) fn stiffness(spring: &Stiffness) -> f64 {
    match spring.kind {
        Kind::LinearCompliance | Kind::RotationalCompliance => 1.0 / spring.nominal,
        _ => spring.nominal,
    }
}
