//! One binary for all integration tests; the file names say what kind of test is inside.

mod architecture;
mod cli;
mod derivatives;
mod dual;
mod elastic_derivatives;
mod estimation;
mod generated;
mod golden_elastic;
mod golden_geometry;
mod identifiability;
mod inverse;
mod least_squares;
mod literature_more_garbow_hillstrom;
mod literature_nist;
mod loaded;
mod random_robots;
mod real_data;
mod recovery;
mod refusals;
mod remarks;
mod robots;
mod structures;
mod support;
mod table;
mod urdf;
mod yaml;
