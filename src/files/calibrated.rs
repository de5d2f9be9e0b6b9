//! Effects under `calibrate:` of a campaign for which nothing is fitted.

use crate::description::campaign::raw::RawCampaign;
use crate::description::robot::Robot;
use crate::diagnostic::{Diagnostic, Locate};
use crate::model::Model;

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
