//! Follows the assembly branch on which a loop was declared.
//!
//! Where two assemblies meet (a flat parallelogram, a stretched or folded pair of links) the closure's determinant is zero, and
//! Newton's method may come out on either. So what it finds counts only where a smooth way leads to it from the declared
//! assembly without such a position: checked in one stride where the joints bend little, else followed in shorter ones
//! (Allgower and Georg 1990, predictor and corrector). What lies behind such a position is refused, because errors of the
//! links far below a tolerance decide which assembly a real linkage takes there.

use super::assembly_error::{AssemblyError, At, Gap};
use super::closure::{ANYHOW, ClosedLoops, Last, Scratch};
use super::constants::Constants;
use super::linear;
use crate::description::raw::JointKind;
use crate::description::robot::FrameIndex;

/// Determinant, as a share of that where the branch is declared, below which a position counts as singular: of a pair of
/// links about 4 deg short of flat. Nearer, errors of 0.25 % of a length decide on which branch the linkage goes on: a
/// parallelogram with one side longer by 0.2 % passes its flat position smoothly, 3.6 deg short of it, and comes out crossed.
/// Designers keep 30 deg and more.
const NEAR: f64 = 0.07;
/// Shares of a stride at which it is checked. At three, a kink anywhere in it shows at one.
const CHECKED: [f64; 3] = [0.25, 0.5, 0.75];
/// How far the unknowns may be from the curve through a stride's ends and their rates, as a share of what they move: a kink
/// anywhere in it, at which they stop or turn back, is off by 2.6 % and more.
const SMOOTH: f64 = 0.02;
/// Movement of the unknowns (rad or m) that needs no check.
const STILL: f64 = 1e-7;
/// Shortest stride, as a share of the way: a tenth of the sharpest bend that is not singular.
const LEAST: f64 = 1e-3;
/// Newton's steps in a stride, which begins near its end; more are needed only where it leads nowhere.
const STEPS: usize = 8;
/// Movement of an input (rad or m) up to which a position is near enough to step on to.
const NEARBY: f64 = 0.5;
/// What unknowns (rad or m) are rounded to before they are found for the last time: far above what different ways leave, and
/// near enough for two steps of Newton's method.
const COARSE: f64 = 1e-6;
/// Gap (m or rad) at a singular position above which the loop is out of reach there, and not only singular.
const OPEN: f64 = 1e-6;

/// Where the branch ended: inputs and unknowns of the last position that is surely on it.
struct Lost {
    inputs: Vec<f64>,
    unknowns: Vec<f64>,
}

impl ClosedLoops {
    /// Finds the passive joints for given other joints, on the declared branch.
    ///
    /// # Errors
    /// [`AssemblyError::Loop`] if the loops are out of reach there, [`AssemblyError::Singular`] if the declared branch
    /// does not lead there.
    pub fn close(&self, constants: &Constants, joints: &mut [f64], scratch: &mut Scratch) -> Result<(), AssemblyError> {
        let mut target = std::mem::take(&mut scratch.target);
        target.clear();
        target.extend(self.group.inputs.iter().map(|&frame| joints[frame]));
        let found = match self.step_from_last(constants, joints, scratch) {
            true => Ok(()),
            false => self.go_from_reference(constants, &target, joints, scratch),
        };
        self.set(&self.group.inputs, &target, joints);
        scratch.target = target;
        if found.is_ok() {
            self.settle(constants, joints, scratch);
            self.remember(constants, joints, scratch);
        }
        found
    }

    /// Closes the loops once more from their unknowns rounded, so that the last digits do not depend on the way they came.
    fn settle(&self, constants: &Constants, joints: &mut [f64], scratch: &mut Scratch) {
        let mut found = std::mem::take(&mut scratch.found);
        found.clear();
        found.extend(self.group.unknowns.iter().map(|&frame| joints[frame]));
        for &frame in &self.group.unknowns {
            joints[frame] = (joints[frame] / COARSE).round() * COARSE;
        }
        if self.newton(constants, joints, ANYHOW, scratch).is_err() {
            self.set(&self.group.unknowns, &found, joints);
        }
        scratch.found = found;
    }

    /// Goes from the declared assembly to the inputs `target`, which are in `joints`: in one stride where that is enough.
    fn go_from_reference(
        &self,
        constants: &Constants,
        target: &[f64],
        joints: &mut [f64],
        scratch: &mut Scratch,
    ) -> Result<(), AssemblyError> {
        self.set(&self.group.inputs, target, joints);
        self.turn_to(&self.inputs, joints, scratch);
        self.set(&self.group.unknowns, &self.reference, joints);
        if self.newton(constants, joints, ANYHOW, scratch).is_ok_and(|quality| quality > NEAR) {
            scratch.from.share = 0.0;
            scratch.from.unknowns.clone_from(&self.reference);
            self.tangent_at_reference(scratch);
            if self.arrive(1.0, joints, scratch) && self.is_smooth(constants, &self.inputs, joints, scratch) {
                return Ok(());
            }
        }
        self.follow(constants, target, joints, scratch)
    }

    /// Points the way from some inputs to those in `joints`.
    fn turn_to(&self, from: &[f64], joints: &[f64], scratch: &mut Scratch) {
        scratch.direction.clear();
        let inputs = self.group.inputs.iter().zip(from);
        scratch.direction.extend(inputs.map(|(&frame, from)| joints[frame] - from));
    }

    /// Steps on from where these loops were closed last, if that is near: robots are mostly asked for one place after another.
    fn step_from_last(&self, constants: &Constants, joints: &mut [f64], scratch: &mut Scratch) -> bool {
        if scratch.values != constants.values {
            scratch.last.clear();
            return false;
        }
        let Some(at) = scratch.last.iter().position(|last| last.unknowns == self.group.unknowns) else { return false };
        let last = std::mem::take(&mut scratch.last[at]);
        self.turn_to(&last.inputs, joints, scratch);
        let near = scratch.direction.iter().all(|moved| moved.abs() < NEARBY);
        let found = near && {
            self.set(&self.group.unknowns, &last.values, joints);
            self.put(&last.inputs, 0.0, joints, scratch);
            self.evaluate(constants, joints, scratch);
            let leaves = self.arrive(0.0, joints, scratch);
            std::mem::swap(&mut scratch.from, &mut scratch.to);
            leaves && self.stride(constants, &last.inputs, 1.0, joints, scratch)
        };
        scratch.last[at] = last;
        found
    }

    /// Notes where the loops are closed now, with the values by which they are.
    fn remember(&self, constants: &Constants, joints: &[f64], scratch: &mut Scratch) {
        if scratch.values != constants.values {
            scratch.values.clone_from(&constants.values);
            scratch.last.clear();
        }
        let at = scratch.last.iter().position(|last| last.unknowns == self.group.unknowns).unwrap_or_else(|| {
            scratch.last.push(Last { unknowns: self.group.unknowns.clone(), ..Last::default() });
            scratch.last.len() - 1
        });
        let last = &mut scratch.last[at];
        let values = |frames: &[FrameIndex], into: &mut Vec<f64>| {
            into.clear();
            into.extend(frames.iter().map(|&frame| joints[frame]));
        };
        values(&self.group.inputs, &mut last.inputs);
        values(&self.group.unknowns, &mut last.values);
    }

    /// Rates of the unknowns at the reference by each input.
    pub(super) fn rates_by_inputs(&mut self, constants: &Constants, joints: &[f64], scratch: &mut Scratch) {
        let (n, inputs) = (self.group.unknowns.len(), self.group.inputs.len());
        let mut rates = vec![0.0; n * inputs];
        for k in 0..inputs {
            scratch.direction.clear();
            scratch.direction.resize(inputs, 0.0);
            scratch.direction[k] = 1.0;
            self.evaluate(constants, joints, scratch);
            if self.solve_drive(scratch) {
                (0..n).for_each(|row| rates[row * inputs + k] = -scratch.step[row]);
            }
        }
        self.rates = rates;
    }

    fn tangent_at_reference(&self, scratch: &mut Scratch) {
        let inputs = self.group.inputs.len();
        let Scratch { from, direction, .. } = scratch;
        from.tangent.clear();
        from.tangent.extend((0..self.group.unknowns.len()).map(|row| -> f64 {
            let row = self.rates[row * inputs..(row + 1) * inputs].iter();
            row.zip(&*direction).map(|(rate, direction)| rate * direction).sum()
        }));
    }

    /// Solves the closure's matrix for the drive, into the scratch's step: the reverse of the tangent.
    fn solve_drive(&self, scratch: &mut Scratch) -> bool {
        let n = self.group.unknowns.len();
        scratch.step.resize(n, 0.0);
        linear::solve(&scratch.matrix, &scratch.drive, self.group.equations, n, &mut scratch.step).is_some()
    }

    /// Notes the end of a stride as it is in `joints`, after Newton's method found it; whether it has a tangent.
    fn arrive(&self, share: f64, joints: &[f64], scratch: &mut Scratch) -> bool {
        if !self.solve_drive(scratch) {
            return false;
        }
        let Scratch { to, step, .. } = scratch;
        to.share = share;
        to.unknowns.clear();
        to.unknowns.extend(self.group.unknowns.iter().map(|&frame| joints[frame]));
        to.tangent.clear();
        to.tangent.extend(step.iter().map(|step| -step));
        true
    }

    /// Whether the unknowns follow one smooth curve from the scratch's `from` to its `to`, nowhere singular. The joints are
    /// those of `to` before and after; shares count from the inputs `start`.
    fn is_smooth(&self, constants: &Constants, start: &[f64], joints: &mut [f64], scratch: &mut Scratch) -> bool {
        let (from, to) = (std::mem::take(&mut scratch.from), std::mem::take(&mut scratch.to));
        let length = to.share - from.share;
        let mut moved: f64 = 0.0;
        for k in 0..to.unknowns.len() {
            let rates = length * from.tangent[k].abs().max(to.tangent[k].abs());
            moved = moved.max((to.unknowns[k] - from.unknowns[k]).abs()).max(rates);
        }
        let mut smooth = moved.is_finite();
        if moved > STILL {
            for part in CHECKED {
                self.put(start, from.share + part * length, joints, scratch);
                // Hermite's cubic.
                let (left, right) = (1.0 - part, part);
                let (a, b) = (left * left * (1.0 + 2.0 * right), right * right * (1.0 + 2.0 * left));
                let (ta, tb) = (length * right * left * left, -length * right * right * left);
                for (k, &frame) in self.group.unknowns.iter().enumerate() {
                    joints[frame] =
                        a * from.unknowns[k] + b * to.unknowns[k] + ta * from.tangent[k] + tb * to.tangent[k];
                }
                smooth = smooth && self.is_near(constants, joints, SMOOTH * moved, scratch);
            }
            self.put(start, to.share, joints, scratch);
            self.set(&self.group.unknowns, &to.unknowns, joints);
        }
        (scratch.from, scratch.to) = (from, to);
        smooth
    }

    /// Whether the loops would close on the same branch with the unknowns moved by no more than `most`.
    fn is_near(&self, constants: &Constants, joints: &[f64], most: f64, scratch: &mut Scratch) -> bool {
        let (rows, n) = (self.group.equations, self.group.unknowns.len());
        self.evaluate(constants, joints, scratch);
        let found = linear::solve(&scratch.matrix, &scratch.residual, rows, n, &mut scratch.step);
        found.is_some_and(|determinant| self.quality(determinant, &scratch.matrix) > NEAR)
            && scratch.step.iter().all(|step| step.abs() <= most)
    }

    /// Sets the inputs to a share of the way from `start`.
    fn put(&self, start: &[f64], share: f64, joints: &mut [f64], scratch: &Scratch) {
        for ((&frame, from), direction) in self.group.inputs.iter().zip(start).zip(&scratch.direction) {
            joints[frame] = from + share * direction;
        }
    }

    /// Follows the branch to the inputs `target`: straight, or moving one input after the other where that way is barred.
    fn follow(
        &self,
        constants: &Constants,
        target: &[f64],
        joints: &mut [f64],
        scratch: &mut Scratch,
    ) -> Result<(), AssemblyError> {
        let Err(lost) = self.walk(constants, &[target.to_vec()], joints, scratch) else { return Ok(()) };
        // From where the branch ends, the gap that stays for the joints asked for.
        self.set(&self.group.inputs, target, joints);
        let beyond: Vec<f64> =
            lost.unknowns.iter().zip(&self.reference).map(|(lost, from)| 2.0 * lost - from).collect();
        let mut least = Gap { length: f64::INFINITY, angle: 0.0 };
        for start in [&lost.unknowns, &beyond, &self.reference] {
            self.set(&self.group.unknowns, start, joints);
            let gap = self.newton(constants, joints, ANYHOW, scratch).err().unwrap_or_default();
            least = if gap.greatest() < least.greatest() { gap } else { least };
            if least.greatest() <= OPEN {
                break;
            }
        }
        if least.greatest() > OPEN {
            return Err(self.failure(least, ""));
        }
        let moving: Vec<usize> = (0..target.len()).filter(|&k| target[k] != self.inputs[k]).collect();
        let ways = [self.one_by_one(target, moving.iter()), self.one_by_one(target, moving.iter().rev())];
        if moving.len() > 1 && ways.iter().any(|way| self.walk(constants, way, joints, scratch).is_ok()) {
            return Ok(());
        }
        Err(self.singular(constants, &lost))
    }

    /// A way to `target` that moves one input after the other.
    fn one_by_one<'k>(&self, target: &[f64], order: impl Iterator<Item = &'k usize>) -> Vec<Vec<f64>> {
        let mut at = self.inputs.clone();
        let step = |&k: &usize| {
            at[k] = target[k];
            at.clone()
        };
        order.map(step).collect()
    }

    /// Follows the branch from the reference over positions of the inputs, stride by stride.
    fn walk(
        &self,
        constants: &Constants,
        way: &[Vec<f64>],
        joints: &mut [f64],
        scratch: &mut Scratch,
    ) -> Result<(), Lost> {
        self.set(&self.group.unknowns, &self.reference, joints);
        let mut start = self.inputs.clone();
        for end in way {
            scratch.direction.clear();
            scratch.direction.extend(end.iter().zip(&start).map(|(end, start)| end - start));
            self.put(&start, 0.0, joints, scratch);
            self.evaluate(constants, joints, scratch);
            let mut stride = if self.arrive(0.0, joints, scratch) { 0.5 } else { 0.0 };
            std::mem::swap(&mut scratch.from, &mut scratch.to);
            while scratch.from.share < 1.0 {
                let share = f64::min(scratch.from.share + stride, 1.0);
                if stride >= LEAST && self.stride(constants, &start, share, joints, scratch) {
                    std::mem::swap(&mut scratch.from, &mut scratch.to);
                    stride *= 2.0;
                } else if stride < LEAST {
                    self.put(&start, scratch.from.share, joints, scratch);
                    let inputs = self.group.inputs.iter().map(|&frame| joints[frame]).collect();
                    return Err(Lost { inputs, unknowns: scratch.from.unknowns.clone() });
                } else {
                    stride *= 0.5;
                }
            }
            start.clone_from(end);
        }
        Ok(())
    }

    /// One stride from the scratch's `from`: along its tangent, corrected and checked.
    fn stride(
        &self,
        constants: &Constants,
        start: &[f64],
        share: f64,
        joints: &mut [f64],
        scratch: &mut Scratch,
    ) -> bool {
        self.put(start, share, joints, scratch);
        let length = share - scratch.from.share;
        for (k, &frame) in self.group.unknowns.iter().enumerate() {
            joints[frame] = scratch.from.unknowns[k] + length * scratch.from.tangent[k];
        }
        self.newton(constants, joints, [STEPS, 1], scratch).is_ok_and(|quality| quality > NEAR)
            && self.arrive(share, joints, scratch)
            && self.is_smooth(constants, start, joints, scratch)
    }

    /// Why the branch ends: the joints there, those first that had moved.
    fn singular(&self, constants: &Constants, lost: &Lost) -> AssemblyError {
        let frames = &constants.model.frames;
        let at = |(&frame, &value): (&FrameIndex, &f64)| At {
            joint: frames[frame].name.clone(),
            value,
            is_angle: frames[frame].joint != JointKind::Prismatic,
        };
        let moved = self.group.inputs.iter().zip(&lost.inputs).zip(&self.inputs);
        let inputs = moved.filter(|((_, value), from)| value != from).map(|(of, _)| at(of)).collect();
        let passive = self.group.unknowns.iter().zip(&lost.unknowns).map(at).collect();
        let mut names = self.group.loops.iter().map(|plan| plan.name.clone());
        AssemblyError::Singular { name: names.next().unwrap_or_default(), others: names.collect(), inputs, passive }
    }
}
