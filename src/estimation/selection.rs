//! What a calibration estimates: which candidates are kept, and which springs act as one.

use super::equivalence::{SpringGroup, groups};
use super::reduction::{Reduction, candidates, reduced};
use super::registration::arrangement;
use super::result::CalibrationError;
use super::settings::{Settings, What};
use super::start::elastic_start;
use crate::description::campaign::Campaign;
use crate::identifiability::{Identifiability, Why};
use crate::model::Model;
use crate::parameter::{Group, Slot};
use crate::prediction::Predictor;

/// What a calibration estimates, and of what it is made.
pub struct Selection<'a> {
    /// Of the candidates.
    pub predictor: Predictor<'a>,
    pub identifiability: Identifiability,
    /// Springs among the candidates that act as one.
    pub groups: Vec<SpringGroup>,
}

impl<'a> Selection<'a> {
    /// Chooses what is kept of the candidates; `sigmas` are those of the rows (m, rad). Where the springs are to be fitted,
    /// `start` is moved to where their fit can begin.
    pub fn new(
        model: &'a Model,
        campaign: &'a Campaign,
        sigmas: &[f64],
        held: &[Slot],
        settings: &Settings,
        start: &mut Vec<f64>,
    ) -> Result<Self, CalibrationError> {
        let slots = match &settings.only {
            Some(only) => {
                let mut slots = arrangement(model, campaign);
                let first = slots.len();
                slots.extend(only.iter().filter(|slot| !slots[..first].contains(slot)).copied().collect::<Vec<_>>());
                slots
            }
            None => candidates(model, campaign, settings.what.unwrap_or_else(|| What::usual(model, campaign)))?,
        };
        let predictor = Predictor::new(model, campaign, slots)?;
        if settings.only.is_none() {
            elastic_start(&predictor, sigmas, held, start, settings)?;
        }
        let Reduction { identifiability, .. } =
            reduced(&predictor, start, sigmas, held, settings.scaling, settings.criterion)?;
        // What moves no reading stays as described, whatever the search for a start tried with it.
        let merged: Vec<usize> = identifiability.merged().collect();
        let exact = identifiability.dropped.iter().filter(|(_, why)| *why == Why::Exact).map(|(column, _)| *column);
        for column in exact.filter(|column| !merged.contains(column)) {
            let slot = predictor.slots[column];
            if model.registry[slot].group == Group::Elastic {
                start[slot] = model.registry[slot].nominal;
            }
        }
        let groups = groups(&predictor, start, &identifiability)?;
        Ok(Self { predictor, identifiability, groups })
    }

    /// Slots of the kept parameters.
    pub fn kept(&self) -> Vec<Slot> {
        self.identifiability.kept.iter().map(|&column| self.predictor.slots[column]).collect()
    }
}
