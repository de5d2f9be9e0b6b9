//! Assembly of loops where their branch is declared: the joints at which they close there, from the description's guess.

use super::assembly_error::{AssemblyError, Gap};
use super::closure::{ANYHOW, ClosedLoops, Role, Scratch};
use super::constants::Constants;
use super::planar::GroundLink;
use crate::description::raw::LoopKind;
use crate::description::robot::FrameIndex;
use crate::model::{LoopGroup, LoopPlan, Stage};

impl ClosedLoops {
    /// Assembles the loops at the configuration at which the branch was declared.
    pub fn assemble(constants: &Constants, earlier: &[Self], group: &LoopGroup) -> Result<Self, AssemblyError> {
        let planar = |plan: &LoopPlan| (plan.kind == LoopKind::Planar).then(|| GroundLink::new(constants, plan));
        let grounds = group.loops.iter().map(planar).collect();
        let mut closed = Self {
            group: group.clone(),
            grounds,
            reference: group.guess.clone(),
            inputs: Vec::new(),
            determinant: 1.0,
            jacobian: Vec::new(),
            rates: Vec::new(),
            open: Gap::default(),
            roles: roles(constants.model.frames.len(), group),
        };
        let mut joints = Vec::new();
        constants.direct_joints(&group.at, &mut joints);
        let mut scratch = Scratch::default();
        let mut earlier = earlier.iter();
        for stage in &constants.model.stages {
            match stage {
                Stage::Loops(other) if other.unknowns == group.unknowns => break,
                Stage::Loops(_) => {
                    if let Some(other) = earlier.next() {
                        other.close(constants, &mut joints, &mut scratch)?;
                    }
                }
                stage => constants.follow(stage, &group.at, &mut joints)?,
            }
        }
        closed.inputs = group.inputs.iter().map(|&frame| joints[frame]).collect();
        for (&frame, &guess) in group.unknowns.iter().zip(&group.guess) {
            joints[frame] = guess;
        }
        match closed.newton(constants, &mut joints, ANYHOW, &mut scratch) {
            Ok(determinant) => {
                closed.determinant = determinant;
                closed.reference = group.unknowns.iter().map(|&frame| joints[frame]).collect();
                closed.open = closed.evaluate(constants, &joints, &mut scratch);
                if group.equations > group.unknowns.len() {
                    closed.jacobian.clone_from(&scratch.matrix);
                    closed.determinant = 1.0;
                    closed.determinant = closed.quality(0.0, &scratch.matrix);
                }
                closed.rates_by_inputs(constants, &joints, &mut scratch);
                Ok(closed)
            }
            Err(gap) => Err(closed.failure(gap, " where its branch is declared")),
        }
    }
}

impl ClosedLoops {
    /// The joints found: a loop that holds each, its frame, its declared and its found value.
    pub(super) fn assembled(&self) -> impl Iterator<Item = (&str, FrameIndex, [f64; 2])> {
        let found = self.group.guess.iter().zip(&self.reference).map(|(guess, found)| [*guess, *found]);
        self.group.unknowns.iter().zip(found).filter_map(|(&frame, values)| {
            let is_in = |plan: &&LoopPlan| plan.branches.iter().any(|branch| branch.contains(&frame));
            Some((self.group.loops.iter().find(is_in)?.name.as_str(), frame, values))
        })
    }
}

/// What each frame's joint is to a group of loops.
fn roles(frames: usize, group: &LoopGroup) -> Vec<Role> {
    let mut roles = vec![Role::Neither; frames];
    group.inputs.iter().enumerate().for_each(|(k, &frame)| roles[frame] = Role::Input(k));
    group.unknowns.iter().enumerate().for_each(|(k, &frame)| roles[frame] = Role::Unknown(k));
    roles
}
