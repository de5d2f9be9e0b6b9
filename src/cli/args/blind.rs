//! Sealed campaigns.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::blind::Kind;

/// `blind`
#[derive(Debug, Subcommand)]
pub enum Blind {
    /// Draw sealed campaigns, their truths apart.
    #[command(
        after_help = "Examples:\n  elastogeo blind make --count 10 --seed 7 --into sealed\n  elastogeo blind make --at workshop --count 40 --seed 11 --into sealed"
    )]
    Make(BlindMake),
    /// Diagnose sealed campaigns, then open their truths.
    #[command(after_help = "Examples:\n  elastogeo blind score sealed\n  elastogeo blind score sealed --leave-out")]
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
    /// Where it is measured: a laboratory has a heavy robot and independent noise that is stated; a workshop has any robot,
    /// noise of several kinds, the last moves, and more that no catalogue knows.
    #[arg(long, value_enum, default_value_t = Place::Laboratory)]
    pub at: Place,
    /// Kinds, in turns; by default single, pair, triple, null, unknown, and in a workshop single, unknown, pair, null,
    /// mixture, trap.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub kinds: Vec<Kind>,
    /// Whether a workshop states its noise; `mixed`: some do.
    #[arg(long, value_enum, default_value_t = Sigma::Mixed)]
    pub sigma: Sigma,
    /// What is measured, in turns: a robot, `position` or `deflection`, and the number of configurations; its springs
    /// between bodies are left out. By default every bundled robot with identifiable springs, both ways, and in a workshop
    /// all bundled robots.
    #[arg(long = "plan", value_name = "ROBOT:OBSERVES:POSES")]
    pub plans: Vec<String>,
}

/// `blind score`
#[derive(Debug, Args)]
pub struct BlindScore {
    /// Folder that `blind make` wrote.
    pub folder: PathBuf,
    /// Diagnose every single one again with its true effect taken out of the catalogue.
    #[arg(long)]
    pub leave_out: bool,
}

/// Where sealed campaigns are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Place {
    /// One kind of noise, which is stated.
    Laboratory,
    /// Noise of several kinds.
    Workshop,
}

/// Whether noise is stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Sigma {
    /// Always.
    Stated,
    /// Never.
    Unstated,
    /// Now and then.
    Mixed,
}
