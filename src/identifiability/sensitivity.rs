//! Sensitivity of the tool's pose to each parameter: how many metres and radians a unit of error costs.

use crate::description::campaign::Campaign;
use crate::kinematics::{By, ErrorColumns, Geometry, Placements, Rates, shift};
use crate::model::Model;
use crate::observation::{DEFLECTION_POSE, POSE};
use crate::parameter::{Group, Slot};
use crate::prediction::{PredictionError, Predictor};

/// mu_P and mu_Phi of a parameter (norms of its position and orientation columns), mean and greatest over the
/// configurations: m and rad per m or rad.
///
/// Source: eq. (55), (56) of the IR663 calibration paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity {
    /// The parameter.
    pub slot: Slot,
    /// Mean and greatest mu_P.
    pub position: [f64; 2],
    /// Mean and greatest mu_Phi.
    pub orientation: [f64; 2],
}

/// Sensitivities of the tool centre point over the distinct configurations of a campaign.
///
/// # Errors
/// A configuration that cannot be assembled.
///
/// ```
/// use elastogeo::identifiability::sensitivities;
/// use elastogeo::kinematics::Geometry;
///
/// let loaded = elastogeo::files::load_campaign("ir663-paper-poses", None)?;
/// let model = &loaded.robot.model;
/// let slots = model.registry.slot("1.r").into_iter().collect::<Vec<_>>();
/// let found = sensitivities(&Geometry::nominal(model)?, &loaded.campaign, &slots)?;
/// // A higher first axis lifts the tool by as much, and turns it by nothing.
/// assert!((found[0].position[0] - 1.0).abs() < 1e-12 && found[0].orientation[1] < 1e-12);
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn sensitivities(
    geometry: &Geometry,
    campaign: &Campaign,
    slots: &[Slot],
) -> Result<Vec<Sensitivity>, PredictionError> {
    let by: Vec<By> = slots.iter().map(|&slot| By::Slot(slot)).collect();
    let mut rates = Rates::new(geometry.model);
    let plan = ErrorColumns::new(geometry, &rates, geometry.model.tool.0, &by);
    let mut placements = Placements::default();
    let mut columns = vec![[0.0; 6]; slots.len()];
    let mut sums = vec![[0.0; 2]; slots.len()];
    let mut greatest = vec![[0.0_f64; 2]; slots.len()];
    let mut seen = std::collections::HashSet::new();
    let mut count = 0.0;
    for (index, reading) in campaign.readings.iter().enumerate().filter(|(_, reading)| seen.insert(reading.pose)) {
        let q = campaign.configuration(index);
        geometry.place(q, &mut placements).map_err(|source| PredictionError::Assembly {
            at: campaign.address(reading),
            pose: campaign.poses[reading.pose].clone(),
            source,
        })?;
        rates.evaluate(geometry, q, &placements);
        plan.evaluate(geometry, &placements, &rates, &mut columns);
        let arm = placements.frames[geometry.model.tool.0].rotation * geometry.tool().translation.vector;
        for (k, column) in columns.iter().enumerate() {
            let norms = [shift(column, &arm).norm(), column[3].hypot(column[4]).hypot(column[5])];
            for (kind, norm) in norms.into_iter().enumerate() {
                sums[k][kind] += norm;
                greatest[k][kind] = greatest[k][kind].max(norm);
            }
        }
        count += 1.0;
    }
    let sensitivity = |k: usize| Sensitivity {
        slot: slots[k],
        position: [sums[k][0] / count, greatest[k][0]],
        orientation: [sums[k][1] / count, greatest[k][1]],
    };
    Ok((0..slots.len()).map(sensitivity).collect())
}

/// What counts in the elastic model: springs, sections and masses that are not zero, or are declared identifiable.
pub fn elastic_parameters(model: &Model) -> Vec<Slot> {
    let counts = |slot: &Slot| {
        let parameter = &model.registry[*slot];
        parameter.group == Group::Elastic && (parameter.nominal != 0.0 || parameter.free)
    };
    (0..model.registry.all().len()).filter(counts).collect()
}

/// Sensitivities of the tool centre point to elastic parameters under the loads of a campaign, over its configurations and
/// loads, each once: of the deflection by the wrench where the campaign reads deflections, else of the pose with own weight,
/// payload and wrench.
///
/// # Errors
/// A configuration that cannot be assembled, or loads that nothing carries.
///
/// ```
/// use elastogeo::identifiability::elastic_sensitivities;
///
/// let loaded = elastogeo::files::load_campaign("kr270-simulated", None)?;
/// let model = &loaded.robot.model;
/// let found = elastic_sensitivities(model, &loaded.campaign, &model.elastic_slots())?;
/// assert!(found.iter().any(|of| of.position[0] > 0.0));
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn elastic_sensitivities(
    model: &Model,
    campaign: &Campaign,
    slots: &[Slot],
) -> Result<Vec<Sensitivity>, PredictionError> {
    let mut seen: Vec<(usize, [f64; 6], Option<_>)> = Vec::new();
    let is_new = |index: usize| {
        let reading = &campaign.readings[index];
        let own = (reading.pose, reading.wrench, reading.payload);
        let is_new = !seen.contains(&own);
        if is_new {
            seen.push(own);
        }
        is_new
    };
    let first: Vec<bool> = (0..campaign.readings.len()).map(is_new).collect();
    let mut at_tool = campaign.select(|index, _| first[index]);
    at_tool.constraints.clear();
    let observes = if campaign.is_difference() { DEFLECTION_POSE } else { POSE };
    for reading in &mut at_tool.readings {
        (reading.observes, reading.marker) = (observes, None);
    }
    let found = Predictor::new(model, &at_tool, slots.to_vec())?.linearised(&model.registry.nominal())?;
    let width = slots.len().max(1);
    let mut all: Vec<Sensitivity> =
        slots.iter().map(|&slot| Sensitivity { slot, position: [0.0; 2], orientation: [0.0; 2] }).collect();
    let count = at_tool.readings.len().max(1) as f64;
    for (_, own) in at_tool.by_reading(&found.jacobian, width) {
        for (k, sensitivity) in all.iter_mut().enumerate() {
            let norm = |rows: std::ops::Range<usize>| rows.map(|row| own[row * width + k].powi(2)).sum::<f64>().sqrt();
            for (of, norm) in [(&mut sensitivity.position, norm(0..3)), (&mut sensitivity.orientation, norm(3..6))] {
                of[0] += norm / count;
                of[1] = of[1].max(norm);
            }
        }
    }
    Ok(all)
}
