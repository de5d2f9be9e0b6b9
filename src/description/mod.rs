//! Reading and writing of the files: robot descriptions, campaigns and measurements, every fault located.
//!
//! A description is read into [`raw`] (the file, in its units), resolved by [`resolve`] into [`robot`] (SI, names as
//! indices), and compiled into [`crate::model::Model`]. Its numbers are listed once, in `parameters`.

pub mod campaign;
pub mod columns;
pub mod convention;
pub mod coupling;
pub mod elastic;
mod form;
pub mod frame;
pub mod fuzzy;
pub mod khalil_kleinfinger;
pub mod limits;
pub(crate) mod parameters;
pub mod path;
pub mod process;
pub mod raw;
pub mod resolve;
pub mod robot;
pub mod table;
pub mod units;
pub mod ur_kinematics;
pub mod urdf;
pub mod validity;
pub mod vary;
pub mod yaml;
