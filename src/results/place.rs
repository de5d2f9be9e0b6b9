//! What `place` finds: where a process deflects the arm least, and the posture there. SI, base axes.

use indexmap::IndexMap;
use serde::Serialize;

use super::own_weight::OwnWeight;
use crate::compensation::{Hold, six};
use crate::description::robot::Variable;
use crate::model::Model;
use crate::planning::stiffest::{Moved, Placed, Wanted, Way};

/// Deflections along the path in the directions that count, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Deflections {
    /// Root mean square over the points.
    pub rms: f64,
    /// Greatest of a point.
    pub max: f64,
}

impl Deflections {
    /// Of a way through the path.
    pub fn of(way: &Way) -> Self {
        let [rms, max] = way.deflection();
        Self { rms, max }
    }
}

/// How the workpiece is moved.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WorkpieceMove {
    /// Along x, y, z, m.
    pub shift: [f64; 3],
    /// Rotation vector, rad.
    pub turn: [f64; 3],
    /// The point about which it turns, m.
    pub about: [f64; 3],
    /// Both as one motion of the base frame's space: position (m) and rotation vector (rad).
    pub motion: [f64; 6],
}

impl WorkpieceMove {
    fn new(moved: &Moved) -> Self {
        let [x, y, z, rx, ry, rz] = moved.by;
        Self { shift: [x, y, z], turn: [rx, ry, rz], about: moved.about.coords.into(), motion: six(&moved.motion()) }
    }
}

/// A point of the path where it is best.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlacedPoint {
    /// Position in the path, from 0.
    pub index: usize,
    /// Name of the point.
    pub name: String,
    /// rad and m.
    pub joints: IndexMap<String, f64>,
    /// The tool there, nothing deflected: m, rotation vector.
    pub pose: [f64; 6],
    /// Force (N) and torque (N.m) on the tool, base axes.
    pub wrench: [f64; 6],
    /// Displacement, m.
    pub deflection: [f64; 3],
    /// Its length in the directions that count.
    pub counted: f64,
    /// The same where the path is given, at the joints given or sought there.
    pub given: Option<f64>,
    /// Condition number of the Jacobian there, m and rad on levers of 1 m.
    pub condition: f64,
}

/// What `place` finds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Placement {
    /// Unit of lengths.
    pub unit: &'static str,
    /// Where the path is given, at the joints given or nearest; `None` where the arm cannot be there.
    pub given: Option<Deflections>,
    /// At the best posture there.
    pub posture: Option<Deflections>,
    /// At the best place and posture.
    pub best: Deflections,
    /// How the workpiece is moved from where the path is given to the best place.
    pub moved: WorkpieceMove,
    /// Points of the path at the best place, in order.
    pub points: Vec<PlacedPoint>,
    /// By variable: the greatest change from one point to the next, rad or m.
    pub steps: IndexMap<String, f64>,
    /// `rms` or `max`.
    pub least: &'static str,
    /// Directions of the deflection that count, of `x`, `y` and `z`: base axes that turn with the workpiece.
    pub directions: Vec<&'static str>,
    /// Directions of the targets that are held, of `x` to `rz`.
    pub held: Vec<&'static str>,
    /// Whether the deflections hold that by own weight.
    pub own_weight: OwnWeight,
    /// Name of the process that pushes on the tool; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub process: Option<String>,
    /// Ways through the path that were tried.
    pub tried: usize,
    /// The file of the path.
    pub table: Option<String>,
    /// Whether the workpiece may be moved.
    #[serde(skip)]
    pub may_move: bool,
    /// Name of the robot.
    #[serde(skip)]
    pub robot: String,
    /// Variables of the robot, in the order of configurations.
    #[serde(skip)]
    pub variables: Vec<Variable>,
}

impl Placement {
    /// With the names of the points, and the way through them as they are given.
    pub fn new(model: &Model, names: &[String], given: Option<&Way>, placed: &Placed, wanted: &Wanted) -> Self {
        let named = |values: &[f64]| -> IndexMap<String, f64> {
            model.variables.iter().zip(values).map(|(variable, value)| (variable.name.clone(), *value)).collect()
        };
        let postures = placed.best.postures.iter().zip(names).enumerate();
        let points = postures.map(|(index, (posture, name))| PlacedPoint {
            index,
            name: name.clone(),
            joints: named(&posture.joints),
            pose: six(&posture.rigid),
            wrench: posture.wrench,
            deflection: posture.deflection.into(),
            counted: posture.counted,
            given: given.and_then(|way| way.postures.get(index)).map(|posture| posture.counted),
            condition: posture.condition,
        });
        let mut steps = vec![0.0_f64; model.variables.len()];
        for pair in placed.best.postures.windows(2) {
            let [one, next] = pair else { continue };
            steps
                .iter_mut()
                .zip(one.joints.iter().zip(&next.joints))
                .for_each(|(most, (a, b))| *most = most.max((a - b).abs()));
        }
        let Hold(held) = wanted.hold;
        Self {
            unit: "m",
            given: given.map(Deflections::of),
            posture: placed.given.as_ref().map(Deflections::of),
            best: Deflections::of(&placed.best),
            moved: WorkpieceMove::new(&placed.best.moved),
            points: points.collect(),
            steps: named(&steps),
            least: match wanted.least {
                crate::planning::stiffest::Least::Rms => "rms",
                crate::planning::stiffest::Least::Max => "max",
            },
            directions: (0..3).filter(|&k| wanted.directions[k]).map(|k| Hold::NAMES[k]).collect(),
            held: (0..6).filter(|&k| held[k]).map(|k| Hold::NAMES[k]).collect(),
            own_weight: OwnWeight::nominal(model, wanted.weight),
            process: None,
            tried: placed.tried,
            may_move: wanted.within.iter().any(|[from, to]| from != to),
            table: None,
            robot: model.name.clone(),
            variables: model.variables.clone(),
        }
    }
}
