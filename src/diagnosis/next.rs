//! Where to measure next: configurations at which rivals that fit alike so far predict different readings.

use nalgebra::DVector;

use super::algebra::solve;
use super::evidence::{Evidence, Hypothesis};
use super::figures::design;
use super::report::NextPose;
use crate::description::campaign::{Campaign, Reading};
use crate::kinematics::Geometry;
use crate::model::Model;
use crate::parameter::Slot;
use crate::prediction::{Linearised, Predictor, Term, effect_columns};
use crate::simulation::{draw_configurations, generator};

/// Configurations drawn to choose from.
const DRAWN: usize = 150;
/// Proposals for each pair.
const EACH: usize = 3;

/// Proposals for the first cause that has rivals; none where configurations cannot be drawn.
pub fn next_poses(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    evidence: &Evidence,
    kept: &[Slot],
    rivals: &[(usize, Vec<(usize, f64)>)],
    seed: u64,
) -> Vec<NextPose> {
    let mut proposals = Vec::new();
    for (own, others) in rivals.iter().filter(|(_, others)| !others.is_empty()).take(2) {
        for (other, _) in others.iter().take(2) {
            let pair = [&evidence.hypotheses[*own], &evidence.hypotheses[*other]];
            let fits = [*own, *other].map(|h| solve(&design(evidence, &[h]), &evidence.residual));
            proposals.extend(
                between(model, campaign, values, kept, pair, &fits, evidence.sigmas[0], seed).unwrap_or_default(),
            );
        }
    }
    proposals
}

#[allow(clippy::too_many_arguments)] // one pair of rivals
fn between(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    kept: &[Slot],
    pair: [&Hypothesis; 2],
    fits: &[DVector<f64>; 2],
    sigma: f64,
    seed: u64,
) -> Option<Vec<NextPose>> {
    let geometry = Geometry::new(model, values).ok()?;
    let configurations = draw_configurations(&geometry, DRAWN, 0.95, &mut generator(seed)).ok()?;
    let mut loads: Vec<[f64; 6]> = campaign.readings.iter().map(|reading| reading.wrench).collect();
    loads.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    loads.dedup();
    loads.truncate(8);
    let first = campaign.readings.first()?;
    let mut trial = campaign.select(|i, _| i == 0);
    trial.readings.clear();
    trial.joints.clear();
    let conditions: Vec<(String, f64)> = campaign.conditions.iter().map(|(n, all)| (n.clone(), all[0])).collect();
    trial.conditions.values_mut().for_each(Vec::clear);
    for (pose, q) in configurations.iter().enumerate() {
        for &wrench in &loads {
            trial.joints.extend_from_slice(q);
            trial.readings.push(Reading { pose: 0, row: pose + 1, wrench, ..*first });
            for (name, value) in &conditions {
                // Sides of approach are free to choose; the rest is as it was.
                let value = if name.starts_with("approach") && pose % 2 == 1 { -value } else { *value };
                trial.conditions.get_mut(name)?.push(value);
            }
        }
    }
    let mut slots: Vec<Slot> = kept.to_vec();
    slots.extend(pair.iter().flat_map(|h| h.constants.iter().copied()).filter(|s| !kept.contains(s)));
    slots.sort_unstable();
    slots.dedup();
    let mut found = Linearised::default();
    Predictor::new(model, &trial, slots.clone()).ok()?.linearise(values, true, &mut found).ok()?;
    let rows = found.residual.len();
    let at = |row: usize, slot: Slot| slots.binary_search(&slot).map_or(0.0, |k| found.jacobian[row * slots.len() + k]);
    let mut apart = vec![0.0; rows];
    for (sign, (hypothesis, x)) in [1.0, -1.0].into_iter().zip(pair.into_iter().zip(fits)) {
        let own = if hypothesis.constants.is_empty() {
            let term = Term::new(model, &hypothesis.effect, &hypothesis.site, &hypothesis.nonlinear);
            Some(effect_columns(model, &trial, values, vec![term]).ok()?)
        } else {
            None
        };
        for (row, apart) in apart.iter_mut().enumerate() {
            let mut sum: f64 = kept.iter().enumerate().map(|(k, &slot)| at(row, slot) * x[k]).sum();
            for k in 0..hypothesis.columns.ncols() {
                let value = match &own {
                    Some((all, width)) => all[row * width + k],
                    None => at(row, hypothesis.constants[k]),
                };
                sum += value * x[kept.len() + k];
            }
            *apart += sign * sum;
        }
    }
    let components = campaign.components();
    let mut order: Vec<(f64, usize)> = (0..trial.readings.len())
        .map(|reading| {
            let rows = &apart[reading * components..(reading + 1) * components];
            (rows.iter().take(3).map(|v| v * v).sum::<f64>().sqrt(), reading)
        })
        .collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut used: Vec<usize> = Vec::new();
    let mut proposals = Vec::new();
    for (size, reading) in order {
        let pose = trial.readings[reading].row;
        if proposals.len() < EACH && !used.contains(&pose) {
            used.push(pose);
            proposals.push(NextPose {
                q: trial.configuration(reading).to_vec(),
                wrench: trial.readings[reading].wrench,
                separates: [pair[0].label(), pair[1].label()],
                apart: size,
                sigmas: size / sigma,
            });
        }
    }
    Some(proposals)
}
