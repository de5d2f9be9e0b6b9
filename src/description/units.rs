//! Units of a file, converted to SI once, on reading.

#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::parameter::Kind;

macro_rules! unit {
    ($(#[$meta:meta])* $name:ident, { $($(#[$variant_meta:meta])* $variant:ident $text:literal $factor:expr,)* }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
        #[cfg_attr(feature = "cli", derive(JsonSchema))]
        pub enum $name { $($(#[$variant_meta])* #[serde(rename = $text)] $variant,)* }
        impl $name {
            /// SI units in one of this unit.
            pub fn factor(self) -> f64 { match self { $(Self::$variant => $factor,)* } }
            /// As written in files and reports.
            pub fn symbol(self) -> &'static str { match self { $(Self::$variant => $text,)* } }
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];
        }
    };
}

unit!(/// Unit of lengths.
    Length, { #[default] Metre "m" 1.0, Centimetre "cm" 1e-2, Millimetre "mm" 1e-3, Micrometre "um" 1e-6, Inch "in" 0.0254,
        Foot "ft" 0.3048, });
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

/// A unit in which a column of a table may be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Of a length.
    Length(Length),
    /// Of an angle.
    Angle(Angle),
    /// Of a force.
    Force(Force),
    /// Of a torque.
    Torque(Torque),
    /// Of a time.
    Time(Time),
}

/// Other ways in which laboratories write units.
const SPELLINGS: [(&str, &str); 26] = [
    ("meter", "m"),
    ("metre", "m"),
    ("centimeter", "cm"),
    ("centimetre", "cm"),
    ("millimeter", "mm"),
    ("millimetre", "mm"),
    ("micrometer", "um"),
    ("\u{b5}m", "um"),
    ("\u{3bc}m", "um"),
    ("inch", "in"),
    ("inche", "in"), // inches
    ("\"", "in"),
    ("foot", "ft"),
    ("feet", "ft"),
    ("\u{b0}", "deg"),
    ("degree", "deg"),
    ("radian", "rad"),
    ("newton", "N"),
    ("Nm", "N.m"),
    ("N*m", "N.m"),
    ("N\u{b7}m", "N.m"),
    ("N m", "N.m"),
    ("Nmm", "N.mm"),
    ("sec", "s"),
    ("second", "s"),
    ("minute", "min"),
];

impl Unit {
    /// The unit of that symbol, or of one of its spellings (`millimeters`, a degree sign, `Nm`).
    pub fn named(text: &str) -> Option<Self> {
        let bare = |text: &str| SPELLINGS.iter().find(|(spelling, _)| *spelling == text).map(|(_, symbol)| *symbol);
        let symbol = bare(text).or_else(|| bare(text.to_lowercase().trim_end_matches('s'))).unwrap_or(text);
        let lengths = Length::ALL.iter().map(|unit| Self::Length(*unit));
        let angles = Angle::ALL.iter().map(|unit| Self::Angle(*unit));
        let forces = Force::ALL.iter().map(|unit| Self::Force(*unit));
        let torques = Torque::ALL.iter().map(|unit| Self::Torque(*unit));
        let times = Time::ALL.iter().map(|unit| Self::Time(*unit));
        let mut all = lengths.chain(angles).chain(forces).chain(torques).chain(times);
        all.find(|unit| unit.symbol() == symbol)
    }

    /// SI units in one of this unit.
    pub fn factor(self) -> f64 {
        match self {
            Self::Length(unit) => unit.factor(),
            Self::Angle(unit) => unit.factor(),
            Self::Force(unit) => unit.factor(),
            Self::Torque(unit) => unit.factor(),
            Self::Time(unit) => unit.factor(),
        }
    }

    /// As written in files and reports.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Length(unit) => unit.symbol(),
            Self::Angle(unit) => unit.symbol(),
            Self::Force(unit) => unit.symbol(),
            Self::Torque(unit) => unit.symbol(),
            Self::Time(unit) => unit.symbol(),
        }
    }

    /// What it measures, and the key of [`Units`] that declares it.
    pub fn quantity(self) -> &'static str {
        match self {
            Self::Length(_) => "length",
            Self::Angle(_) => "angle",
            Self::Force(_) => "force",
            Self::Torque(_) => "torque",
            Self::Time(_) => "time",
        }
    }

    /// Whether it is the SI unit, which holds where nothing is declared.
    pub fn is_default(self) -> bool {
        match self {
            Self::Length(unit) => unit == Length::default(),
            Self::Angle(unit) => unit == Angle::default(),
            Self::Force(unit) => unit == Force::default(),
            Self::Torque(unit) => unit == Torque::default(),
            Self::Time(unit) => unit == Time::default(),
        }
    }
}

/// Units a file declares at its top; SI where absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
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

/// Units that are stated in addition to others: those that are not named are the others'.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SomeUnits {
    /// Lengths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<Length>,
    /// Angles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Angle>,
    /// Forces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<Force>,
    /// Torques.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque: Option<Torque>,
    /// Masses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<Mass>,
    /// Translational stiffness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<Stiffness>,
    /// Rotational stiffness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotational_stiffness: Option<RotationalStiffness>,
    /// Pressures and moduli.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Pressure>,
    /// Time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<Time>,
}

impl SomeUnits {
    /// All units, where those that are not named are these.
    pub fn or(self, others: Units) -> Units {
        Units {
            length: self.length.unwrap_or(others.length),
            angle: self.angle.unwrap_or(others.angle),
            force: self.force.unwrap_or(others.force),
            torque: self.torque.unwrap_or(others.torque),
            mass: self.mass.unwrap_or(others.mass),
            stiffness: self.stiffness.unwrap_or(others.stiffness),
            rotational_stiffness: self.rotational_stiffness.unwrap_or(others.rotational_stiffness),
            pressure: self.pressure.unwrap_or(others.pressure),
            time: self.time.unwrap_or(others.time),
        }
    }
}

impl From<Units> for SomeUnits {
    fn from(all: Units) -> Self {
        Self {
            length: Some(all.length),
            angle: Some(all.angle),
            force: Some(all.force),
            torque: Some(all.torque),
            mass: Some(all.mass),
            stiffness: Some(all.stiffness),
            rotational_stiffness: Some(all.rotational_stiffness),
            pressure: Some(all.pressure),
            time: Some(all.time),
        }
    }
}

impl Units {
    /// SI units in the file's unit of a compliance, by row (x, y, z, rx, ry, rz) and column (fx, .., mz).
    pub fn compliance(&self, [row, column]: [usize; 2]) -> f64 {
        let displacement = if row < 3 { self.length.factor() } else { self.angle.factor() };
        displacement / if column < 3 { self.force.factor() } else { self.torque.factor() }
    }

    /// The unit in which columns of a kind are written, where a column may have another than the file's.
    pub fn unit(&self, kind: Kind) -> Option<Unit> {
        match kind {
            Kind::Length => Some(Unit::Length(self.length)),
            Kind::Angle => Some(Unit::Angle(self.angle)),
            _ => None,
        }
    }

    /// Units of a force and moment: fx, fy, fz, mx, my, mz.
    pub fn of_wrench(&self) -> [Unit; 6] {
        std::array::from_fn(|k| if k < 3 { Unit::Force(self.force) } else { Unit::Torque(self.torque) })
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
