//! Whether the positions of a result are those of a robot that sags under its own weight.

use serde::Serialize;

use crate::description::campaign::{Campaign, Reading};
use crate::elastics::Elastics;
use crate::model::Model;

/// Whether own weight and preloads are in predicted positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OwnWeight {
    /// They are.
    Included,
    /// The description has masses and compliances, and the result leaves their deflection out.
    LeftOut,
    /// The description declares no masses, nor anything else that loads it.
    None,
    /// It declares masses, and nothing compliant that they could deflect; `none` in JSON.
    #[serde(rename = "none")]
    Rigid,
    /// The same, and measured torques of the joints hold it; `included` in JSON.
    #[serde(rename = "included")]
    InTorques,
    /// It declares no masses, and bodies that the tool carries in some readings deflect it; `none` in JSON.
    #[serde(rename = "none")]
    Payloads,
    /// It declares no masses, and the measured torques of the joints deflect it; `none` in JSON.
    #[serde(rename = "none")]
    Torques,
}

impl OwnWeight {
    /// Of a model with its values (all slots, SI), of which own weight is `counted` or not.
    pub fn new(model: &Model, values: &[f64], counted: bool) -> Self {
        let elastics = Elastics::new(model, &model.shifted(values), &[]);
        match (elastics.is_loaded(), elastics.is_compliant(), counted) {
            (false, ..) => Self::None,
            (true, false, _) => Self::Rigid,
            (true, true, true) => Self::Included,
            (true, true, false) => Self::LeftOut,
        }
    }

    /// Of the description itself.
    pub fn nominal(model: &Model, counted: bool) -> Self {
        Self::new(model, &model.registry.nominal(), counted)
    }

    /// Of what is predicted for a campaign's readings: absolute ones hold it, differences do not.
    pub fn of_campaign(model: &Model, values: &[f64], campaign: &Campaign) -> Self {
        let own = Self::new(model, values, !campaign.is_difference());
        let holds_torques = || campaign.readings.iter().any(|reading| reading.observes.by_variable().is_some());
        if own == Self::Rigid && holds_torques() {
            return Self::InTorques;
        }
        if own != Self::None || !Elastics::new(model, &model.shifted(values), &[]).is_compliant() {
            return own;
        }
        let is_carried = |reading: &Reading| reading.payload.is_some_and(|payload| payload.mass != 0.0);
        match (campaign.conditions.torques.iter().any(Option::is_some), campaign.readings.iter().any(is_carried)) {
            (true, _) => Self::Torques,
            (_, true) => Self::Payloads,
            _ => own,
        }
    }

    /// Of what a campaign's readings are predicted with, in words.
    pub fn of_readings(self) -> String {
        self.words("deflections hold only what the wrench adds")
    }

    /// In words, `why` where it is left out.
    pub fn words(self, why: &str) -> String {
        match self {
            Self::Included => "own weight: included".into(),
            Self::LeftOut => format!("own weight: left out; {why}"),
            Self::None => "own weight: none; the description declares no masses".into(),
            Self::Rigid => "own weight: none; the description declares masses, and no compliance under them".into(),
            Self::InTorques => {
                "own weight: in the torques; the description declares no compliance that it could deflect".into()
            }
            Self::Payloads => "own weight: none; the description declares no masses, and the payloads count".into(),
            Self::Torques => {
                "own weight: none; the description declares no masses, and the measured torques count".into()
            }
        }
    }
}
