//! Configurations at which the ball on the tool touches what it is to touch: readings of contacts are made by them, and what
//! these can tell is judged there.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector, Rotation3, Vector3};

use super::reading::target_values;
use super::single::SinglePredictor;
use crate::description::campaign::Campaign;
use crate::kinematics::AssemblyError;
use crate::math::linear::least_norm;
use crate::model::Model;
use crate::observation::{MOST_ROWS, MeasuredPoint, PointDerivative, Rows, TargetValues, Twist};

/// Most Newton steps; from where they converge they are few.
const MOST_STEPS: usize = 40;
/// Greatest step of a variable, rad and m.
const GREATEST_STEP: f64 = 0.3;
/// Gap at which the ball counts as touching, m: far below any noise.
const TOUCHES: f64 = 1e-9;
/// Gap at which no step makes it smaller, m: what is left is rounding.
const ROUNDING: f64 = 1e-13;

/// Brings the ball of a campaign's readings to what they refer to.
pub struct Toucher<'a> {
    predictor: SinglePredictor<'a>,
}

impl<'a> Toucher<'a> {
    /// For the readings of `campaign` by a robot of these `values`.
    ///
    /// # Errors
    /// The loops cannot be assembled with these values.
    pub fn new(model: &'a Model, values: &[f64], campaign: &'a Campaign) -> Result<Self, AssemblyError> {
        Ok(Self { predictor: SinglePredictor::new(model, values, campaign)? })
    }

    /// A configuration near `start` (rad, m), whatever the limits of joints, at which the ball of a reading is `off` (the rows of
    /// its kind, m) from touching a target with these values; none where Newton's method finds none.
    pub fn touching(&self, reading: usize, target: &TargetValues, start: &[f64], off: &Rows) -> Option<Vec<f64>> {
        let campaign = self.predictor.campaign;
        let of = campaign.readings.get(reading)?;
        let (model, rows) = (self.predictor.geometry().model, of.observes.rows());
        let geometry = self.predictor.geometry();
        let onto = geometry.placement(model.base_slot(of.session)).rotation;
        let mut workspace = self.predictor.workspace();
        let mut q = start.to_vec();
        let mut best: Option<(f64, Vec<f64>)> = None;
        for _ in 0..MOST_STEPS {
            self.predictor.place(&q, &mut workspace).ok()?;
            let seen = self.predictor.see(reading, &of.wrench, &mut workspace).ok()?;
            let at = geometry.base() * seen.real;
            let point = MeasuredPoint {
                measured: of.measured,
                target: *target,
                ..MeasuredPoint::rigid(at.translation.vector, at.rotation, Rotation3::identity())
            };
            let value = of.observes.value(&point);
            let gap = DVector::from_fn(rows, |k, _| value[k] - off[k]);
            let size = gap.amax();
            if size < TOUCHES {
                // Steps go on as long as they help: dependence is exact only at no gap.
                match &best {
                    Some((least, _)) if size >= 0.1 * least => break,
                    _ => best = Some((size, q.clone())),
                }
                if size < ROUNDING {
                    break;
                }
            }
            self.predictor.differentiate(reading, &of.wrench, &seen, true, &mut workspace);
            let columns: Vec<Rows> = workspace
                .jacobian
                .iter()
                .map(|[x, y, z, rx, ry, rz]| {
                    let by = Twist::new(onto * Vector3::new(*x, *y, *z), onto * Vector3::new(*rx, *ry, *rz));
                    of.observes.derivative(&point, &PointDerivative::of_frames(by))
                })
                .collect();
            let jacobian = DMatrix::from_fn(rows, columns.len(), |i, j| columns[j][i]);
            let step = least_norm(jacobian, &gap);
            let shorter = (GREATEST_STEP / step.amax().max(f64::MIN_POSITIVE)).min(1.0);
            q.iter_mut().zip(step.iter()).for_each(|(q, step)| *q += shorter * step);
        }
        best.map(|(_, q)| q)
    }
}

/// The campaign with the joints of each ball in a socket moved to where it sits in it: motions that change no reading leave
/// derivatives exactly dependent there, and nowhere else. What cannot be moved there stays.
///
/// # Errors
/// The loops cannot be assembled with these values.
pub fn seated<'c>(model: &Model, campaign: &'c Campaign, values: &[f64]) -> Result<Cow<'c, Campaign>, AssemblyError> {
    let sits = |index: &usize| campaign.readings[*index].observes.holds_point();
    let sockets: Vec<usize> = (0..campaign.readings.len()).filter(sits).collect();
    if sockets.is_empty() {
        return Ok(Cow::Borrowed(campaign));
    }
    let toucher = Toucher::new(model, values, campaign)?;
    let mut moved = campaign.clone();
    for index in sockets {
        let target = target_values(model, campaign, campaign.readings[index].target, values);
        if let Some(q) = toucher.touching(index, &target, campaign.configuration(index), &[0.0; MOST_ROWS]) {
            // Other readings of the row are taken there too.
            let row = campaign.readings[index].row;
            for own in (0..campaign.readings.len()).filter(|own| *own == index || campaign.readings[*own].row == row) {
                moved.joints[own * campaign.variables..(own + 1) * campaign.variables].copy_from_slice(&q);
            }
        }
    }
    Ok(Cow::Owned(moved))
}
