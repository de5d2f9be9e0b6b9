//! What a kind of reading must say about itself, and what the model tells it of a measured point.
//!
//! Quantities are SI (m, rad); vectors have the axes of the measurement frame unless said otherwise. Rotations of a point
//! are spatial (left) rotation vectors, so that residuals of orientations are to first order what derivatives describe
//! (Barfoot, *State Estimation for Robotics*, sec. 7.1).

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

use crate::math::linear::Svd;
use crate::parameter::Kind;

/// Greatest number of rows of one reading.
pub const MOST_ROWS: usize = 6;

/// One number for each row of a reading, lengths before angles; zero beyond the kind's number of rows.
pub type Rows = [f64; MOST_ROWS];

/// A column of measured values in a CSV file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ValueColumn {
    /// Its name.
    pub name: &'static str,
    /// What it measures: says the unit in which files write it.
    pub kind: Kind,
}

impl ValueColumn {
    /// A column of lengths.
    pub const fn length(name: &'static str) -> Self {
        Self { name, kind: Kind::Length }
    }

    /// A column of numbers without a unit.
    pub const fn number(name: &'static str) -> Self {
        Self { name, kind: Kind::Other("") }
    }

    /// A column of angles, or of the components of a rotation vector.
    pub const fn angle(name: &'static str) -> Self {
        Self { name, kind: Kind::Angle }
    }
}

/// Columns of a position.
pub const XYZ: [ValueColumn; 3] = [ValueColumn::length("x"), ValueColumn::length("y"), ValueColumn::length("z")];

/// What the model predicts of a measured point (a marker or the tool centre point).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredPoint {
    /// Position with nothing deflected, m.
    pub undeflected: Vector3<f64>,
    /// Displacement by load, own weight and effects, m.
    pub displacement: Vector3<f64>,
    /// Rotation vector by which they turn the body that carries it, rad.
    pub turned: Vector3<f64>,
    /// Orientation of the tool, deflected.
    pub orientation: Rotation3<f64>,
    /// Orientation of the body that carries it, deflected.
    pub body: Rotation3<f64>,
    /// Direction of gravity; zero where none is declared.
    pub gravity: Vector3<f64>,
    /// Of a torque: the load with which the motor holds its joint, N.m or N.
    pub load: f64,
    /// What was read there: residuals of directions are taken across it. Zero where nothing was measured yet.
    pub measured: Rows,
    /// Values of what the reading refers to, in the order of its kind; zero for kinds that refer to nothing.
    pub target: TargetValues,
}

/// Column that names the anchor from which a reading is measured.
pub const ANCHOR_COLUMN: &str = "anchor";
/// Column that names the contact that a reading touches.
pub const CONTACT_COLUMN: &str = "contact";

/// Greatest number of values of what a reading refers to.
pub const MOST_TARGET_VALUES: usize = 8;

/// Values of what a reading refers to (a fixed point, m; a zero; a gain), in the order that its kind says, SI.
pub type TargetValues = [f64; MOST_TARGET_VALUES];

impl MeasuredPoint {
    /// A point (m) of a body with this orientation, nothing deflected, the tool turned in it. Gravity, load, what was read and the
    /// target are zero.
    pub fn rigid(at: Vector3<f64>, body: Rotation3<f64>, tool: Rotation3<f64>) -> Self {
        Self {
            undeflected: at,
            displacement: Vector3::zeros(),
            turned: Vector3::zeros(),
            orientation: body * tool,
            body,
            gravity: Vector3::zeros(),
            load: 0.0,
            measured: [0.0; MOST_ROWS],
            target: [0.0; MOST_TARGET_VALUES],
        }
    }

    /// Position, deflected, m.
    pub fn position(&self) -> Vector3<f64> {
        self.undeflected + self.displacement
    }

    /// The fixed point to which the reading refers, m: the first three values of its target.
    pub fn anchor(&self) -> Vector3<f64> {
        Vector3::from_column_slice(&self.target[..3])
    }
}

/// Displacement (m) and rotation vector (rad) of a point, or their derivatives by a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twist {
    /// Displacement.
    pub displacement: Vector3<f64>,
    /// Rotation vector.
    pub rotation: Vector3<f64>,
}

impl Twist {
    /// No motion.
    pub fn zero() -> Self {
        Self::new(Vector3::zeros(), Vector3::zeros())
    }

    /// A displacement and a rotation vector.
    pub fn new(displacement: Vector3<f64>, rotation: Vector3<f64>) -> Self {
        Self { displacement, rotation }
    }
}

/// Derivative of a measured point by one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointDerivative {
    /// Of the undeflected point, as the frames that carry it move.
    pub undeflected: Twist,
    /// Of its displacement and rotation by load.
    pub deflection: Twist,
}

impl PointDerivative {
    /// The frames move, and the deflection stays.
    pub fn of_frames(undeflected: Twist) -> Self {
        Self { undeflected, deflection: Twist::zero() }
    }

    /// The deflection changes, and the frames stay.
    pub fn of_deflection(deflection: Twist) -> Self {
        Self { undeflected: Twist::zero(), deflection }
    }

    /// Of the deflected point.
    pub fn total(&self) -> Twist {
        Twist::new(
            self.undeflected.displacement + self.deflection.displacement,
            self.undeflected.rotation + self.deflection.rotation,
        )
    }
}

/// The instrument's noise, one sigma.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Of a coordinate by axis, m; of a distance the first (a file gives one number there).
    pub position: [f64; 3],
    /// Of a component of a rotation vector, rad.
    pub orientation: f64,
    /// Of a torque or force, N.m or N.
    pub load: f64,
    /// What is added to that of positions with their distance from the instrument, m/m: a constant and a part of the distance, as
    /// makers of trackers state it.
    pub ppm: f64,
    /// Whether a file states that of positions, of orientations, of loads.
    pub is_stated: [bool; 3],
}

impl Noise {
    /// Noise of an instrument, m and rad.
    pub fn of(position: [f64; 3], orientation: f64) -> Self {
        Self { position, orientation, load: 1.0, ppm: 0.0, is_stated: [true, true, false] }
    }

    /// That of a measured value, with what its distance from the instrument adds.
    #[must_use]
    pub fn at(mut self, observes: &dyn Observation, measured: &Rows) -> Self {
        let distance = match observes.measured_position(measured) {
            Some(position) => position.norm(),
            None if observes.length_rows() == 1 => measured[0].abs(),
            None => 0.0,
        };
        let more = self.ppm * distance;
        self.position.iter_mut().for_each(|sigma| *sigma += more);
        self.ppm = 0.0;
        self
    }
}

/// What the readings of a kind are made for: it decides what is estimated where nobody says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Geometry and joint offsets.
    Geometry,
    /// Stiffness: geometry shows in the readings only through the deflection.
    Stiffness,
}

/// A value that cannot be measured.
pub struct ValueFault {
    /// Its column.
    pub column: &'static str,
    /// What it must be.
    pub message: &'static str,
    /// What to do.
    pub remedy: &'static str,
}

/// A kind of reading.
pub trait Observation: Sync {
    /// Its name in files, `observes: <name>`, and on the command line.
    fn name(&self) -> &'static str;

    /// One sentence about it, for the JSON Schema and the help.
    fn about(&self) -> &'static str;

    /// Columns of the measured values, lengths first, in the order of [`Rows`]; by default none.
    fn columns(&self) -> &'static [ValueColumn] {
        &[]
    }

    /// Other columns in which files may have the same; none, or all of them, where they lack [`Observation::columns`].
    fn other_columns(&self) -> &'static [ValueColumn] {
        &[]
    }

    /// The measured values from those of [`Observation::other_columns`].
    fn of_other_columns(&self, _read: &[f64]) -> Rows {
        [0.0; MOST_ROWS]
    }

    /// The values of [`Observation::other_columns`] that mean what was measured, where a file may have them.
    fn in_other_columns(&self, _measured: &Rows) -> Option<[f64; 2]> {
        None
    }

    /// The kind that a reading is where its file has all columns of that kind: it has those of this kind, and more.
    fn with_more_columns(&self) -> Option<&'static dyn Observation> {
        None
    }

    /// First part of columns `<it>.<variable>`, for kinds of which a row holds one reading for each variable.
    fn by_variable(&self) -> Option<&'static str> {
        None
    }

    /// Whether base, tool and markers do not show in it: a body or a joint is read, wherever the robot stands.
    fn ignores_arrangement(&self) -> bool {
        false
    }

    /// Number of residuals of a reading.
    fn rows(&self) -> usize {
        self.columns().len()
    }

    /// Number of residuals that are lengths, m; they come first.
    fn length_rows(&self) -> usize {
        self.columns().iter().filter(|column| column.kind == Kind::Length).count()
    }

    /// Number of residuals that are angles, rad; they come behind the lengths.
    fn angle_rows(&self) -> usize {
        if self.by_variable().is_some() { 0 } else { self.rows() - self.length_rows() }
    }

    /// Whether the orientation of the tool shows: then the tool has 6 parameters, else 3, and residuals behind the
    /// lengths are a rotation vector, rad.
    fn sees_orientation(&self) -> bool {
        false
    }

    /// The text column that names what a reading refers to ([`MeasuredPoint::target`]), for kinds that need something.
    fn target_column(&self) -> Option<&'static str> {
        None
    }

    /// Whether the robot touches what it refers to, a contact: joints are led there where it is planned or simulated.
    fn touches(&self) -> bool {
        self.target_column() == Some(CONTACT_COLUMN)
    }

    /// Whether it is measured from a fixed anchor.
    fn needs_anchor(&self) -> bool {
        self.target_column() == Some(ANCHOR_COLUMN)
    }

    /// Whether what it refers to holds the point in all directions.
    fn holds_point(&self) -> bool {
        false
    }

    /// Whether what it refers to is a face.
    fn is_on_face(&self) -> bool {
        false
    }

    /// Whether its lengths are the instrument's, as an unknown scale of which shows them: not where nothing is measured.
    fn is_scaled(&self) -> bool {
        true
    }

    /// Whether it holds both position and orientation of the tool.
    fn holds_pose(&self) -> bool {
        let blank = [0.0; MOST_ROWS];
        self.measured_position(&blank).is_some() && self.measured_orientation(&blank).is_some()
    }

    /// Derivative of the prediction by the value `k` of what it refers to.
    fn by_target(&self, _point: &MeasuredPoint, _k: usize) -> Rows {
        [0.0; MOST_ROWS]
    }

    /// Whether a reading is the difference of two at one configuration, with and without the wrench: then own weight and
    /// the pose of the base drop out, and readings without load say nothing.
    fn is_difference(&self) -> bool {
        false
    }

    /// What is usually estimated from it.
    fn purpose(&self) -> Purpose {
        Purpose::Geometry
    }

    /// A start for the values of what readings refer to, from the points at which they were taken, with what they read, nothing
    /// deflected; none where nothing better than the values assumed is known.
    fn target_start(&self, _read: &[MeasuredPoint]) -> Option<TargetValues> {
        None
    }

    /// The same where it is declared about where the target is, `near`: of values that this does not say.
    fn target_start_near(&self, _near: &TargetValues, _read: &[MeasuredPoint]) -> Option<TargetValues> {
        None
    }

    /// Where the point is when it comes from a direction (unit, measurement frame) onto a target with these values; none of targets that
    /// one place or direction touches.
    fn touched_from(&self, _target: &TargetValues, _direction: &Vector3<f64>) -> Option<Vector3<f64>> {
        None
    }

    /// What is declared for it in addition to the joints and lengths of the robot: what to look at where nothing explains the readings.
    fn depends_on(&self) -> &'static str {
        "where the markers are"
    }

    /// Name of one residual in reports, in the plural.
    fn residuals_named(&self) -> &'static str {
        "coordinates"
    }

    /// What is wrong with values that cannot be measured; `is_free` says which values of the target are unknown.
    fn fault(&self, _measured: &Rows, _is_free: &[bool]) -> Option<ValueFault> {
        None
    }

    /// The same read by an instrument that counts the other way, where there is one: an accelerometer at rest shows the reaction to
    /// gravity, upwards.
    fn reversed(&self, _measured: &Rows) -> Option<Rows> {
        None
    }

    /// The measured position of the point, m, where the reading holds it: base and markers can then be fitted point by
    /// point.
    fn measured_position(&self, _measured: &Rows) -> Option<Vector3<f64>> {
        None
    }

    /// The measured orientation of the tool, where the reading holds it.
    fn measured_orientation(&self, _measured: &Rows) -> Option<Rotation3<f64>> {
        None
    }

    /// Where directions of the tool are read: the sum of their outer products with the axes of the tool that they are of, which is
    /// the rotation itself of a whole orientation. The rotation nearest to sums of these is that of least squares
    /// (Wahba, *A least squares estimate of satellite attitude*, SIAM Rev. 7, 1965).
    fn measured_axes(&self, measured: &Rows) -> Option<Matrix3<f64>> {
        self.measured_orientation(measured).map(Rotation3::into_inner)
    }

    /// What an ideal instrument would read, as columns.
    fn value(&self, point: &MeasuredPoint) -> Rows;

    /// Measured minus predicted, m and rad.
    fn residual(&self, measured: &Rows, point: &MeasuredPoint) -> Rows {
        let value = self.value(point);
        std::array::from_fn(|k| measured[k] - value[k])
    }

    /// Derivative of the prediction by a parameter, with the sign of [`Observation::residual`]'s `measured`.
    fn derivative(&self, point: &MeasuredPoint, by: &PointDerivative) -> Rows;

    /// One sigma of each row, m and rad; by default that of positions for lengths and that of orientations for all others.
    fn sigmas(&self, noise: &Noise) -> Rows {
        let (lengths, rows) = (self.length_rows(), self.rows());
        std::array::from_fn(|k| match noise.position.get(k) {
            Some(sigma) if k < lengths => *sigma,
            _ if k < rows => noise.orientation,
            _ => 0.0,
        })
    }

    /// Adds noise to an ideal reading; `normal` draws standard normal numbers, in the order of rows.
    fn disturb(&self, measured: &mut Rows, noise: &Noise, normal: &mut dyn FnMut() -> f64) {
        let sigmas = self.sigmas(noise);
        for (value, sigma) in measured.iter_mut().zip(sigmas).take(self.rows()) {
            *value += sigma * normal();
        }
    }

    /// Whether residuals of two readings of one configuration may be compared: neither shares a measurement with the
    /// other, and both look along the same direction.
    fn is_comparable(&self, _same_point: bool, _same_target: bool) -> bool {
        true
    }
}

/// A vector in the first three rows.
pub fn rows_of(vector: &Vector3<f64>) -> Rows {
    [vector.x, vector.y, vector.z, 0.0, 0.0, 0.0]
}

/// A single row.
pub(super) fn row(value: f64) -> Rows {
    [value, 0.0, 0.0, 0.0, 0.0, 0.0]
}

/// Centre a and constant c of the least-squares solution of y = 2 a.p + c over points p (m) and y (m^2): what spheres and
/// distances from one point come down to. None where the points do not determine it.
pub(super) fn centre_of(pairs: impl Iterator<Item = (Vector3<f64>, f64)> + Clone) -> Option<(Vector3<f64>, f64)> {
    let count = pairs.clone().count();
    let (sum, total) = pairs.clone().fold((Vector3::zeros(), 0.0), |(at, of), (p, y)| (at + p, of + y));
    let (at, of) = (sum / count as f64, total / count as f64);
    let (points, right): (Vec<Vector3<f64>>, Vec<f64>) = pairs.map(|(p, y)| (p - at, y - of)).unzip();
    if count < 3 || points.iter().any(|p| !p.norm().is_finite()) {
        return None;
    }
    let Svd { left, values, right: directions } = Svd::new(&DMatrix::from_fn(count, 3, |row, k| points[row][k]))?;
    if values[2] <= f64::EPSILON * values[0] {
        return None;
    }
    let along = left.tr_mul(&DVector::from_vec(right));
    let centre: Vector3<f64> =
        (0..3).map(|k| Vector3::from_fn(|i, _| directions[(i, k)]) * (0.5 * along[k] / values[k])).sum();
    centre.norm().is_finite().then(|| (centre, of - 2.0 * centre.dot(&at)))
}
