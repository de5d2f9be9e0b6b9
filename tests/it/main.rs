//! One binary for all integration tests; the file names say what kind of test is inside.

mod golden_geometry;
mod support;
