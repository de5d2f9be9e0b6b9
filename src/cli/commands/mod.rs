//! One file a command.

pub mod blind;
pub mod certificate;
pub mod check;
pub mod compensate;
pub mod compensator;
pub mod completions;
pub mod convert;
mod designed;
pub mod diagnose;
pub mod explain;
pub mod identifiability;
pub mod identify;
pub mod identify_fuzzy;
pub mod init;
pub mod man;
pub mod plan;
pub mod pose;
pub mod register;
pub mod report;
pub mod residuals;
pub mod schema;
pub mod sensitivity;
pub mod simulate;
pub mod solve;
pub mod stiffness;
pub mod track;
pub mod view;
