//! elastogeo
pub mod description;
pub mod kinematics;
pub mod model;
pub mod parameter;
pub mod remark;
