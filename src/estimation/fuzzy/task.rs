//! What is fitted: the readings of one campaign as a function of some inputs.

use super::settings::FuzzySettings;
use crate::description::campaign::Campaign;
use crate::description::fuzzy::Input;
use crate::description::robot::FrameIndex;
use crate::model::Model;

/// How rules divide the inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Structure {
    /// All combinations of sets of each input, as the IR663 paper.
    Grid,
    /// Splits along one input each: rules only where the readings show that they differ.
    Tree,
}

impl Structure {
    /// What suits a number of inputs.
    pub fn of(inputs: usize) -> Self {
        if inputs > GRID_INPUTS { Self::Tree } else { Self::Grid }
    }
}

/// Axes of the components of a compliance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxesOf {
    /// The base's.
    Base,
    /// Those of a frame, turning with it.
    Frame(FrameIndex),
    /// Those of the base or of a frame of the arm, whichever leave least in cross-validation. Grids: the base's.
    Best,
}

/// Inputs up to which rules form a grid where it is not said: with more a grid has more rules than a campaign has readings.
const GRID_INPUTS: usize = 3;

/// A fit of fuzzy compliances that is asked for.
#[derive(Debug, Clone, Copy)]
pub struct FuzzyTask<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Deflections of one marker or of the tool, or of three and more markers.
    pub campaign: &'a Campaign,
    /// Which of its readings are held out.
    pub held_out: &'a [bool],
    /// What the compliance may depend on.
    pub inputs: &'a [Input],
    /// How rules divide the inputs; `None`: a grid of up to three inputs, and else a tree.
    pub structure: Option<Structure>,
    /// Axes of the components.
    pub axes: AxesOf,
    /// Whether the compliance is symmetric (Maxwell, Betti): x by fy is y by fx.
    pub reciprocal: bool,
    /// Limits.
    pub settings: FuzzySettings,
}

impl FuzzyTask<'_> {
    /// How rules divide the inputs.
    pub fn structure(&self) -> Structure {
        self.structure.unwrap_or(Structure::of(self.inputs.len()))
    }
}
