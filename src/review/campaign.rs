//! A campaign reviewed whole: calibrated, diagnosed, and the robot drawn at its configurations. SI, base frame.

use std::time::Instant;

use nalgebra::Matrix3;

use super::readings::{Readings, readings};
use super::slice::{Slice, slice};
use super::strain_energy::{StrainEnergy, compliance, strain_energy, typical};
use crate::Error;
use crate::description::campaign::Campaign;
use crate::description::robot::Robot;
use crate::diagnosis::{self, Diagnosis, diagnose};
use crate::estimation::{Calibration, CalibrationError, Settings, calibrate};
use crate::identifiability::{Sensitivity, elastic_parameters, elastic_sensitivities, sensitivities};
use crate::kinematics::{Geometry, Placements};
use crate::math::distinct;
use crate::model::Model;
use crate::parameter::Group;
use crate::scene::{Scene, Shot, draw};
use crate::state::{Loads, Mechanics, StateError};

/// Most configurations of a campaign that are drawn.
const SHOTS: usize = 24;

/// A campaign reviewed.
pub struct Review<'a> {
    /// The model.
    pub model: &'a Model,
    /// The campaign.
    pub campaign: &'a Campaign,
    /// Readings that the calibration held out.
    pub held_out: &'a [bool],
    /// The calibration and its seconds, or why there is none.
    pub calibration: Result<(Calibration, f64), String>,
    /// The diagnosis.
    pub diagnosis: Diagnosis,
    /// Its seconds.
    pub seconds: f64,
    /// Residuals stage by stage.
    pub readings: Readings,
    /// Stiffness over a slice of the workspace, through the typical configuration.
    pub slice: Option<Slice>,
    /// Shares of the elements in the strain energy.
    pub strain_energy: Option<StrainEnergy>,
    /// How much the tool moves by each free parameter of the geometry, and by each elastic one under the campaign's loads.
    pub sensitivity: [Vec<Sensitivity>; 2],
    /// The robot as it is drawn.
    pub scene: Scene,
    /// Configurations of the campaign that are drawn, the typical one first.
    pub shots: Vec<Shot>,
    /// Proposed configurations.
    pub next: Vec<Shot>,
}

/// Reviews a campaign; `progress` hears what is being done.
///
/// # Errors
/// A calibration or diagnosis that cannot be done, or a robot that cannot be assembled; a campaign that frees nothing is
/// no error.
pub fn review<'a>(
    robot: &Robot,
    model: &'a Model,
    campaign: &'a Campaign,
    held_out: &'a [bool],
    seed: u64,
    progress: &mut dyn FnMut(&str),
) -> Result<Review<'a>, Error> {
    progress("calibrating");
    let started = Instant::now();
    let mut iterated = |_: &_| progress("calibrating");
    let calibration = match calibrate(model, campaign, held_out, &Settings::default(), &mut iterated) {
        Ok(found) => Ok((found, started.elapsed().as_secs_f64())),
        Err(why @ (CalibrationError::NothingFree | CalibrationError::NothingElastic)) => Err(why.to_string()),
        Err(other) => return Err(other.into()),
    };
    let started = Instant::now();
    let stated: Vec<bool> = campaign.readings.iter().map(|reading| reading.check == Some(true)).collect();
    let diagnosis = diagnose(model, campaign, &stated, &diagnosis::Settings::new(campaign, seed), progress)?;
    let seconds = started.elapsed().as_secs_f64();
    progress("sensitivities");
    let sensitivity = [
        sensitivities(&Geometry::nominal(model)?, campaign, &model.free_slots())?,
        elastic_sensitivities(model, campaign, &elastic_parameters(model))?,
    ];
    progress("drawing");
    let fitted = calibration.as_ref().ok().map(|(found, _)| found);
    let stages = readings(model, campaign, fitted, &diagnosis)?;
    // Lengths as described: calibrated ones can be far off where the readings hardly determine them. Stiffness as calibrated.
    let calibrated = fitted.map_or(&diagnosis.calibrated, |found| &found.values);
    let both = model.registry.all().iter().zip(calibrated);
    let values: Vec<f64> = both.map(|(p, value)| if p.group == Group::Elastic { *value } else { p.nominal }).collect();
    let mechanics = Mechanics::new(model, &values, Loads { weight: false, wrench: true }, &[])?;
    let geometry = &mechanics.geometry;
    let first = typical(model, campaign);
    let mut placements = Placements::default();
    geometry.place(campaign.configuration(first), &mut placements)?;
    let scene = draw(robot, geometry, &placements);
    let next = diagnosis.next_poses.iter().enumerate().filter_map(|(k, pose)| {
        shot(&scene, &mechanics, &pose.q, format!("{}: {}", k + 1, pose.separates.join(" / ")), Vec::new())
    });
    Ok(Review {
        shots: shots(&scene, &mechanics, campaign, first),
        next: next.collect(),
        slice: slice(&mechanics, campaign.configuration(first)),
        strain_energy: strain_energy(&mechanics, campaign),
        sensitivity,
        readings: stages,
        model,
        campaign,
        held_out,
        calibration,
        diagnosis,
        seconds,
        scene,
    })
}

/// The robot at a configuration; `None` where it cannot be assembled.
pub fn shot(scene: &Scene, mechanics: &Mechanics, q: &[f64], name: String, rows: Vec<usize>) -> Option<Shot> {
    let mut state = mechanics.state();
    let compliance = match mechanics.place(q, &mut state) {
        Ok(()) => compliance(mechanics, &state),
        // What can move without force is drawn all the same.
        Err(StateError::Mechanism(_)) => None,
        Err(StateError::Assembly(_)) => return None,
    };
    let points = scene.place(&mechanics.geometry, &state.placements);
    let compliance = compliance.map(|c| -> Matrix3<f64> { c.fixed_view::<3, 3>(0, 0).into_owned() });
    Some(Shot { name, points, moved: Vec::new(), compliance, rows })
}

/// The typical configuration and others spread over the campaign.
fn shots(scene: &Scene, mechanics: &Mechanics, campaign: &Campaign, first: usize) -> Vec<Shot> {
    let poses: Vec<usize> = distinct(campaign.readings.iter().map(|reading| reading.pose));
    let typical = campaign.readings.get(first).map(|reading| reading.pose);
    let step = poses.len().div_ceil(SHOTS).max(1);
    let others = poses.iter().copied().step_by(step).filter(|pose| Some(*pose) != typical);
    typical
        .into_iter()
        .chain(others)
        .filter_map(|pose| {
            let at = campaign.readings.iter().position(|reading| reading.pose == pose)?;
            let rows = campaign.readings.iter().filter(|reading| reading.pose == pose).map(|reading| reading.row);
            shot(scene, mechanics, campaign.configuration(at), campaign.poses[pose].clone(), rows.collect())
        })
        .collect()
}
