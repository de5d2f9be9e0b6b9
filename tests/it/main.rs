//! One binary for all integration tests; the file names say what kind of test is inside.

mod cli;
mod derivatives;
mod dual;
mod golden_geometry;
mod identifiability;
mod inverse;
mod least_squares;
mod literature_more_garbow_hillstrom;
mod literature_nist;
mod random_robots;
mod real_data;
mod refusals;
mod remarks;
mod support;
mod table;
mod urdf;
mod yaml;
