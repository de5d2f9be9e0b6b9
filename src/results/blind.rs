//! What `blind score` finds on sealed campaigns.

use serde::Serialize;

use crate::blind::{Examined, Score};

/// A campaign after its truth was opened.
#[derive(Debug, Serialize)]
pub struct ScoredCampaign<'a> {
    /// The right causes, or rightly none.
    pub right: bool,
    /// At the right sites too.
    pub right_sites: bool,
    /// The answer and the truth.
    pub said: &'a Examined,
}

/// The score, and each campaign.
#[derive(Debug, Serialize)]
pub struct BlindScore<'a> {
    pub score: &'a Score,
    pub campaigns: Vec<ScoredCampaign<'a>>,
}

impl<'a> BlindScore<'a> {
    /// Of campaigns examined.
    pub fn new(score: &'a Score, all: &'a [Examined]) -> Self {
        let one = |said: &'a Examined| ScoredCampaign { right: said.is_right(), right_sites: said.is_at_site(), said };
        Self { score, campaigns: all.iter().map(one).collect() }
    }
}
