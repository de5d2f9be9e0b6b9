//! Reading and writing of the files: robot descriptions, campaigns and measurements, every fault located.
//!
//! A description goes through three ages: [`raw`] (the file), [`robot`] (SI, names resolved by [`resolve`]) and the
//! compiled [`crate::model::Model`].

pub mod campaign;
pub mod coupling;
pub mod elastic;
pub mod frame;
pub mod fuzzy;
pub mod limits;
pub(crate) mod parameters;
pub mod path;
pub mod process;
pub mod raw;
pub mod resolve;
pub mod robot;
pub mod table;
pub mod units;
pub mod urdf;
pub mod yaml;
