//! Where to measure next: configurations at which rivals that fit alike so far predict different readings.
//!
//! Source: Atkinson and Fedorov, *The design of experiments for discriminating between two rival models*, Biometrika 62,
//! 1975.

use nalgebra::DVector;

use super::competition::Competition;
use super::inputs::Inputs;
use super::linear_problem::LinearProblem;
use super::result::NextPose;
use super::rivals::Rival;
use crate::description::campaign::{Campaign, ConditionColumn, Reading};
use crate::kinematics::Geometry;
use crate::math::{extremes, least_squares};
use crate::simulation::{draw_configurations_in, generator, joint_box};

/// Proposals for the first causes that have rivals, `rivals` being those of each member; none where configurations cannot
/// be drawn.
pub fn next_poses(
    inputs: &Inputs,
    competition: &Competition,
    members: &[usize],
    rivals: &[Vec<Rival>],
) -> Vec<NextPose> {
    let settings = &inputs.settings.proposals;
    let open = members.iter().zip(rivals).filter(|(_, rivals)| !rivals.is_empty()).take(settings.pairs);
    let pairs = open.flat_map(|(&own, rivals)| rivals.iter().take(settings.pairs).map(move |r| [own, r.hypothesis]));
    let pairs: Vec<[usize; 2]> = pairs.collect();
    if pairs.is_empty() {
        return Vec::new();
    }
    let Some(trial) = trial(inputs, competition) else { return Vec::new() };
    let proposals = pairs.into_iter().filter_map(|pair| between(inputs, competition, &trial, pair));
    proposals.flatten().collect()
}

/// A campaign of configurations drawn, each under the loads of the campaign; its measured values mean nothing.
fn trial(inputs: &Inputs, competition: &Competition) -> Option<Campaign> {
    let (settings, campaign) = (&inputs.settings.proposals, &competition.campaign);
    let geometry = Geometry::new(inputs.model, &competition.values).ok()?;
    let mut random = generator(inputs.settings.seed);
    // Without limits nothing says that a joint can leave the range that was measured.
    let measured = |(variable, own): (usize, [f64; 2])| {
        let is_limited =
            inputs.model.variables[variable].limits.is_some_and(|both| both.iter().all(|end| end.is_finite()));
        let all = (0..campaign.readings.len()).filter_map(|index| campaign.configuration(index).get(variable).copied());
        if is_limited { own } else { extremes(all) }
    };
    let within: Vec<[f64; 2]> =
        (0..inputs.model.variables.len()).zip(joint_box(inputs.model, settings.range)).map(measured).collect();
    let configurations = draw_configurations_in(&geometry, &within, settings.drawn, &mut random).ok()?;
    let mut loads: Vec<[f64; 6]> = campaign.readings.iter().map(|reading| reading.wrench).collect();
    loads.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    loads.dedup();
    loads.truncate(settings.loads);
    let first = campaign.readings.first()?;
    let mut trial = campaign.select(|_, _| false);
    for (pose, q) in configurations.iter().enumerate() {
        for &wrench in &loads {
            trial.joints.extend_from_slice(q);
            trial.readings.push(Reading { pose: 0, row: pose + 1, wrench, ..*first });
            for (column, (condition, all)) in trial.conditions.columns_mut().zip(campaign.conditions.columns()) {
                // Sides of approach are free to choose; all else is as in the first reading.
                let is_turned = matches!(condition, ConditionColumn::Approach(_)) && pose % 2 == 1;
                column.push(if is_turned { -all[0] } else { all[0] });
            }
        }
    }
    Some(trial)
}

/// The configurations at which two hypotheses differ most.
fn between(inputs: &Inputs, competition: &Competition, trial: &Campaign, pair: [usize; 2]) -> Option<Vec<NextPose>> {
    let problem = &competition.problem;
    let hypotheses = pair.map(|h| problem.hypotheses[h].clone());
    let separates = hypotheses.each_ref().map(|hypothesis| hypothesis.label());
    let predicted =
        LinearProblem::new(inputs.model, trial, &competition.values, &competition.kept, hypotheses.to_vec()).ok()?;
    let [one, other] = [0, 1].map(|k| {
        let fit = least_squares(&problem.design(&[pair[k]]), &problem.residual);
        predicted.design(&[k]) * fit
    });
    let difference: DVector<f64> = one - other;
    let apart: Vec<f64> = predicted.errors(&difference).iter().map(|error| error.norm()).collect();
    let first = trial.first_rows();
    let sigmas =
        |reading: usize| difference.rows(first[reading], trial.readings[reading].observes.rows().min(3)).norm();
    let mut order: Vec<usize> = (0..apart.len()).collect();
    order.sort_by(|&a, &b| apart[b].total_cmp(&apart[a]));
    let mut used: Vec<usize> = Vec::new();
    let mut proposals = Vec::new();
    for reading in order {
        let Reading { row, wrench, .. } = trial.readings[reading];
        if proposals.len() < inputs.settings.proposals.each && !used.contains(&row) {
            used.push(row);
            let (q, separates) = (trial.configuration(reading).to_vec(), separates.clone());
            proposals.push(NextPose { q, wrench, separates, apart: apart[reading], sigmas: sigmas(reading) });
        }
    }
    Some(proposals)
}
