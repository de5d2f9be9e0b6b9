//! What was not tried and why, and what other measurements exclude.

use nalgebra::DVector;

use super::claims::Claim;
use super::hypothesis::Hypothesis;
use super::linear_problem::LinearProblem;
use super::result::{EffectAtSite, Excluded, NotTried};
use crate::description::campaign::Campaign;
use crate::effects::{Condition, Effect, Family, Nonlinear, SiteKind, Survey};
use crate::math::{least_squares, orthonormal, project_off};
use crate::model::Model;
use crate::noise::{Motion, reference_noise};

/// Share of the gap below which a motion that fixed reflectors show cannot carry it.
const OF_GAP: f64 = 0.5;
/// Probability of as much motion of fixed reflectors by noise alone, below which they moved.
const CHANCE: f64 = 0.01;

/// Effects of the catalogue that no hypothesis stands for, with what they need. Those that are calibrated with every
/// hypothesis (`known`) were tried.
pub fn not_tried(model: &Model, survey: &Survey, hypotheses: &[Hypothesis], known: &[String]) -> Vec<NotTried> {
    let is_tried = |name: &str| {
        name == "outliers"
            || known.iter().any(|known| known == name)
            || hypotheses.iter().any(|hypothesis| hypothesis.effect.name() == name)
    };
    let untried = model.catalogue.iter().filter(|effect| !is_tried(effect.name()) && !effect.is_free_form());
    let of = |effect: &std::sync::Arc<dyn Effect>| {
        let needs = match effect.reads().first() {
            _ if survey.is_difference && !effect.reads().is_empty() => "absolute readings",
            _ if effect.sites(model).is_empty() && effect.sits_at() == SiteKind::Marker => "several markers",
            Some(Condition::Time) if effect.sits_at() == SiteKind::Marker && survey.longest_session.is_some() => {
                "several markers"
            }
            Some(Condition::Time) => "a column `time`",
            Some(Condition::Temperature) => "a column `temperature` that varies",
            Some(Condition::Approach) => "columns `approach.<variable>`, from both sides",
            Some(Condition::LastMove) => {
                "configurations in the order in which they were measured, reached by moves that differ"
            }
            Some(Condition::GearRatio) => "`gear_ratios` in the description",
            None if effect.sites(model).is_empty() => "a site of its kind on this robot",
            None if effect.family(&Nonlinear::default()) == Family::Elastic => {
                let has_weight = survey.greatest_own_load.iter().any(|load| *load > 0.0);
                match (has_weight, survey.loaded) {
                    (false, false) => "masses of the bodies, or an applied wrench",
                    _ => "a load that shows at its sites in these readings",
                }
            }
            None => "readings in which it shows: what is calibrated reproduces it here",
        };
        NotTried { effect: effect.name().into(), needs: needs.into() }
    };
    untried.map(of).collect()
}

/// Takes out the hypotheses that the base moved with time or temperature, where fixed reflectors moved by much less than a gap (m): all of
/// them where the reflectors moved by no more than noise, or where `is_fixed`. Reflectors beside the robot exclude that the instrument moved, and
/// no hypothesis.
pub fn excluded(campaign: &Campaign, gap: f64, is_fixed: bool, hypotheses: &mut Vec<Hypothesis>) -> Vec<Excluded> {
    let motion = reference_noise(&campaign.references).and_then(|seen| seen.motion);
    let is_still = |motion: &Motion| motion.rms < OF_GAP * gap && (is_fixed || motion.p > CHANCE);
    let Some(motion) = motion.filter(is_still) else { return Vec::new() };
    let [rms, greatest, gap] = [motion.rms, motion.greatest, gap].map(|length| 1e3 * length);
    let seen = if motion.p > CHANCE { "stood still within their scatter," } else { "moved by" };
    if campaign.references.beside_base {
        let by = format!(
            "reflectors on the pedestal {seen} {rms:.4} mm (rms, at most {greatest:.4} mm); the gap is {gap:.4} mm; if a base moved with time, it \
             is the robot on its mount, and not the instrument"
        );
        return vec![Excluded { effect: "frame-drift".into(), site: "instrument".into(), by }];
    }
    let by = format!(
        "fixed reflectors {seen} {rms:.4} mm (rms, at most {greatest:.4} mm); the gap is {gap:.4} mm; if they stand beside the robot and not on \
         its base, declare `on: pedestal`"
    );
    let mut found: Vec<Excluded> = Vec::new();
    for hypothesis in hypotheses.iter().filter(|hypothesis| moves_base(hypothesis)) {
        let EffectAtSite { effect, site } = hypothesis.named();
        if !found.iter().any(|known| known.effect == effect && known.site == site) {
            found.push(Excluded { effect, site, by: by.clone() });
        }
    }
    hypotheses.retain(|hypothesis| !moves_base(hypothesis));
    found
}

/// Whether reflectors beside the robot moved certainly, and by as much as a motion of the base carries (m): then it is the instrument that
/// moved.
pub fn is_of_instrument(campaign: &Campaign, carried: f64) -> bool {
    let motion = reference_noise(&campaign.references).and_then(|seen| seen.motion);
    let moved = |motion: Motion| motion.p <= CHANCE && motion.rms >= OF_GAP * carried;
    campaign.references.beside_base && motion.is_some_and(moved)
}

/// Whether what is claimed of a base that moves with time is much more than fixed reflectors moved by. `gap` (m) is what calibration
/// leaves.
pub fn moves_too_far(campaign: &Campaign, problem: &LinearProblem, claims: &[Claim], gap: f64) -> bool {
    let members: Vec<usize> = claims.iter().map(|claim| claim.hypothesis).collect();
    if campaign.references.beside_base || !members.iter().any(|&h| moves_base(&problem.hypotheses[h])) {
        return false;
    }
    let Some(motion) = reference_noise(&campaign.references).and_then(|seen| seen.motion) else { return false };
    let design = problem.design(&members);
    let amounts = least_squares(&design, &problem.residual);
    let mut first = problem.nuisance.ncols();
    let mut moved = DVector::zeros(problem.rows());
    for &member in &members {
        let columns = &problem.hypotheses[member].columns;
        if moves_base(&problem.hypotheses[member]) {
            moved += columns * amounts.rows(first, columns.ncols());
        }
        first += columns.ncols();
    }
    // A base that is fitted takes its mean place up.
    let moved = project_off(&moved, &orthonormal(&problem.nuisance, None));
    motion.rms < OF_GAP * gap * moved.norm() / problem.residual.norm()
}

/// Whether a hypothesis has the base move with time, or with temperature: fixed reflectors would have moved too.
fn moves_base(hypothesis: &Hypothesis) -> bool {
    hypothesis.site.kind == SiteKind::Base && matches!(hypothesis.family(), Family::Time | Family::Temperature)
}
