//! Effects of a campaign that count as nothing: under `calibrate:` without constants, or declared without what they depend on.

use crate::description::campaign::Campaign;
use crate::description::campaign::raw::RawCampaign;
use crate::description::robot::Robot;
use crate::diagnostic::{Code, Diagnostic, Locate};
use crate::effects::{Condition, Family};
use crate::model::{EffectEntry, Model};

/// A warning for each effect under `calibrate:` that has no constant in the description, and is not declared there: nothing would be
/// fitted for it.
pub(super) fn without_constants(raw: &RawCampaign, robot: &Robot, model: &Model, locate: Locate) -> Vec<Diagnostic> {
    let has_none = |name: &str| {
        let is_declared = robot.effects.iter().any(|own| own.effect.as_deref() == Some(name));
        let Some(effect) = model.catalogue.get(name).filter(|_| !is_declared && name != "geometry") else {
            return false;
        };
        model.sites_with_constants(effect.as_ref()).is_empty()
    };
    let warned = |(position, name): (usize, &String)| {
        Diagnostic::warning(format!("`calibrate: {name}` has no constant in the description: nothing is fitted for it"))
            .at(locate(&["calibrate", &position.to_string()]))
            .remedy(
                "declare it under `effects:` of the description, with its site; or leave it out: `diagnose` tries it",
            )
    };
    raw.calibrate.iter().flatten().enumerate().filter(|(_, name)| has_none(name)).map(warned).collect()
}

/// A warning of declared effects that count as nothing here, since the campaign does not give what they depend on.
pub(super) fn without_conditions(model: &Model, campaign: &Campaign) -> Option<Diagnostic> {
    let conditions = &campaign.conditions;
    let lacks = |entry: &EffectEntry, condition: &Condition| match condition {
        Condition::Time => conditions.time.is_none().then_some("times"),
        Condition::Temperature => (!conditions.has_temperature()).then_some("temperatures"),
        Condition::LastMove => (!conditions.is_ordered()).then_some("the order of measurement"),
        // A joint may also cross with the load.
        Condition::Approach if entry.effect.family(&entry.nonlinear) != Family::History => None,
        Condition::Approach => {
            let has_sides = |variable| conditions.sides(variable).is_some();
            (!(0..campaign.variables).any(has_sides)).then_some("sides of approach")
        }
        Condition::GearRatio => None,
    };
    let entries = model.effects.iter().map(|on| &on.entry);
    let lacking = entries.filter_map(|entry| {
        let what = entry.effect.reads().iter().find_map(|condition| lacks(entry, condition))?;
        Some(format!("{entry} ({what})"))
    });
    let named: Vec<String> = lacking.collect();
    (!named.is_empty()).then(|| {
        let message = format!("declared effects count as nothing, for what the campaign does not give: {}", named.join(", "));
        Diagnostic::warning(message).code(Code::Missing).remedy(
            "add the columns `time`, `temperature` or `approach.<variable>`, or the order (`order:` or a column `order`); or take the effects out",
        )
    })
}
