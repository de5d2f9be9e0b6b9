//! One check: what a calibration says of the robot's constants, and of where base and tool are.

use nalgebra::{DMatrix, DVector};

use super::contrast::inverse;
use super::error::TrackingError;
use crate::description::campaign::Campaign;
use crate::description::raw::RawFit;
use crate::estimation::Calibration;
use crate::math::distinct;
use crate::model::Model;
use crate::parameter::{Group, Slot};

/// Estimates of one kind with their covariance, SI.
#[derive(Debug, Clone)]
pub struct Estimates {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Their values.
    pub values: DVector<f64>,
    /// Covariance of the values.
    pub covariance: DMatrix<f64>,
    /// Degrees of freedom of the covariance; infinite where it counts as known.
    pub freedom: f64,
}

/// What a fit left of the readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residuals {
    /// Standard deviation of the residuals, in units of the stated noise, or of one that is the same for all campaigns.
    pub ratio: f64,
    /// Its degrees of freedom.
    pub freedom: f64,
    /// Whether the noise was stated: ratios compare with those of the same kind only.
    pub stated: bool,
}

/// One check of a robot.
#[derive(Debug, Clone)]
pub struct Check {
    /// Its name.
    pub name: String,
    /// When, in the unit of the history (months, or checks).
    pub time: f64,
    /// The robot's constants.
    pub robot: Estimates,
    /// Base, and tool, where the campaign estimates them.
    pub placed: [Option<Estimates>; 2],
    /// What the fit left; `None` of a description.
    pub residuals: Option<Residuals>,
    /// Configurations fitted.
    pub poses: usize,
    /// Root mean square position error of readings held out, m.
    pub check_rms: Option<f64>,
}

/// Whether a parameter is the robot's own, and not of the session.
pub fn is_of_robot(model: &Model, slot: Slot) -> bool {
    matches!(model.registry[slot].group, Group::Geometry | Group::Elastic | Group::Effect)
}

/// Names of the robot's own parameters that a calibration kept.
pub fn kept(model: &Model, found: &Calibration) -> Vec<String> {
    let estimated =
        found.estimates.iter().filter(|estimate| estimate.identifiable() && is_of_robot(model, estimate.slot));
    estimated.map(|estimate| model.registry[estimate.slot].name.clone()).collect()
}

impl Estimates {
    /// Of a calibration, those of these slots that it kept.
    fn of(model: &Model, found: &Calibration, wanted: impl Fn(Slot) -> bool) -> Option<Self> {
        let kept = found.identifiability.kept.iter().enumerate();
        let own: Vec<(usize, _)> = kept
            .filter_map(|(at, &column)| Some((at, found.estimates.get(column)?)))
            .filter(|(_, estimate)| wanted(estimate.slot))
            .collect();
        if own.is_empty() {
            return None;
        }
        let widths: Option<Vec<(f64, f64)>> = own.iter().map(|(_, estimate)| estimate.repeatability()).collect();
        let widths = widths?;
        let covariance = DMatrix::from_fn(own.len(), own.len(), |i, j| {
            let correlation = if i == j { 1.0 } else { found.correlation[(own[i].0, own[j].0)] };
            correlation * widths[i].0 * widths[j].0
        });
        Some(Self {
            names: own.iter().map(|(_, estimate)| model.registry[estimate.slot].name.clone()).collect(),
            values: DVector::from_iterator(own.len(), own.iter().map(|(_, estimate)| estimate.value)),
            covariance,
            freedom: widths.iter().map(|(_, freedom)| *freedom).fold(f64::INFINITY, f64::min),
        })
    }

    /// Those of these names, in their order; `None` where one is not there.
    pub fn only(&self, names: &[String]) -> Option<Self> {
        let at: Option<Vec<usize>> =
            names.iter().map(|name| self.names.iter().position(|known| known == name)).collect();
        let at = at?;
        Some(Self {
            names: names.to_vec(),
            values: DVector::from_iterator(at.len(), at.iter().map(|&k| self.values[k])),
            covariance: DMatrix::from_fn(at.len(), at.len(), |i, j| self.covariance[(at[i], at[j])]),
            freedom: self.freedom,
        })
    }

    /// Those of these names with their covariance where the others stand as they are: for comparison with estimates that hold the
    /// others at these values.
    pub fn given_others(&self, names: &[String]) -> Option<Self> {
        let scale = self.covariance.diagonal().map(|variance| variance.max(f64::MIN_POSITIVE).sqrt());
        let size = &scale * scale.transpose();
        let covariance = inverse(&self.covariance.component_div(&size))?.component_div(&size);
        let own = Self { covariance, ..self.clone() }.only(names)?;
        let scale = own.covariance.diagonal().map(|information| information.max(f64::MIN_POSITIVE).sqrt());
        let size = &scale * scale.transpose();
        let covariance = inverse(&own.covariance.component_div(&size))?.component_div(&size);
        Some(Self { covariance, ..own })
    }
}

impl Check {
    /// Of a campaign, calibrated.
    ///
    /// # Errors
    /// [`TrackingError::NothingKept`].
    pub fn of(
        name: &str,
        time: f64,
        model: &Model,
        campaign: &Campaign,
        found: &Calibration,
    ) -> Result<Self, TrackingError> {
        let robot = Estimates::of(model, found, |slot| is_of_robot(model, slot))
            .ok_or_else(|| TrackingError::NothingKept { campaign: name.into() })?;
        let place = |first: Slot| Estimates::of(model, found, |slot| (first..first + 6).contains(&slot));
        let freedom = match &found.shared {
            Some(shared) => shared.between,
            None => found.degrees_of_freedom,
        };
        let configurations = campaign.configurations();
        let readings = campaign.readings.iter().zip(&found.held_out).filter(|(_, held_out)| !**held_out);
        let poses: Vec<usize> = distinct(readings.filter_map(|(reading, _)| configurations.get(reading.pose).copied()));
        let check = &found.after.check;
        Ok(Self {
            name: name.into(),
            time,
            robot,
            placed: [place(model.base), place(model.tool.1)],
            residuals: Some(Residuals { ratio: found.noise_ratio, freedom, stated: campaign.sigma.is_some() }),
            poses: poses.len(),
            check_rms: (check.readings > 0).then_some(check.distance[1]),
        })
    }

    /// Of a description that says how well it was determined. Its covariance counts as known.
    pub fn of_description(name: &str, time: f64, model: &Model, fit: &RawFit) -> Option<Self> {
        let slot = |name: &String| model.registry.slot(name).filter(|slot| is_of_robot(model, *slot));
        let own: Vec<(usize, Slot)> =
            fit.parameters.iter().enumerate().filter_map(|(at, name)| Some((at, slot(name)?))).collect();
        let entry = |i: usize, j: usize| fit.covariance.get(i.max(j)).and_then(|row| row.get(i.min(j))).copied();
        let mut covariance = DMatrix::zeros(own.len(), own.len());
        for (i, (row, _)) in own.iter().enumerate() {
            for (j, (column, _)) in own.iter().enumerate() {
                covariance[(i, j)] = entry(*row, *column)?;
            }
        }
        let robot = Estimates {
            names: own.iter().map(|(_, slot)| model.registry[*slot].name.clone()).collect(),
            values: DVector::from_iterator(own.len(), own.iter().map(|(_, slot)| model.registry[*slot].nominal)),
            covariance,
            freedom: f64::INFINITY,
        };
        (!own.is_empty()).then_some(Self {
            name: name.into(),
            time,
            robot,
            placed: [None, None],
            residuals: None,
            poses: 0,
            check_rms: None,
        })
    }
}
