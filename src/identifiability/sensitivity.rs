//! Sensitivity of the tool's pose to each parameter: how many metres and radians a unit of error costs.

use crate::description::campaign::Campaign;
use crate::kinematics::{By, ErrorColumns, Geometry, Placements, Rates, shift};
use crate::parameter::Slot;
use crate::prediction::PredictionError;

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
            row: reading.row,
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
