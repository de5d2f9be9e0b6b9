//! Starting, looking up, setting up.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

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
    /// Fuzzy compliance in a file of its own.
    Rules,
}

/// `completions`
#[derive(Debug, Args)]
pub struct Completions {
    /// The shell.
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}
