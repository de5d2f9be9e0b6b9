//! What is shown to the user; computes nothing new.

pub mod remarks;
