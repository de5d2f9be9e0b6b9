//! elastogeo
pub mod description;
pub mod remark;
