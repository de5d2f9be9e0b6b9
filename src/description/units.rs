//! Units of a file, converted to SI once, on reading.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::parameter::Kind;

macro_rules! unit {
    ($(#[$meta:meta])* $name:ident, { $($(#[$variant_meta:meta])* $variant:ident $text:literal $factor:expr,)* }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize, JsonSchema)]
        pub enum $name { $($(#[$variant_meta])* #[serde(rename = $text)] $variant,)* }
        impl $name {
            /// SI units in one of this unit.
            pub fn factor(self) -> f64 { match self { $(Self::$variant => $factor,)* } }
            /// As written in files and reports.
            pub fn symbol(self) -> &'static str { match self { $(Self::$variant => $text,)* } }
        }
    };
}

unit!(/// Unit of lengths.
    Length, { #[default] Metre "m" 1.0, Millimetre "mm" 1e-3, Micrometre "um" 1e-6, Inch "in" 0.0254, });
unit!(/// Unit of angles.
    Angle, { #[default] Radian "rad" 1.0, Degree "deg" std::f64::consts::PI / 180.0, Milliradian "mrad" 1e-3, });
unit!(/// Unit of forces.
    Force, { #[default] Newton "N" 1.0, Kilonewton "kN" 1e3, });
unit!(/// Unit of torques.
    Torque, { #[default] NewtonMetre "N.m" 1.0, NewtonMillimetre "N.mm" 1e-3, KilonewtonMetre "kN.m" 1e3, });
unit!(/// Unit of masses.
    Mass, { #[default] Kilogram "kg" 1.0, Gram "g" 1e-3, });
unit!(/// Unit of translational stiffness.
    Stiffness, { #[default] NewtonPerMetre "N/m" 1.0, NewtonPerMillimetre "N/mm" 1e3, NewtonPerMicrometre "N/um" 1e6, });
unit!(/// Unit of rotational stiffness.
    RotationalStiffness, { #[default] NewtonMetrePerRadian "N.m/rad" 1.0, NewtonMillimetrePerRadian "N.mm/rad" 1e-3,
        KilonewtonMetrePerRadian "kN.m/rad" 1e3, NewtonMetrePerDegree "N.m/deg" 180.0 / std::f64::consts::PI, });
unit!(/// Unit of pressures and moduli.
    Pressure, { #[default] Pascal "Pa" 1.0, Megapascal "MPa" 1e6, Gigapascal "GPa" 1e9, });
unit!(/// Unit of time.
    Time, { #[default] Second "s" 1.0, Minute "min" 60.0, Hour "h" 3600.0, });

/// Units a file declares at its top; SI where absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Units {
    /// Lengths.
    pub length: Length,
    /// Angles.
    pub angle: Angle,
    /// Forces.
    pub force: Force,
    /// Torques.
    pub torque: Torque,
    /// Masses.
    pub mass: Mass,
    /// Translational stiffness.
    pub stiffness: Stiffness,
    /// Rotational stiffness.
    pub rotational_stiffness: RotationalStiffness,
    /// Pressures and moduli.
    pub pressure: Pressure,
    /// Time.
    pub time: Time,
}

impl Units {
    /// SI units in the file's unit of a compliance, by row (x, y, z, rx, ry, rz) and column (fx, .., mz).
    pub fn compliance(&self, [row, column]: [usize; 2]) -> f64 {
        let displacement = if row < 3 { self.length.factor() } else { self.angle.factor() };
        displacement / if column < 3 { self.force.factor() } else { self.torque.factor() }
    }

    /// SI units in one of the file's units of a kind of quantity.
    pub fn of(&self, kind: Kind) -> f64 {
        match kind {
            Kind::Length => self.length.factor(),
            Kind::Angle => self.angle.factor(),
            Kind::LinearStiffness => self.stiffness.factor(),
            Kind::LinearCompliance => 1.0 / self.stiffness.factor(),
            Kind::RotationalStiffness => self.rotational_stiffness.factor(),
            Kind::RotationalCompliance => 1.0 / self.rotational_stiffness.factor(),
            Kind::Pressure => self.pressure.factor(),
            Kind::Mass => self.mass.factor(),
            Kind::Other("m2") => self.length.factor().powi(2),
            Kind::Other("m4") => self.length.factor().powi(4),
            Kind::Other(_) => 1.0,
        }
    }
}
