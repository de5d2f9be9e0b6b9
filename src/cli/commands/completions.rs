//! `completions`: a script for a shell.

use clap::CommandFactory;

use crate::Error;
use crate::cli::args::{Arguments, Completions};
use crate::cli::output::Output;

pub fn run(command: &Completions) -> Result<Output, Error> {
    let mut script = Vec::new();
    clap_complete::generate(command.shell, &mut Arguments::command(), "elastogeo", &mut script);
    let text = String::from_utf8_lossy(&script).into_owned();
    Ok(Output::new(text.clone(), &serde_json::json!({"shell": command.shell.to_string(), "script": text}))?
        .verbatim()
        .bare())
}
