//! Generic loop closure: Newton on the cut joints, from the declared branch, with continuation where it is far.

use super::assembly_error::AssemblyError;
use super::constants::Constants;
use super::linearisation::Linearisation;
use super::planar::GroundLink;
use super::{linear, planar, spatial};
use crate::description::raw::LoopKind;
use crate::description::robot::FrameIndex;
use crate::model::{LoopGroup, Stage};

/// Workspace of a closure.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    pub linearisation: Linearisation,
    matrix: Vec<f64>,
    residual: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
    inputs: Vec<f64>,
}

/// Loops that are closed together, assembled once on their declared branch.
#[derive(Debug, Clone)]
pub struct ClosedLoops {
    group: LoopGroup,
    grounds: Vec<Option<GroundLink>>,
    /// Joints (unknowns) at the reference configuration.
    reference: Vec<f64>,
    /// Inputs at the reference configuration.
    inputs: Vec<f64>,
    /// Sign of the closure's determinant on the declared branch; of an over-constrained closure, of its Jacobian's
    /// against that of the reference, which is +1 by definition.
    sign: f64,
    /// Jacobian at the reference, where there are more equations than unknowns; empty otherwise.
    jacobian: Vec<f64>,
}

const MAX_ITERATIONS: usize = 60;
/// A Newton step below this (rad or m) leaves an error of its square.
const SMALL_STEP: f64 = 1e-8;
/// Residual (m or rad) below which a loop is closed.
const CLOSED: f64 = 1e-9;

impl ClosedLoops {
    /// Assembles the loops at the configuration at which the branch was declared.
    pub fn assemble(constants: &Constants, earlier: &[Self], group: &LoopGroup) -> Result<Self, AssemblyError> {
        let planar =
            |plan: &crate::model::LoopPlan| (plan.kind == LoopKind::Planar).then(|| GroundLink::new(constants, plan));
        let grounds = group.loops.iter().map(planar).collect();
        let mut closed = Self {
            group: group.clone(),
            grounds,
            reference: group.guess.clone(),
            inputs: Vec::new(),
            sign: 0.0,
            jacobian: Vec::new(),
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
        match closed.newton(constants, &mut joints, &mut scratch) {
            Ok(sign) => {
                closed.sign = sign;
                closed.reference = group.unknowns.iter().map(|&frame| joints[frame]).collect();
                if group.equations > group.unknowns.len() {
                    closed.evaluate(constants, &joints, &mut scratch);
                    closed.jacobian = scratch.matrix;
                    closed.sign = 1.0;
                }
                Ok(closed)
            }
            Err(gap) => Err(closed.failure(gap, " where its branch is declared")),
        }
    }

    fn failure(&self, gap: f64, branch: &'static str) -> AssemblyError {
        let mut names = self.group.loops.iter().map(|plan| plan.name.clone());
        AssemblyError::Loop { name: names.next().unwrap_or_default(), others: names.collect(), gap, branch }
    }

    /// The loops' plan.
    pub fn group(&self) -> &LoopGroup {
        &self.group
    }

    /// Finds the passive joints for given other joints, on the declared branch: Newton from the reference, and where
    /// that fails or ends on another branch, by continuation from it in smaller and smaller steps.
    pub fn close(&self, constants: &Constants, joints: &mut [f64], scratch: &mut Scratch) -> Result<(), AssemblyError> {
        self.set(&self.group.unknowns, &self.reference, joints);
        if self.newton(constants, joints, scratch).is_ok_and(|sign| sign == self.sign) {
            return Ok(());
        }
        let mut target = std::mem::take(&mut scratch.inputs);
        target.clear();
        target.extend(self.group.inputs.iter().map(|&frame| joints[frame]));
        let result = self.continuation(constants, &target, joints, scratch);
        self.set(&self.group.inputs, &target, joints);
        scratch.inputs = target;
        // From where the branch ends, the gap that stays for the joints asked for.
        result.map_err(|gap| match self.newton(constants, joints, scratch) {
            Err(gap) => self.failure(gap, ""),
            Ok(_) => self.failure(gap, " on its declared branch"),
        })
    }

    /// The determinant's sign, from what a solve found: see [`ClosedLoops::sign`].
    fn branch(&self, sign: f64, matrix: &[f64]) -> f64 {
        if self.jacobian.is_empty() {
            return sign;
        }
        let (rows, columns) = (self.group.equations, self.group.unknowns.len());
        let reference = nalgebra::DMatrix::from_row_slice(rows, columns, &self.jacobian);
        reference.tr_mul(&nalgebra::DMatrix::from_row_slice(rows, columns, matrix)).determinant().signum()
    }

    fn set(&self, frames: &[FrameIndex], values: &[f64], joints: &mut [f64]) {
        for (&frame, &value) in frames.iter().zip(values) {
            joints[frame] = value;
        }
    }

    fn continuation(
        &self,
        constants: &Constants,
        target: &[f64],
        joints: &mut [f64],
        scratch: &mut Scratch,
    ) -> Result<(), f64> {
        self.set(&self.group.unknowns, &self.reference, joints);
        let mut good = self.reference.clone();
        let (mut done, mut step) = (0.0, 0.25);
        let mut gap = f64::INFINITY;
        while done < 1.0 {
            let next = f64::min(done + step, 1.0);
            for ((&frame, from), to) in self.group.inputs.iter().zip(&self.inputs).zip(target) {
                joints[frame] = from + next * (to - from);
            }
            self.set(&self.group.unknowns, &good, joints);
            match self.newton(constants, joints, scratch) {
                Ok(sign) if sign == self.sign => {
                    done = next;
                    step *= 1.5;
                    for (value, &frame) in good.iter_mut().zip(&self.group.unknowns) {
                        *value = joints[frame];
                    }
                }
                outcome => {
                    gap = outcome.err().unwrap_or(gap);
                    step *= 0.5;
                    if step < 1e-3 {
                        self.set(&self.group.unknowns, &good, joints);
                        return Err(if gap.is_finite() { gap } else { 0.0 });
                    }
                }
            }
        }
        Ok(())
    }

    /// Newton with step halving on the unknowns in `joints`; the determinant's sign, or the gap that stays.
    fn newton(&self, constants: &Constants, joints: &mut [f64], scratch: &mut Scratch) -> Result<f64, f64> {
        let n = self.group.unknowns.len();
        let mut best = self.evaluate(constants, joints, scratch);
        for _ in 0..MAX_ITERATIONS {
            scratch.step.resize(n, 0.0);
            let Some(sign) =
                linear::solve(&scratch.matrix, &scratch.residual, self.group.equations, n, &mut scratch.step)
            else {
                return Err(best);
            };
            let largest = scratch.step.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
            // Angles must not leap to another branch.
            let mut factor = f64::min(1.0, 0.7 / largest.max(1e-300));
            scratch.trial.clear();
            scratch.trial.extend(self.group.unknowns.iter().map(|&frame| joints[frame]));
            let mut gap = f64::INFINITY;
            for _ in 0..12 {
                for (k, &frame) in self.group.unknowns.iter().enumerate() {
                    joints[frame] = scratch.trial[k] - factor * scratch.step[k];
                }
                if factor == 1.0 && largest < SMALL_STEP {
                    // Quadratic convergence: what is left is the step's square. Over-constrained loops keep their gap.
                    return if best < CLOSED || best <= self.group.gap || self.group.equations == n && best < 1e-6 {
                        Ok(self.branch(sign, &scratch.matrix))
                    } else {
                        Err(best)
                    };
                }
                gap = self.evaluate(constants, joints, scratch);
                if gap < best || gap < CLOSED {
                    break;
                }
                factor *= 0.5;
            }
            if !(gap < best || gap < CLOSED || gap <= self.group.gap) {
                return Err(best);
            }
            best = gap;
        }
        Err(best)
    }

    /// Residual (returned as its largest component) and Jacobian by the unknowns, into the scratch.
    fn evaluate(&self, constants: &Constants, joints: &[f64], scratch: &mut Scratch) -> f64 {
        let n = self.group.unknowns.len();
        scratch.matrix.clear();
        scratch.matrix.resize(self.group.equations * n, 0.0);
        scratch.residual.clear();
        scratch.residual.resize(self.group.equations, 0.0);
        for at in 0..self.group.loops.len() {
            let plan = &self.group.loops[at];
            self.linearise(constants, at, joints, false, &mut scratch.linearisation);
            let found = &scratch.linearisation;
            scratch.residual[plan.row..plan.row + found.rows].copy_from_slice(&found.residual[..found.rows]);
            for (frame, column) in &found.joints {
                if let Some(k) = self.group.unknowns.iter().position(|unknown| unknown == frame) {
                    for (row, value) in column[..found.rows].iter().enumerate() {
                        scratch.matrix[(plan.row + row) * n + k] += value;
                    }
                }
            }
        }
        scratch.residual.iter().fold(0.0, |m, r| if r.is_nan() { f64::INFINITY } else { m.max(r.abs()) })
    }

    /// Residual and derivatives of one loop of the group.
    pub fn linearise(&self, constants: &Constants, at: usize, joints: &[f64], slots: bool, out: &mut Linearisation) {
        out.joints.clear();
        out.slots.clear();
        let plan = &self.group.loops[at];
        match &self.grounds[at] {
            Some(ground) => planar::linearise(constants, plan, ground, joints, slots, out),
            None => spatial::linearise(constants, plan, joints, slots, out),
        }
    }
}
