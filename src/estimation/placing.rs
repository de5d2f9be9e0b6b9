//! Base, tool and markers of one group of readings, searched for globally with the robot rigid and its frames given.
//!
//! With the frames given, a reading depends on twelve numbers or so, and hundreds of fits cost less than one of the robot.
//! A fit by least squares is begun from many placements: rotations spread over all, each at the position that the readings
//! suggest (their mean; of distances the points that trilateration finds from the mean distance to each anchor). The
//! cheapest end is taken. Very weak priors about the description keep what the readings do not show from drifting.
//!
//! Sources: Kabsch 1976 (rigid fit, [`crate::math`]);
//! Manolakis, *Efficient solution and performance analysis of 3-D position estimation by trilateration*, IEEE Trans. Aerosp.
//! Electron. Syst. 32, 1996.

use nalgebra::{DMatrix, DVector, Matrix3, Point3, Rotation3, Vector3};

use super::settings::RegistrationSettings;
use crate::description::campaign::{Campaign, Reading, Target};
use crate::kinematics::{Transform, rotation_vector};
use crate::least_squares::{self, Bounds, EvaluationError, Problem};
use crate::math::{left_jacobian, nearest_rotation, rigid_fit};
use crate::observation::{MOST_TARGET_VALUES, MeasuredPoint, Observes, PointDerivative, TargetValues, Twist};
use crate::parameter::Slot;

/// Readings that share base and tool, and where their values stand.
pub struct Group<'a> {
    /// The readings.
    pub campaign: &'a Campaign,
    /// Their kind.
    pub observes: Observes,
    /// Frame of the marker or the tool of each reading, base axes.
    pub frames: Vec<Transform>,
    /// First of the three slots of the point that each reading sees.
    pub points: Vec<Slot>,
    /// First of the six slots of the base.
    pub base: Slot,
    /// Whether the points are unknown.
    pub are_points_free: bool,
    /// First of the three slots of the tool's rotation, where it shows, and whether it is unknown.
    pub tool_rotation: Option<(Slot, bool)>,
}

/// Puts the best placement found into `values`.
pub fn placed(group: &Group, values: &mut [f64], settings: &RegistrationSettings) {
    let some = Rigid::new(group, values, settings.readings);
    let mut ends: Vec<(f64, Vec<f64>, Rotation3<f64>)> = Vec::new();
    for (rotation, position) in some.starts(settings).into_iter().take(settings.starts) {
        let (rotation, turn) = some.turned(rotation);
        let trial = Rigid { rotation, ..some.clone() };
        ends.extend(trial.fitted(position, turn, settings.iterations));
    }
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    ends.truncate(settings.finalists);
    // The finalists on all readings: a subset may prefer another.
    let all = Rigid::new(group, values, usize::MAX);
    let last = |(_, x, rotation): (f64, Vec<f64>, Rotation3<f64>)| {
        Rigid { rotation, ..all.clone() }.minimized(&x, settings.last_iterations)
    };
    let best = ends.into_iter().filter_map(last).min_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((_, x, rotation)) = best {
        all.put(&x, &rotation, values);
    }
}

/// Standard deviations of the priors of the base, m and rad. Thousands of times what an instrument resolves, so that they
/// decide only what no reading does.
const LOOSE_BASE: [f64; 2] = [30.0, 10.0];
/// The same of points and of the tool's rotation: where only their sum with the base shows, the description is believed of
/// the tool, which was drawn, rather than of the base, which depends on where the instrument stood.
const LOOSE_TOOL: [f64; 2] = [3.0, 1.0];

/// Rounds of fitting the rotations of base and tool in turn, before both are fitted together.
const TURNS: usize = 10;

/// Residuals of some readings of a group in standard deviations, then weak priors, as a function of the base's position,
/// its rotation from `rotation`, the points and the tool's rotation.
#[derive(Clone)]
struct Rigid<'a> {
    group: &'a Group<'a>,
    /// Rotation of the base from which the search sets out.
    rotation: Rotation3<f64>,
    /// Readings used.
    used: Vec<usize>,
    /// First slots of the unknown points, each once.
    points: Vec<Slot>,
    /// The point that each reading sees, as described, m.
    described: Vec<Vector3<f64>>,
    /// The tool's rotation as described.
    turn: Vector3<f64>,
    /// Of each row of a reading, m and rad.
    sigmas: Vec<f64>,
    /// The description's unknowns, and how far they may be (n).
    expected: Vec<f64>,
    deviations: Vec<f64>,
}

impl<'a> Rigid<'a> {
    /// With at most so many of the readings, spread evenly.
    fn new(group: &'a Group<'a>, values: &[f64], most: usize) -> Self {
        let count = group.campaign.readings.len();
        let mut points = group.points.clone();
        points.sort_unstable();
        points.dedup();
        points.retain(|_| group.are_points_free);
        let mut expected = [values[group.base..group.base + 3].to_vec(), vec![0.0; 3]].concat();
        expected.extend(points.iter().flat_map(|&slot| values[slot..slot + 3].to_vec()));
        let mut deviations = [[LOOSE_BASE[0]; 3], [LOOSE_BASE[1]; 3]].concat();
        deviations.resize(expected.len(), LOOSE_TOOL[0]);
        let turn = group.tool_rotation.map_or_else(Vector3::zeros, |(slot, _)| at(values, slot));
        if group.tool_rotation.is_some_and(|(_, is_free)| is_free) {
            expected.extend(turn.iter());
            deviations.extend([LOOSE_TOOL[1]; 3]);
        }
        let observes = group.observes;
        Self {
            rotation: Rotation3::new(at(values, group.base + 3)),
            used: (0..count).step_by(count.div_ceil(most.max(1)).max(1)).collect(),
            described: group.points.iter().map(|&slot| at(values, slot)).collect(),
            sigmas: observes.sigmas(&group.campaign.noise())[..observes.rows()].to_vec(),
            group,
            points,
            turn,
            expected,
            deviations,
        }
    }

    /// Where in the unknowns the point of a reading begins; `None` where it is known.
    fn point_of(&self, reading: usize) -> Option<usize> {
        self.points.iter().position(|slot| *slot == self.group.points[reading]).map(|k| 6 + 3 * k)
    }

    /// Where in the unknowns the tool's rotation begins; `None` where it is known.
    fn turn_of(&self) -> Option<usize> {
        (self.expected.len() > 6 + 3 * self.points.len()).then_some(6 + 3 * self.points.len())
    }

    /// Rotations and positions of the base to begin at.
    fn starts(&self, settings: &RegistrationSettings) -> Vec<(Rotation3<f64>, Vector3<f64>)> {
        let campaign = self.group.campaign;
        let mut starts = vec![(self.rotation, Vector3::from_column_slice(&self.expected[..3]))];
        let mean = |vectors: Vec<Vector3<f64>>| vectors.iter().sum::<Vector3<f64>>() / vectors.len().max(1) as f64;
        let points: Vec<Vector3<f64>> =
            self.used.iter().map(|&i| (self.group.frames[i] * Point3::from(self.described[i])).coords).collect();
        let readings = || self.used.iter().map(|&i| &campaign.readings[i]);
        let measured: Option<Vec<Vector3<f64>>> =
            readings().map(|reading| self.group.observes.measured_position(&reading.measured)).collect();
        let centre = mean(points.clone());
        let (centres, rotations) = match measured {
            Some(measured) => {
                let (fitted, _) = rigid_fit(&points, &measured);
                // The fit of rigid points is nearly right unless they are unknown: its quarter turns too.
                (vec![mean(measured)], rotations().into_iter().map(|turn| turn * fitted).collect())
            }
            None if self.group.observes.target_column().is_some() => (self.trilaterated(settings), rotations()),
            None => (vec![starts[0].0 * centre + starts[0].1], rotations()),
        };
        let from = |rotation: Rotation3<f64>, middle: &Vector3<f64>| (rotation, middle - rotation * centre);
        starts.extend(rotations.iter().flat_map(|rotation| centres.iter().map(|middle| from(*rotation, middle))));
        starts
    }

    /// Where the readings' mean distances to their anchors meet: up to two points, of which a plane of anchors cannot tell
    /// which it is.
    fn trilaterated(&self, settings: &RegistrationSettings) -> Vec<Vector3<f64>> {
        let campaign = self.group.campaign;
        let mut spheres: Vec<(Vector3<f64>, f64)> = Vec::new();
        for target in 0..campaign.targets.len() {
            let own =
                || self.used.iter().map(|&i| &campaign.readings[i]).filter(|reading| reading.target == Some(target));
            let radius = own().map(|reading| reading.measured[0]).sum::<f64>() / own().count().max(1) as f64;
            spheres.extend(own().next().map(|reading| (anchor(campaign, reading), radius)));
        }
        let count = spheres.len().max(1) as f64;
        let middle = spheres.iter().map(|(centre, _)| centre).sum::<Vector3<f64>>() / count;
        let size = spheres.iter().map(|(_, radius)| radius).sum::<f64>() / count;
        let mut found: Vec<(f64, Vector3<f64>)> = Vec::new();
        for k in 0..6 {
            let mut from = middle;
            from[k / 2] += if k % 2 == 0 { size } else { -size };
            let end = Spheres(&spheres).meet(from, settings.iterations);
            let is_new = |point: &Vector3<f64>| found.iter().all(|(_, known)| (known - point).norm() > 0.01 * size);
            found.extend(end.filter(|(_, point)| is_new(point)));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.truncate(2);
        found.into_iter().map(|(_, point)| point).collect()
    }

    /// Rotations of base and tool that fit the directions read of the tool, from one of the base, in turn by least squares. Where
    /// positions are read too that of the base stays.
    fn turned(&self, mut base: Rotation3<f64>) -> (Rotation3<f64>, Vector3<f64>) {
        let mut turn = Rotation3::new(self.turn);
        let observes = self.group.observes;
        let seen: Vec<(Rotation3<f64>, Matrix3<f64>)> = (self.used.iter())
            .filter(|&&i| self.group.campaign.readings[i].marker.is_none())
            .filter_map(|&i| {
                let axes = observes.measured_axes(&self.group.campaign.readings[i].measured)?;
                Some((self.group.frames[i].rotation, axes))
            })
            .collect();
        if seen.is_empty() {
            return (base, self.turn);
        }
        let is_base_known =
            self.used.iter().any(|&i| observes.measured_position(&self.group.campaign.readings[i].measured).is_some());
        for _ in 0..TURNS {
            if self.turn_of().is_some() {
                let sum = seen.iter().map(|(frame, axes)| (base * frame).inverse() * axes).sum();
                turn = nearest_rotation(&sum);
            }
            if is_base_known {
                break;
            }
            base = nearest_rotation(&seen.iter().map(|(frame, axes)| axes * (frame * turn).inverse()).sum());
        }
        (base, rotation_vector(&turn))
    }

    /// Cost, unknowns and rotation where a fit from the base at `position` and this turn of the tool ends.
    fn fitted(
        &self,
        position: Vector3<f64>,
        turn: Vector3<f64>,
        most: usize,
    ) -> Option<(f64, Vec<f64>, Rotation3<f64>)> {
        let mut start = self.expected.clone();
        start[..3].copy_from_slice(position.as_slice());
        if let Some(begin) = self.turn_of() {
            start[begin..begin + 3].copy_from_slice(turn.as_slice());
        }
        self.minimized(&start, most)
    }

    /// The same from unknowns.
    fn minimized(&self, start: &[f64], most: usize) -> Option<(f64, Vec<f64>, Rotation3<f64>)> {
        let limits = least_squares::Settings {
            max_iterations: most,
            cost_tolerance: 1e-10,
            ..least_squares::Settings::default()
        };
        let end = least_squares::minimize(self, start, &Bounds::none(start.len()), &limits).ok()?;
        end.cost.is_finite().then_some((end.cost, end.x, self.rotation))
    }

    /// Writes unknowns into all values.
    fn put(&self, x: &[f64], rotation: &Rotation3<f64>, values: &mut [f64]) {
        let turned = Rotation3::new(Vector3::from_column_slice(&x[3..6])) * rotation;
        put(values, self.group.base, Vector3::from_column_slice(&x[..3]));
        put(values, self.group.base + 3, rotation_vector(&turned));
        for (k, &slot) in self.points.iter().enumerate() {
            put(values, slot, Vector3::from_column_slice(&x[6 + 3 * k..9 + 3 * k]));
        }
        if let (Some(begin), Some((slot, _))) = (self.turn_of(), self.group.tool_rotation) {
            let turn = Rotation3::new(Vector3::from_column_slice(&x[begin..begin + 3]));
            put(values, slot, rotation_vector(&turn));
        }
    }
}

impl Problem for Rigid<'_> {
    fn parameters(&self) -> usize {
        self.expected.len()
    }

    fn residuals(&self) -> usize {
        self.used.len() * self.sigmas.len() + self.expected.len()
    }

    fn evaluate(
        &self,
        x: &[f64],
        residual: &mut DVector<f64>,
        mut jacobian: Option<&mut DMatrix<f64>>,
    ) -> Result<(), EvaluationError> {
        let campaign = self.group.campaign;
        let vector = |begin: usize| Vector3::from_column_slice(&x[begin..begin + 3]);
        let turned = left_jacobian(&vector(3));
        let base = Rotation3::new(vector(3)) * self.rotation;
        let turn = self.turn_of().map_or(self.turn, vector);
        let tool_turned = left_jacobian(&turn);
        if let Some(jacobian) = jacobian.as_deref_mut() {
            jacobian.fill(0.0);
        }
        for (row, &index) in self.used.iter().enumerate() {
            let (reading, frame) = (&campaign.readings[index], &self.group.frames[index]);
            let begin = self.point_of(index);
            let arm = base * (frame * Point3::from(begin.map_or(self.described[index], vector))).coords;
            let onto = base * frame.rotation;
            // No group of readings of a body, which would need gravity, is placed.
            let point = MeasuredPoint {
                load: reading.load,
                measured: reading.measured,
                target: target_of(campaign, reading),
                ..MeasuredPoint::rigid(arm + vector(0), onto, Rotation3::new(turn))
            };
            let first = row * self.sigmas.len();
            let found = self.group.observes.residual(&reading.measured, &point);
            for (k, sigma) in self.sigmas.iter().enumerate() {
                residual[first + k] = found[k] / sigma;
            }
            let Some(jacobian) = jacobian.as_deref_mut() else { continue };
            let mut set = |column: usize, displacement: Vector3<f64>, rotation: Vector3<f64>| {
                let by = PointDerivative::of_frames(Twist::new(displacement, rotation));
                let change = self.group.observes.derivative(&point, &by);
                for (k, sigma) in self.sigmas.iter().enumerate() {
                    jacobian[(first + k, column)] = -change[k] / sigma;
                }
            };
            for axis in 0..3 {
                let unit = Vector3::ith(axis, 1.0);
                let about = turned * unit;
                set(axis, unit, Vector3::zeros());
                set(3 + axis, about.cross(&arm), about);
                begin.into_iter().for_each(|begin| set(begin + axis, onto * unit, Vector3::zeros()));
                let turn = self.turn_of().filter(|_| reading.marker.is_none());
                turn.into_iter().for_each(|begin| set(begin + axis, Vector3::zeros(), onto * (tool_turned * unit)));
            }
        }
        let priors = self.used.len() * self.sigmas.len();
        for (k, (expected, deviation)) in self.expected.iter().zip(&self.deviations).enumerate() {
            residual[priors + k] = (expected - x[k]) / deviation;
            if let Some(jacobian) = jacobian.as_deref_mut() {
                jacobian[(priors + k, k)] = -1.0 / deviation;
            }
        }
        Ok(())
    }
}

/// Values of what a reading refers to.
fn target_of(campaign: &Campaign, reading: &Reading) -> TargetValues {
    campaign.target_of(reading).map_or([0.0; MOST_TARGET_VALUES], Target::assumed)
}

/// The fixed point of a reading, m.
fn anchor(campaign: &Campaign, reading: &Reading) -> Vector3<f64> {
    Vector3::from_column_slice(&target_of(campaign, reading)[..3])
}

/// The 24 rotations that turn a cube onto itself: none is farther than 63 degrees from one of them.
fn rotations() -> Vec<Rotation3<f64>> {
    let half = std::f64::consts::FRAC_PI_2;
    let about = |axis: Vector3<f64>, quarter: usize| Rotation3::new(axis * (half * quarter as f64));
    let faces = (0..4).map(|k| about(Vector3::y(), k)).chain([1, 3].map(|k| about(Vector3::x(), k)));
    faces.flat_map(|face| (0..4).map(move |k| face * about(Vector3::z(), k))).collect()
}

/// Spheres, by centre and radius (m): the point where they meet is sought.
struct Spheres<'a>(&'a [(Vector3<f64>, f64)]);

impl Spheres<'_> {
    /// Cost and point at which they meet best, from a point.
    fn meet(&self, from: Vector3<f64>, most: usize) -> Option<(f64, Vector3<f64>)> {
        let limits = least_squares::Settings { max_iterations: most, ..least_squares::Settings::default() };
        let end = least_squares::minimize(self, from.as_slice(), &Bounds::none(3), &limits).ok()?;
        end.cost.is_finite().then(|| (end.cost, Vector3::from_column_slice(&end.x)))
    }
}

impl Problem for Spheres<'_> {
    fn parameters(&self) -> usize {
        3
    }

    fn residuals(&self) -> usize {
        self.0.len()
    }

    fn evaluate(
        &self,
        x: &[f64],
        residual: &mut DVector<f64>,
        mut jacobian: Option<&mut DMatrix<f64>>,
    ) -> Result<(), EvaluationError> {
        for (row, (centre, radius)) in self.0.iter().enumerate() {
            let arm = Vector3::from_column_slice(x) - centre;
            residual[row] = arm.norm() - radius;
            if let Some(jacobian) = jacobian.as_deref_mut() {
                let along = arm / arm.norm().max(f64::MIN_POSITIVE);
                (0..3).for_each(|k| jacobian[(row, k)] = along[k]);
            }
        }
        Ok(())
    }
}

fn at(values: &[f64], slot: Slot) -> Vector3<f64> {
    Vector3::new(values[slot], values[slot + 1], values[slot + 2])
}

fn put(values: &mut [f64], slot: Slot, vector: Vector3<f64>) {
    values[slot..slot + 3].copy_from_slice(vector.as_slice());
}
