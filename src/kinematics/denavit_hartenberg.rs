//! Denavit and Hartenberg's parameters of an arm whose joints stand in series, from where its axes lie: of a description of any
//! convention.
//!
//! Source: J. Denavit and R. S. Hartenberg, *A kinematic notation for lower-pair mechanisms based on matrices*, 1955; with the common
//! normal of two parallel axes where the description's frames have it.

use nalgebra::{Rotation3, Vector3};

use super::assembly_error::AssemblyError;
use super::geometry::{Geometry, Placements};
use super::transform::Transform;
use crate::description::raw::JointKind;
use crate::description::robot::Motion;
use crate::math::wrapped;

/// A joint: `Rz(theta) Tz(d) Tx(a) Rx(alpha)` lead from its frame to that of the next joint (rad, m).
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Name of the description's frame that the joint moves.
    pub joint: String,
    /// Name of the variable that is added to `theta`, or to `d` of a joint that slides.
    pub variable: String,
    pub slides: bool,
    pub theta: f64,
    pub d: f64,
    /// Zero of the last joint, whose frame is the description's.
    pub a: f64,
    pub alpha: f64,
}

/// Parameters of an arm.
#[derive(Debug, Clone, PartialEq)]
pub struct DenavitHartenberg {
    /// The first joint's frame in the description's base frame.
    pub base: Transform,
    pub links: Vec<Link>,
    /// The tool centre point in the last joint's frame.
    pub tool: Transform,
}

/// Why an arm has no such parameters.
#[derive(Debug, thiserror::Error)]
pub enum NoSeries {
    #[error("the joint `{0}` has no variable of its own")]
    Driven(String),
    #[error("no joint moves the tool")]
    Rigid,
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
}

/// Sine of the angle below which axes are parallel but for rounding.
const PARALLEL: f64 = 1e-9;

/// An axis of a joint in the base frame, in the sense in which its variable counts.
struct Axis {
    frame: usize,
    variable: usize,
    at: Vector3<f64>,
    along: Vector3<f64>,
}

/// The parameters of the joints that carry the tool.
///
/// # Errors
/// A joint on the way to the tool that a loop, a coupling or an actuator moves; frames that cannot be placed.
pub fn denavit_hartenberg(geometry: &Geometry) -> Result<DenavitHartenberg, NoSeries> {
    let model = geometry.model;
    let mut placed = Placements::default();
    geometry.place(&model.middle(), &mut placed)?;
    let mut path: Vec<usize> = std::iter::successors(Some(model.tool.0), |&frame| Some(model.frames[frame].antecedent))
        .take_while(|&frame| frame != 0)
        .filter(|&frame| model.frames[frame].joint != JointKind::Fixed)
        .collect();
    path.reverse();
    let axes: Vec<Axis> = path
        .into_iter()
        .map(|frame| match model.frames[frame].motion {
            Motion::Variable { index, direction } => {
                let at = &placed.frames[frame];
                let along = at.rotation * (direction * Vector3::z());
                Ok(Axis { frame, variable: index, at: at.translation.vector, along })
            }
            _ => Err(NoSeries::Driven(model.frames[frame].name.clone())),
        })
        .collect::<Result<_, _>>()?;
    let (Some(first), Some(last)) = (axes.first(), axes.last()) else { return Err(NoSeries::Rigid) };

    // Where the description's constants put the first frame before its joint moves it.
    let antecedent = &placed.frames[model.frames[first.frame].antecedent];
    let unmoved = antecedent * geometry.constants.frames[first.frame].transform;
    let mut arriving = (unmoved.translation.vector, unmoved.rotation * Vector3::x());
    let base = frame_of(arriving.0, arriving.1, first.along);
    let mut links = Vec::with_capacity(axes.len());
    for (k, axis) in axes.iter().enumerate() {
        let (foot, x, next) = match axes.get(k + 1) {
            None => (axis.at, placed.frames[axis.frame].rotation * Vector3::x(), None),
            Some(next) => {
                let (foot, x, end) = common_normal(axis, next, &usual_normal(geometry, next.frame, &placed));
                (foot, x, Some((end, next)))
            }
        };
        let turned = signed_angle(&arriving.1, &x, &axis.along);
        let slid = (foot - arriving.0).dot(&axis.along);
        let (frame, q) = (&model.frames[axis.frame], placed.variables[axis.variable]);
        let slides = frame.joint == JointKind::Prismatic;
        let (theta, d) = if slides { (turned, slid - q) } else { (wrapped(turned - q), slid) };
        let (a, alpha) =
            next.map_or((0.0, 0.0), |(end, next)| ((end - foot).dot(&x), signed_angle(&axis.along, &next.along, &x)));
        let variable = model.variables[axis.variable].name.clone();
        links.push(Link { joint: frame.name.clone(), variable, slides, theta, d, a, alpha });
        arriving = (next.map_or(foot, |(end, _)| end), x);
    }
    let at_tool = placed.frames[model.tool.0] * geometry.tool();
    let tool = frame_of(last.at, arriving.1, last.along).inverse() * at_tool;
    Ok(DenavitHartenberg { base, links, tool })
}

/// Where the description has the common normal of a joint's axis with the one before: `Ry(beta) Rz(gamma) Tz(b)` in the antecedent.
fn usual_normal(geometry: &Geometry, frame: usize, placed: &Placements) -> Transform {
    let frame = &geometry.model.frames[frame];
    let [beta, gamma, b] = [0, 1, 2].map(|k| geometry.values()[frame.slots[k]]);
    let turned =
        Rotation3::from_axis_angle(&Vector3::y_axis(), beta) * Rotation3::from_axis_angle(&Vector3::z_axis(), gamma);
    placed.frames[frame.antecedent] * Transform::from_parts((turned * Vector3::new(0.0, 0.0, b)).into(), turned)
}

/// Foot on the first axis, direction, and foot on the second of the common normal; of parallel axes through the point, and in the
/// sense, that the description's frame has it.
fn common_normal(a: &Axis, b: &Axis, usual: &Transform) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let sense = usual.rotation * Vector3::x();
    let like = |x: Vector3<f64>| if x.dot(&sense) < 0.0 { -x } else { x };
    let cross = a.along.cross(&b.along);
    let between = b.at - a.at;
    if cross.norm() < PARALLEL {
        let foot = a.at + (usual.translation.vector - a.at).dot(&a.along) * a.along;
        let end = b.at + (foot - b.at).dot(&b.along) * b.along;
        let apart = end - foot;
        let x = if apart.norm() > PARALLEL { like(apart.normalize()) } else { square_to(&sense, &a.along) };
        return (foot, x, end);
    }
    let n = cross.norm_squared();
    let along_a = between.cross(&b.along).dot(&cross) / n;
    let along_b = between.cross(&a.along).dot(&cross) / n;
    (a.at + along_a * a.along, like(cross.normalize()), b.at + along_b * b.along)
}

/// The part of a direction that is square to an axis, of unit length.
fn square_to(direction: &Vector3<f64>, axis: &Vector3<f64>) -> Vector3<f64> {
    let left = direction - direction.dot(axis) * axis;
    left.try_normalize(PARALLEL).unwrap_or_else(|| axis.cross(&axis.yzx()).normalize())
}

/// A frame with its z along an axis, and its x as near to a direction as that leaves.
fn frame_of(at: Vector3<f64>, x: Vector3<f64>, z: Vector3<f64>) -> Transform {
    let x = square_to(&x, &z);
    let axes = nalgebra::Matrix3::from_columns(&[x, z.cross(&x), z]);
    Transform::from_parts(at.into(), Rotation3::from_matrix_unchecked(axes))
}

/// Angle from one direction to another about an axis, rad.
fn signed_angle(from: &Vector3<f64>, to: &Vector3<f64>, axis: &Vector3<f64>) -> f64 {
    from.cross(to).dot(axis).atan2(from.dot(to))
}
