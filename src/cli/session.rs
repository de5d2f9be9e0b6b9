//! What every command runs with.

use super::args::Arguments;
use super::terminal::Terminal;
use crate::files::Reader;

/// Arguments of all commands, the terminal, and the files that were read.
pub struct Session<'a> {
    /// The command line.
    pub arguments: &'a Arguments,
    /// Where text and progress go.
    pub terminal: Terminal<'a>,
    /// Reads inputs, and keeps them from being written over.
    pub reader: Reader,
}

impl Session<'_> {
    /// Seed of everything random.
    pub fn seed(&self) -> u64 {
        self.arguments.seed
    }
}
