//! An arm at one point of the path: postures that meet it, how far each is deflected, and how it moves without leaving the point.

use nalgebra::{DMatrix, Rotation3, Vector3, Vector6};

use super::{Stop, Wanted, Work};
use crate::kinematics::{Hold, InverseSettings, Target, Transform, solve};
use crate::math::norm;
use crate::prediction::{SinglePredictor, SingleWorkspace};

/// Eigenvalues of the squared Jacobian below this part of the greatest are of self-motions.
const NOTHING: f64 = 1e-12;

/// A configuration at a point of the path.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture {
    /// Variables, rad and m.
    pub joints: Vec<f64>,
    /// The tool at them, nothing deflected, base frame.
    pub rigid: Transform,
    /// Wrench on the tool, N and N.m, base axes.
    pub wrench: [f64; 6],
    /// Displacement by the wrench (and own weight, if that counts), m, base axes.
    pub deflection: Vector3<f64>,
    /// Its length in the directions that count, m.
    pub counted: f64,
    /// Greatest over least singular value, m and rad on levers of 1 m.
    pub condition: f64,
    /// Motions of the variables that keep the point, to first order, in their scale.
    pub self_motions: Vec<Vec<f64>>,
}

/// The arm and what it does.
pub struct Arm<'a> {
    pub predictor: &'a SinglePredictor<'a>,
    pub work: &'a Work,
    pub wanted: &'a Wanted,
    /// A unit of each variable: 1 rad, or half the range of a length.
    pub scale: Vec<f64>,
}

impl Arm<'_> {
    fn target(&self, index: usize, motion: &Transform) -> Target {
        let pose = motion * self.work.targets[index];
        let rotation = self.wanted.hold.turns().then_some(pose.rotation);
        Target { position: pose.translation.vector.into(), rotation, hold: self.wanted.hold }
    }

    /// All postures found at a point: branches, or samples of self-motions.
    ///
    /// # Errors
    /// [`Stop`] where there is none.
    pub fn anywhere(
        &self,
        index: usize,
        motion: &Transform,
        samples: usize,
        work: &mut SingleWorkspace,
    ) -> Result<Vec<Posture>, Stop> {
        let settings = InverseSettings {
            restarts: self.wanted.search.restarts,
            seed: self.wanted.seed,
            samples,
            ..Default::default()
        };
        let found = solve(self.predictor.geometry(), &self.target(index, motion), &settings)?;
        let postures = found.into_iter().map(|solution| self.posture(index, motion, solution.joints, work));
        let (mut good, mut why) = (Vec::new(), None);
        for posture in postures {
            match posture {
                Ok(posture) => good.push(posture),
                Err(stop) => why = why.or(Some(stop)),
            }
        }
        match why {
            Some(stop) if good.is_empty() => Err(stop),
            _ => Ok(good),
        }
    }

    /// The posture nearest to a configuration.
    ///
    /// # Errors
    /// [`Stop`] where there is none.
    pub fn near(
        &self,
        index: usize,
        motion: &Transform,
        from: Vec<f64>,
        work: &mut SingleWorkspace,
    ) -> Result<Posture, Stop> {
        let settings = InverseSettings { restarts: 0, from: Some(from), ..InverseSettings::default() };
        let found = solve(self.predictor.geometry(), &self.target(index, motion), &settings)?;
        let joints = found.into_iter().next().map(|solution| solution.joints).unwrap_or_default();
        self.posture(index, motion, joints, work)
    }

    /// How far a configuration at a point is deflected.
    ///
    /// # Errors
    /// [`Stop`] where it is singular or cannot be loaded.
    pub fn posture(
        &self,
        index: usize,
        motion: &Transform,
        joints: Vec<f64>,
        work: &mut SingleWorkspace,
    ) -> Result<Posture, Stop> {
        let posture = self.loaded(index, motion, joints, work)?;
        match posture.condition <= self.wanted.worst_condition {
            true => Ok(posture),
            false => Err(Stop::Condition { condition: posture.condition }),
        }
    }

    /// The same, however singular it is.
    ///
    /// # Errors
    /// [`Stop`] where it cannot be placed or loaded.
    pub fn loaded(
        &self,
        index: usize,
        motion: &Transform,
        joints: Vec<f64>,
        work: &mut SingleWorkspace,
    ) -> Result<Posture, Stop> {
        let wrench = self.wrench(index, &motion.rotation);
        self.predictor.place(&joints, work)?;
        let seen = self.predictor.see(index, &wrench, work)?;
        self.predictor.differentiate(index, &wrench, &seen, false, work);
        let (condition, self_motions) = self.conditioning(&(motion.rotation * self.work.targets[index].rotation), work);
        let deflection = if self.wanted.weight { seen.by_wrench + seen.by_weight } else { seen.by_wrench };
        let along = motion.rotation.inverse() * deflection;
        let counted = (0..3).filter(|&k| self.wanted.directions[k]).map(|k| along[k] * along[k]).sum::<f64>().sqrt();
        Ok(Posture { joints, rigid: seen.rigid, wrench, deflection, counted, condition, self_motions })
    }

    /// Wrench at a point of the turned workpiece.
    fn wrench(&self, index: usize, turn: &Rotation3<f64>) -> [f64; 6] {
        let w = &self.work.wrenches[index];
        let (force, moment) = (turn * Vector3::new(w[0], w[1], w[2]), turn * Vector3::new(w[3], w[4], w[5]));
        let turned = [force.x, force.y, force.z, moment.x, moment.y, moment.z];
        std::array::from_fn(|k| turned[k] + self.work.carried[k])
    }

    /// Condition number of what is held, and the motions of the variables that leave it, at the configuration just differentiated.
    fn conditioning(&self, axes: &Rotation3<f64>, work: &SingleWorkspace) -> (f64, Vec<Vec<f64>>) {
        let Hold(held) = self.wanted.hold;
        let count = work.jacobian.len();
        let mut rows = DMatrix::zeros(6, count);
        for (k, (column, scale)) in work.jacobian.iter().zip(&self.scale).enumerate() {
            let turn = axes.inverse() * Vector3::new(column[3], column[4], column[5]);
            let motion = Vector6::new(column[0], column[1], column[2], turn.x, turn.y, turn.z) * *scale;
            (0..6).filter(|&row| held[row]).for_each(|row| rows[(row, k)] = motion[row]);
        }
        let eigen = rows.tr_mul(&rows).symmetric_eigen();
        let most = eigen.eigenvalues.max();
        let is_lost = |value: f64| value <= NOTHING * most || !value.is_finite();
        let seen = eigen.eigenvalues.iter().filter(|&&value| !is_lost(value));
        let (rank, least) = seen.fold((0, f64::INFINITY), |(n, least), &value| (n + 1, least.min(value)));
        let full = rank >= count.min(self.wanted.hold.count());
        let condition = if full { (most / least).sqrt() } else { f64::INFINITY };
        let free = (0..count).filter(|&k| is_lost(eigen.eigenvalues[k]));
        (condition, free.map(|k| eigen.eigenvectors.column(k).iter().copied().collect()).collect())
    }

    /// Moves a posture along its self-motions as long as it is deflected less, in steps, coarse ones first. Each goes down along the
    /// self-motion that deflects it less, so that what makes no difference stays.
    pub fn settle(
        &self,
        index: usize,
        motion: &Transform,
        mut posture: Posture,
        steps: &[f64],
        work: &mut SingleWorkspace,
    ) -> Posture {
        const MOVES: usize = 30;
        for &step in steps {
            for _ in 0..MOVES {
                let mut towards = |by: &[f64], size: f64| {
                    let moved = posture.joints.iter().zip(by).zip(&self.scale);
                    let from = moved.map(|((q, by), scale)| q + size * by * scale).collect();
                    self.near(index, motion, from, work).ok()
                };
                let mut down = vec![0.0; self.scale.len()];
                for direction in &posture.self_motions {
                    let [more, less] = [step, -step].map(|size| towards(direction, size).map(|found| found.counted));
                    // At a limit the posture itself stands for the side that cannot be.
                    let slope = less.unwrap_or(posture.counted) - more.unwrap_or(posture.counted);
                    down.iter_mut().zip(direction).for_each(|(down, d)| *down += slope * d);
                }
                let size = norm(&down);
                if !(size > 0.0 && size.is_finite()) {
                    break;
                }
                match towards(&down, step / size) {
                    Some(found) if found.counted < posture.counted * (1.0 - self.wanted.search.worth) => {
                        posture = found
                    }
                    _ => break,
                }
            }
        }
        posture
    }
}
