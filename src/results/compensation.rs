//! What `compensate` finds: commands under which the real robot passes where it should. SI.

use indexmap::IndexMap;
use nalgebra::Vector3;
use serde::Serialize;

use super::own_weight::OwnWeight;
use crate::compensation::{self, Hold, Outcome, Point, Refusal, Sides};
use crate::description::robot::Variable;
use crate::math::{mean_rms_max, norm};
use crate::model::Model;
use crate::process::Bent;

/// How the robot misses a target without correction, by what causes it, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Deviation {
    /// Displacement of the tool from the target by all causes together, base axes; the sum of the four that follow.
    pub all: [f64; 3],
    /// Angle between the tool's axes and the target's, rad.
    pub orientation: f64,
    /// By the difference between the calibrated constants and the controller's, base axes.
    pub geometry: [f64; 3],
    /// By own weight and preloads, base axes.
    pub weight: [f64; 3],
    /// By the applied wrench, that of a process included, base axes.
    pub wrench: [f64; 3],
    /// By the effects of the description, base axes.
    pub effects: [f64; 3],
}

impl Deviation {
    fn new(found: &compensation::Deviation) -> Self {
        let xyz = |v: &Vector3<f64>| [v.x, v.y, v.z];
        Self {
            all: xyz(&found.all),
            orientation: found.turned,
            geometry: xyz(&found.geometry),
            weight: xyz(&found.weight),
            wrench: xyz(&found.wrench),
            effects: xyz(&found.effects),
        }
    }
}

/// A strip that can yield, at a point: how far its free end is bent, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StripAt {
    /// Under the tool.
    pub bent: f64,
    /// After the tool has left.
    pub left: f64,
    /// Greatest curvature so far over that at which it yields; 1 as long as it has not.
    pub worst: f64,
}

impl From<Bent> for StripAt {
    fn from(bent: Bent) -> Self {
        Self { bent: bent.under, left: bent.left, worst: bent.worst }
    }
}

/// What a path leaves of a strip.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StripLeft {
    /// The last point that touches it.
    pub after: String,
    /// There.
    #[serde(flatten)]
    pub at: StripAt,
    /// How far its free end springs back when the tool leaves, m.
    pub sprung_back: f64,
    /// The first point at which it yields.
    pub yields_at: Option<String>,
}

impl StripLeft {
    /// From the points of a path, in their order, that touch the strip.
    pub fn new<'a>(points: impl Iterator<Item = (&'a str, StripAt)>) -> Option<Self> {
        let (mut last, mut yields_at) = (None, None);
        for (name, at) in points {
            if yields_at.is_none() && at.worst > 1.0 {
                yields_at = Some(name.to_string());
            }
            last = Some((name.to_string(), at));
        }
        let (after, at) = last?;
        Some(Self { after, at, sprung_back: at.bent - at.left, yields_at })
    }
}

/// A point that is met.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CorrectedPoint {
    /// Position in the path, from 0.
    pub index: usize,
    /// Name of the point.
    pub name: String,
    /// Commands, rad and m.
    pub joints: IndexMap<String, f64>,
    /// Predicted distance from the target.
    pub residual: f64,
    /// Predicted angle from what is held of the target's axes, rad.
    pub orientation_residual: f64,
    /// Standard uncertainty of the point along x, y, z, m, where the description says how it was fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_uncertainty: Option<[f64; 3]>,
    /// By direction that is not held: the target less where the point is, m along x, y, z of the base, rad about rx, ry, rz of the
    /// target.
    pub let_go: IndexMap<&'static str, f64>,
    /// Always `ok` here; a point that cannot be met is a [`RefusedPoint`].
    pub status: PointStatus,
    /// Commands less nominal ones.
    pub correction: Option<IndexMap<String, f64>>,
    /// Pose of the commands by the controller's own geometry (m, rotation vector).
    pub pose: Option<[f64; 6]>,
    /// `None` where arm and process have no equilibrium without correction.
    pub before: Option<Deviation>,
    /// Force (N) and torque (N.m) on the tool at the target, those of a process included, base axes.
    pub wrench: [f64; 6],
    /// With a process: distance from the target of the equilibrium found from the commands alone.
    pub settled: Option<f64>,
    /// With a strip that can yield, where the tool touches it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strip: Option<StripAt>,
    /// How far the linear deflection at the commands is off that of the equilibrium at the deflected pose; absent with
    /// `--equilibrium` and in a stream.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linear_error: Option<f64>,
    /// Steps of the search that found the commands.
    pub iterations: usize,
    /// Condition number of the Jacobian at the nominal commands, m and rad on levers of 1 m.
    pub condition: f64,
}

/// Whether a point can be met: `ok`, or `refused: ` and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PointStatus {
    /// The point is met.
    Ok,
    /// The point is refused, and why.
    Refused(String),
}

impl std::fmt::Display for PointStatus {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Ok => f.write_str("ok"),
            Self::Refused(why) => write!(f, "refused: {why}"),
        }
    }
}

impl Serialize for PointStatus {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// A point that cannot be met.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RefusedPoint {
    /// Position in the path, from 0.
    pub index: usize,
    /// Name of the point.
    pub name: String,
    joints: Option<f64>,
    residual: Option<f64>,
    /// `refused: ` and why.
    pub status: PointStatus,
    /// Why it is refused, in words.
    #[serde(skip)]
    pub why: String,
}

impl RefusedPoint {
    /// A point, counted from 0, and why it is refused.
    pub fn new(index: usize, name: String, why: String) -> Self {
        Self { index, name, joints: None, residual: None, status: PointStatus::Refused(why.clone()), why }
    }
}

/// A point of the path.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum CompensatedPoint {
    /// The point is met.
    Corrected(Box<CorrectedPoint>),
    /// The point cannot be met.
    Refused(RefusedPoint),
}

/// Distances from the targets.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Distances {
    /// Mean, m.
    pub mean: f64,
    /// Root mean square, m.
    pub rms: f64,
    /// Greatest, m.
    pub max: f64,
}

impl Distances {
    /// Of lengths.
    pub(super) fn of(all: impl Iterator<Item = f64>) -> Self {
        let [mean, rms, max] = mean_rms_max(all);
        Self { mean, rms, max }
    }
}

/// What `compensate` finds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compensation {
    /// Unit of lengths.
    pub unit: &'static str,
    /// All points of the path, in order.
    pub points: Vec<CompensatedPoint>,
    /// Without correction.
    pub before: Distances,
    /// As predicted at the corrected commands.
    pub after: Distances,
    /// How far linear deflections are off those of the equilibria at the deflected poses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linear_error: Option<Distances>,
    /// Standard uncertainties of where the points are then, where the description says how it was fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Distances>,
    /// Indices, from 0.
    pub refused: Vec<usize>,
    /// Where the sides of approach come from.
    pub sides: Sides,
    /// Directions of the targets that are held.
    pub held: Vec<&'static str>,
    /// Whether the predictions hold the deflection by own weight.
    pub own_weight: OwnWeight,
    /// Effects of the measurement, which are not compensated.
    pub left_out: Vec<String>,
    /// Name of the process that pushes on the tool; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub process: Option<String>,
    /// With a strip that can yield: what remains of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strip: Option<StripLeft>,
    /// The file of the commands.
    pub table: Option<String>,
    /// Name of the robot.
    #[serde(skip)]
    pub robot: String,
    /// Variables of the robot, in the order of the commands.
    #[serde(skip)]
    pub variables: Vec<Variable>,
}

impl Compensation {
    /// With the names of points; `nominal` commands, and `poses` of the commands by the controller's geometry.
    pub fn new(
        model: &Model,
        names: &[String],
        nominal: &[Option<Vec<f64>>],
        poses: &[Option<[f64; 6]>],
        outcome: &Outcome,
        hold: Hold,
    ) -> Self {
        let named = Named { model, names, nominal, poses, hold };
        let refused = |index: usize, why: &Refusal| RefusedPoint::new(index, names[index].clone(), why.to_string());
        let points = outcome.points.iter().enumerate().map(|(index, point)| match point {
            Ok(point) => CompensatedPoint::Corrected(Box::new(named.corrected(index, point))),
            Err(why) => CompensatedPoint::Refused(refused(index, why)),
        });
        let met = || outcome.points.iter().filter_map(|point| point.as_ref().ok());
        let touching = outcome.points.iter().zip(names);
        let touching = touching.filter_map(|(point, name)| Some((name.as_str(), point.as_ref().ok()?.strip?.into())));
        let refused = outcome.points.iter().enumerate().filter(|(_, point)| point.is_err());
        Self {
            unit: "m",
            points: points.collect(),
            before: Distances::of(met().filter_map(|point| point.before).map(|deviation| deviation.all.norm())),
            after: Distances::of(met().map(|point| point.corrected.position)),
            linear_error: met()
                .any(|point| point.linear_error.is_some())
                .then(|| Distances::of(met().filter_map(|point| point.linear_error))),
            uncertainty: None,
            refused: refused.map(|(index, _)| index).collect(),
            sides: outcome.sides,
            held: (0..6).filter(|&k| hold.0[k]).map(|k| Hold::NAMES[k]).collect(),
            own_weight: OwnWeight::nominal(model, true),
            left_out: outcome.left_out.clone(),
            process: None,
            strip: StripLeft::new(touching),
            table: None,
            robot: model.name.clone(),
            variables: model.variables.clone(),
        }
    }

    /// The same with the standard uncertainties (m) of all points of the path.
    #[must_use]
    pub fn with_uncertainties(mut self, all: &[[f64; 3]]) -> Self {
        for point in &mut self.points {
            if let CompensatedPoint::Corrected(point) = point {
                point.standard_uncertainty = all.get(point.index).copied();
            }
        }
        let size = |own: [f64; 3]| norm(&own);
        let sizes: Vec<f64> = self.met().filter_map(|point| point.standard_uncertainty).map(size).collect();
        self.uncertainty = Some(Distances::of(sizes.into_iter()));
        self
    }

    /// The points that are met.
    pub fn met(&self) -> impl Iterator<Item = &CorrectedPoint> {
        self.points.iter().filter_map(|point| match point {
            CompensatedPoint::Corrected(point) => Some(&**point),
            CompensatedPoint::Refused(_) => None,
        })
    }

    /// The points that are refused.
    pub fn not_met(&self) -> impl Iterator<Item = &RefusedPoint> {
        self.points.iter().filter_map(|point| match point {
            CompensatedPoint::Corrected(_) => None,
            CompensatedPoint::Refused(point) => Some(point),
        })
    }
}

/// What a point is called and was commanded, by index.
struct Named<'a> {
    model: &'a Model,
    names: &'a [String],
    nominal: &'a [Option<Vec<f64>>],
    poses: &'a [Option<[f64; 6]>],
    hold: Hold,
}

impl Named<'_> {
    fn corrected(&self, index: usize, point: &Point) -> CorrectedPoint {
        let found = &point.corrected;
        let joints = |q: &[f64]| self.model.variables.iter().zip(q).map(|(v, q)| (v.name.clone(), *q)).collect();
        let less = |nominal: &Vec<f64>| -> Vec<f64> { found.joints.iter().zip(nominal).map(|(q, n)| q - n).collect() };
        CorrectedPoint {
            index,
            name: self.names[index].clone(),
            joints: joints(&found.joints),
            residual: found.position,
            orientation_residual: found.orientation,
            standard_uncertainty: None,
            let_go: self.hold.let_go().map(|k| (Hold::NAMES[k], found.off[k])).collect(),
            status: PointStatus::Ok,
            correction: self.nominal[index].as_ref().map(less).map(|by| joints(&by)),
            pose: self.poses[index],
            before: point.before.as_ref().map(Deviation::new),
            wrench: point.wrench,
            settled: point.settled,
            strip: point.strip.map(StripAt::from),
            linear_error: point.linear_error,
            iterations: found.iterations,
            condition: found.condition,
        }
    }
}
