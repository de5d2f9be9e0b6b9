//! Statics of one configuration: what elements are there, equations of the unknowns, own weight.

use nalgebra::{Matrix6, Matrix6x3, Vector3, Vector6};

use super::elimination::Elimination;
use crate::elements::{Held, Placed};

/// Why a structure has no statics at a configuration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Mechanism {
    /// It can move without any force, or buckles.
    #[error("{0}")]
    Moves(String),
    /// Nothing of a boom is out of its sleeve.
    #[error("beam `{beam}` is drawn into its sleeve here: nothing of it is out")]
    DrawnIn {
        /// Name.
        beam: String,
    },
}

impl Mechanism {
    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::Moves(_) => "give what moves without force a stiffness, or support it",
            Self::DrawnIn { .. } => "slide it further out; `limits` of its joint, where they are declared, keep it out",
        }
    }
}

/// Statics at one configuration. Reused between configurations: nothing is allocated after the first.
#[derive(Debug, Clone, Default)]
pub struct Statics {
    /// Positions of the vertices, m, base frame.
    pub points: Vec<Vector3<f64>>,
    /// Values where springs depend on the configuration, and the inputs of their rules; else empty.
    pub(super) local: Vec<f64>,
    pub(super) inputs: Vec<f64>,
    /// Of each member.
    pub(super) placed: Vec<Placed>,
    pub(super) closings: Vec<ClosingStatics>,
    pub(super) elimination: Elimination,
    pub(super) matrix: Vec<f64>,
    pub(super) out_of_plane: OutOfPlane,
    /// Internal forces and deformations under own weight.
    pub(super) weight: WeightStatics,
    /// Own weight is to be left out.
    weightless: bool,
    /// What the linear gaps of closures leave out at finite motions; empty where nothing has moved.
    pub(super) defects: Vec<Vector6<f64>>,
}

/// A closure at a configuration.
#[derive(Debug, Clone, Default)]
pub(super) struct ClosingStatics {
    /// What turns the gap into a force, of springs and of closures' released directions.
    pub held: Held,
    /// By how much the wrench of a spring has changed with a finite deflection.
    pub drawn: Vector6<f64>,
    /// Internal forces along its cycle by its unit forces, and the deformations they cause.
    pub forces: Vec<Matrix6<f64>>,
    pub strains: Vec<Matrix6<f64>>,
}

/// What decides which forces out of the plane of planar loops take part.
#[derive(Debug, Clone, Default)]
pub(super) struct OutOfPlane {
    /// Of each planar closing and member of its cycle: internal forces by its forces out of the plane, without those parts that do
    /// work in the plane.
    pub forces: Vec<Vec<Matrix6x3<f64>>>,
    /// Compliance of the closings out of their planes, m/N, row-major.
    pub compliance: Vec<f64>,
    /// Unknowns in the order of the compliance's rows; in the end those that are not determined.
    pub unknowns: Vec<usize>,
}

/// Statics under own weight and preloads.
#[derive(Debug, Clone, Default)]
pub(super) struct WeightStatics {
    /// Whether they were counted.
    pub active: bool,
    /// Spatial wrench of each vertex and all it carries.
    pub carried: Vec<Vector6<f64>>,
    /// Internal forces by tree member, the unknowns' share included.
    pub forces: Vec<Vector6<f64>>,
    /// Deformations by tree member, those of distributed loads and of released directions included.
    pub strains: Vec<Vector6<f64>>,
    pub unknowns: Vec<f64>,
}

impl Statics {
    /// Workspace of statics with own weight and preloads, or without.
    pub fn new(weight: bool) -> Self {
        Self { weightless: !weight, ..Self::default() }
    }

    /// Whether own weight and preloads are counted, where there are any.
    pub(super) fn counts_weight(&self) -> bool {
        !self.weightless
    }

    /// Whether own weight or preloads were counted.
    pub fn is_loaded(&self) -> bool {
        self.weight.active
    }
}
