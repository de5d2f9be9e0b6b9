//! What is shown to the user, as text and HTML; computes nothing new.

mod against;
pub mod blind;
pub mod campaign;
pub mod compensation;
pub mod compensator;
pub mod controller_terms;
pub mod diagnosis;
pub mod diagnostics;
pub mod fuzzy;
pub mod html;
pub mod identification;
pub mod mjcf;
pub mod place;
pub mod plan;
pub mod plots;
pub mod pose;
pub mod program;
pub mod robot;
pub mod solve;
pub mod stiffness;
pub mod table;
pub mod tables;
pub mod track;
pub mod variation;
pub mod xml;
