//! The robot in its controller: what joints of a path mean, and poses of corrected commands.

use nalgebra::Rotation3;

use crate::Error;
use crate::cli::args::FrameName;
use crate::cli::session::Session;
use crate::compensation::{Asked, Controller, Desired, Hold, Refusal, desire, six};
use crate::description::path::Path;
use crate::diagnostic::Diagnostic;
use crate::elastics::Elastics;
use crate::files::LoadedRobot;
use crate::kinematics::{Geometry, Placements, Transform};

/// The description that the controller works with.
pub struct ControllerFile {
    loaded: Option<LoadedRobot>,
    markers: Vec<usize>,
    pub diagnostics: Vec<Diagnostic>,
}

/// The controller's geometry: targets of a path, and poses of commands.
pub struct Shown<'a> {
    geometry: Geometry<'a>,
    markers: &'a [usize],
    /// The base frame in that of the measurements.
    measured: Transform,
}

impl ControllerFile {
    pub fn new(name: Option<&str>, loaded: &LoadedRobot, path: &Path, session: &Session) -> Result<Self, Error> {
        let own: Vec<usize> = (0..loaded.model.markers.len()).collect();
        let Some(name) = name else {
            let mut diagnostics = Vec::new();
            if path.joints && !path.position {
                let text = "the path gives joints, and the description itself says where they lead without load: \
                            what load and effects do is corrected, geometry errors are not";
                diagnostics.push(
                    Diagnostic::warning(text).remedy("give --nominal, the description the controller works with"),
                );
            }
            return Ok(Self { loaded: None, markers: own, diagnostics });
        };
        let nominal = session.reader.robot(name)?;
        let of = |l: &LoadedRobot| -> Vec<String> { l.model.variables.iter().map(|v| v.name.clone()).collect() };
        if of(&nominal) != of(loaded) {
            return Err(Error::input(
                format!(
                    "--nominal `{name}` has the variables {}, and the robot {}",
                    of(&nominal).join(", "),
                    of(loaded).join(", ")
                ),
                "give the uncalibrated description of the same robot",
            ));
        }
        let mut markers = Vec::new();
        for marker in &loaded.model.markers {
            let found = nominal.model.marker(&marker.name);
            let used = path.campaign.readings.iter().any(|r| r.marker == Some(markers.len()));
            match found {
                Some(found) => markers.push(found),
                None if used => {
                    return Err(Error::input(
                        format!("--nominal `{name}` has no marker `{}`", marker.name),
                        "give the uncalibrated description of the same robot",
                    ));
                }
                None => markers.push(0),
            }
        }
        let mut diagnostics = nominal.diagnostics.clone();
        diagnostics.extend(exchanged(name, &nominal, loaded));
        Ok(Self { loaded: Some(nominal), markers, diagnostics })
    }

    /// Its geometry, and that of the calibrated robot's base.
    ///
    /// # Errors
    /// A description that cannot be assembled.
    pub fn geometry<'a>(&'a self, loaded: &'a LoadedRobot) -> Result<Shown<'a>, Error> {
        let model = self.loaded.as_ref().map_or(&loaded.model, |nominal| &nominal.model);
        let measured = Geometry::nominal(&loaded.model)?.base().inverse();
        Ok(Shown { geometry: Geometry::nominal(model)?, markers: &self.markers, measured })
    }
}

/// A warning where the calibrated description is given as that of the controller, or the same description as both.
fn exchanged(name: &str, nominal: &LoadedRobot, robot: &LoadedRobot) -> Option<Diagnostic> {
    // `diagnose --apply` writes the range of its readings and no fit.
    let is_calibrated = |loaded: &LoadedRobot| {
        let has_causes = loaded.raw.effects.iter().any(|effect| effect.applied.is_some());
        loaded.raw.calibration.fit.is_some() || loaded.raw.validity.is_some() || has_causes
    };
    if is_calibrated(nominal) && !is_calibrated(robot) {
        let text = format!(
            "--nominal `{name}` was written by a calibration or a diagnosis, and the robot was not: corrections have the wrong sign if they are exchanged"
        );
        return Some(
            Diagnostic::warning(text).remedy("give ROBOT the calibrated description and --nominal the controller's"),
        );
    }
    let values = |loaded: &LoadedRobot| loaded.model.shifted(&loaded.model.registry.nominal());
    let gives = Elastics::new(&robot.model, &values(robot), &[]).is_compliant();
    let is_same = !gives && values(nominal) == values(robot) && nominal.raw.effects == robot.raw.effects;
    is_same.then(|| {
        Diagnostic::warning(format!(
            "the robot and --nominal `{name}` are the same description: there is nothing to correct"
        ))
        .remedy("give ROBOT the description that `identify --save` wrote")
    })
}

impl Shown<'_> {
    /// The controller's own.
    pub fn geometry(&self) -> &Geometry<'_> {
        &self.geometry
    }

    /// Pose of commands by the controller's geometry.
    pub fn pose(&self, q: &[f64], marker: Option<usize>) -> Option<[f64; 6]> {
        self.controller().pose(q, marker, &mut Placements::default()).ok().map(|pose| six(&pose))
    }

    fn controller(&self) -> Controller<'_> {
        Controller { geometry: &self.geometry, markers: self.markers }
    }

    /// Targets and nominal commands of a path, sought from `from` (rad and m) on.
    pub fn desired(
        &self,
        path: &Path,
        from: Option<&[f64]>,
        frame: FrameName,
        hold: Hold,
    ) -> Result<Vec<Result<Desired, Refusal>>, Error> {
        let controller = self.controller();
        let Path { joints: own, position, orientation, .. } = *path;
        let asked = Asked { joints: own, position, orientation, hold };
        let variables = self.geometry.model.variables.len();
        let axes: Option<Rotation3<f64>> = match (from, asked.joints || asked.orientation) {
            (Some(q), false) if variables >= 6 || hold.turns() => {
                let pose = controller.pose(q, None, &mut Placements::default())?;
                Some(pose.rotation)
            }
            (None, false) if variables >= 6 => {
                return Err(Error::input(
                    "the path gives positions, and nothing says how the tool should stand",
                    "add columns rx, ry, rz or the joints, or give `compensate --from`, a configuration whose orientation is kept",
                ));
            }
            _ => None,
        };
        let frame = match frame {
            FrameName::Base => Transform::identity(),
            FrameName::Measurement => self.measured,
        };
        Ok(desire(&controller, &path.campaign, asked, &frame, axes, from))
    }
}
