//! Campaigns: measurements of a robot, resolved against its model, in SI.

mod amount;
mod bodies;
mod columns;
mod conditions;
mod configurations;
mod contradictions;
mod doubts;
mod faults;
mod noise_doubts;
mod order;
pub mod raw;
mod raw_certificate;
mod raw_files;
mod raw_instrument;
mod raw_measurements;
mod raw_targets;
mod read;
mod read_targets;
mod references;
mod row;
mod row_loads;
mod rows;
mod sessions;
mod source;
mod stated;
mod targets;
mod torques;
mod unused;
mod write;

use crate::description::robot::FrameIndex;
use crate::observation::{MOST_ROWS, Noise, Observes, Purpose, Rows};
use crate::parameter::Kind;
pub use amount::Amount;
pub use columns::{expected_columns, kinds};
pub use conditions::{ConditionColumn, Conditions, EARLIER_MOVES, OrderBy};
pub use configurations::{Point, point_of};
pub use faults::faults;
pub use read::resolve;
pub use references::{
    Configuration, ReferenceReading, References, completed as completed_reference, reference_columns,
};
pub use sessions::{InSession, Sessions, Sharing};
pub use targets::{Between, Constraint, Target, TargetValue};
pub use write::{csv, csv_in, names};

pub use super::columns::{LOAD_POINT, WRENCH};
pub use super::elastic::Payload;

/// Measurements of one robot. Lengths in m, angles in rad, forces in N, torques in N.m, times in s, temperatures in K or degC
/// as given.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Campaign {
    /// Display name.
    pub name: String,
    /// One unit of its file's angles, rad; `None` where no file is behind it.
    pub angle_unit: Option<f64>,
    /// What a reading is; of several kinds the first, of absolute readings and differences the first that is absolute.
    pub observes: Observes,
    /// One sigma of each coordinate (of a distance: the first), if it is known.
    pub sigma: Option<[f64; 3]>,
    /// Where `sigma` comes from.
    pub noise_origin: NoiseOrigin,
    /// One sigma of each component of an orientation, if stated.
    pub sigma_orientation: Option<f64>,
    /// Whether the base's pose in the measurement frame is unknown.
    pub estimate_base: bool,
    /// Whether markers or tool are unknown.
    pub estimate_tool: bool,
    /// Whether the instrument's scale is unknown.
    pub estimate_scale: bool,
    /// Effects re-fitted whatever is tried.
    pub calibrate: Vec<String>,
    /// Elements left out.
    pub without: Vec<String>,
    /// What readings refer to in addition to the robot: fixed points, contacts, gains; by name in the files.
    pub targets: Vec<Target>,
    /// Distances and angles between targets that hold: [`Constraint::held`] of those declared.
    pub constraints: Vec<Constraint>,
    /// Distances and angles between targets as declared.
    pub declared: Vec<Constraint>,
    /// Names of the bodies that the tool carries in some readings.
    pub payloads: Vec<(String, Payload)>,
    /// Frames of which a body is read, next to the markers of the robot: the reading's marker counts them behind those.
    pub bodies: Vec<FrameIndex>,
    /// Fixed reflectors, measured while the robot was.
    pub references: References,
    /// Runs of readings with arrangements of their own.
    pub sessions: Sessions,
    /// Files of the readings, with the number of rows through the end of each.
    pub files: Vec<(String, usize)>,
    /// Names of the configurations.
    pub poses: Vec<String>,
    /// Number of variables in each reading's configuration.
    pub variables: usize,
    /// Variables of all readings, one after the other.
    pub joints: Vec<f64>,
    /// The readings.
    pub readings: Vec<Reading>,
    /// Conditions under which the readings were taken.
    pub conditions: Conditions,
}

/// Where the noise of a campaign's lengths comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NoiseOrigin {
    /// Its files state it, or nothing does.
    #[default]
    Stated,
    /// Scatter of the distances between markers of one body.
    RigidMarkers,
    /// Scatter of readings repeated in place.
    Repeats,
    /// Scatter of fixed reflectors.
    References,
}

/// One reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Row in the files, header and empty lines left out, counted from 1 through all files.
    pub row: usize,
    /// Line of the file on which the row starts, counted from 1; 0 where it came from no file.
    pub line: usize,
    /// Configuration, by index in [`Campaign::poses`].
    pub pose: usize,
    /// The marker measured; `None` is the tool centre point.
    pub marker: Option<usize>,
    /// What it is.
    pub observes: Observes,
    /// The measured values, in the order of the columns of [`Reading::observes`], m and rad.
    pub measured: Rows,
    /// One sigma of the instrument.
    pub noise: Noise,
    /// What it refers to, by index in [`Campaign::targets`]; `None` where [`Reading::observes`] needs nothing.
    pub target: Option<usize>,
    /// Its session, and whose base, tool and scale it has.
    pub session: InSession,
    /// Force and torque applied on the tool, base axes.
    pub wrench: [f64; 6],
    /// Where they are applied.
    pub load_point: LoadPoint,
    /// Of a torque: the load with which the motor holds its joint by the description, N.m or N.
    pub load: f64,
    /// What the tool carries.
    pub payload: Option<Payload>,
    /// Whether the reading is held out to check, if the file says so.
    pub check: Option<bool>,
}

/// Where a wrench is applied.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum LoadPoint {
    /// At the measured point.
    #[default]
    Measured,
    /// At a marker of the same body; `None` is the tool centre point.
    Marker(Option<usize>),
    /// At the origin of a frame of the same body.
    Frame(FrameIndex),
}

impl Reading {
    /// Whether anything is applied to the robot: a wrench, or a body that it carries.
    pub fn is_loaded(&self) -> bool {
        self.wrench != [0.0; 6] || self.payload.is_some_and(|payload| payload.mass != 0.0)
    }
}

impl Campaign {
    /// Variables of a reading.
    pub fn configuration(&self, reading: usize) -> &[f64] {
        &self.joints[reading * self.variables..(reading + 1) * self.variables]
    }

    /// Number of residuals: those of the readings, then one for each constraint.
    pub fn rows(&self) -> usize {
        self.readings.iter().map(|reading| reading.observes.rows()).sum::<usize>() + self.constraints.len()
    }

    /// Greatest number of residuals of a reading.
    pub fn most_rows(&self) -> usize {
        self.readings.iter().map(|reading| reading.observes.rows()).max().unwrap_or(0)
    }

    /// The rows of each reading, in order, of `rows` that have `width` numbers each (row-major, readings one after the
    /// other, constraints behind them).
    pub fn by_reading<'a>(
        &'a self,
        mut rows: &'a [f64],
        width: usize,
    ) -> impl Iterator<Item = (&'a Reading, &'a [f64])> {
        self.readings.iter().map(move |reading| {
            let (own, left) = rows.split_at((reading.observes.rows() * width).min(rows.len()));
            rows = left;
            (reading, own)
        })
    }

    /// First row of each reading.
    pub fn first_rows(&self) -> Vec<usize> {
        let next = |sum: &mut usize, reading: &Reading| {
            let first = *sum;
            *sum += reading.observes.rows();
            Some(first)
        };
        self.readings.iter().scan(0, next).collect()
    }

    /// The file of a reading, if it came from one.
    pub fn file(&self, reading: &Reading) -> Option<&str> {
        self.files.iter().find(|(_, end)| reading.row <= *end).map(|(file, _)| file.as_str())
    }

    /// Where a reading stands: `measurements.csv:56`, file and line; its row where it came from no file.
    pub fn address(&self, reading: &Reading) -> String {
        match self.file(reading) {
            Some(file) if reading.line > 0 => format!("{file}:{}", reading.line),
            _ => format!("row {}", reading.row),
        }
    }

    /// The sensor of a variable's torque, by index in [`Campaign::targets`].
    pub fn sensor_of(&self, observes: &Observes, variable: &str) -> Option<usize> {
        let own = |target: &Target| Some(target.column) == observes.by_variable() && target.member.0 == variable;
        self.targets.iter().position(own)
    }

    /// Whether all readings are differences with and without load: then own weight and the base drop out.
    pub fn is_difference(&self) -> bool {
        self.observes.is_difference()
    }

    /// Whether some readings are differences with and without load.
    pub fn holds_differences(&self) -> bool {
        self.readings.iter().any(|reading| reading.observes.is_difference())
    }

    /// The campaign's absolute readings and its differences, each a campaign; `None` where it holds only one of the two.
    pub fn by_difference(&self) -> Option<[Self; 2]> {
        let is_mixed = !self.is_difference() && self.holds_differences();
        is_mixed.then(|| [false, true].map(|own| self.select(|_, reading| reading.observes.is_difference() == own)))
    }

    /// What its readings are made for: those that are absolute, where it has any.
    pub fn purpose(&self) -> Purpose {
        self.observes.purpose()
    }

    /// Whether no reading and no constraint holds a known length: the robot could be of any size then.
    pub fn lacks_length(&self) -> bool {
        let is_unknown = |reading: &Reading| {
            let target = self.target_of(reading).filter(|_| reading.observes.touches());
            target.is_some_and(|target| {
                target.values.iter().all(|value| value.kind != Kind::Length || value.parameter.is_some())
            })
        };
        let is_known = |constraint: &Constraint| {
            constraint.length.is_none() && [Between::Points, Between::Faces].contains(&constraint.between)
        };
        !self.constraints.iter().any(is_known) && !self.readings.is_empty() && self.readings.iter().all(is_unknown)
    }

    /// Whether the noise is known of what judges the campaign: of lengths, where no reading holds any of angles, else of torques.
    pub fn states_noise(&self) -> bool {
        let holds = |rows: fn(&Reading) -> usize| self.readings.iter().any(|reading| rows(reading) > 0);
        if self.sigma.is_some() || holds(|reading| reading.observes.length_rows()) {
            return self.sigma.is_some();
        }
        match holds(|reading| reading.observes.angle_rows()) {
            true => self.sigma_orientation.is_some(),
            false => !self.readings.is_empty() && self.readings.iter().all(|reading| reading.noise.is_stated[2]),
        }
    }

    /// Whether any reading holds lengths: it is not of angles or torques alone.
    pub fn holds_lengths(&self) -> bool {
        self.readings.iter().any(|reading| reading.observes.length_rows() > 0)
    }

    /// Whether any reading holds the orientation of the tool.
    pub fn sees_orientation(&self) -> bool {
        self.readings.iter().any(|reading| reading.observes.sees_orientation())
    }

    /// The instrument's noise, one sigma: as stated, else 1 mm and 1 mrad. Where only that of positions is stated, a
    /// rotation vector has the same number in rad: a component of it weighs as much as a coordinate at an arm of 1 m.
    pub fn noise(&self) -> Noise {
        noise_of(self.sigma, self.sigma_orientation)
    }

    /// States the instrument's noise, one sigma, of the campaign and of all its readings (m, rad); `None` says that it is not
    /// known.
    pub fn state_noise(&mut self, sigma: Option<[f64; 3]>, orientation: Option<f64>) {
        (self.sigma, self.sigma_orientation, self.noise_origin) = (sigma, orientation, NoiseOrigin::Stated);
        let noise = self.noise();
        self.readings.iter_mut().for_each(|reading| reading.noise = noise);
    }

    /// A reading of the campaign's kind, with its noise, of the tool centre point, in which nothing is measured.
    pub fn blank(&self) -> Reading {
        Reading {
            row: 0,
            line: 0,
            pose: 0,
            observes: self.observes,
            marker: None,
            measured: [0.0; MOST_ROWS],
            noise: self.noise(),
            target: None,
            session: InSession::default(),
            wrench: [0.0; 6],
            load_point: LoadPoint::default(),
            load: 0.0,
            payload: None,
            check: None,
        }
    }

    /// What a reading refers to.
    pub fn target_of(&self, reading: &Reading) -> Option<&Target> {
        self.targets.get(reading.target?)
    }

    /// Targets to which each point is measured, by index; a single `None` where the kind of reading needs none.
    pub fn targets_per_point(&self) -> Vec<Option<usize>> {
        let is_needed = self.observes.target_column().is_some() && !self.targets.is_empty();
        if is_needed { (0..self.targets.len()).map(Some).collect() } else { vec![None] }
    }

    /// The campaign with only the readings for which `keep` holds.
    #[must_use]
    pub fn select(&self, keep: impl Fn(usize, &Reading) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.readings.len()).filter(|&i| keep(i, &self.readings[i])).collect();
        let readings: Vec<Reading> = kept.iter().map(|&i| self.readings[i]).collect();
        let own = main_kind(readings.iter().map(|reading| reading.observes));
        let is_other = |kind: &Observes| kind.is_difference() != self.observes.is_difference();
        let observes = own.filter(is_other).unwrap_or(self.observes);
        Self {
            observes,
            joints: kept.iter().flat_map(|&i| self.configuration(i).iter().copied()).collect(),
            conditions: self.conditions.select(&kept),
            name: self.name.clone(),
            calibrate: self.calibrate.clone(),
            without: self.without.clone(),
            targets: self.targets.clone(),
            constraints: Constraint::held(&self.declared, &self.targets, &readings),
            declared: self.declared.clone(),
            readings,
            payloads: self.payloads.clone(),
            bodies: self.bodies.clone(),
            references: self.references.clone(),
            sessions: self.sessions.clone(),
            files: self.files.clone(),
            poses: self.poses.clone(),
            ..*self
        }
    }
}

/// The kind of readings that a campaign is known by: the first that is absolute, where it has any.
pub(crate) fn main_kind(mut kinds: impl Iterator<Item = Observes> + Clone) -> Option<Observes> {
    kinds.clone().find(|kind| !kind.is_difference()).or_else(|| kinds.next())
}

/// Noise as it is stated, or what is assumed instead ([`Campaign::noise`]).
pub(crate) fn noise_of(sigma: Option<[f64; 3]>, orientation: Option<f64>) -> Noise {
    let is_stated = [sigma.is_some(), orientation.is_some(), false];
    let orientation = orientation.unwrap_or_else(|| sigma.map_or(1e-3, |sigma| sigma[0]));
    Noise { is_stated, ..Noise::of(sigma.unwrap_or([1e-3; 3]), orientation) }
}
