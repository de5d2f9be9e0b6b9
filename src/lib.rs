//! elastogeo
pub mod remark;
