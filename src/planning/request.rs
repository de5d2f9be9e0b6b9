//! What is to be planned: how many configurations, of what, where, and by which criterion. SI, base frame.

use nalgebra::{Point3, Vector3};

use super::criterion::Optimality;
use super::settings::Settings;
use crate::description::campaign::{Campaign, Reading};
use crate::estimation::What;
use crate::identifiability::{Criterion, Scaling};
use crate::observation::Observes;
use crate::parameter::Slot;
use crate::simulation::Loaded;

/// An instrument that sees a reflector only from the side to which it opens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// The instrument, m, in the robot's base frame.
    pub instrument: Point3<f64>,
    /// Half opening of a reflector's cone, rad.
    pub cone: f64,
    /// Axis of the cone in the frame that carries the reflector, a unit vector.
    pub facing: Vector3<f64>,
}

impl Sight {
    /// Whether a reflector at `point` (m, base frame) whose cone opens along `axis` is seen.
    pub fn sees(&self, point: &Point3<f64>, axis: &Vector3<f64>) -> bool {
        let towards = self.instrument - point;
        towards.norm() > 0.0 && axis.angle(&towards) <= self.cone
    }
}

/// What can be read, as a campaign says it.
#[derive(Debug, Clone)]
pub struct Design {
    /// The campaign; its readings do not count.
    pub campaign: Campaign,
    /// Readings that are made together at one configuration; a configuration gets the ones that serve best. Those of a contact
    /// are of configurations at which the ball touches.
    pub ways: Vec<Vec<Reading>>,
    /// File of each of these readings, as the campaign names it; `None` where it names one file alone, or none for a new session.
    pub files: Vec<Vec<Option<String>>>,
    /// Values at which is planned, by slot, SI: where base, tool and what readings refer to are about.
    pub values: Vec<f64>,
}

/// What is to be planned.
#[derive(Debug, Clone)]
pub struct Request {
    /// Configurations to add.
    pub count: usize,
    /// Which parameters are estimated in addition to base and tool.
    pub what: What,
    /// What a reading is.
    pub observes: Observes,
    /// Points measured at each configuration; `None` is the tool centre point.
    pub markers: Vec<Option<usize>>,
    /// Loads that can be applied, N and N.m, base axes; each configuration gets the one that serves best. None where
    /// empty.
    pub loads: Vec<[f64; 6]>,
    /// Readings of each point.
    pub repeats: usize,
    /// One sigma of a coordinate, m.
    pub sigma: f64,
    /// One sigma of a component of the orientation, rad.
    pub sigma_orientation: f64,
    /// Whether base, and tool and markers, are unknown.
    pub estimate: [bool; 2],
    /// What is to be best.
    pub criterion: Optimality,
    /// From where points must be seen.
    pub sight: Option<Sight>,
    /// Box of the variables, rad and m.
    pub within: Vec<[f64; 2]>,
    /// Where the measured points may be: least and greatest x, y, z in the robot's base frame, m.
    pub workspace: Option<[[f64; 2]; 3]>,
    /// Least distance between the tool centre points of two configurations, m.
    pub apart: f64,
    /// Configurations and loads at which the error counts; drawn in `tested_within` where empty.
    pub tests: Vec<Loaded>,
    /// Box of the variables in which test poses are drawn, rad and m.
    pub tested_within: Vec<[f64; 2]>,
    /// Readings that are made already.
    pub measured: Option<Campaign>,
    /// What can be read at a configuration, where a campaign file says it: then what is observed, markers, noise and unknowns
    /// are those of it.
    pub design: Option<Design>,
    /// Parameters to hold at their nominal values.
    pub hold: Vec<Slot>,
    /// Column scaling of the reduction.
    pub scaling: Scaling,
    /// When a parameter that is not exactly dependent is dropped.
    pub tolerance: Criterion,
    /// Seed of all that is drawn.
    pub seed: u64,
    /// How the search proceeds.
    pub settings: Settings,
}
