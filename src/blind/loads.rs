//! Loads on the joints of a machine by virtual work, from differences of placements: exact whatever closes its loops, and
//! independent of the derivatives that are under test. Forces in N, moments in N.m, base axes.

use nalgebra::{Point3, Vector3};

use crate::description::campaign::{Campaign, Reading};
use crate::description::raw::JointKind;
use crate::kinematics::{AssemblyError, Geometry, Placements};
use crate::model::Model;
use crate::state::masses;

/// Step of differences, rad and m.
const STEP: f64 = 1e-6;
/// Lengths below this one (m) are none.
const LEAST_LENGTH: f64 = 1e-3;

/// Lengths of the body that moves with a frame: those of the frames that it carries.
pub fn lengths_of(model: &Model, frame: usize) -> Vec<usize> {
    let carried = model.frames.iter().skip(1).filter(|other| other.antecedent == frame);
    let slots = carried
        .flat_map(|f| [2, 4, 6].into_iter().filter(|k| *k != 6 || f.joint != JointKind::Prismatic).map(|k| f.slots[k]));
    slots.filter(|&slot| model.registry[slot].nominal.abs() > LEAST_LENGTH).collect()
}

/// A force at a point of a frame.
#[derive(Debug, Clone, Copy)]
pub struct Applied {
    pub frame: usize,
    /// In the frame.
    pub point: Point3<f64>,
    pub force: Vector3<f64>,
}

impl Applied {
    /// The force of a reading, at its marker or the tool.
    pub fn of(geometry: &Geometry, reading: &Reading) -> Self {
        let (frame, point) = match reading.marker {
            Some(marker) => (geometry.model.markers[marker].frame, geometry.marker(marker)),
            None => (geometry.model.tool.0, geometry.tool().translation.vector.into()),
        };
        let force = Vector3::new(reading.wrench[0], reading.wrench[1], reading.wrench[2]);
        Self { frame, point, force }
    }
}

/// Loads on the joints of all variables, and the turn of each joint by its variable.
pub struct JointLoads {
    pub loads: Vec<f64>,
    pub rates: Vec<f64>,
}

/// What weighs, and the joints that carry it.
pub struct Weights {
    /// Frame, kg, point in the frame.
    masses: Vec<(usize, f64, Vector3<f64>)>,
    /// By variable.
    pub joints: Vec<usize>,
}

impl Weights {
    pub fn new(model: &Model, values: &[f64]) -> Self {
        let joints = (0..model.variables.len()).filter_map(|variable| model.joint_of(variable)).collect();
        Self { masses: masses(model, values), joints }
    }

    /// Loads under own weight and, if given, an applied force.
    pub fn loads(&self, geometry: &Geometry, q: &[f64], applied: Option<Applied>) -> Result<JointLoads, AssemblyError> {
        let gravity = geometry.model.structure.gravity;
        let (mut low, mut high) = (Placements::default(), Placements::default());
        let mut found = JointLoads { loads: Vec::new(), rates: Vec::new() };
        for (variable, &joint) in self.joints.iter().enumerate() {
            let mut moved = q.to_vec();
            moved[variable] -= STEP;
            geometry.place(&moved, &mut low)?;
            moved[variable] += 2.0 * STEP;
            geometry.place(&moved, &mut high)?;
            let path = |frame: usize, point: Point3<f64>| (high.frames[frame] * point) - (low.frames[frame] * point);
            let of_mass =
                |&(frame, mass, at): &(usize, f64, Vector3<f64>)| mass * path(frame, Point3::from(at)).dot(&gravity);
            let mut work: f64 = self.masses.iter().map(of_mass).sum();
            if let Some(Applied { frame, point, force }) = applied {
                work += path(frame, point).dot(&force);
            }
            let turn = high.joints[joint] - low.joints[joint];
            found.loads.push(work / turn);
            found.rates.push(turn / (2.0 * STEP));
        }
        Ok(found)
    }

    /// Greatest load on the joint of each variable over a campaign.
    pub fn greatest(&self, geometry: &Geometry, campaign: &Campaign) -> Result<Vec<f64>, AssemblyError> {
        let mut greatest = vec![0.0_f64; self.joints.len()];
        for (index, reading) in campaign.readings.iter().enumerate() {
            let applied = Applied::of(geometry, reading);
            let JointLoads { loads, .. } = self.loads(geometry, campaign.configuration(index), Some(applied))?;
            greatest.iter_mut().zip(loads).for_each(|(greatest, load)| *greatest = greatest.max(load.abs()));
        }
        Ok(greatest)
    }

    /// Moment of all weight after a frame, and of a force, about the frame's origin.
    pub fn moment_about(&self, model: &Model, placed: &Placements, pivot: usize, applied: &Applied) -> Vector3<f64> {
        let foot = placed.frames[pivot].translation.vector;
        let mut moment = ((placed.frames[applied.frame] * applied.point).coords - foot).cross(&applied.force);
        for &(body, mass, at) in &self.masses {
            if pivot == 0 || body == pivot || model.path(body).contains(&pivot) {
                let arm = (placed.frames[body] * Point3::from(at)).coords - foot;
                moment += arm.cross(&(model.structure.gravity * mass));
            }
        }
        moment
    }
}
