//! The command line.

mod blind;
mod campaign;
mod choices;
mod planned;
mod robot;
mod start;
mod track;

pub use blind::{Blind, BlindMake, BlindScore, Place, Sigma};
pub use campaign::{
    Compensator, Diagnose, Identifiability, Identify, LossName, OnCampaign, PlacementName, Reduction, Register, Report,
    Residuals, Robust,
};
pub use planned::{Compensate, FrameName, Place as PlaceOf, Plan, Simulate};
pub use robot::{Check, Convert, Pose, Solve, Stiffness, View, WriteAs};
pub use start::{Completions, Explain, Init, Man, Schema, SchemaOf, StarterKind};
pub use track::{AlarmAt, Track};

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};

use crate::observation::Kinds;

/// Calibrate declared robots: kinematics, what can be identified, calibration, proof on poses not seen.
#[derive(Debug, Parser)]
#[command(
    name = "elastogeo",
    version,
    about,
    after_help = "A first hour: `elastogeo init my-robot`, then `elastogeo identify my-robot`.\nWhat a word means: `elastogeo explain rank`.\n\nExit status: 0 done, 1 the result is not to be used, 2 bad input, 3 an alarm that was asked for."
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
    /// Number of threads, 1 to 1024; all processors by default. Results do not depend on it.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Go on where content is implausible: what would be refused is a warning.
    #[arg(long, global = true)]
    pub force: bool,
    /// Print nothing but errors; files are written all the same.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

impl Arguments {
    /// The arguments of a command line, the program's name first, that may name these kinds of readings.
    pub fn parsed(kinds: &Kinds, words: impl IntoIterator<Item = OsString>) -> Result<Self, clap::Error> {
        let observes = |command: clap::Command| {
            command.mut_arg("observes", |argument| argument.value_parser(planned::kinds_of_readings(kinds)))
        };
        let command = Self::command().mut_subcommand("simulate", observes).mut_subcommand("plan", observes);
        // A number below zero is a value, and refused as one, not taken for a flag.
        let mut command = command.mut_subcommands(|own| own.allow_negative_numbers(true));
        let mut found = command.try_get_matches_from_mut(words)?;
        Self::from_arg_matches_mut(&mut found).map_err(|error| error.format(&mut command))
    }
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
    /// Validate a robot or a campaign; print frames, loops, parameters, what is elastic; or readings, joint ranges, noise,
    /// what will be estimated.
    #[command(
        after_help = "Examples:\n  elastogeo check universal-ur5\n  elastogeo check my-robot\n  elastogeo check my-robot/robot.yaml --snapshot my-robot.snap"
    )]
    Check(Check),
    /// Write a robot as YAML or URDF.
    #[command(
        after_help = "Examples:\n  elastogeo convert arm.urdf arm.yaml\n  elastogeo convert my-robot/robot.yaml my-robot.urdf\n  elastogeo convert calibrated.yaml my-calibration.yaml --as ur-kinematics\n  elastogeo convert calibrated.yaml arm.xml --as mjcf"
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
    /// Where the robot stands and what its tool is: base, tool and markers fitted alone.
    #[command(
        after_help = "Examples:\n  elastogeo register my-robot\n  elastogeo register my-robot --save registered.yaml --loss tukey"
    )]
    Register(Register),
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
    Residuals(Residuals),
    /// One self-contained HTML file about a campaign: the answer first, plots, the robot in 3-D (report.html, or --output).
    #[command(
        after_help = "Examples:\n  elastogeo report kr270-no-compensator\n  elastogeo report my-robot --output monday.html --json monday.json"
    )]
    Report(Report),
    /// Campaigns of one robot over time: what changed and when, what happened, the next check (track.html, or --output).
    #[command(
        after_help = "Examples:\n  elastogeo track my-robot/robot.yaml january february march\n  elastogeo track calibrated.yaml january february --dates 2026-01-12,2026-02-09 --alarm\n  elastogeo track calibrated.yaml january february --change 3.theta=0.02\n\nExit status with --alarm: 0 nothing changed, 3 something has, 2 bad input, 1 not computed."
    )]
    Track(Track),
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
    /// Where a process deflects the arm least: the workpiece shifted and turned, and the posture of a redundant arm.
    #[command(
        after_help = "Examples:\n  elastogeo place kuka-ir663 ir663-strip --process ir663-strip --move x=-200:200,z=-100:100\n  elastogeo place franka-panda milling.csv --hold axis --direction z --table placed.csv"
    )]
    Place(PlaceOf),
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
