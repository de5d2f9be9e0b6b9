//! What is asked of a robot and its readings.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::estimation::fuzzy::Structure;
use crate::estimation::{Scheme, Split, Weights};
use crate::identifiability::Scaling;

/// A robot and a campaign.
#[derive(Debug, Args)]
pub struct OnCampaign {
    /// Bundled name, or a .yaml or .urdf file.
    pub robot: String,
    /// Campaign file, its folder, or a bundled campaign.
    pub campaign: String,
}

/// `residuals`
#[derive(Debug, Args)]
pub struct Residuals {
    /// Robot and campaign.
    #[command(flatten)]
    pub on: OnCampaign,
    /// Write the residuals as a table, a reading a row (.csv or .xlsx); mm and deg.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Write the observed and the predicted error of each configuration as a table (.csv or .xlsx), mm; of a description that
    /// `identify --save` wrote.
    #[arg(long, value_name = "FILE")]
    pub configurations: Option<PathBuf>,
    /// Write the residuals' figures by session, station, file, kind, marker and target as a table (.csv or .xlsx).
    #[arg(long, value_name = "FILE")]
    pub parts: Option<PathBuf>,
}

/// How columns are scaled and parameters dropped.
#[derive(Debug, Args)]
pub struct Reduction {
    /// Parameters are dropped below this fraction of the greatest singular value, or `noise`: where an error of the
    /// parameter's tolerance would show less than the readings' noise.
    #[arg(long, default_value = "6e-5", value_name = "FRACTION|noise")]
    pub tolerance: String,
    /// Scaling of columns.
    #[arg(long, value_enum, default_value_t = Scaling::Norm)]
    pub scale: Scaling,
    /// Parameters to hold at their nominal values.
    #[arg(long, value_delimiter = ',', value_name = "NAME,..")]
    pub hold: Vec<String>,
}

/// `identifiability`
#[derive(Debug, Args)]
pub struct Identifiability {
    /// Robot and campaign.
    #[command(flatten)]
    pub on: OnCampaign,
    /// Which columns: `geometric`, `elastic`, or `geometric,elastic`; by default as `identify`.
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
    /// What to identify: `geometric`, `elastic`, or `geometric,elastic`; by default stiffness from deflections and
    /// geometry from all other readings, with the springs where `calibrate:` of the campaign names an effect of theirs. Or `fuzzy`, a fuzzy compliance in place of springs and beams; `grey`, springs with a fuzzy
    /// correction of what they leave; or `local`, springs that differ by configuration, blended by fuzzy rules.
    #[arg(long, value_delimiter = ',')]
    pub what: Vec<String>,
    /// Joints (by frame) or variables that rules may depend on; by default all variables that change, and for a tree the
    /// joints of loops too.
    #[arg(long, value_delimiter = ',', value_name = "NAME,..")]
    pub inputs: Vec<String>,
    /// How rules divide the inputs: all combinations of sets, or splits along one input each. By default a grid of up to
    /// three inputs, and else a tree.
    #[arg(long, value_enum)]
    pub structure: Option<Structure>,
    /// Frame along whose axes a fuzzy compliance has its components, or `base`; by default the base's of a grid, and of a tree
    /// those that leave least in cross-validation.
    #[arg(long, value_name = "FRAME")]
    pub axes: Option<String>,
    /// Make a fuzzy compliance symmetric: displacement x by fy is y by fx (trees).
    #[arg(long)]
    pub reciprocal: bool,
    /// Fit rules (and what they are compared with) only to readings under this force, N; the other loads judge them.
    #[arg(long, value_name = "N")]
    pub fit_force: Option<f64>,
    /// How the modal values of a fuzzy compliance are placed.
    #[arg(long, value_enum, default_value_t = PlacementName::GaussNewton)]
    pub placement: PlacementName,
    /// How springs that the readings see as one are split back into the description's.
    #[arg(long, value_enum, default_value_t = Split::Prior)]
    pub split: Split,
    /// Fit the logarithms of springs: none ends at or below 0, and their intervals are of factors.
    #[arg(long)]
    pub logarithms: bool,
    /// Write the calibrated description (.yaml or .urdf).
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Write the parameters as a table (.csv or .xlsx): nominal, value, 95 % interval.
    #[arg(long, value_name = "FILE", conflicts_with = "compare")]
    pub table: Option<PathBuf>,
    /// Write the observed and the predicted error of each configuration held out as a table (.csv or .xlsx), mm.
    #[arg(long, value_name = "FILE", conflicts_with = "compare")]
    pub configurations: Option<PathBuf>,
    /// Write the residuals' figures by session, station, file, kind, marker and target as a table (.csv or .xlsx).
    #[arg(long, value_name = "FILE", conflicts_with = "compare")]
    pub parts: Option<PathBuf>,
    /// Say what has moved since this description, which takes the place of the campaign's: one that `identify --save` wrote
    /// from an earlier campaign.
    #[arg(long, value_name = "ROBOT", conflicts_with_all = ["robot", "compare", "prior"])]
    pub since: Option<String>,
    /// Compare the result with another set of parameters: a description, an earlier `--save` for example. Both predict the readings
    /// held out, with base and tool fitted anew in the same way.
    #[arg(long, value_name = "ROBOT", conflicts_with = "compare")]
    pub against: Option<String>,
    /// Write identified rules to this file (.yaml), which the description of --save then names.
    #[arg(long, value_name = "FILE", requires = "save")]
    pub save_rules: Option<PathBuf>,
    /// Reduction.
    #[command(flatten)]
    pub reduction: Reduction,
    /// How the fit proceeds. Where they converge, all end at the same parameters; `batch` does soonest.
    #[arg(long, value_enum, default_value_t = Scheme::Batch)]
    pub scheme: Scheme,
    /// Weights of readings.
    #[arg(long, value_enum, default_value_t = Weights::Stated)]
    pub weights: Weights,
    /// Robust loss.
    #[command(flatten)]
    pub robust: Robust,
    /// Let the stated tolerances pull parameters towards their nominal values.
    #[arg(long)]
    pub prior: bool,
    /// Share of the configurations held out to check where the campaign does not say.
    #[arg(long, default_value_t = crate::estimation::CHECK)]
    pub check: f64,
    /// Draw only so many of the configurations to fit, seeded.
    #[arg(long, value_name = "N")]
    pub train: Option<usize>,
    /// Ordinary and weighted least squares side by side; of fuzzy and grey, with the parametric model, by load.
    #[arg(long)]
    pub compare: bool,
}

/// Which readings count how much where they do not fit.
#[derive(Debug, Clone, Copy, Args)]
pub struct Robust {
    /// Robust loss: outliers count little. By default plain squares; `register` takes `cauchy` where readings are far off.
    #[arg(long, value_enum)]
    pub loss: Option<LossName>,
    /// Residual beyond which the robust loss gives way, 0.5 to 1000 (of `tukey` from 1.547), in standard deviations: the
    /// stated ones, or those that the residuals of a first robust fit show, if greater. By default 1.345 of `huber`, 2.385
    /// of `cauchy`, 4.685 of `tukey`: 95 % efficient on normal noise.
    #[arg(long, value_name = "SCALE", requires = "loss")]
    pub loss_scale: Option<f64>,
}

/// `register`
#[derive(Debug, Args)]
pub struct Register {
    /// Campaign file, its folder, or a bundled campaign.
    pub campaign: String,
    /// Another description than the campaign's.
    #[arg(long)]
    pub robot: Option<String>,
    /// Write the description with base, tool and markers set (.yaml or .urdf).
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Parameters to hold at their nominal values.
    #[arg(long, value_delimiter = ',', value_name = "NAME,..")]
    pub hold: Vec<String>,
    /// Robust loss.
    #[command(flatten)]
    pub robust: Robust,
    /// Share of the configurations held out to check where the campaign does not say.
    #[arg(long, default_value_t = crate::estimation::CHECK)]
    pub check: f64,
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
    /// Also say which parameters have moved since this description, which takes the place of the campaign's: one that `identify --save`
    /// wrote from an earlier campaign.
    #[arg(long, value_name = "ROBOT", conflicts_with = "robot")]
    pub since: Option<String>,
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
    /// Campaign of deflections at three angles of the joint or more: a compliance of the joint at each angle and its spring from them,
    /// and both in one fit. The mounting is that of the description.
    #[arg(long, value_name = "CAMPAIGN", conflicts_with_all = ["circle", "anchor", "mounting", "compliances"])]
    pub deflections: Option<String>,
    /// Another description than that of the campaign of --deflections.
    #[arg(long, value_name = "ROBOT", requires = "deflections")]
    pub robot: Option<String>,
    /// The spring of the description, where it has several.
    #[arg(long, value_name = "NAME", requires = "deflections")]
    pub spring: Option<String>,
    /// Angles of the joint within this of each other count as one, deg.
    #[arg(long, value_name = "DEG", default_value_t = 2.0, requires = "deflections")]
    pub within: f64,
}

/// Placements of modal values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PlacementName {
    /// Gauss-Newton on the residual that the best conclusions leave.
    GaussNewton,
    /// Random search of Solis and Wets, seeded.
    SolisWets,
}

/// `report`
#[derive(Debug, Args)]
pub struct Report {
    /// Campaign file, its folder, or a bundled campaign.
    pub campaign: String,
    /// Another description than the campaign's.
    #[arg(long)]
    pub robot: Option<String>,
    /// Compare the result with another set of parameters, as `identify --against` does.
    #[arg(long, value_name = "ROBOT", conflicts_with = "certificate")]
    pub against: Option<String>,
    /// Write the report's data as JSON to this file, in addition to the report.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// A calibration certificate instead (certificate.html, or --output): errors before and after with their uncertainty, the
    /// verdict on a tolerance, accuracy and repeatability of poses, every reading, and what the campaign's `certificate:` says.
    #[arg(long)]
    pub certificate: bool,
    /// Greatest position error that the certificate allows, mm; by default what the campaign's `certificate:` says.
    #[arg(long, value_name = "MM", requires = "certificate", allow_hyphen_values = true)]
    pub tolerance: Option<f64>,
    /// Write the certificate's data as XML to this file.
    #[arg(long, value_name = "FILE", requires = "certificate")]
    pub xml: Option<PathBuf>,
}
