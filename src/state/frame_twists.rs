//! How several frames move with the same variables and parameters, at one configuration.

use crate::description::robot::FrameIndex;
use crate::kinematics::{By, ErrorColumns, Geometry, Placements, Rates};

/// What of it does not depend on the configuration.
#[derive(Debug, Clone)]
pub struct FrameTwistPlan {
    plans: Vec<(FrameIndex, ErrorColumns)>,
    columns: usize,
    count: usize,
}

/// Displacement of each frame's origin (m) and its rotation (rad), base axes, per unit of each variable or parameter.
#[derive(Debug, Clone, Default)]
pub struct FrameTwists {
    /// By frame; empty of frames that were not planned.
    columns: Vec<Vec<[f64; 6]>>,
}

impl FrameTwistPlan {
    /// Columns of `frames`, which may come twice, by variables and parameters.
    pub fn new(geometry: &Geometry, pattern: &Rates, mut frames: Vec<FrameIndex>, by: &[By]) -> Self {
        frames.sort_unstable();
        frames.dedup();
        let plans = frames.into_iter().map(|frame| (frame, ErrorColumns::new(geometry, pattern, frame, by))).collect();
        Self { plans, columns: by.len(), count: geometry.model.frames.len() }
    }

    /// Workspace for one thread.
    pub fn twists(&self) -> FrameTwists {
        let mut columns = vec![Vec::new(); self.count];
        self.plans.iter().for_each(|(frame, _)| columns[*frame] = vec![[0.0; 6]; self.columns]);
        FrameTwists { columns }
    }

    /// Whether rates of joints are needed for some frame.
    pub(super) fn needs_rates(&self, only: Option<FrameIndex>) -> bool {
        self.asked(only).any(|(_, plan)| plan.needs_rates())
    }

    fn asked(&self, only: Option<FrameIndex>) -> impl Iterator<Item = &(FrameIndex, ErrorColumns)> {
        self.plans.iter().filter(move |(frame, _)| only.is_none_or(|asked| asked == *frame))
    }

    pub(super) fn evaluate(
        &self,
        geometry: &Geometry,
        placements: &Placements,
        rates: &Rates,
        only: Option<FrameIndex>,
        out: &mut FrameTwists,
    ) {
        for (frame, plan) in self.asked(only) {
            plan.evaluate(geometry, placements, rates, &mut out.columns[*frame]);
        }
    }
}

impl FrameTwists {
    /// Takes a column times a factor from another, of all frames.
    pub fn take_from(&mut self, own: usize, other: usize, factor: f64) {
        for columns in self.columns.iter_mut().filter(|columns| !columns.is_empty()) {
            let taken = columns[other];
            columns[own].iter_mut().zip(taken).for_each(|(value, by)| *value -= factor * by);
        }
    }

    /// Of a frame that was planned.
    pub fn of(&self, frame: FrameIndex) -> &[[f64; 6]] {
        &self.columns[frame]
    }
}
