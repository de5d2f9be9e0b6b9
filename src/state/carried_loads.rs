//! What each body carries: the force and the moment of all that hangs on it, under own weight and an applied wrench.
//!
//! Bodies after a joint hang on the one before it. Where a loop joins them elsewhere too, only what the joints of the tree carry
//! is counted.

use nalgebra::Vector3;

use super::joint_loads::{Mass, masses};
use super::mechanics::{LoadedPoint, Mechanics, State};
use crate::description::robot::FrameIndex;

/// Masses and the tree of frames.
#[derive(Debug, Clone)]
pub struct CarriedLoadPlan {
    masses: Vec<Mass>,
    /// Of each frame the one that it hangs on; the base's is void.
    antecedents: Vec<FrameIndex>,
}

/// Force, N, and moment about the base's origin, N.m; base axes.
type ForceAndMoment = [Vector3<f64>; 2];

/// Loads by body at one configuration. Reused between configurations: nothing is allocated.
#[derive(Debug, Clone, Default)]
pub struct CarriedLoads {
    /// Of the masses of each frame itself.
    weights: Vec<ForceAndMoment>,
    /// Of the masses of all frames that hang on it.
    own: Vec<ForceAndMoment>,
    /// By frame: of [`CarriedLoadPlan::load`], force and moment about the base's origin, base axes; and whether the loaded point
    /// hangs on it.
    pub total: Vec<(ForceAndMoment, bool)>,
}

impl CarriedLoadPlan {
    /// For the masses that a model has at the values of its mechanics.
    pub fn new(mechanics: &Mechanics) -> Self {
        let model = mechanics.geometry.model;
        let antecedents = model.frames.iter().map(|frame| frame.antecedent).collect();
        Self { masses: masses(model, mechanics.geometry.values()), antecedents }
    }

    /// Workspace for one thread.
    pub fn loads(&self) -> CarriedLoads {
        let nothing = [Vector3::zeros(); 2];
        let of_frames = vec![nothing; self.antecedents.len()];
        CarriedLoads {
            weights: of_frames.clone(),
            own: of_frames,
            total: vec![(nothing, false); self.antecedents.len()],
        }
    }

    /// Loads of own weight at a placed configuration.
    pub fn place(&self, mechanics: &Mechanics, state: &State, out: &mut CarriedLoads) {
        let gravity = mechanics.geometry.model.structure.gravity;
        out.weights.fill([Vector3::zeros(); 2]);
        out.own.fill([Vector3::zeros(); 2]);
        for &(frame, mass, centre) in &self.masses {
            let at = (state.placements.frames[frame] * nalgebra::Point3::from(centre)).coords;
            add(&mut out.weights[frame], &[mass * gravity, at.cross(&(mass * gravity))]);
        }
        // Each frame comes after the one that it hangs on.
        for frame in (1..self.antecedents.len()).rev() {
            let (weight, after) = (out.weights[frame], out.own[frame]);
            let before = &mut out.own[self.antecedents[frame]];
            add(before, &weight);
            add(before, &after);
        }
    }

    /// Adds the wrench on a point, or, `without_weight`, counts it alone.
    pub fn load(&self, point: &LoadedPoint, without_weight: bool, out: &mut CarriedLoads) {
        let CarriedLoads { own, total, .. } = out;
        for ((load, hangs), own) in total.iter_mut().zip(own.iter()) {
            (*load, *hangs) = (if without_weight { [Vector3::zeros(); 2] } else { *own }, false);
        }
        let applied = [point.force, point.moment + point.position.cross(&point.force)];
        let mut frame = point.at.frame;
        while frame != 0 {
            frame = self.antecedents[frame];
            let (load, hangs) = &mut total[frame];
            add(load, &applied);
            *hangs = true;
        }
    }
}

fn add(to: &mut ForceAndMoment, more: &ForceAndMoment) {
    to.iter_mut().zip(more).for_each(|(sum, own)| *sum += own);
}
