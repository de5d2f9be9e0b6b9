//! Elastic elements: one file for each kind, all behind [`ElasticElement`].
//!
//! An element joins two vertices of the structure. It says what it depends on, where its local axes are, how it deforms
//! there under internal forces, and how both change with parameters and with the motion of the frames. Trees and closures of
//! [`crate::elastics`] ask nothing else, so that a new kind is a file here, a line below, and the place in
//! [`crate::model`] that builds it from a description.

mod beam;
mod element;
mod flexibility;
mod lumped;
mod per_length;
mod screw;
mod section;
mod spring;

pub use beam::{Beam, Material, Normal, Rigidity, Section, axes as beam_axes};
pub use element::{
    BodyPoint, Configuration, Deflected, Direction, ElasticElement, Frames, Held, Motion, MotionRate, ParameterUse,
    Placed, Rate, VertexIndex, VertexMotion, reduction, spatial,
};
pub use flexibility::Flexibility;
pub use lumped::{Axes, Law, Lumped};
pub use per_length::PerLength;
pub use screw::{Screw, ScrewTriangle, screw_pins};
pub use section::{Properties, properties};
pub use spring::{Spring, SpringState};
