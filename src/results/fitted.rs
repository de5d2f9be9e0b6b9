//! What `report` finds of a campaign of angles or loads alone, in which effects are not compared: what `identify` finds. Angles in deg,
//! loads in N.m and N.

use serde::Serialize;

use super::identification::Identification;
use super::report::{CampaignSummary, Sources, StageLabel, stage_label};
use super::residuals::{DescriptionResiduals, ReadingResidual};
use crate::description::campaign::Campaign;
use crate::diagnostic::Diagnostic;
use crate::estimation::Calibration;
use crate::model::Model;
use crate::review::StageKey;

/// What `report` finds of readings without lengths.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FittedReport {
    /// The campaign, with the unit of what judges it: `deg` or `N.m`.
    pub campaign: CampaignSummary,
    /// Commands that find the same.
    pub sources: Sources,
    /// What `identify` finds.
    pub identify: Identification,
    /// Why effects are not compared.
    pub not_diagnosed: String,
    /// How far calibration is described in `identify.residuals`.
    pub stages: Vec<StageLabel>,
    /// What calibration leaves of each reading.
    pub readings: Vec<ReadingResidual>,
    /// In two sentences; set when the page is written.
    pub answer: Option<String>,
    /// What casts doubt on the figures.
    pub diagnostics: Vec<Diagnostic>,
}

impl FittedReport {
    /// Of a calibration, and why there is no diagnosis.
    pub fn new(
        model: &Model,
        campaign: &Campaign,
        found: &Calibration,
        identify: Identification,
        sources: Sources,
        not_diagnosed: String,
    ) -> Self {
        let stages = [StageKey::Described, StageKey::Registered, StageKey::Calibrated];
        let summary = CampaignSummary::of(model, campaign, &found.held_out);
        Self {
            campaign: CampaignSummary { unit: identify.judged_unit(), sigma: None, ..summary },
            sources,
            identify,
            not_diagnosed,
            stages: stages.map(|key| StageLabel { key, label: stage_label(key) }).to_vec(),
            readings: DescriptionResiduals::new(model, campaign, &found.residual).readings,
            answer: None,
            diagnostics: Vec::new(),
        }
    }
}
