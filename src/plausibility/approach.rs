//! Whether sides of approach can be of the moves that led to the configurations.

use super::amount::STANDING;
use super::evidence::{Evidence, Limits};
use crate::diagnostic::{Code, Diagnostic};

/// Moves with a side below which nothing is said: of 20 sides that have nothing to do with the moves, 18 are against them with
/// a probability of 2e-4.
const LEAST: usize = 20;
/// Share of the sides against their moves from which the column is doubted: in files whose rows are in no order it is one half.
const AGAINST: f64 = 0.9;

/// A warning of joints whose sides of approach are the reverse of their last moves: a rising angle comes from below, -1.
pub(super) fn goes_with_the_moves(evidence: &Evidence, _: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    // Readings of one configuration have one move.
    let is_new = |index: &usize| {
        index.checked_sub(1).is_none_or(|before| {
            campaign.readings[before].session != campaign.readings[*index].session
                || campaign.configuration(before) != campaign.configuration(*index)
        })
    };
    let configurations: Vec<usize> = (0..campaign.readings.len()).filter(is_new).collect();
    let judged = |variable: usize| -> Option<[usize; 2]> {
        let (sides, moves) = (campaign.conditions.sides(variable)?, campaign.conditions.last_move.get(variable)?);
        // A joint that stood still came from no side, whatever its encoder shows.
        let [angle, length] = STANDING;
        let least = if model.variables[variable].is_angle { angle } else { length };
        let both = configurations.iter().filter_map(|&index| Some((sides.get(index)?, moves.get(index)?)));
        let judged = both.filter(|(side, moved)| **side != 0.0 && moved.abs() > least);
        let signs: Vec<f64> = judged.map(|(side, moved)| side * moved).collect();
        (!signs.is_empty()).then(|| [signs.iter().filter(|sign| **sign > 0.0).count(), signs.len()])
    };
    let all: Vec<(usize, [usize; 2])> =
        (0..model.variables.len()).filter_map(|variable| Some((variable, judged(variable)?))).collect();
    let [against, count] = all.iter().fold([0, 0], |sum, (_, own)| [sum[0] + own[0], sum[1] + own[1]]);
    if count < LEAST || (against as f64) < AGAINST * count as f64 {
        return Vec::new();
    }
    let columns: Vec<String> =
        all.iter().map(|(variable, _)| format!("`approach.{}`", model.variables[*variable].name)).collect();
    let message = format!(
        "{}: {against} of {count} sides are the reverse of the joint's move from the configuration before",
        columns.join(", ")
    );
    let remedy = "1 is from above, the angle falling, and -1 from below: change the signs of the columns, or, where each configuration was \
                  overshot and approached back, leave them";
    vec![
        Diagnostic::warning(message)
            .code(Code::Doubtful)
            .remedy(remedy)
            .figure("against", against as f64)
            .figure("moves", count as f64),
    ]
}
