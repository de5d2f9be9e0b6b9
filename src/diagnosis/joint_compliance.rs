//! The compliance of a joint as a hypothesis would have it: no spring pushes against its load. What makes it negative in the campaign is no cause.

use nalgebra::DMatrix;

use super::hypothesis::{Hypothesis, JointCompliance};
use crate::description::campaign::Campaign;
use crate::description::robot::Motion;
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;
use crate::parameter::Slot;
use crate::prediction::PredictionError;

/// Gives hypotheses that change the compliance of a joint what that compliance is at the configurations of a campaign. The joints of screws are
/// left out, whose compliance is not that of the joint alone.
pub fn add_compliances(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    nuisance: &[Slot],
    hypotheses: &mut [Hypothesis],
) -> Result<(), PredictionError> {
    let at_zero = vec![0.0; model.frames.len()];
    let changes = |of: &Hypothesis, joints: &[f64]| of.effect.compliance(&of.site, &of.nonlinear, joints);
    let mut own: Vec<(&mut Hypothesis, Slot, Vec<Vec<f64>>)> = hypotheses
        .iter_mut()
        .filter(|of| changes(of, &at_zero).is_some())
        .filter_map(|of| {
            let frame = &model.frames[of.site.frame];
            let is_driven = matches!(frame.motion, Motion::Variable { .. });
            let slot = model.axial_compliance(frame).filter(|_| is_driven)?;
            Some((of, slot, Vec::new()))
        })
        .collect();
    if own.is_empty() {
        return Ok(());
    }
    let geometry = Geometry::new(model, values).map_err(PredictionError::from)?;
    let mut placements = Placements::default();
    let mut seen = None;
    for (index, reading) in campaign.readings.iter().enumerate().filter(|(_, of)| of.observes.length_rows() > 0) {
        if seen.replace(reading.pose) == Some(reading.pose) {
            continue;
        }
        let placed = geometry.place(campaign.configuration(index), &mut placements);
        placed.map_err(|source| PredictionError::at(campaign, index, source.into()))?;
        for (of, _, rows) in &mut own {
            rows.extend(changes(of, &placements.joints));
        }
    }
    for (of, slot, rows) in own.into_iter().filter(|(_, _, rows)| !rows.is_empty()) {
        let by_amount = DMatrix::from_fn(rows.len(), rows[0].len(), |row, k| rows[row][k]);
        let constant = (!nuisance.contains(&slot)).then(|| values[slot]);
        of.compliance = Some(JointCompliance { slot, constant, by_amount });
    }
    Ok(())
}
