//! URDF in and out, against forward functions written here from the definitions of both formats.

mod chain;
mod constants;
mod forward;
mod refusals;
mod round_trip;
mod tables;
