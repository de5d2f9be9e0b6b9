//! The `elastogeo` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    elastogeo::cli::main()
}
