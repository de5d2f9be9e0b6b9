//! Generic loop closure: Newton on the cut joints, from the declared branch. Whether what it finds belongs to that branch
//! is the matter of [`super::branch`].

use super::assembly_error::{AssemblyError, Gap};
use super::constants::Constants;
use super::linearisation::Linearisation;
use super::planar::GroundLink;
use super::{linear, planar, spatial};
use crate::description::raw::LoopKind;
use crate::description::robot::FrameIndex;
use crate::model::LoopGroup;

/// Workspace of a closure.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    pub linearisation: Linearisation,
    pub(super) matrix: Vec<f64>,
    pub(super) residual: Vec<f64>,
    pub(super) step: Vec<f64>,
    trial: Vec<f64>,
    /// Change of the inputs along the way that is followed.
    pub(super) direction: Vec<f64>,
    /// How the residual changes with the inputs along that way, the unknowns held.
    pub(super) drive: Vec<f64>,
    /// Ends of a stride along that way.
    pub(super) from: Node,
    pub(super) to: Node,
    /// Inputs for which the loops are being closed.
    pub(super) target: Vec<f64>,
    /// Unknowns as they were found first.
    pub(super) found: Vec<f64>,
    /// Values by which loops were closed last, and where.
    pub(super) values: Vec<f64>,
    pub(super) last: Vec<Last>,
}

/// Where a group of loops was closed last.
#[derive(Debug, Clone, Default)]
pub struct Last {
    /// Its unknowns.
    pub unknowns: Vec<FrameIndex>,
    /// Their values.
    pub values: Vec<f64>,
    /// Values of its inputs.
    pub inputs: Vec<f64>,
}

/// A position on the way that is followed.
#[derive(Debug, Clone, Default)]
pub struct Node {
    /// Share of the way.
    pub share: f64,
    /// Unknowns there.
    pub unknowns: Vec<f64>,
    /// How they change with the share.
    pub tangent: Vec<f64>,
}

/// Loops that are closed together, assembled once on their declared branch.
#[derive(Debug, Clone)]
pub struct ClosedLoops {
    pub(super) group: LoopGroup,
    pub(super) grounds: Vec<Option<GroundLink>>,
    /// Joints (unknowns) at the reference configuration.
    pub(super) reference: Vec<f64>,
    /// Inputs at the reference configuration.
    pub(super) inputs: Vec<f64>,
    /// The closure's determinant at the reference; of an over-constrained closure, of its Jacobian times the transpose of
    /// that at the reference.
    pub(super) determinant: f64,
    /// Jacobian at the reference, where there are more equations than unknowns; empty otherwise.
    pub(super) jacobian: Vec<f64>,
    /// Change of the unknowns at the reference by each input, row-major: unknowns x inputs.
    pub(super) rates: Vec<f64>,
    /// Gap that stays at the reference.
    pub(super) open: Gap,
    /// What each frame's joint is to these loops.
    pub(super) roles: Vec<Role>,
}

/// What a joint is to loops that are closed together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// The unknown of this number.
    Unknown(usize),
    /// The input of this number.
    Input(usize),
    /// It does not move them.
    Neither,
}

/// Most steps of Newton's method, and how often one is halved: as many as may help from afar.
pub(super) const ANYHOW: [usize; 2] = [60, 12];
/// A Newton step below this (rad or m) leaves an error of its square.
const SMALL_STEP: f64 = 1e-8;
/// Residual (m or rad) below which a loop is closed.
const CLOSED: f64 = 1e-9;

impl ClosedLoops {
    pub(super) fn failure(&self, gap: Gap, branch: &'static str) -> AssemblyError {
        let mut names = self.group.loops.iter().map(|plan| plan.name.clone());
        AssemblyError::Loop { name: names.next().unwrap_or_default(), others: names.collect(), gap, branch }
    }

    /// The gap that stays where the branch is declared, with the name of the (first) loop.
    pub fn open(&self) -> (&str, Gap) {
        (self.group.loops.first().map_or("", |plan| &plan.name), self.open)
    }

    /// The loops' plan.
    pub fn group(&self) -> &LoopGroup {
        &self.group
    }

    /// The closure's determinant over that at the reference, from the determinant that a solve found and its matrix: 1 at
    /// the reference, 0 at a singular position, negative on the other side of one.
    pub(super) fn quality(&self, determinant: f64, matrix: &[f64]) -> f64 {
        if self.jacobian.is_empty() {
            return determinant / self.determinant;
        }
        let (rows, columns) = (self.group.equations, self.group.unknowns.len());
        let reference = nalgebra::DMatrix::from_row_slice(rows, columns, &self.jacobian);
        let product = reference.tr_mul(&nalgebra::DMatrix::from_row_slice(rows, columns, matrix));
        product.determinant() / self.determinant
    }

    pub(super) fn set(&self, frames: &[FrameIndex], values: &[f64], joints: &mut [f64]) {
        for (&frame, &value) in frames.iter().zip(values) {
            joints[frame] = value;
        }
    }

    /// Newton with step halving on the unknowns in `joints`; the determinant over that at the reference, or the gap that
    /// stays. The scratch then holds the closure's matrix and drive where the loops are closed.
    pub(super) fn newton(
        &self,
        constants: &Constants,
        joints: &mut [f64],
        [steps, halvings]: [usize; 2],
        scratch: &mut Scratch,
    ) -> Result<f64, Gap> {
        let n = self.group.unknowns.len();
        let mut best = self.evaluate(constants, joints, scratch);
        for _ in 0..steps {
            scratch.step.resize(n, 0.0);
            let Some(determinant) =
                linear::solve(&scratch.matrix, &scratch.residual, self.group.equations, n, &mut scratch.step)
            else {
                return Err(best);
            };
            let largest = scratch.step.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
            // Angles must not leap to another branch.
            let mut factor = f64::min(1.0, 0.7 / largest.max(1e-300));
            scratch.trial.clear();
            scratch.trial.extend(self.group.unknowns.iter().map(|&frame| joints[frame]));
            let mut gap = Gap { length: f64::INFINITY, angle: 0.0 };
            let is_closer = |gap: &Gap, best: &Gap| {
                let gap = gap.greatest();
                gap < best.greatest() || gap < CLOSED || gap <= self.group.gap
            };
            for _ in 0..halvings {
                for (k, &frame) in self.group.unknowns.iter().enumerate() {
                    joints[frame] = scratch.trial[k] - factor * scratch.step[k];
                }
                if factor == 1.0 && largest < SMALL_STEP {
                    // Quadratic convergence: what is left is the step's square. Over-constrained loops keep their gap.
                    let left = best.greatest();
                    return if left < CLOSED || left <= self.group.gap || self.group.equations == n && left < 1e-6 {
                        Ok(self.quality(determinant, &scratch.matrix))
                    } else {
                        Err(best)
                    };
                }
                gap = self.evaluate(constants, joints, scratch);
                // What no unknown moves stays, and hides how much closer the rest is.
                if is_closer(&gap, &best) {
                    break;
                }
                factor *= 0.5;
            }
            if !is_closer(&gap, &best) {
                return Err(best);
            }
            best = gap;
        }
        Err(best)
    }

    /// Residual (returned as its largest components) and Jacobian by the unknowns, into the scratch.
    pub(super) fn evaluate(&self, constants: &Constants, joints: &[f64], scratch: &mut Scratch) -> Gap {
        let n = self.group.unknowns.len();
        scratch.matrix.clear();
        scratch.matrix.resize(self.group.equations * n, 0.0);
        scratch.residual.clear();
        scratch.residual.resize(self.group.equations, 0.0);
        scratch.drive.clear();
        scratch.drive.resize(self.group.equations, 0.0);
        let mut gap = Gap::default();
        for at in 0..self.group.loops.len() {
            let plan = &self.group.loops[at];
            // Components of a position first, then those of a rotation.
            let lengths = if plan.kind == LoopKind::Planar { 2 } else { 3 };
            self.linearise(constants, at, joints, false, &mut scratch.linearisation);
            let found = &scratch.linearisation;
            let residual = &found.residual[..found.rows];
            residual.iter().enumerate().for_each(|(k, component)| gap.add(*component, k >= lengths));
            scratch.residual[plan.row..plan.row + found.rows].copy_from_slice(residual);
            for (frame, column) in &found.joints {
                let rows = column[..found.rows].iter().enumerate();
                match self.roles[*frame] {
                    Role::Unknown(k) => rows.for_each(|(row, value)| scratch.matrix[(plan.row + row) * n + k] += value),
                    Role::Input(k) => {
                        let rate = scratch.direction.get(k).copied().unwrap_or_default();
                        rows.for_each(|(row, value)| scratch.drive[plan.row + row] += value * rate);
                    }
                    Role::Neither => {}
                }
            }
        }
        gap
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
