//! Sealed campaigns.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

/// `blind`
#[derive(Debug, Subcommand)]
pub enum Blind {
    /// Draw sealed campaigns, their truths apart.
    #[command(after_help = "Examples:\n  elastogeo blind make --count 10 --seed 7 --into sealed")]
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
    /// Diagnose every single one again with its true effect taken out of the catalogue.
    #[arg(long)]
    pub leave_out: bool,
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
    /// One effect, and what no catalogue knows.
    Mixture,
}
