//! What is fitted: the readings of one campaign as a function of some inputs.

use super::settings::FuzzySettings;
use crate::description::campaign::Campaign;
use crate::description::fuzzy::Input;
use crate::model::Model;

/// A fit of fuzzy compliances that is asked for.
#[derive(Debug, Clone, Copy)]
pub struct FuzzyTask<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Deflections of one marker or of the tool.
    pub campaign: &'a Campaign,
    /// Which of its readings are held out.
    pub held_out: &'a [bool],
    /// What the compliance may depend on.
    pub inputs: &'a [Input],
    /// Limits.
    pub settings: FuzzySettings,
}
