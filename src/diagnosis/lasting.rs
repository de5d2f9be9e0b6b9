//! What of a cause is the robot's, and what belongs to the session in which it was found.

use super::level::Level;
use super::result::Cause;
use crate::description::frame::Motion;
use crate::effects::{Driver, EffectEntry, Family, Nonlinear, NonlinearValue};
use crate::model::Model;
use crate::parameter::Slot;

impl Cause {
    /// Whether one of its entries belongs to the session, and not to the robot: what is of the measurement, and what goes with the time of
    /// this session, but for a law that comes again in every one.
    pub fn is_of_the_session(&self, entry: &EffectEntry) -> bool {
        // What goes with the time since the start of every session comes again in each of them.
        let is_of_sessions = entry.nonlinear.values().contains(&NonlinearValue::Driver(Driver::SessionTime));
        let recurs = is_of_sessions || self.level == Level::Law && entry.effect.recurs();
        let is_of_time = self.family == Family::Time && !recurs;
        entry.effect.is_of_the_measurement(&entry.site) || is_of_time
    }

    /// What stays of an entry that belongs to the session, as constants of the robot from its end on; `None` where nothing does, or where
    /// other joints follow the one that slipped.
    pub fn remains(&self, model: &Model, entry: &EffectEntry) -> Option<EffectEntry> {
        let effect = model.catalogue.get(entry.effect.remains().filter(|_| self.level == Level::Law)?)?.clone();
        let Motion::Variable { index, direction } = model.frames.get(entry.site.frame)?.motion else { return None };
        let mut unit = vec![0.0; model.variables.len()];
        *unit.get_mut(index)? = 1.0;
        if model.followers().iter().any(|follower| follower.of(&unit) != 0.0) {
            return None;
        }
        let nonlinear = Nonlinear::default();
        let constants = effect.constants(model, &entry.site, &nonlinear);
        let of = |(slot, amount): (&Slot, &f64)| (model.registry[*slot].name.clone(), direction * amount);
        let amounts = constants.iter().zip(entry.amounts.values()).map(of).collect();
        Some(EffectEntry { effect, site: entry.site.clone(), nonlinear, amounts })
    }
}
