//! The command line.

use std::path::PathBuf;

use clap::builder::ArgPredicate;
use clap::{Args, Parser, Subcommand, ValueEnum};

/// Calibrate declared robots: kinematics, what can be identified, calibration, proof on poses not seen.
#[derive(Debug, Parser)]
#[command(
    name = "elastogeo",
    version,
    about,
    after_help = "A first hour: `elastogeo init my-robot`, then `elastogeo identify my-robot`.\nWhat a word means: `elastogeo explain rank`.\n\nExit status: 0 done, 1 the computation could not be completed, 2 bad input."
)]
pub struct Arguments {
    /// How results are printed.
    #[arg(long, global = true, value_enum, default_value_t = Format::Text)]
    pub format: Format,
    /// Write the result to this file, whole or not at all.
    #[arg(long, global = true, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Seed of everything drawn at random.
    #[arg(long, global = true, default_value_t = 1)]
    pub seed: u64,
    /// Number of threads; all processors by default. Results do not depend on it.
    #[arg(long, global = true, value_name = "N")]
    pub jobs: Option<usize>,
    /// Print nothing but errors; files are written all the same.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// How results are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Tables with units.
    Text,
    /// JSON.
    Json,
}

/// Commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Start: a folder with a commented description, a campaign and made-up readings.
    #[command(
        after_help = "Examples:\n  elastogeo init my-robot\n  elastogeo init my-palletiser --kind parallelogram\n  elastogeo init my-cell --kind urdf arm.urdf"
    )]
    Init(Init),
    /// What a word of the results means: rank, dropped, shrinkage, an effect, ..; without a word, the list.
    #[command(
        after_help = "Examples:\n  elastogeo explain rank\n  elastogeo explain gravity-compensator\n  elastogeo explain"
    )]
    Explain(Explain),
    /// Validate a robot; print frames, loops, degrees of freedom, parameters, what is elastic.
    #[command(
        after_help = "Examples:\n  elastogeo check universal-ur5\n  elastogeo check my-robot/robot.yaml --snapshot my-robot.snap"
    )]
    Check(Check),
    /// Write a robot as YAML or URDF.
    #[command(
        after_help = "Examples:\n  elastogeo convert arm.urdf arm.yaml\n  elastogeo convert my-robot/robot.yaml my-robot.urdf"
    )]
    Convert(Convert),
    /// Forward model: frames and markers at given joints.
    #[command(
        after_help = "Examples:\n  elastogeo pose universal-ur5 --joints q1=30,q2=-60,q3=90\n  elastogeo pose kuka-ir663 --table poses.csv --format json"
    )]
    Pose(Pose),
    /// Stiffness at a frame or marker: condensed 6x6, deflection, who gives how much.
    #[command(
        after_help = "Examples:\n  elastogeo stiffness kuka-kr270 --joints q2=-60,q3=90,q5=20 --wrench 0,0,-2500,0,0,0"
    )]
    Stiffness(Stiffness),
    /// Inverse model: all branches, or the one nearest to a configuration.
    #[command(
        after_help = "Examples:\n  elastogeo solve universal-ur5 --target 400,100,300\n  elastogeo solve universal-ur5 --target 400,100,300,180,0,0 --from q2=-60,q3=90"
    )]
    Solve(Solve),
    /// How much the tool moves per unit of each parameter, over a campaign's configurations.
    #[command(after_help = "Examples:\n  elastogeo sensitivity kuka-ir663 ir663-simulated")]
    Sensitivity(OnCampaign),
    /// What a campaign can tell: rank, what is dropped and merged into what, conditioning, observability.
    #[command(
        after_help = "Examples:\n  elastogeo identifiability kuka-ir663 ir663-paper-poses\n  elastogeo identifiability my-robot/robot.yaml my-robot --tolerance noise"
    )]
    Identifiability(Identifiability),
    /// Calibrate a robot on a campaign and judge it on poses the fit did not see.
    #[command(
        after_help = "Examples:\n  elastogeo identify kr270-simulated\n  elastogeo identify my-robot --save calibrated.yaml\n  elastogeo identify kr270-no-compensator --what elastic"
    )]
    Identify(Identify),
    /// Where the sim-to-real gap lies, which effect causes it, how far it shrinks on readings not seen.
    #[command(
        after_help = "Examples:\n  elastogeo diagnose kr270-no-compensator\n  elastogeo diagnose my-robot --apply diagnosed.yaml"
    )]
    Diagnose(Diagnose),
    /// Gravity compensator: its mounting from measured points, its spring from compliances of the joint it unloads.
    #[command(
        after_help = "Examples:\n  elastogeo compensator --circle circle.csv --anchor anchor.csv\n  elastogeo compensator --mounting 680,-100,650 --compliances k2.csv"
    )]
    Compensator(Compensator),
    /// Compare a description with measurements, fitting nothing.
    #[command(
        after_help = "Examples:\n  elastogeo residuals calibrated.yaml my-robot\n  elastogeo residuals kuka-kr270 kr270-simulated --format json"
    )]
    Residuals(OnCampaign),
    /// One self-contained HTML file about a campaign: the answer first, plots, the robot in 3-D (report.html, or --output).
    #[command(
        after_help = "Examples:\n  elastogeo report kr270-no-compensator\n  elastogeo report my-robot --output monday.html --json monday.json"
    )]
    Report(Report),
    /// The robot itself in 3-D as one self-contained HTML file (view.html, or --output), and as SVG.
    #[command(
        after_help = "Examples:\n  elastogeo view kuka-ir663\n  elastogeo view kuka-ir663 --wrench 0,0,-2500 --svg robot.svg"
    )]
    View(View),
    /// Make a campaign from a description with drawn or given errors.
    #[command(
        after_help = "Examples:\n  elastogeo simulate universal-ur5 --poses 40 --into trial\n  elastogeo simulate universal-ur5 --poses 40 --effect gear-ratio@joint:2:ratio=5e-4 --into trial"
    )]
    Simulate(Simulate),
    /// Commands under which the real robot passes where it should: geometry, own weight, load and effects corrected.
    #[command(
        after_help = "Examples:\n  elastogeo compensate calibrated.yaml path.csv --nominal my-robot/robot.yaml --table corrected.csv\n  elastogeo compensate kuka-ir663 ir663-strip --process ir663-strip"
    )]
    Compensate(Compensate),
    /// Choose the configurations (and loads) to measure that leave the smallest error after compensation.
    #[command(
        after_help = "Examples:\n  elastogeo plan universal-ur5 --poses 12 --table poses.csv\n  elastogeo plan kuka-kr270 --poses 10 --add-to kr270-simulated"
    )]
    Plan(Plan),
    /// Make sealed campaigns with withheld causes, or score the diagnosis on them.
    #[command(subcommand)]
    Blind(Blind),
    /// Print a JSON Schema.
    #[command(after_help = "Examples:\n  elastogeo schema robot --output robot.schema.json")]
    Schema(Schema),
    /// Print a completion script for a shell.
    #[command(after_help = "Examples:\n  elastogeo completions bash\n  elastogeo completions zsh --output _elastogeo")]
    Completions(Completions),
    /// Write manual pages.
    #[command(hide = true)]
    #[command(after_help = "Examples:\n  elastogeo man /usr/local/share/man/man1")]
    Man(Man),
}

/// `init`
#[derive(Debug, Args)]
pub struct Init {
    /// Folder to make; nothing is overwritten.
    pub name: String,
    /// The URDF to start from, with `--kind urdf`; it is copied into the folder.
    pub file: Option<PathBuf>,
    /// What kind of robot; serial by default, urdf where a file is given.
    #[arg(long, value_enum)]
    pub kind: Option<StarterKind>,
}

/// Kinds of starters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum StarterKind {
    /// Six revolute axes in a row.
    Serial,
    /// An arm whose elbow is driven through a parallelogram.
    Parallelogram,
    /// Whatever the URDF holds.
    Urdf,
}

/// `explain`
#[derive(Debug, Args)]
pub struct Explain {
    /// The word; the list of all words without it.
    pub term: Option<String>,
}

/// `man`
#[derive(Debug, Args)]
pub struct Man {
    /// Folder for the pages.
    pub folder: PathBuf,
}

/// `check`
#[derive(Debug, Args)]
pub struct Check {
    /// Bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// Compare with the snapshot in this file; write it if there is none.
    #[arg(long, value_name = "FILE")]
    pub snapshot: Option<PathBuf>,
}

/// `convert`
#[derive(Debug, Args)]
pub struct Convert {
    /// Bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// File to write; its ending (.yaml or .urdf) says which format.
    pub to: PathBuf,
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
    #[arg(long, requires = "wrench")]
    pub equilibrium: bool,
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
}

/// A robot and a campaign.
#[derive(Debug, Args)]
pub struct OnCampaign {
    /// Bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// Campaign file, its folder, or a bundled campaign.
    pub campaign: String,
}

/// How columns are scaled and parameters dropped.
#[derive(Debug, Args)]
pub struct Reduction {
    /// Parameters are dropped below this fraction of the greatest singular value, or `noise`: where an error of the
    /// parameter's tolerance would show less than the readings' noise.
    #[arg(long, default_value = "6e-5", value_name = "FRACTION|noise")]
    pub tolerance: String,
    /// Scaling of columns.
    #[arg(long, value_enum, default_value_t = Scale::Norm)]
    pub scale: Scale,
    /// Parameters to hold at their nominal values.
    #[arg(long, value_delimiter = ',', value_name = "NAME,..")]
    pub hold: Vec<String>,
}

/// Scaling of columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Scale {
    /// To length one.
    Norm,
    /// By the parameters' stated tolerances.
    Tolerance,
}

/// `identifiability`
#[derive(Debug, Args)]
pub struct Identifiability {
    /// Robot and campaign.
    #[command(flatten)]
    pub on: OnCampaign,
    /// Which columns: geometric, elastic, or both; by default as `identify`.
    #[arg(long, value_delimiter = ',')]
    pub what: Vec<String>,
    /// Reduction.
    #[command(flatten)]
    pub reduction: Reduction,
}

/// `identify`
#[derive(Debug, Args)]
pub struct Identify {
    /// Campaign file, its folder, or a bundled campaign.
    pub campaign: String,
    /// Another description than the campaign's.
    #[arg(long)]
    pub robot: Option<String>,
    /// What to identify: geometric, elastic, or both; by default stiffness from deflections and geometry from all
    /// other readings. Or `fuzzy`, a compliance by rules in place of springs and beams; or `grey`, springs with a fuzzy
    /// correction of what they leave.
    #[arg(long, value_delimiter = ',')]
    pub what: Vec<String>,
    /// Joints (by frame) or variables that a fuzzy compliance may depend on; by default all variables that change.
    #[arg(long, value_delimiter = ',', value_name = "NAME,..")]
    pub inputs: Vec<String>,
    /// Fit rules (and what they are compared with) only to readings under this force, N; the other loads judge them.
    #[arg(long, value_name = "N")]
    pub fit_force: Option<f64>,
    /// How the modal values of a fuzzy compliance are placed.
    #[arg(long, value_enum, default_value_t = PlacementName::GaussNewton)]
    pub placement: PlacementName,
    /// How springs that the readings see as one are split back into the description's.
    #[arg(long, value_enum, default_value_t = SplitName::Prior)]
    pub split: SplitName,
    /// Write the calibrated description (.yaml or .urdf).
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Write identified rules to this file (.yaml), which the description of --save then names.
    #[arg(long, value_name = "FILE", requires = "save")]
    pub save_rules: Option<PathBuf>,
    /// Reduction.
    #[command(flatten)]
    pub reduction: Reduction,
    /// How the fit proceeds; all end at the same parameters.
    #[arg(long, value_enum, default_value_t = SchemeName::Batch)]
    pub scheme: SchemeName,
    /// Weights of readings.
    #[arg(long, value_enum, default_value_t = WeightsName::Stated)]
    pub weights: WeightsName,
    /// Robust loss.
    #[arg(long, value_enum, default_value_t = LossName::Squares)]
    pub loss: LossName,
    /// Residual, in sigmas, beyond which the robust loss gives way.
    #[arg(long, default_value_t = 3.0)]
    pub loss_scale: f64,
    /// Let the stated tolerances pull parameters towards their nominal values.
    #[arg(long)]
    pub prior: bool,
    /// Share of the configurations set aside to check where the campaign does not say.
    #[arg(long, default_value_t = 0.25)]
    pub check: f64,
    /// Draw only so many of the configurations to fit, seeded.
    #[arg(long, value_name = "N")]
    pub train: Option<usize>,
    /// Ordinary and weighted least squares side by side; of fuzzy and grey, beside the parametric model, by load.
    #[arg(long)]
    pub compare: bool,
}

/// `diagnose`
#[derive(Debug, Args)]
pub struct Diagnose {
    /// Campaign file, its folder, or a bundled campaign.
    pub campaign: String,
    /// Another description than the campaign's.
    #[arg(long)]
    pub robot: Option<String>,
    /// Write the description as diagnosed: calibrated, effects switched on.
    #[arg(long, value_name = "FILE")]
    pub apply: Option<PathBuf>,
}

/// `compensator`
#[derive(Debug, Args)]
pub struct Compensator {
    /// CSV of the spring's point on the moving link at angles of the joint: columns q (deg), x, y, z (mm, any axes).
    #[arg(long, value_name = "FILE")]
    pub circle: Option<PathBuf>,
    /// CSV of reference points that turn about the spring's anchor on link 1: columns point, x, y, z (mm, the same
    /// axes); q may be there.
    #[arg(long, value_name = "FILE", requires = "circle")]
    pub anchor: Option<PathBuf>,
    /// L, ax and ay (mm), where they are known and not measured.
    #[arg(long, value_name = "L,AX,AY", allow_hyphen_values = true, conflicts_with_all = ["circle", "anchor"])]
    pub mounting: Option<String>,
    /// CSV of compliances of the joint: columns q (deg), k2 (1e-6 rad/(N.m)), and ci95, half widths of their 95 %
    /// intervals, where known.
    #[arg(long, value_name = "FILE")]
    pub compliances: Option<PathBuf>,
}

/// Placements of modal values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PlacementName {
    /// Gauss-Newton on the residual that the best conclusions leave.
    GaussNewton,
    /// Random search of Solis and Wets, seeded.
    SolisWets,
}

/// Rules of splitting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SplitName {
    /// In proportion to what the description says.
    Prior,
    /// The smallest sum of squared compliances.
    MinimumNorm,
}

/// Schemes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SchemeName {
    /// All at once.
    Batch,
    /// Configuration by configuration.
    PoseByPose,
    /// Base and tool, then geometry, in turns.
    Alternating,
}

/// Weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum WeightsName {
    /// The campaign's stated noise.
    Stated,
    /// All alike (OLS).
    Equal,
    /// Noise of each direction, from a first fit (WLS).
    Direction,
}

/// Losses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LossName {
    /// Plain squares.
    Squares,
    /// Huber's.
    Huber,
    /// Cauchy's.
    Cauchy,
    /// Tukey's.
    Tukey,
}

/// `simulate`
#[derive(Debug, Args)]
pub struct Simulate {
    /// Bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// Number of configurations to draw, or a CSV of configurations in the description's units.
    #[arg(long, value_name = "N|FILE")]
    pub poses: String,
    /// Folder to write campaign.yaml, measurements.csv and truth.json to.
    #[arg(long, value_name = "FOLDER")]
    pub into: PathBuf,
    /// Process that pushes back as the tool moves, a YAML file or a bundled one: readings are taken in equilibrium with
    /// it, and hold its wrench; --poses may be a path of poses. Without errors or noise unless they are given.
    #[arg(long, value_name = "FILE")]
    pub process: Option<String>,
    /// What a reading is.
    #[arg(long, value_enum, default_value_t = ObservesName::Position)]
    pub observes: ObservesName,
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
    /// `inf`, which makes it rigid.
    #[arg(long, value_delimiter = ',', value_name = "NAME=..", allow_hyphen_values = true)]
    pub set: Vec<String>,
    /// Place the robot at random in the measurement frame and declare base (and markers) unknown.
    #[arg(long)]
    pub unknown_base: bool,
    /// Move markers at random by millimetres and declare them unknown.
    #[arg(long)]
    pub unknown_tool: bool,
    /// Share of each variable's limits from which configurations are drawn.
    #[arg(long, default_value_t = 0.8)]
    pub share: f64,
    /// Narrower limits of variables, in the description's units: name=low:high.
    #[arg(long, value_delimiter = ',', value_name = "NAME=LOW:HIGH", allow_hyphen_values = true)]
    pub range: Vec<String>,
    /// Share of configurations marked `check`.
    #[arg(long, default_value_t = 0.25)]
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
    /// Bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// Number of configurations to choose.
    #[arg(long, value_name = "N")]
    pub poses: usize,
    /// What is to be identified: geometric, elastic, or both; by default stiffness from deflections and geometry from
    /// all other readings.
    #[arg(long, value_delimiter = ',')]
    pub what: Vec<String>,
    /// What a reading is; by default a deflection where only stiffness is to be identified, else a position.
    #[arg(long, value_enum)]
    pub observes: Option<ObservesName>,
    /// Markers read at each configuration; the tool centre point by default.
    #[arg(long, value_delimiter = ',')]
    pub markers: Vec<String>,
    /// Readings of each marker at each configuration.
    #[arg(long, default_value_t = 1)]
    pub repeats: usize,
    /// Noise of a coordinate, one sigma, mm.
    #[arg(long, default_value_t = 0.03)]
    pub noise: f64,
    /// Noise of a component of the orientation, one sigma, deg.
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
    /// What is to be best: test-error (position error after compensation at the test poses), D, A, E, O1 to O5.
    #[arg(long, default_value = "test-error")]
    pub criterion: String,
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
    /// Box in which the measured points stay, base frame, in the description's units.
    #[arg(long, value_name = "X0,X1,Y0,Y1,Z0,Z1", allow_hyphen_values = true)]
    pub workspace: Option<String>,
    /// Least distance between the tool centre points of two configurations, in the description's units.
    #[arg(long, default_value_t = 0.0)]
    pub apart: f64,
    /// Add to the readings of this campaign, which says what is observed, how well, and what is unknown.
    #[arg(long, value_name = "CAMPAIGN", conflicts_with_all = ["observes", "unknown_base", "unknown_tool"])]
    pub add_to: Option<String>,
    /// Write the configurations (and loads) as a CSV.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Reduction.
    #[command(flatten)]
    pub reduction: Reduction,
}

/// What a reading is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ObservesName {
    /// Position.
    Position,
    /// Position and orientation.
    Pose,
    /// Distance from the description's anchors.
    Distance,
    /// Loaded less unloaded position.
    Deflection,
}

/// `compensate`
#[derive(Debug, Args)]
pub struct Compensate {
    /// The robot as calibrated: bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// CSV of points, or a bundled process whose path is meant: joints, or x, y, z and rx, ry, rz (rotation vector); and
    /// fx to mz, marker, approach.<variable>, temperature, as in campaigns.
    pub path: String,
    /// The description that the controller works with: what joints of the path mean, and from which poses are told.
    #[arg(long, value_name = "ROBOT")]
    pub nominal: Option<String>,
    /// Units of the path where they are not the description's: `length=mm,angle=deg`.
    #[arg(long, value_name = "KIND=UNIT,..")]
    pub units: Option<String>,
    /// Marker that should pass; the tool centre point by default.
    #[arg(long, value_name = "MARKER")]
    pub at: Option<String>,
    /// Frame of the path's poses.
    #[arg(long, value_enum, default_value_t = FrameName::Base)]
    pub frame: FrameName,
    /// Configuration from which the first point is sought, and whose orientation is kept where the path has none.
    #[arg(long, value_name = "A=..,B=..", allow_hyphen_values = true)]
    pub from: Option<String>,
    /// What of the targets is held; by default all that the robot's variables can.
    #[arg(long, value_enum)]
    pub hold: Option<HoldName>,
    /// Process that pushes back as the tool moves: a YAML file, or a bundled one.
    #[arg(long, value_name = "FILE")]
    pub process: Option<String>,
    /// Residual up to which a point counts as met, mm (and mm on a lever of 1 m).
    #[arg(long, value_name = "MM", default_value_t = 1e-4, allow_hyphen_values = true)]
    pub residual: f64,
    /// Greatest correction of an angle, deg; of a stroke in proportion to half its range.
    #[arg(long, value_name = "DEG", default_value_t = 5.0, allow_hyphen_values = true)]
    pub largest: f64,
    /// Write the corrected commands and the controller's poses of them (CSV); not if a point is refused.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Write the table without the points refused.
    #[arg(long, requires = "table")]
    pub keep_going: bool,
}

/// Frame of a path's poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FrameName {
    /// The robot's base.
    Base,
    /// That in which the calibrated base has its pose.
    Measurement,
}

/// What of a target is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum HoldName {
    /// Position and orientation.
    Pose,
    /// Position and the tool's z axis.
    Axis,
    /// Position alone.
    Position,
}

/// `schema`
#[derive(Debug, Args)]
pub struct Schema {
    /// Which.
    #[arg(value_enum)]
    pub of: SchemaOf,
}

/// Which schema.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SchemaOf {
    /// Robot description.
    Robot,
    /// Campaign.
    Campaign,
    /// Process.
    Process,
}

/// `completions`
#[derive(Debug, Args)]
pub struct Completions {
    /// The shell.
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

/// `blind`
#[derive(Debug, Subcommand)]
pub enum Blind {
    /// Draw sealed campaigns, their truths apart.
    #[command(after_help = "Examples:\n  elastogeo blind make --count 10 --seed 7 --into sealed")]
    Make(BlindMake),
    /// Diagnose sealed campaigns, then open their truths.
    #[command(after_help = "Examples:\n  elastogeo blind score sealed")]
    Score(BlindScore),
}

/// `blind make`
#[derive(Debug, Args)]
pub struct BlindMake {
    /// Folder to write a folder for each campaign, and `truth`, to.
    #[arg(long, value_name = "FOLDER")]
    pub into: PathBuf,
    /// Number of campaigns.
    #[arg(long, default_value_t = 20)]
    pub count: usize,
    /// Kinds, in turns.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [BlindKind::Single, BlindKind::Pair, BlindKind::Triple, BlindKind::Null, BlindKind::Unknown])]
    pub kinds: Vec<BlindKind>,
    /// What is measured, in turns: a robot, `position` or `deflection`, and the number of configurations; its springs
    /// between bodies are left out. By default every bundled robot with identifiable springs, both ways.
    #[arg(long = "plan", value_name = "ROBOT:OBSERVES:POSES")]
    pub plans: Vec<String>,
}

/// `blind score`
#[derive(Debug, Args)]
pub struct BlindScore {
    /// Folder that `blind make` wrote.
    pub folder: PathBuf,
}

/// What sealed campaigns hide.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BlindKind {
    /// One effect.
    Single,
    /// Two.
    Pair,
    /// Three.
    Triple,
    /// None.
    Null,
    /// What no catalogue knows.
    Unknown,
}

/// `report`
#[derive(Debug, Args)]
pub struct Report {
    /// Campaign file, its folder, or a bundled campaign.
    pub campaign: String,
    /// Another description than the campaign's.
    #[arg(long)]
    pub robot: Option<String>,
    /// Write the report's data as JSON to this file, beside the report.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
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
