//! Equilibrium of the arm and a process that pushes back as the tool moves.
//!
//! The tool is at x where the arm, under the wrench that the process exerts at x, puts it. Newton's steps on
//! x - P(q, w(x)) = 0 with the arm's compliance C and the process's gradient K: (1 - C K) dx = P - x. The balance is
//! stable as long as 1 - C K has not passed through a singular matrix, which is the arm's and the process's buckling.

use nalgebra::{Matrix3, Vector3};

use super::{BalanceSettings, Refusal};
use crate::prediction::{Seen, SinglePredictor, SingleWorkspace};
use crate::process::{Bent, Process, Push};

/// A point of the arm and what loads it there.
#[derive(Debug, Clone, Copy)]
pub struct Balance {
    /// The point as predicted.
    pub seen: Seen,
    /// The whole wrench on it, N and N.m, base axes.
    pub wrench: [f64; 6],
    /// How far a strip that can yield is bent there.
    pub strip: Option<Bent>,
}

/// From where an equilibrium with a process is sought, base axes.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    /// What loads the tool in addition, N and N.m.
    pub wrench: [f64; 6],
    /// Direction in which the tool travels.
    pub travel: Vector3<f64>,
    /// Point, m.
    pub point: Vector3<f64>,
}

/// The reading `index` at the configuration just placed, in equilibrium with a process.
///
/// # Errors
/// [`Refusal`] if the process cannot be there, or there is no stable equilibrium.
pub fn settle(
    predictor: &SinglePredictor,
    index: usize,
    process: &Process,
    start: &Start,
    settings: &BalanceSettings,
    work: &mut SingleWorkspace,
) -> Result<Balance, Refusal> {
    let by_force: Matrix3<f64> = predictor.compliance(index, work).fixed_view::<3, 3>(0, 0).into_owned();
    let mut at = |x: &Vector3<f64>| -> Result<(Push, Seen, [f64; 6], Vector3<f64>), Refusal> {
        let push = process.push(x, &start.travel)?;
        let mut wrench = start.wrench;
        (0..3).for_each(|k| wrench[k] += push.force[k]);
        let seen = predictor.see(index, &wrench, work)?;
        let gap = seen.real.translation.vector - x;
        Ok((push, seen, wrench, gap))
    };
    let mut x = start.point;
    let (mut push, mut seen, mut wrench, mut gap) = at(&x)?;
    for _ in 0..settings.max_steps {
        let matrix = Matrix3::identity() - by_force * push.gradient;
        if gap.norm() < settings.closed {
            return if matrix.determinant() > 0.0 {
                Ok(Balance { seen, wrench, strip: None })
            } else {
                Err(Refusal::Unstable)
            };
        }
        let Some(step) = matrix.try_inverse().map(|inverse| inverse * gap) else { return Err(Refusal::Unstable) };
        let mut share = 1.0;
        loop {
            let trial = x + step * share;
            let why = match at(&trial) {
                Ok(found) if found.3.norm() < gap.norm() => {
                    x = trial;
                    (push, seen, wrench, gap) = found;
                    break;
                }
                // Past the strip's end or the like: too long a step, unless every step ends there.
                Err(why) => Some(why),
                Ok(_) => None,
            };
            share *= 0.5;
            if share < 1e-6 {
                return if gap.norm() < 1e3 * settings.closed {
                    Ok(Balance { seen, wrench, strip: None })
                } else if matrix.determinant() <= 0.0 {
                    Err(Refusal::Unstable)
                } else {
                    Err(why.unwrap_or(Refusal::Unsettled { gap: gap.norm() }))
                };
            }
        }
    }
    Err(Refusal::Unsettled { gap: gap.norm() })
}
