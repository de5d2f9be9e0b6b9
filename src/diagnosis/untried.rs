//! What was not tried and why, and what other measurements exclude.

use super::hypothesis::Hypothesis;
use super::result::{EffectAtSite, Excluded, NotTried};
use crate::description::campaign::Campaign;
use crate::effects::{Condition, Effect, Family, Nonlinear, Site, SiteKind, Survey};
use crate::model::Model;
use crate::noise::reference_noise;

/// Share of the gap below which a motion that fixed reflectors show cannot carry it.
const OF_GAP: f64 = 0.5;

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
            Some(Condition::Time) => "a column `time`",
            Some(Condition::Temperature) => "a column `temperature` that varies",
            Some(Condition::Approach) => "columns `approach.<variable>`, from both sides",
            Some(Condition::LastMove) => "a column `order` or `time`, or `order: rows`",
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
    let mut all: Vec<NotTried> = untried.map(of).collect();
    all.extend(model.catalogue.iter().filter_map(|effect| of_passive_joints(model, effect.as_ref())));
    all
}

/// What an effect of joints needs to be tried at joints that loops and actuators move; `None` where it sits at none.
fn of_passive_joints(model: &Model, effect: &dyn Effect) -> Option<NotTried> {
    let has_constants = |site: &Site| !effect.constants(model, site, &Nonlinear::default()).is_empty();
    let is_passive = |site: &Site| site.kind == SiteKind::Joint && site.coordinate.is_none();
    let sites = effect.sites(model);
    let passive = sites.iter().filter(|site| is_passive(site) && has_constants(site));
    let names: Vec<String> = passive.map(|site| format!("`{}`", site.name)).collect();
    (!names.is_empty()).then(|| {
        let needs =
            format!("to be declared under `effects:` at joints that a loop or an actuator moves, {}", names.join(", "));
        NotTried { effect: effect.name().into(), needs }
    })
}

/// Takes out the hypotheses that the base moved in time, where fixed reflectors moved by much less than a gap (m).
pub fn excluded(campaign: &Campaign, gap: f64, hypotheses: &mut Vec<Hypothesis>) -> Vec<Excluded> {
    let motion = reference_noise(&campaign.references).and_then(|seen| seen.motion);
    let Some(motion) = motion.filter(|motion| motion.rms < OF_GAP * gap) else { return Vec::new() };
    let [rms, greatest, gap] = [motion.rms, motion.greatest, gap].map(|length| 1e3 * length);
    let by = format!("fixed reflectors moved by {rms:.4} mm (rms, at most {greatest:.4} mm); the gap is {gap:.4} mm");
    let is_excluded =
        |hypothesis: &Hypothesis| hypothesis.site.kind == SiteKind::Base && hypothesis.family() == Family::Time;
    let mut found: Vec<Excluded> = Vec::new();
    for hypothesis in hypotheses.iter().filter(|hypothesis| is_excluded(hypothesis)) {
        let EffectAtSite { effect, site } = hypothesis.named();
        if !found.iter().any(|known| known.effect == effect && known.site == site) {
            found.push(Excluded { effect, site, by: by.clone() });
        }
    }
    hypotheses.retain(|hypothesis| !is_excluded(hypothesis));
    found
}
