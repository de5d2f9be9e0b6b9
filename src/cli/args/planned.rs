//! Readings to come and paths to follow.

use std::path::PathBuf;

use clap::builder::{ArgPredicate, PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};

use super::Reduction;
use crate::description::table::{Orientation, QuaternionOrder};
use crate::observation::{Kinds, Observes};
use crate::planning::stiffest::Least;
use crate::render::program::Moves;

/// `simulate`
#[derive(Debug, Args)]
pub struct Simulate {
    /// Bundled name, or a .yaml or .urdf file. Or a campaign file, of which nothing need be measured: its contacts, sensors,
    /// payloads, sessions and unknowns are simulated, each of its files with the configurations asked for.
    #[arg(value_name = "ROBOT|CAMPAIGN")]
    pub robot: String,
    /// Number of configurations to draw, or a CSV of configurations in the description's units: one column a variable, and
    /// loads fx, .., mz. Where it has a pose next to the joints, as `compensate --table` writes it, the joints count.
    #[arg(long, value_name = "N|FILE")]
    pub poses: String,
    /// Folder to write campaign.yaml, measurements.csv and truth.json to.
    #[arg(long, value_name = "FOLDER")]
    pub into: PathBuf,
    /// Process that pushes back as the tool moves, a YAML file or a bundled one: readings are taken in equilibrium with
    /// it, and hold its wrench; --poses may be a path of poses. Without errors or noise unless they are given.
    #[arg(long, value_name = "FILE")]
    pub process: Option<String>,
    /// What a reading is; by default a position.
    #[arg(long, value_parser = kinds_of_readings(&Kinds::standard()))]
    pub observes: Option<Observes>,
    /// Markers read at each configuration; the tool centre point by default.
    #[arg(long, value_delimiter = ',')]
    pub markers: Vec<String>,
    /// Readings of each marker at each configuration.
    #[arg(long, default_value_t = 1)]
    pub repeats: usize,
    /// Noise of a coordinate, one sigma, mm.
    #[arg(long, default_value_t = 0.03, default_value_if("process", ArgPredicate::IsPresent, "0"))]
    pub noise: f64,
    /// Noise of a component of the orientation, one sigma, deg.
    #[arg(long, default_value_t = 0.003, default_value_if("process", ArgPredicate::IsPresent, "0"))]
    pub orientation_noise: f64,
    /// Geometry errors: normal, this many times each free parameter's tolerance.
    #[arg(long, default_value_t = 1.0, default_value_if("process", ArgPredicate::IsPresent, "0"))]
    pub errors: f64,
    /// Errors of springs: normal, this many times each identifiable spring's tolerance.
    #[arg(long, default_value_t = 0.0)]
    pub elastic_errors: f64,
    /// Wrench read at each marker, base axes, in the description's units; may be given several times.
    #[arg(long, value_name = "FX,..,MZ", allow_hyphen_values = true)]
    pub wrench: Vec<String>,
    /// Errors of single parameters: name=value, added to the nominal value, in the description's units; of a stiffness also
    /// `inf`, which makes it rigid, and of a spring that is rigid as described its stiffness itself.
    #[arg(long, value_delimiter = ',', value_name = "NAME=..", allow_hyphen_values = true)]
    pub set: Vec<String>,
    /// Place the robot at random in the measurement frame and declare base (and markers) unknown.
    #[arg(long)]
    pub unknown_base: bool,
    /// Move markers at random by millimetres and declare them unknown.
    #[arg(long)]
    pub unknown_tool: bool,
    /// Names of sessions, in each of which an equal run of the configurations is read: with --unknown-base and --unknown-tool
    /// base and tool are others in each, and declared unknown per session.
    #[arg(long, value_delimiter = ',', value_name = "NAME,..", conflicts_with = "process")]
    pub sessions: Vec<String>,
    /// How often the fixture of a campaign's contacts is put down anew: members of their `group:`.
    #[arg(long, default_value_t = 1)]
    pub placements: usize,
    /// Share of each variable's limits from which configurations are drawn.
    #[arg(long, default_value_t = 0.8)]
    pub share: f64,
    /// Narrower limits of variables, in the description's units: name=low:high.
    #[arg(long, value_delimiter = ',', value_name = "NAME=LOW:HIGH", allow_hyphen_values = true)]
    pub range: Vec<String>,
    /// Box through which no link may pass, in addition to those that the description declares; may be given several times. Ends left out
    /// are open. Base frame, in the description's units.
    #[arg(long, value_name = "X0:X1,Y0:Y1,Z0:Z1", allow_hyphen_values = true)]
    pub keep_out: Vec<String>,
    /// Share of configurations marked `check`.
    #[arg(long, default_value_t = crate::estimation::CHECK)]
    pub check: f64,
    /// Effect to put in, its parameters in SI (`gear-ratio@joint:2:ratio=5e-4`); may be given several times. Records the
    /// conditions too.
    #[arg(long, value_name = "EFFECT@SITE:PARAMETER=..,..", allow_hyphen_values = true)]
    pub effect: Vec<String>,
    /// Record side of approach, time and temperature.
    #[arg(long)]
    pub conditions: bool,
}

/// `plan`
#[derive(Debug, Args)]
pub struct Plan {
    /// Bundled name, or a .yaml or .urdf file. Or a campaign file: what it says can be read is planned, whether anything is
    /// measured yet or not.
    #[arg(value_name = "ROBOT|CAMPAIGN")]
    pub robot: String,
    /// Number of configurations to choose.
    #[arg(long, value_name = "N")]
    pub poses: usize,
    /// What is to be identified: `geometric`, `elastic`, or `geometric,elastic`; by default stiffness from deflections
    /// and geometry from all other readings.
    #[arg(long, value_delimiter = ',')]
    pub what: Vec<String>,
    /// What a reading is; by default a deflection where only stiffness is to be identified, else a position.
    #[arg(long, value_parser = kinds_of_readings(&Kinds::standard()))]
    pub observes: Option<Observes>,
    /// Markers read at each configuration; the tool centre point by default.
    #[arg(long, value_delimiter = ',')]
    pub markers: Vec<String>,
    /// Readings of each marker at each configuration.
    #[arg(long, default_value_t = 1)]
    pub repeats: usize,
    /// Noise of a coordinate, one sigma, mm; with --add-to the noise that the campaign states counts.
    #[arg(long, default_value_t = 0.03)]
    pub noise: f64,
    /// Noise of a component of the orientation, one sigma, deg; with --add-to the campaign's, where stated.
    #[arg(long, default_value_t = 0.003)]
    pub orientation_noise: f64,
    /// The robot's place in the measurement frame is unknown.
    #[arg(long)]
    pub unknown_base: bool,
    /// Markers or tool are unknown.
    #[arg(long)]
    pub unknown_tool: bool,
    /// Load that can be applied, base axes, in the description's units; may be given several times. Each configuration
    /// gets the one that serves best.
    #[arg(long, value_name = "FX,..,MZ", allow_hyphen_values = true)]
    pub wrench: Vec<String>,
    /// CSV of the configurations at which accuracy counts: one column a variable, and loads fx, .., mz, in the
    /// description's units; by default 100 drawn in the box.
    #[arg(long, value_name = "FILE")]
    pub test: Option<PathBuf>,
    /// Limits between which test poses are drawn, as of --range, which holds for what is not named.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "NAME=LOW:HIGH",
        allow_hyphen_values = true,
        conflicts_with = "test"
    )]
    pub test_range: Vec<String>,
    /// What is to be best: test-error (position error after compensation at the test poses), D, A, E, O1 to O5.
    #[arg(long, default_value = "test-error")]
    pub criterion: String,
    /// Take the constants of the robot as known to their tolerances beforehand, as `identify --prior` does: so few configurations do
    /// that they alone would not tell the parameters apart.
    #[arg(long)]
    pub prior: bool,
    /// Where the instrument stands in the robot's base frame, in the description's units.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub instrument: Option<String>,
    /// Half opening of the cone from which a reflector is seen, deg.
    #[arg(long, value_name = "DEG", requires = "instrument", default_value_t = 60.0)]
    pub cone: f64,
    /// Direction to which reflectors open, in the frame that carries them; its z axis by default.
    #[arg(long, value_name = "X,Y,Z", requires = "instrument", allow_hyphen_values = true)]
    pub facing: Option<String>,
    /// Narrower limits of variables, in the description's units: name=low:high.
    #[arg(long, value_delimiter = ',', value_name = "NAME=LOW:HIGH", allow_hyphen_values = true)]
    pub range: Vec<String>,
    /// Share of each variable's limits to stay in.
    #[arg(long, default_value_t = 1.0)]
    pub share: f64,
    /// Box in which the measured points stay, base frame, in the description's units; ends left out are open.
    #[arg(long, value_name = "X0:X1,Y0:Y1,Z0:Z1", allow_hyphen_values = true)]
    pub workspace: Option<String>,
    /// Box through which no link may pass, in addition to those that the description declares; may be given several times. Ends left out
    /// are open. Base frame, in the description's units.
    #[arg(long, value_name = "X0:X1,Y0:Y1,Z0:Z1", allow_hyphen_values = true)]
    pub keep_out: Vec<String>,
    /// Least distance between the tool centre points of two configurations, in the description's units.
    #[arg(long, default_value_t = 0.0)]
    pub apart: f64,
    /// Add to the readings of this campaign, which says what is observed, how well, and what is unknown.
    #[arg(long, value_name = "CAMPAIGN", conflicts_with_all = ["observes", "unknown_base", "unknown_tool"])]
    pub add_to: Option<String>,
    /// Session of the campaign in which is measured next, one of its own or a new one; by default its last.
    #[arg(long, value_name = "NAME")]
    pub session: Option<String>,
    /// Placement in which the fixture of the campaign's contacts stands; by default the last in its files.
    #[arg(long, value_name = "NAME")]
    pub placement: Option<String>,
    /// How often the fixture is put down, where nothing is measured yet; once by default.
    #[arg(long, value_name = "N")]
    pub placements: Option<usize>,
    /// Write the configurations (and loads) as a CSV; of a campaign with its columns, in its units.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Reduction.
    #[command(flatten)]
    pub reduction: Reduction,
}

/// Reads a kind of readings that can be planned and simulated by its name in files: a contact needs a fixture, a torque its sensor.
pub(super) fn kinds_of_readings(kinds: &Kinds) -> impl TypedValueParser<Value = Observes> + use<> {
    let kinds = kinds.clone();
    let measured = kinds.iter().filter(|kind| !kind.columns().is_empty());
    let values: Vec<PossibleValue> =
        measured.map(|kind| PossibleValue::new(kind.name()).help(kind.about().trim_end_matches('.'))).collect();
    PossibleValuesParser::new(values).try_map(move |name| kinds.named(&name).ok_or("no such kind of readings"))
}

/// `compensate`
#[derive(Debug, Args)]
pub struct Compensate {
    /// The robot as calibrated: bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// CSV of points, or a bundled process whose path is meant: joints, or x, y, z and rx, ry, rz (rotation vector); and
    /// fx to mz, marker, approach.<variable>, temperature, as in campaigns.
    #[arg(required_unless_present = "stream")]
    pub path: Option<String>,
    /// Read points from the standard input, a line with the columns' names first, and answer each line with its commands.
    #[arg(long, conflicts_with_all = ["path", "table", "program", "process"])]
    pub stream: bool,
    /// The description that the controller works with: what joints of the path mean, and from which poses are computed.
    #[arg(long, value_name = "ROBOT")]
    pub nominal: Option<String>,
    /// Units of the path where they are not the description's: `length=mm,angle=deg`.
    #[arg(long, value_name = "KIND=UNIT,..")]
    pub units: Option<String>,
    /// How the path writes its orientations: by default as rx, ry, rz, rotation vectors.
    #[arg(long, value_enum, default_value_t = OrientationName::RotationVector)]
    pub orientation: OrientationName,
    /// Marker that should pass; the tool centre point by default.
    #[arg(long, value_name = "MARKER")]
    pub at: Option<String>,
    /// Frame of the path's poses.
    #[arg(long, value_enum, default_value_t = FrameName::Base)]
    pub frame: FrameName,
    /// Configuration from which the first point is sought, and whose orientation is kept where the path has none.
    #[arg(long, value_name = "A=..,B=..", allow_hyphen_values = true)]
    pub from: Option<String>,
    /// What of the targets is held: `pose`, `axis` (position and the tool's z axis), `position`, or directions, along x,
    /// y, z of the base and about rx, ry, rz of the target's own axes (`position,rz` of a SCARA robot); by default the pose,
    /// `axis` of robots with five variables and `position` of those with fewer.
    #[arg(long, value_delimiter = ',', value_name = "WHAT,..")]
    pub hold: Vec<String>,
    /// Load of all points, base axes, in the description's units, where the path has no columns fx .. mz.
    #[arg(long, value_name = "FX,..,MZ", allow_hyphen_values = true)]
    pub wrench: Option<String>,
    /// Process that pushes back as the tool moves: a YAML file, or a bundled one.
    #[arg(long, value_name = "FILE")]
    pub process: Option<String>,
    /// Find the equilibrium at the deflected pose of each point instead of adding the linear deflection.
    #[arg(long)]
    pub equilibrium: bool,
    /// Instead of commands: how far what pushes on the tool moves it with declared numbers multiplied by factors, each alone;
    /// named by where they stand in the description (`sections.*.wall=0.5,2`, `joint_stiffness.2.kar=2`) or in the process
    /// (`process.strip.young=1.1`). `place.x=-100,100` (y, z) moves path and process. May be given several times.
    #[arg(long, value_name = "PARAMETER=FACTOR,..", allow_hyphen_values = true,
        conflicts_with_all = ["stream", "table", "program", "keep_going"])]
    pub vary: Vec<String>,
    /// Residual up to which a point counts as met, mm (and mm on a lever of 1 m); 1e-4 by default. Where it is given, a
    /// linear deflection that is off by more is a warning.
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pub residual: Option<f64>,
    /// Greatest correction of an angle, deg; of a stroke in proportion to half its range.
    #[arg(long, value_name = "DEG", default_value_t = 5.0, allow_hyphen_values = true)]
    pub largest: f64,
    /// Write the corrected commands and the controller's poses of them (CSV); not if a point is refused.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Write table and program without the points refused.
    #[arg(long)]
    pub keep_going: bool,
    /// Print the corrected path as a program: krl, rapid, urscript, fanuc-ls, gcode, csv or json, or by a template of your own
    /// (minijinja, given what `json` prints).
    #[arg(long, value_name = "LANGUAGE|FILE")]
    pub program: Option<String>,
    /// What the moves of the program name; by default joints, poses in G-code.
    #[arg(long, value_enum, requires = "program")]
    pub moves: Option<Moves>,
    /// Speed of the tool along linear moves of the program, mm/s.
    #[arg(long, value_name = "MM/S", default_value_t = 50.0, allow_hyphen_values = true, requires = "program")]
    pub speed: f64,
    /// Name of the program; by default that of the path's file.
    #[arg(long, value_name = "NAME", requires = "program")]
    pub program_name: Option<String>,
}

/// `place`
#[derive(Debug, Args)]
pub struct Place {
    /// Bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// CSV of points, or a bundled process whose path is meant, as `compensate` takes it: joints, or x, y, z and rx, ry, rz; and fx
    /// to mz, which turn with the workpiece.
    pub path: String,
    /// How far the workpiece may be shifted along x, y, z, and turned about rx, ry, rz (a rotation vector) through the middle of the
    /// path, base axes, in the description's units; it stays where it is in what is not named.
    #[arg(long = "move", value_delimiter = ',', value_name = "NAME=LOW:HIGH", allow_hyphen_values = true)]
    pub movement: Vec<String>,
    /// What of the targets is held, as of `compensate`: what is let go is chosen for the least deflection.
    #[arg(long, value_delimiter = ',', value_name = "WHAT,..")]
    pub hold: Vec<String>,
    /// Directions of the deflection that count: x, y, z of the base as the workpiece is given, which turn with it; all by default.
    #[arg(long, value_delimiter = ',', value_name = "AXIS,..", value_parser = ["x", "y", "z"])]
    pub direction: Vec<String>,
    /// Which deflection along the path is to be least.
    #[arg(long, value_enum, default_value_t = Least::Rms)]
    pub least: Least,
    /// Load of all points, base axes, in the description's units; it does not turn with the workpiece.
    #[arg(long, value_name = "FX,..,MZ", allow_hyphen_values = true)]
    pub wrench: Option<String>,
    /// Process that pushes back, a YAML file or a bundled one: its force where the tool should be; it moves with the workpiece, but
    /// for what it says is carried.
    #[arg(long, value_name = "FILE")]
    pub process: Option<String>,
    /// Count the deflection by own weight and preloads too.
    #[arg(long)]
    pub weight: bool,
    /// Units of the path where they are not the description's: `length=mm,angle=deg`.
    #[arg(long, value_name = "KIND=UNIT,..")]
    pub units: Option<String>,
    /// How the path writes its orientations: by default as rx, ry, rz, rotation vectors.
    #[arg(long, value_enum, default_value_t = OrientationName::RotationVector)]
    pub orientation: OrientationName,
    /// Configuration from which the first point is sought, and whose orientation is kept where the path has none.
    #[arg(long, value_name = "A=..,B=..", allow_hyphen_values = true)]
    pub from: Option<String>,
    /// Box through which no link may pass, in addition to those that the description declares; may be given several times. Ends left out
    /// are open. Base frame, in the description's units.
    #[arg(long, value_name = "X0:X1,Y0:Y1,Z0:Z1", allow_hyphen_values = true)]
    pub keep_out: Vec<String>,
    /// Greatest condition number of a posture (m and rad on levers of 1 m).
    #[arg(long, value_name = "N", default_value_t = 1000.0)]
    pub condition: f64,
    /// Write the path where it is best: joints, poses and wrenches, as `compensate` and `pose` read them.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
}

/// Frame of a path's poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FrameName {
    /// The robot's base.
    Base,
    /// That in which the calibrated base has its pose.
    Measurement,
}

/// How a path writes its orientations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OrientationName {
    /// Columns rx, ry, rz.
    RotationVector,
    /// Columns qx, qy, qz, qw, or q0 to q3 with the scalar last.
    QuaternionXyzw,
    /// The same, the scalar first.
    QuaternionWxyz,
    /// Columns A, B, C of a KUKA controller: about z, the new y, the new x.
    KukaAbc,
    /// Columns roll, pitch, yaw, about the fixed x, y, z.
    RollPitchYaw,
    /// Columns r11 to r33.
    Matrix,
}

impl From<OrientationName> for Orientation {
    fn from(name: OrientationName) -> Self {
        match name {
            OrientationName::RotationVector => Self::RotationVector,
            OrientationName::QuaternionXyzw => Self::Quaternion(QuaternionOrder::Xyzw),
            OrientationName::QuaternionWxyz => Self::Quaternion(QuaternionOrder::Wxyz),
            OrientationName::KukaAbc => Self::KukaAbc,
            OrientationName::RollPitchYaw => Self::RollPitchYaw,
            OrientationName::Matrix => Self::Matrix,
        }
    }
}
