//! The parameters of a robot description, one row each: key in the file, quantity, range, common error, and where the
//! number stands. Resolving, compiling and writing back go over these tables; no other place spells a key.
//!
//! A parameter is named `<owner>.<symbol>`. Names are made of owner and symbol here; identity is that of the key.

use super::raw::{
    JointKind, RawActuator, RawBaseStiffness, RawBody, RawFrame, RawJointStiffness, RawMarker, RawMaterial,
    RawPlacement, RawRobot, RawSection, RawSpring, RawStiffness, RawTool, SectionShape,
};
use super::units::Units;
use crate::parameter::Kind;

/// Values that a number may have by its nature.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Range {
    /// Any.
    Any,
    /// 0 or more.
    NotNegative,
    /// Above 0: at least 1e-9 of the declared value.
    Positive,
    /// Between two values, SI.
    Within([f64; 2]),
}

/// A number of an entry `R` of the file.
pub(crate) struct Number<R> {
    /// Symbol, which is also its key where it has one of its own.
    pub symbol: &'static str,
    /// What it measures.
    pub kind: Kind,
    /// Values that it may have.
    pub range: Range,
    /// How far it is commonly off (one sigma): a share of its value, and at least so much, SI.
    pub common: [f64; 2],
    /// The number as declared, in the file's units.
    pub get: fn(&R) -> Option<f64>,
    set: fn(&mut R, f64),
}

impl<R> Number<R> {
    /// The declared number, SI.
    pub fn si(&self, entry: &R, units: &Units) -> Option<f64> {
        (self.get)(entry).map(|value| value * units.of(self.kind))
    }

    /// Bounds of its value, SI.
    pub fn bounds(&self, nominal: f64) -> [f64; 2] {
        match self.range {
            Range::Any => [f64::NEG_INFINITY, f64::INFINITY],
            Range::NotNegative => [0.0, f64::INFINITY],
            Range::Positive => [1e-9 * nominal, f64::INFINITY],
            Range::Within(bounds) => bounds,
        }
    }

    /// How far it is commonly off, SI.
    pub fn tolerance(&self, nominal: f64) -> f64 {
        (self.common[0] * nominal).max(self.common[1])
    }
}

/// A stiffness of an entry `R` of the file, declared by its value or by its inverse.
pub(crate) struct Stiffness<R> {
    /// Symbol, which is also its key (but for `rate` of a spring).
    pub symbol: &'static str,
    /// What it measures, as a stiffness.
    pub kind: Kind,
    /// The stiffness as declared, in the file's units.
    pub get: fn(&R) -> Option<&RawStiffness>,
    at: fn(&mut R) -> &mut Option<RawStiffness>,
}

// Derived, they would ask the same of `R`.
impl<R> Clone for Number<R> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<R> Copy for Number<R> {}
impl<R> Clone for Stiffness<R> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<R> Copy for Stiffness<R> {}

macro_rules! numbers {
    ($raw:ty { $($field:ident: $kind:expr, $range:expr, $common:expr;)* }) => {
        [$(Number::<$raw> {
            symbol: stringify!($field),
            kind: $kind,
            range: $range,
            common: $common,
            get: |entry| entry.$field,
            set: |entry, value| entry.$field = Some(value),
        },)*]
    };
}

macro_rules! components {
    ($raw:ty { $($symbol:literal: $field:ident $([$at:literal])+, $kind:expr, $common:expr;)* }) => {
        [$(Number::<$raw> {
            symbol: $symbol,
            kind: $kind,
            range: Range::Any,
            common: [0.0, $common],
            get: |entry| entry.$field.map(|vector| vector$([$at])+),
            set: |entry, value| entry.$field.get_or_insert_default()$([$at])+ = value,
        },)*]
    };
}

macro_rules! stiffnesses {
    ($raw:ty { $($symbol:literal: $field:ident, $kind:expr;)* }) => {
        [$(Stiffness::<$raw> {
            symbol: $symbol,
            kind: $kind,
            get: |entry| entry.$field.as_ref(),
            at: |entry| &mut entry.$field,
        },)*]
    };
}

macro_rules! pose {
    ($raw:ty) => {
        components!($raw {
            "x": at[0], Kind::Length, 1e-3;
            "y": at[1], Kind::Length, 1e-3;
            "z": at[2], Kind::Length, 1e-3;
            "rx": rotation[0], Kind::Angle, 1e-3;
            "ry": rotation[1], Kind::Angle, 1e-3;
            "rz": rotation[2], Kind::Angle, 1e-3;
        })
    };
}

const AREA: Kind = Kind::Other("m2");
const AREA_MOMENT: Kind = Kind::Other("m4");

// Errors of lengths and angles of the geometry are those of `calibration`: 1 mm and 1 mrad where it states none.

/// Constants of a frame, in the order of their transforms.
pub(crate) const FRAME: [Number<RawFrame>; 7] = numbers!(RawFrame {
    beta: Kind::Angle, Range::Any, [0.0, 1e-3];
    gamma: Kind::Angle, Range::Any, [0.0, 1e-3];
    b: Kind::Length, Range::Any, [0.0, 1e-3];
    alpha: Kind::Angle, Range::Any, [0.0, 1e-3];
    d: Kind::Length, Range::Any, [0.0, 1e-3];
    theta: Kind::Angle, Range::Any, [0.0, 1e-3];
    r: Kind::Length, Range::Any, [0.0, 1e-3];
});

/// Constants of a slider-crank.
pub(crate) const SLIDER_CRANK: [Number<RawActuator>; 5] = numbers!(RawActuator {
    stroke: Kind::Length, Range::Any, [0.0, 1e-3];
    kappa: Kind::Angle, Range::Any, [0.0, 1e-3];
    lambda: Kind::Angle, Range::Any, [0.0, 1e-3];
    l1: Kind::Length, Range::Any, [0.0, 1e-3];
    l3: Kind::Length, Range::Any, [0.0, 1e-3];
});

/// Position and rotation vector of the base.
pub(crate) const BASE: [Number<RawPlacement>; 6] = pose!(RawPlacement);
/// Position and rotation vector of the tool.
pub(crate) const TOOL: [Number<RawTool>; 6] = pose!(RawTool);
/// Position of a marker.
pub(crate) const MARKER: [Number<RawMarker>; 3] = components!(RawMarker {
    "x": at[0], Kind::Length, 1e-3;
    "y": at[1], Kind::Length, 1e-3;
    "z": at[2], Kind::Length, 1e-3;
});

/// Mass of a body.
pub(crate) const MASS: Number<RawBody> = numbers!(RawBody { mass: Kind::Mass, Range::NotNegative, [0.1, 0.0]; })[0];
/// Centre of mass of a body.
pub(crate) const CENTRE: [Number<RawBody>; 3] = components!(RawBody {
    "x": com[0], Kind::Length, 0.02;
    "y": com[1], Kind::Length, 0.02;
    "z": com[2], Kind::Length, 0.02;
});

/// Constants of a material; one of `poisson` and `shear` is declared.
pub(crate) const MATERIAL: [Number<RawMaterial>; 5] = numbers!(RawMaterial {
    young: Kind::Pressure, Range::Positive, [0.05, 0.0];
    poisson: Kind::Other("1"), Range::Within([-0.999, 0.5]), [0.0, 0.02];
    shear: Kind::Pressure, Range::Positive, [0.05, 0.0];
    density: Kind::Other("kg/m3"), Range::NotNegative, [0.05, 1.0];
    expansion: Kind::Other("1/K"), Range::Any, [0.05, 0.0];
});
/// Young's modulus.
pub(crate) const YOUNG: Number<RawMaterial> = MATERIAL[0];
/// Poisson's ratio.
pub(crate) const POISSON: Number<RawMaterial> = MATERIAL[1];
/// Shear modulus.
pub(crate) const SHEAR: Number<RawMaterial> = MATERIAL[2];
/// Density.
pub(crate) const DENSITY: Number<RawMaterial> = MATERIAL[3];
/// Coefficient of thermal expansion.
pub(crate) const EXPANSION: Number<RawMaterial> = MATERIAL[4];

/// Dimensions and properties of a cross-section; [`section_symbols`] says which of them a shape needs.
pub(crate) const SECTION: [Number<RawSection>; 11] = numbers!(RawSection {
    width: Kind::Length, Range::Positive, [0.05, 0.0];
    height: Kind::Length, Range::Positive, [0.05, 0.0];
    wall: Kind::Length, Range::Positive, [0.05, 0.0];
    flange: Kind::Length, Range::Positive, [0.05, 0.0];
    diameter: Kind::Length, Range::Positive, [0.05, 0.0];
    area: AREA, Range::Positive, [0.05, 0.0];
    iy: AREA_MOMENT, Range::Positive, [0.05, 0.0];
    iz: AREA_MOMENT, Range::Positive, [0.05, 0.0];
    j: AREA_MOMENT, Range::Positive, [0.05, 0.0];
    shear_y: AREA, Range::Positive, [0.05, 0.0];
    shear_z: AREA, Range::Positive, [0.05, 0.0];
});

/// Length of a spring without force.
pub(crate) const FREE_LENGTH: Number<RawSpring> = Number {
    symbol: "free_length",
    kind: Kind::Length,
    range: Range::Any,
    common: [0.0, 0.02],
    // A preload at a length says the same.
    get: |spring| spring.free_length.or(spring.preload),
    set: |spring, value| (spring.free_length, spring.preload, spring.preload_length) = (Some(value), None, None),
};
/// Anchors of a spring on its two bodies.
pub(crate) const ANCHORS: [Number<RawSpring>; 6] = components!(RawSpring {
    "x1": anchors[0][0], Kind::Length, 1e-3;
    "y1": anchors[0][1], Kind::Length, 1e-3;
    "z1": anchors[0][2], Kind::Length, 1e-3;
    "x2": anchors[1][0], Kind::Length, 1e-3;
    "y2": anchors[1][1], Kind::Length, 1e-3;
    "z2": anchors[1][2], Kind::Length, 1e-3;
});

/// Rate of a spring between bodies.
pub(crate) const RATE: Stiffness<RawSpring> = stiffnesses!(RawSpring { "stiffness": rate, Kind::LinearStiffness; })[0];
/// Axial stiffness of an actuator.
pub(crate) const AXIAL: Stiffness<RawActuator> =
    stiffnesses!(RawActuator { "axial": axial, Kind::LinearStiffness; })[0];
/// Springs of a joint: along and across its axis, about it and about what lies across it; then along and about its x and y,
/// where these differ.
pub(crate) const JOINT: [Stiffness<RawJointStiffness>; 8] = stiffnesses!(RawJointStiffness {
    "ka": ka, Kind::LinearStiffness;
    "kr": kr, Kind::LinearStiffness;
    "kar": kar, Kind::RotationalStiffness;
    "krr": krr, Kind::RotationalStiffness;
    "krx": krx, Kind::LinearStiffness;
    "kry": kry, Kind::LinearStiffness;
    "krrx": krrx, Kind::RotationalStiffness;
    "krry": krry, Kind::RotationalStiffness;
});
/// Which of [`JOINT`] holds each direction of a joint (along x, y, z, about x, y, z), where `given` says which are declared.
pub(crate) fn joint_directions(given: impl Fn(usize) -> bool) -> [usize; 6] {
    let across = |all: usize, [x, y]: [usize; 2]| if given(x) || given(y) { [x, y] } else { [all, all] };
    let ([x, y], [rx, ry]) = (across(1, [4, 5]), across(3, [6, 7]));
    [x, y, 0, rx, ry, 2]
}
/// Those of [`JOINT`] that hold a direction, in the order in which parameters stand.
pub(crate) fn joint_springs(directions: [usize; 6]) -> Vec<usize> {
    let [x, y, z, rx, ry, rz] = directions;
    let mut springs = vec![z, x, y, rz, rx, ry];
    springs.dedup();
    springs
}
/// Springs of the pedestal along and about x, y, z.
pub(crate) const PEDESTAL: [Stiffness<RawBaseStiffness>; 6] = stiffnesses!(RawBaseStiffness {
    "kx": kx, Kind::LinearStiffness;
    "ky": ky, Kind::LinearStiffness;
    "kz": kz, Kind::LinearStiffness;
    "krx": krx, Kind::RotationalStiffness;
    "kry": kry, Kind::RotationalStiffness;
    "krz": krz, Kind::RotationalStiffness;
});

/// Symbols of a table.
pub(crate) const fn symbols<R, const N: usize>(table: &[Number<R>; N]) -> [&'static str; N] {
    let mut symbols = [""; N];
    let mut k = 0;
    while k < N {
        symbols[k] = table[k].symbol;
        k += 1;
    }
    symbols
}

/// Symbols by which a section of a shape is declared.
pub(crate) fn section_symbols(shape: Option<SectionShape>) -> &'static [&'static str] {
    match shape {
        Some(SectionShape::Box) => &["width", "height", "wall"],
        Some(SectionShape::Tube) => &["diameter", "wall"],
        Some(SectionShape::Rectangle) => &["width", "height"],
        Some(SectionShape::Rod) => &["diameter"],
        Some(SectionShape::I) => &["width", "height", "wall", "flange"],
        None => &["area", "iy", "iz", "j"],
    }
}

/// What owns a parameter: an entry of the file, by its name there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Owner<'r> {
    Base,
    Frame(&'r str),
    Actuator(&'r str),
    Tool,
    Marker(&'r str),
    /// Springs of the joint of a frame.
    Joint(&'r str),
    Pedestal,
    Spring(&'r str),
    Material(&'r str),
    Section(&'r str),
    /// The body of a frame.
    Body(&'r str),
}

impl<'r> Owner<'r> {
    /// Path of its entry in the file.
    pub fn path(self) -> Vec<&'r str> {
        match self {
            Self::Base => vec!["base"],
            Self::Tool => vec!["tool"],
            Self::Pedestal => vec!["base_stiffness"],
            Self::Frame(name) => vec!["frames", name],
            Self::Actuator(name) => vec!["actuators", name],
            Self::Marker(name) => vec!["markers", name],
            Self::Joint(name) => vec!["joint_stiffness", name],
            Self::Spring(name) => vec!["springs", name],
            Self::Material(name) => vec!["materials", name],
            Self::Section(name) => vec!["sections", name],
            Self::Body(name) => vec!["bodies", name],
        }
    }

    /// Entries that could own a parameter of this name, were they declared. The one place that takes a name apart: one that
    /// a file gives and nothing has.
    pub fn possible(name: &'r str) -> Vec<Self> {
        let owner = name.rsplit_once('.').map_or(name, |(owner, _)| owner);
        let joint = owner.strip_prefix("joint").map(Self::Joint);
        [Self::Frame(owner), Self::Actuator(owner), Self::Marker(owner), Self::Spring(owner)]
            .into_iter()
            .chain(joint)
            .collect()
    }

    /// Name of one of its parameters.
    pub fn parameter(self, symbol: &str) -> String {
        match self {
            Self::Base | Self::Pedestal => format!("base.{symbol}"),
            Self::Tool => format!("tool.{symbol}"),
            Self::Joint(frame) => format!("joint{frame}.{symbol}"),
            Self::Body(frame) => format!("body{frame}.{symbol}"),
            Self::Frame(name)
            | Self::Actuator(name)
            | Self::Marker(name)
            | Self::Spring(name)
            | Self::Material(name)
            | Self::Section(name) => format!("{name}.{symbol}"),
        }
    }
}

/// A parameter that a description has.
#[derive(Debug, Clone)]
pub(crate) struct Key<'r> {
    pub owner: Owner<'r>,
    /// Symbol.
    pub symbol: &'static str,
    /// Name: of owner and symbol.
    pub name: String,
    /// What the number in the file measures: a compliance where a stiffness is declared as one.
    pub kind: Kind,
    /// Whether the file declares it, or it follows from what the file declares; else it is rigid, or nothing needs it.
    pub declared: bool,
}

/// Collects keys.
struct Keys<'r>(Vec<Key<'r>>);

impl<'r> Keys<'r> {
    fn numbers<R>(&mut self, owner: Owner<'r>, table: &[Number<R>], declared: impl Fn(&Number<R>) -> bool) {
        self.0.extend(table.iter().map(|row| {
            let (symbol, kind, declared) = (row.symbol, row.kind, declared(row));
            Key { owner, symbol, name: owner.parameter(symbol), kind, declared }
        }));
    }

    /// Stiffnesses of an entry, which may be absent: `declared` says whether it is there.
    fn stiffnesses<R>(&mut self, owner: Owner<'r>, table: &[Stiffness<R>], entry: Option<&R>, declared: bool) {
        self.0.extend(table.iter().map(|row| {
            let given = entry.and_then(|entry| (row.get)(entry));
            let by_compliance = given.is_some_and(|given| given.compliance.is_some());
            let kind = if by_compliance { row.kind.inverse() } else { row.kind };
            Key { owner, symbol: row.symbol, name: owner.parameter(row.symbol), kind, declared }
        }));
    }
}

/// Every parameter of a description.
pub(crate) fn parameters(raw: &RawRobot) -> Vec<Key<'_>> {
    let mut keys = Keys(Vec::new());
    keys.numbers(Owner::Base, &BASE, |_| true);
    raw.frames.keys().filter(|name| *name != "0").for_each(|name| keys.numbers(Owner::Frame(name), &FRAME, |_| true));
    raw.actuators.keys().for_each(|name| keys.numbers(Owner::Actuator(name), &SLIDER_CRANK, |_| true));
    keys.numbers(Owner::Tool, &TOOL, |_| true);
    raw.markers.keys().for_each(|name| keys.numbers(Owner::Marker(name), &MARKER, |_| true));
    let springs = |entry: Option<&RawJointStiffness>| -> Vec<Stiffness<RawJointStiffness>> {
        let given = |k: usize| entry.is_some_and(|entry| (JOINT[k].get)(entry).is_some());
        joint_springs(joint_directions(given)).into_iter().map(|k| JOINT[k]).collect()
    };
    for (name, entry) in &raw.joint_stiffness {
        keys.stiffnesses(Owner::Joint(name), &springs(Some(entry)), Some(entry), true);
    }
    let moves = |frame: &RawFrame| !matches!(frame.joint, None | Some(JointKind::Fixed));
    for (name, _) in raw.frames.iter().filter(|(name, frame)| moves(frame) && !raw.joint_stiffness.contains_key(*name))
    {
        keys.stiffnesses(Owner::Joint(name), &springs(None), None, false);
    }
    keys.stiffnesses(Owner::Pedestal, &PEDESTAL, raw.base_stiffness.as_ref(), raw.base_stiffness.is_some());
    for (name, actuator) in &raw.actuators {
        keys.stiffnesses(Owner::Actuator(name), &[AXIAL], Some(actuator), true);
    }
    for (name, spring) in &raw.springs {
        keys.stiffnesses(Owner::Spring(name), &[RATE], Some(spring), true);
        // Without a free length the spring's tension is unknown, and nothing depends on a length it does not have.
        keys.numbers(Owner::Spring(name), &[FREE_LENGTH], |row| (row.get)(spring).is_some());
        keys.numbers(Owner::Spring(name), &ANCHORS, |_| true);
    }
    for (name, material) in &raw.materials {
        keys.numbers(Owner::Material(name), &MATERIAL, |row| match row.symbol {
            "shear" => material.shear.is_some(),
            "poisson" => material.shear.is_none(),
            other => other != "expansion",
        });
    }
    for (name, section) in &raw.sections {
        keys.numbers(Owner::Section(name), &SECTION, |row| section_symbols(section.shape).contains(&row.symbol));
    }
    for name in raw.bodies.keys() {
        keys.numbers(Owner::Body(name), &[MASS], |_| true);
        keys.numbers(Owner::Body(name), &CENTRE, |_| true);
    }
    keys.0
}

fn set<R>(table: &[Number<R>], entry: Option<&mut R>, symbol: &str, value: f64) {
    if let (Some(row), Some(entry)) = (table.iter().find(|row| row.symbol == symbol), entry) {
        (row.set)(entry, value);
    }
}

/// Writes a stiffness, or the compliance it is the inverse of, as `kind` says.
fn hold<R>(table: &[Stiffness<R>], entry: Option<&mut R>, symbol: &str, value: f64, kind: Kind) {
    if let (Some(row), Some(entry)) = (table.iter().find(|row| row.symbol == symbol), entry) {
        let given = (row.at)(entry).get_or_insert_default();
        (given.value, given.compliance) = if kind == row.kind { (Some(value), None) } else { (None, Some(value)) };
    }
}

impl Key<'_> {
    /// Writes a value, in the file's unit of `kind`, where the parameter stands in the file.
    pub fn write(&self, raw: &mut RawRobot, value: f64, kind: Kind) {
        let symbol = self.symbol;
        match self.owner {
            Owner::Base => set(&BASE, Some(&mut raw.base), symbol, value),
            Owner::Tool => set(&TOOL, Some(&mut raw.tool), symbol, value),
            Owner::Frame(name) => set(&FRAME, raw.frames.get_mut(name), symbol, value),
            Owner::Actuator(name) => {
                hold(&[AXIAL], raw.actuators.get_mut(name), symbol, value, kind);
                set(&SLIDER_CRANK, raw.actuators.get_mut(name), symbol, value);
            }
            Owner::Marker(name) => set(&MARKER, raw.markers.get_mut(name), symbol, value),
            Owner::Joint(name) => {
                let joint = raw.joint_stiffness.entry(name.to_owned()).or_default();
                hold(&JOINT, Some(joint), symbol, value, kind);
            }
            Owner::Pedestal => {
                hold(&PEDESTAL, Some(raw.base_stiffness.get_or_insert_default()), symbol, value, kind);
            }
            Owner::Spring(name) => {
                hold(&[RATE], raw.springs.get_mut(name), symbol, value, kind);
                set(&[FREE_LENGTH], raw.springs.get_mut(name), symbol, value);
                set(&ANCHORS, raw.springs.get_mut(name), symbol, value);
            }
            Owner::Material(name) => set(&MATERIAL, raw.materials.get_mut(name), symbol, value),
            Owner::Section(name) => set(&SECTION, raw.sections.get_mut(name), symbol, value),
            Owner::Body(name) => {
                set(&[MASS], raw.bodies.get_mut(name), symbol, value);
                set(&CENTRE, raw.bodies.get_mut(name), symbol, value);
            }
        }
    }
}
