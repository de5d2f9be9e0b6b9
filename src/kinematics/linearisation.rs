//! What a loop's closure gives Newton's method: residual (m, rad) and derivatives.

use crate::description::robot::FrameIndex;
use crate::parameter::Slot;

/// Derivative of a loop's residual: up to six components.
pub type Column = [f64; 6];

/// A loop's residual and derivatives at given joints.
#[derive(Debug, Clone, Default)]
pub struct Linearisation {
    pub residual: Column,
    /// Number of components that count.
    pub rows: usize,
    /// By moving joints of the loop.
    pub joints: Vec<(FrameIndex, Column)>,
    /// By constants of the loop.
    pub slots: Vec<(Slot, Column)>,
}
