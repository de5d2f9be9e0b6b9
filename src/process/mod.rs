//! Processes: the wrench on the tool as a function of where the tool really is. They know no robot.

mod elastica;
mod plastic;
mod strip;

pub use elastica::{Tip, bend};
pub use plastic::{Bent, Plastic};
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
    /// The strip cannot be bent so far.
    #[error(
        "the strip folds at its clamp before its surface is {depth:.2} mm deep at {along:.2} mm from it: what does not harden \
         holds no more (`hardening`)"
    )]
    Hinge {
        /// Place along the strip, mm.
        along: f64,
        /// Depth, mm.
        depth: f64,
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

    /// The same process elsewhere, m.
    #[must_use]
    pub fn moved(&self, by: &Vector3<f64>) -> Self {
        let mut moved = self.clone();
        moved.strip.iter_mut().for_each(|strip| strip.clamp += by);
        moved.springs.iter_mut().for_each(|(at, _)| *at += by);
        moved
    }

    /// Whether what the tool did before counts: a strip that yields.
    pub fn remembers(&self) -> bool {
        self.strip.as_ref().is_some_and(|strip| strip.plastic.is_some())
    }

    /// The process after the tool was at a point (m) reached by travelling in a direction, and how far its strip was bent;
    /// `None` of one that remembers nothing, and where the tool does not touch.
    ///
    /// # Errors
    /// [`ProcessError`].
    pub fn after(&self, at: &Vector3<f64>, travel: &Vector3<f64>) -> Result<Option<(Self, Bent)>, ProcessError> {
        let Some(strip) = &self.strip else { return Ok(None) };
        let after = strip.after(at, travel)?;
        Ok(after.map(|(strip, bent)| (Self { strip: Some(strip), ..self.clone() }, bent)))
    }

    /// What it does to the tool at a point (m) reached by travelling in a direction (any length; zero: without travel).
    ///
    /// # Errors
    /// [`ProcessError`].
    ///
    /// ```
    /// use nalgebra::Vector3;
    ///
    /// let (process, _) = elastogeo::files::Reader::default().process("ir663-strip")?;
    /// // 25 mm into the strip, 400 mm from its clamp; the strip pushes the tool up, and 920 N hang on it.
    /// let push = process.push(&Vector3::new(1.83, 0.0, 1.4), &Vector3::zeros())?;
    /// assert!(push.force.z > -920.0);
    /// # Ok::<(), elastogeo::Error>(())
    /// ```
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
