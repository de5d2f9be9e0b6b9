//! What a path asks for: targets, and the commands that a robot without errors would need.

use nalgebra::{Rotation3, Translation3, Vector3};

use super::{Desired, Hold, Refusal, Unreachable};
use crate::description::campaign::Campaign;
use crate::kinematics::{Geometry, InverseSettings, Placements, Target, Transform, rotation_vector, solve};

/// What the rows of a path give.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Asked {
    /// Joints: commands whose nominal pose is wanted, or the branch to take where positions are given too.
    pub joints: bool,
    /// Positions.
    pub position: bool,
    /// Orientations.
    pub orientation: bool,
    /// What is held of a target that the nominal robot cannot meet in all directions.
    pub hold: Hold,
}

/// The robot in its controller: nominal, rigid. Its variables are those of the calibrated robot.
#[derive(Debug, Clone, Copy)]
pub struct Controller<'a> {
    /// Nominal geometry.
    pub geometry: &'a Geometry<'a>,
    /// For each marker of the calibrated robot: the nominal one.
    pub markers: &'a [usize],
}

impl Controller<'_> {
    /// Pose of a marker (none: the tool centre point) at commands, base frame; axes of the tool. What a controller that
    /// takes poses must be given for these commands.
    ///
    /// # Errors
    /// The loops cannot be closed there.
    pub fn pose(&self, q: &[f64], marker: Option<usize>, placements: &mut Placements) -> Result<Transform, Refusal> {
        let placed = self.geometry.place(q, placements);
        placed.map_err(Unreachable::from)?;
        let tool = self.geometry.tool();
        let (frame, point) = self.point(marker);
        let frame = placements.frames[frame];
        Ok(Transform::from_parts(Translation3::from((frame * point).coords), frame.rotation * tool.rotation))
    }

    fn point(&self, marker: Option<usize>) -> (usize, nalgebra::Point3<f64>) {
        match marker {
            Some(marker) => {
                let marker = self.markers[marker];
                (self.geometry.model.markers[marker].frame, self.geometry.marker(marker))
            }
            None => (self.geometry.model.tool.0, self.geometry.tool().translation.vector.into()),
        }
    }
}

/// Targets and nominal commands of a path's rows. `axes` are the tool's where a path gives positions alone; poses given
/// stand in `frame` (in the base frame). `from` is where the search of the first row's commands starts.
pub fn desire(
    controller: &Controller,
    path: &Campaign,
    asked: Asked,
    frame: &Transform,
    axes: Option<Rotation3<f64>>,
    from: Option<&[f64]>,
) -> Vec<Result<Desired, Refusal>> {
    let mut placements = Placements::default();
    let mut last: Option<Vec<f64>> = from.map(<[f64]>::to_vec);
    let rows = path.readings.iter().enumerate();
    rows.map(|(row, reading)| {
        let v = &reading.measured;
        let position = frame * nalgebra::Point3::new(v[0], v[1], v[2]);
        let turned = frame.rotation * Rotation3::new(Vector3::new(v[3], v[4], v[5]));
        let at = |rotation| Transform::from_parts(Translation3::from(position.coords), rotation);
        if asked.joints {
            let nominal = path.configuration(row).to_vec();
            let pose = controller.pose(&nominal, reading.marker, &mut placements)?;
            let target = match (asked.position, asked.orientation) {
                (true, true) => at(turned),
                (true, false) => at(pose.rotation),
                _ => pose,
            };
            return Ok(Desired { nominal, target });
        }
        let rotation = if asked.orientation { Some(turned) } else { axes };
        let sought = Sought { marker: reading.marker, position: position.coords, rotation, hold: asked.hold };
        let nominal = inverse(controller, &sought, last.as_deref())?;
        last = Some(nominal.clone());
        let pose = controller.pose(&nominal, reading.marker, &mut placements)?;
        Ok(Desired { nominal, target: at(rotation.unwrap_or(pose.rotation)) })
    })
    .collect()
}

/// A target of the nominal robot.
struct Sought {
    marker: Option<usize>,
    position: Vector3<f64>,
    rotation: Option<Rotation3<f64>>,
    hold: Hold,
}

/// Nominal commands for a point, nearest to the last: its whole pose where the robot can, and else what is held of it.
fn inverse(controller: &Controller, sought: &Sought, last: Option<&[f64]>) -> Result<Vec<f64>, Refusal> {
    let geometry = controller.geometry;
    let (frame, point) = controller.point(sought.marker);
    let tool = geometry.tool();
    // The tool centre point that goes with the marker.
    let arm = match sought.rotation {
        Some(rotation) => rotation * tool.rotation.inverse() * (tool.translation.vector - point.coords),
        None => Vector3::zeros(),
    };
    let position = (sought.position + arm).into();
    if sought.marker.is_some() && (frame != geometry.model.tool.0 || sought.rotation.is_none()) {
        return Err(Unreachable::MarkerNeedsJoints.into());
    }
    let near = InverseSettings { restarts: 0, from: last.map(<[f64]>::to_vec), ..InverseSettings::default() };
    let anywhere = InverseSettings { restarts: 192, ..near.clone() };
    let settings = [&near, &anywhere].into_iter().skip(usize::from(last.is_none()));
    let whole = sought.rotation.is_some() && sought.hold != Hold::POSE;
    let holds = whole.then_some(Hold::POSE).into_iter().chain([sought.hold]);
    let mut why = Unreachable::NoSolution;
    for (settings, hold) in settings.flat_map(|settings| holds.clone().map(move |hold| (settings, hold))) {
        match solve(geometry, &Target { position, rotation: sought.rotation, hold }, settings) {
            Ok(mut found) if !found.is_empty() => return Ok(found.swap_remove(0).joints),
            Ok(_) => {}
            Err(error) => why = error.into(),
        }
    }
    Err(why.into())
}

/// Position (m) and rotation vector (rad) of a pose.
pub fn six(pose: &Transform) -> [f64; 6] {
    let (p, r) = (pose.translation.vector, rotation_vector(&pose.rotation));
    [p.x, p.y, p.z, r.x, r.y, r.z]
}
