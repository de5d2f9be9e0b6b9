//! What is asked of a robot alone.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// `check`
#[derive(Debug, Args)]
pub struct Check {
    /// A robot: bundled name, or a .yaml or .urdf file. Or a campaign: its file (it has `measurements:`), its folder, or a
    /// bundled one.
    #[arg(value_name = "ROBOT|CAMPAIGN")]
    pub file: String,
    /// Another description than the campaign's.
    #[arg(long, value_name = "ROBOT")]
    pub robot: Option<String>,
    /// Compare a robot with the snapshot in this file; write it if there is none.
    #[arg(long, value_name = "FILE")]
    pub snapshot: Option<PathBuf>,
}

/// `convert`
#[derive(Debug, Args)]
pub struct Convert {
    /// Bundled name, or a .yaml or .urdf file; or kinematics as `ur_calibration` writes them (.yaml).
    pub robot: String,
    /// File to write; its ending (.yaml or .urdf) says which format, and --as does for .xml and for tables (.csv or .xlsx).
    pub to: PathBuf,
    /// The description that the controller works with: tables also have its values and the differences.
    #[arg(long, value_name = "ROBOT")]
    pub nominal: Option<String>,
    /// Write this format, whatever the ending.
    #[arg(long = "as", value_enum, value_name = "FORMAT")]
    pub write_as: Option<WriteAs>,
}

/// Formats of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum WriteAs {
    /// A description.
    Yaml,
    /// A URDF.
    Urdf,
    /// Where each of the six joints of such an arm places its link: `kinematics_params_file` of the driver.
    UrKinematics,
    /// A model of the simulator MuJoCo.
    Mjcf,
    /// A table of Denavit and Hartenberg's parameters: theta, d, a, alpha lead from one joint to the next.
    Dh,
    /// The same as modified by Craig: alpha and a of the link before, then theta and d.
    DhModified,
    /// A table of what is to be added to the zero of each joint; needs --nominal.
    Mastering,
}

/// `pose`
#[derive(Debug, Args)]
pub struct Pose {
    /// Bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// Values of the variables, in the description's units; those not named are zero (or the middle of their limits
    /// where zero is outside).
    #[arg(
        long,
        value_name = "A=..,B=..",
        allow_hyphen_values = true,
        conflicts_with = "table",
        required_unless_present = "table"
    )]
    pub joints: Option<String>,
    /// CSV of configurations, one column a variable, in the description's units.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Wrench on the tool, base axes, in the description's units of force and torque; own weight is added.
    #[arg(long, value_name = "FX,..,MZ", allow_hyphen_values = true)]
    pub wrench: Option<String>,
    /// Find the equilibrium at the deflected pose instead of adding the linear deflection.
    #[arg(long)]
    pub equilibrium: bool,
    /// Tool and markers where own weight, preloads, --wrench and the effects switched on put them, as `simulate` has
    /// them; without it where the rigid robot has them.
    #[arg(long)]
    pub weight: bool,
}

/// `stiffness`
#[derive(Debug, Args)]
pub struct Stiffness {
    /// Bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// Values of the variables, in the description's units; those not named are zero (or the middle of their limits
    /// where zero is outside).
    #[arg(long, value_name = "A=..,B=..", allow_hyphen_values = true)]
    pub joints: String,
    /// Frame or marker; the tool centre point by default.
    #[arg(long, value_name = "FRAME|MARKER")]
    pub at: Option<String>,
    /// Wrench there, base axes, in the description's units of force and torque.
    #[arg(long, value_name = "FX,..,MZ", allow_hyphen_values = true)]
    pub wrench: Option<String>,
    /// Add own weight and preloads.
    #[arg(long)]
    pub weight: bool,
    /// Find the equilibrium at the deflected pose.
    #[arg(long)]
    pub equilibrium: bool,
}

/// `solve`
#[derive(Debug, Args)]
pub struct Solve {
    /// Bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// Position and rotation vector of the tool in the base frame, in the description's units; three numbers for a
    /// position alone.
    #[arg(long, value_name = "X,Y,Z[,RX,RY,RZ]", allow_hyphen_values = true)]
    pub target: String,
    /// Only the solution nearest to this configuration.
    #[arg(long, value_name = "A=..,B=..", allow_hyphen_values = true)]
    pub from: Option<String>,
    /// Starts without a new branch after which the search ends.
    #[arg(long, default_value_t = 192)]
    pub restarts: usize,
    /// Bring the tool to the target as own weight, preloads and the effects switched on deflect it; without it the rigid
    /// robot's.
    #[arg(long)]
    pub weight: bool,
}

/// `view`
#[derive(Debug, Args)]
pub struct View {
    /// Bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// Values of the variables, in the description's units; those not named are zero (or the middle of their limits
    /// where zero is outside, or where nothing else can be assembled).
    #[arg(long, value_name = "A=..,B=..", allow_hyphen_values = true)]
    pub joints: Option<String>,
    /// Wrench at the tool centre point, base axes, in the description's units: draws the deflected shape.
    #[arg(long, value_name = "FX,..,MZ", allow_hyphen_values = true)]
    pub wrench: Option<String>,
    /// Add own weight and preloads to the deflected shape.
    #[arg(long)]
    pub weight: bool,
    /// Write a drawing for papers, from the side that `--look` says.
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// From where the drawing is seen, deg: about z from -y, and above the horizon.
    #[arg(long, value_name = "YAW,PITCH", default_value = "-50,20", allow_hyphen_values = true)]
    pub look: String,
    /// Leave names out of the drawing.
    #[arg(long)]
    pub no_names: bool,
}
