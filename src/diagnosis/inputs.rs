//! What a diagnosis is made from; the same for all its competitions.

use super::settings::Settings;
use crate::description::campaign::Campaign;
use crate::model::Model;
use crate::parameter::Slot;

/// A campaign and the model that it is diagnosed against.
pub struct Inputs<'a> {
    /// The model.
    pub model: &'a Model,
    /// All readings, outliers included.
    pub campaign: &'a Campaign,
    /// Readings that are not fitted.
    pub held_out: &'a [bool],
    /// Settings.
    pub settings: &'a Settings,
    /// Parameters of the model that are calibrated with every hypothesis.
    pub nuisance: Vec<Slot>,
}

impl<'a> Inputs<'a> {
    /// The same with parameters held.
    pub fn without(&self, held: &[Slot]) -> Inputs<'a> {
        let nuisance = self.nuisance.iter().copied().filter(|slot| !held.contains(slot)).collect();
        Self { nuisance, ..*self }
    }
}
