//! What is asked of a robot over time.

use clap::{Args, ValueEnum};

/// `track`
#[derive(Debug, Args)]
pub struct Track {
    /// Description of the robot; where `identify --save` wrote it, the reference of all checks.
    pub robot: String,
    /// Campaigns of this robot in the order of time: files, folders or bundled ones.
    #[arg(required = true, value_name = "CAMPAIGN")]
    pub campaigns: Vec<String>,
    /// Days of the campaigns (2026-01-12), in their order; by default those of `certificate: date` where each campaign has one,
    /// else checks count as equally far apart.
    #[arg(long, value_delimiter = ',', value_name = "DATE,..")]
    pub dates: Vec<String>,
    /// Exit status 1 where the last check shows a change of the robot, or any check.
    #[arg(long, value_enum, num_args = 0..=1, default_missing_value = "last", value_name = "AT")]
    pub alarm: Option<AlarmAt>,
    /// A change that the next check is to show, in mm or deg, or in SI; by default three sigmas of each parameter.
    #[arg(long, value_name = "NAME=VALUE")]
    pub change: Vec<String>,
    /// Checks in a year, over which 5 % of false alarms are spent.
    #[arg(long, default_value_t = 12, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub a_year: u32,
    /// Share of the configurations held out to check where a campaign does not say.
    #[arg(long, default_value_t = crate::estimation::CHECK)]
    pub check: f64,
}

/// Which checks raise the alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AlarmAt {
    /// The last one.
    Last,
    /// Any of them.
    Any,
}
