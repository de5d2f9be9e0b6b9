//! `schema`: JSON Schemas of the files.

use crate::cli::args::{Schema, SchemaOf};
use crate::cli::{Failure, Output};
use crate::description::campaign::raw::RawCampaign;
use crate::description::process::RawProcess;
use crate::description::raw::RawRobot;

pub fn run(command: &Schema) -> Result<Output, Failure> {
    let schema = match command.of {
        SchemaOf::Robot => schemars::schema_for!(RawRobot),
        SchemaOf::Process => schemars::schema_for!(RawProcess),
        SchemaOf::Campaign => schemars::schema_for!(RawCampaign),
    };
    let json = serde_json::to_value(schema).map_err(Failure::computation)?;
    let text = serde_json::to_string_pretty(&json).map_err(Failure::computation)? + "\n";
    Ok(Output::new(text, json))
}
