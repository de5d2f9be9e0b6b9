//! `schema`: JSON Schemas of the files.

use crate::Error;
use crate::cli::args::{Schema, SchemaOf};
use crate::cli::output::Output;
use crate::description::campaign::raw::RawCampaign;
use crate::description::process::RawProcess;
use crate::description::raw::{RawFuzzy, RawRobot};

pub fn run(command: &Schema) -> Result<Output, Error> {
    let text = text(command.of)?;
    let json: serde_json::Value = serde_json::from_str(&text)?;
    Ok(Output::new(text, &json)?.verbatim().bare())
}

/// A schema as the text of a file.
pub fn text(of: SchemaOf) -> Result<String, Error> {
    let schema = match of {
        SchemaOf::Robot => schemars::schema_for!(RawRobot),
        SchemaOf::Process => schemars::schema_for!(RawProcess),
        SchemaOf::Rules => schemars::schema_for!(RawFuzzy),
        SchemaOf::Campaign => schemars::schema_for!(RawCampaign),
    };
    Ok(serde_json::to_string_pretty(&schema)? + "\n")
}

/// The file of a schema, as descriptions and campaigns name it.
pub fn file_name(of: SchemaOf) -> &'static str {
    match of {
        SchemaOf::Robot => "robot.schema.json",
        SchemaOf::Campaign => "campaign.schema.json",
        SchemaOf::Process => "process.schema.json",
        SchemaOf::Rules => "rules.schema.json",
    }
}
