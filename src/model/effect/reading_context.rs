//! What an effect may look at in a reading, and what it may change there.
//!
//! Lengths in m, angles in rad, loads in N and N.m; the measured point and the base in the measurement frame.

use nalgebra::{Rotation3, Vector3};

use super::driver::Driver;
use super::site::Site;
use crate::parameter::Slot;

/// What one unit of an effect's parameter changes in a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// A joint (by its coordinate) stands elsewhere than commanded, rad or m of the joint. Where a reading is the
    /// difference of two at one pose, it cancels.
    Joint(usize, f64),
    /// A joint deflects under load, rad or m: only what the applied wrench adds counts in a difference.
    Deflection(usize, f64),
    /// A parameter of the geometry has another value in this reading, SI.
    Slot(Slot, f64),
    /// The measured point is displaced (m) and the tool turned (rad), measurement frame.
    Point(Vector3<f64>, Vector3<f64>),
}

/// The changes of a reading by one unit of each parameter: the index of the parameter, and what it changes. Made once
/// for an effect at a site ([`super::Effect::changes`]) and evaluated for every reading: it must not allocate.
pub type Changes = std::sync::Arc<dyn Fn(&ReadingContext, &mut Vec<(usize, Change)>) + Send + Sync>;

/// A quantity of the surroundings that an effect reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// Time of the reading.
    Time,
    /// Temperature, of the site where it is measured there.
    Temperature,
    /// Side from which each variable approached its value.
    Approach,
    /// Move by which each variable reached its value.
    LastMove,
    /// Turns of the motor in a turn of the joint, which the description gives.
    GearRatio,
}

/// The load on a body of all that hangs on it, as it shows in a reading: of a difference, what the applied wrench adds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarriedLoad {
    /// Origin of the body's frame, measurement frame, m.
    pub origin: Vector3<f64>,
    /// Axes of the body in those of the measurement frame.
    pub axes: Rotation3<f64>,
    /// Force, N, then moment about the origin, N.m; axes of the body.
    pub wrench: [f64; 6],
    /// Whether the measured point hangs on it.
    pub carries_point: bool,
}

/// The state of the robot and its surroundings in one reading.
#[derive(Debug, Clone)]
pub struct ReadingContext<'a> {
    /// Coordinates ([`crate::model::Model::coordinates`]): actuated variables, then joints that follow them; rad or m.
    pub q: &'a [f64],
    /// Joint values by frame, rad or m.
    pub joints: &'a [f64],
    /// Load on the joint of each coordinate under own weight and the applied wrench, N.m or N.
    pub load: &'a [f64],
    /// The same under own weight alone.
    pub own_load: &'a [f64],
    /// Side of approach of each coordinate, +1 or -1; 0 where it is not known.
    pub side: &'a [f64],
    /// Move of each coordinate from the configuration before, rad or m; 0 where that is not known.
    pub last_move: &'a [f64],
    /// Moves before the last one, the later first: those of all coordinates one after the other, rad or m; 0 where not known.
    pub earlier_moves: &'a [f64],
    /// s from the start, where known.
    pub time: Option<f64>,
    /// s from the first reading of the session, where known.
    pub session_time: Option<f64>,
    /// Place in the order of measurement, counted in readings, where known.
    pub order: Option<f64>,
    /// Temperature of the reading, degC or K as given, where known; of the effect's site where that is measured.
    pub temperature: Option<f64>,
    /// The marker that was read, by index in [`crate::model::Model::markers`]; `None` is the tool centre point.
    pub marker: Option<usize>,
    /// Measured point, measurement frame, m (of a deflection: where it is, not how far it moves).
    pub position: Vector3<f64>,
    /// Origin of the base in the measurement frame, m.
    pub base: Vector3<f64>,
    /// Axes of the body that carries the measured point, in those of the measurement frame.
    pub body: Rotation3<f64>,
    /// Against gravity, measurement frame; zero without gravity.
    pub up: Vector3<f64>,
    /// What each frame's body carries, by frame.
    pub carried: &'a [CarriedLoad],
    /// Displacement by the applied wrench alone, measurement frame, m.
    pub deflection: Vector3<f64>,
    /// The reading is the loaded position less the unloaded one.
    pub is_difference: bool,
}

impl ReadingContext<'_> {
    /// A function of the load on the joint of a coordinate, as it shows in this reading: of a difference, what the applied
    /// wrench adds to it.
    pub fn of_load(&self, variable: usize, law: impl Fn(f64) -> f64) -> f64 {
        law(self.load[variable]) - if self.is_difference { law(self.own_load[variable]) } else { 0.0 }
    }

    /// Moves by which a coordinate came here, the last first, rad or m.
    pub fn moves(&self, variable: usize) -> impl Iterator<Item = f64> {
        let earlier = self.earlier_moves.chunks_exact(self.last_move.len().max(1));
        std::iter::once(self.last_move).chain(earlier).filter_map(move |moves| moves.get(variable).copied())
    }
}

impl ReadingContext<'_> {
    /// What a curve follows, SI; `None` where it is not known.
    pub fn driver(&self, driver: Driver) -> Option<f64> {
        match driver {
            Driver::Angle(variable) => self.q.get(variable).copied(),
            Driver::OwnLoad(variable) => self.own_load.get(variable).copied(),
            Driver::Load(variable) => self.load.get(variable).copied(),
            Driver::LastMove(variable) => self.last_move.get(variable).copied(),
            Driver::Time => self.time,
            Driver::SessionTime => self.session_time,
            Driver::Order => self.order,
            Driver::Temperature => self.temperature,
            Driver::Range => Some(self.position.norm()),
            Driver::Height => Some(self.up.dot(&self.position)),
        }
    }
}

/// What a campaign offers, for effects to choose by which nonlinear values to try.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Survey {
    /// Greatest load on the joint of each coordinate, N.m or N.
    pub greatest_load: Vec<f64>,
    /// Greatest load of own weight alone on the joint of each coordinate, N.m or N.
    pub greatest_own_load: Vec<f64>,
    /// Times of the configurations in order, s; empty where not known.
    pub times: Vec<f64>,
    /// Mean temperature of each frame, as the campaign gives it; none where it is not known or does not vary.
    pub mean_temperatures: Vec<Option<f64>>,
    /// Coordinates whose side of approach is known and not always the same.
    pub sides: Vec<bool>,
    /// Coordinates whose last moves are known, by an order that the campaign gives, and not always the same.
    pub moves: Vec<bool>,
    /// Least and greatest value of each coordinate, rad or m.
    pub ranges: Vec<[f64; 2]>,
    /// Greatest known move of each coordinate, rad or m; 0 where moves are not known or all the same.
    pub greatest_moves: Vec<f64>,
    /// Time from the first to the last reading of the longest session, s, where known.
    pub longest_session: Option<f64>,
    /// Knots of free curves of what varies enough: quantiles of its values in the readings, SI.
    pub knots: Vec<(Driver, Vec<f64>)>,
    /// Markers that were read, by index in [`crate::model::Model::markers`].
    pub markers: Vec<usize>,
    /// Whether a wrench is applied.
    pub loaded: bool,
    /// Readings are differences.
    pub is_difference: bool,
}

impl Survey {
    /// Mean of the temperature that a site has, where it is known and varies.
    pub fn mean_temperature(&self, site: &Site) -> Option<f64> {
        self.mean_temperatures.get(site.frame).copied().flatten()
    }
}
