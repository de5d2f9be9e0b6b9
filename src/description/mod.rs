//! Reading of descriptions and campaigns: raw (the file) -> resolved (SI, names checked, every fault located).
pub mod raw;
pub mod resolve;
pub mod robot;
pub mod units;
