//! Processes: the wrench on the tool as a function of where the tool really is. They know no robot.

mod elastica;
mod strip;

pub use elastica::{Tip, bend};
pub use strip::Strip;

use nalgebra::{Matrix3, Vector3};

use crate::description::process::RawProcess;

/// What pushes back on the tool. All in the robot's base frame, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Process {
    /// Display name.
    pub name: String,
    /// Force at all times, N.
    pub carried: Vector3<f64>,
    /// A strip that the tool bends.
    pub strip: Option<Strip>,
    /// Springs: where they do not pull (m), and force per displacement by axis (N/m).
    pub springs: Vec<(Vector3<f64>, Vector3<f64>)>,
}

/// What a process does to the tool at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Push {
    /// Force on the tool, N.
    pub force: Vector3<f64>,
    /// Its derivative by the tool's position, N/m.
    pub gradient: Matrix3<f64>,
}

/// A place at which a process cannot be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProcessError {
    /// Past the free end.
    #[error("the tool slips off the strip's free end: it would touch {reach:.2} mm of {length:.2} mm from the clamp")]
    Off {
        /// Length of strip from the clamp to where it would be touched, mm.
        reach: f64,
        /// Length of the strip, mm.
        length: f64,
    },
    /// At or behind the clamp.
    #[error("the tool pushes on the clamp itself, {along:.2} mm from where the strip leaves it")]
    Clamp {
        /// Place along the strip, mm.
        along: f64,
    },
    /// No shape of the strip was found.
    #[error("no shape of the strip has its surface {depth:.2} mm deep at {along:.2} mm from the clamp")]
    Shape {
        /// Place along the strip, mm.
        along: f64,
        /// Depth, mm.
        depth: f64,
    },
}

impl Process {
    /// A process from a file without faults.
    pub fn new(raw: &RawProcess) -> Self {
        let units = &raw.units;
        let spring = |stiffness: [f64; 3]| Vector3::from(stiffness) * units.stiffness.factor();
        Self {
            name: raw.process.clone().unwrap_or_else(|| "process".into()),
            carried: Vector3::from(raw.carried.unwrap_or_default()) * units.force.factor(),
            strip: raw.strip.as_ref().map(|strip| Strip::new(strip, units)),
            springs: raw
                .springs
                .iter()
                .map(|s| (Vector3::from(s.at) * units.length.factor(), spring(s.stiffness)))
                .collect(),
        }
    }

    /// What it does to the tool at a point (m) reached by travelling in a direction (any length; zero: without travel).
    ///
    /// # Errors
    /// [`ProcessError`].
    pub fn push(&self, at: &Vector3<f64>, travel: &Vector3<f64>) -> Result<Push, ProcessError> {
        let mut all = Push { force: self.carried, gradient: Matrix3::zeros() };
        if let Some(strip) = &self.strip {
            let push = strip.push(at, travel)?;
            all.force += push.force;
            all.gradient += push.gradient;
        }
        for (unloaded, stiffness) in &self.springs {
            all.force -= stiffness.component_mul(&(at - unloaded));
            all.gradient -= Matrix3::from_diagonal(stiffness);
        }
        Ok(all)
    }
}
