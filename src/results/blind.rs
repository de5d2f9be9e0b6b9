//! What `blind score` finds on sealed campaigns.

use serde::Serialize;

use crate::blind::{Examined, Score, score};

/// A campaign after its truth was opened.
#[derive(Debug, Serialize)]
pub struct ScoredCampaign {
    /// The right causes, or rightly none.
    pub right: bool,
    /// At the right sites too.
    pub right_sites: bool,
    /// Whether a name is false.
    pub false_name: bool,
    /// The answer and the truth.
    pub said: Examined,
}

/// The score, and each campaign.
#[derive(Debug, Serialize)]
pub struct BlindScore {
    /// Figures over all campaigns.
    pub score: Score,
    /// Answer and truth of each campaign.
    pub campaigns: Vec<ScoredCampaign>,
    /// The same with the true effect of each single one taken out of the catalogue, where that was asked for.
    pub left_out: Option<LeftOut>,
}

/// What is said where the true effect is not in the catalogue.
#[derive(Debug, Serialize)]
pub struct LeftOut {
    /// Figures over these campaigns.
    pub score: Score,
    /// Answer and truth of each of them.
    pub campaigns: Vec<ScoredCampaign>,
}

impl BlindScore {
    /// Of campaigns examined, and of those examined without their true effects.
    pub fn new(all: Vec<Examined>, left_out: Option<Vec<Examined>>) -> Self {
        let each = |all: Vec<Examined>| all.into_iter().map(ScoredCampaign::new).collect();
        let left_out = left_out.map(|all| LeftOut { score: score(&all), campaigns: each(all) });
        Self { score: score(&all), campaigns: each(all), left_out }
    }
}

impl ScoredCampaign {
    fn new(said: Examined) -> Self {
        Self { right: said.is_right(), right_sites: said.is_at_site(), false_name: said.has_false_name(), said }
    }
}
