//! First age of a robot description: the image of the YAML file, in the file's own units, nothing checked beyond its
//! shape. Every field may be absent, so that one fault does not hide the next; [`super::resolve`] says what is missing.

use indexmap::IndexMap;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::units::Units;

fn absent<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// A name in YAML may be written as a number (`1`).
fn name(_: &mut SchemaGenerator) -> Schema {
    json_schema!({"type": ["string", "integer", "null"]})
}

fn names(_: &mut SchemaGenerator) -> Schema {
    json_schema!({"type": ["array", "null"], "items": {"type": ["string", "integer"]}})
}

macro_rules! raw {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* $field:ident: $type:ty,)* }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name { $($(#[$field_meta])* #[serde(skip_serializing_if = "absent")] pub $field: $type,)* }
    };
}

raw! {
    /// A robot: what is declared of it. Everything else (kinematics, closure, error Jacobian, identifiable set) is derived.
    pub struct RawRobot {
        /// Display name.
        robot: Option<String>,
        /// Where the numbers come from; say here what is assumed.
        source: Option<String>,
        /// Units of every number in this file; SI where absent.
        units: Units,
        /// URDF file to start from, relative to this file. Its joints become frames of the same names; `frames` below
        /// adds to them or overrides single keys. A URDF is always SI.
        urdf: Option<String>,
        /// Order of the actuated variables; by default the order in which frames and actuators name them.
        #[schemars(schema_with = "names")]
        variables: Vec<String>,
        /// Frames by name. `0` is the base and is not declared.
        frames: IndexMap<String, RawFrame>,
        /// Joints that follow others: `6 = -1 * 5`, several terms joined by `+` or `-`.
        couplings: Vec<String>,
        /// Closed loops by name.
        loops: IndexMap<String, RawLoop>,
        /// Actuators that do not sit at their joint, by name.
        actuators: IndexMap<String, RawActuator>,
        /// Pose of the robot's base frame 0 in the measurement frame.
        base: RawPlacement,
        /// Tool centre point. By default the origin of the only frame that carries nothing.
        tool: RawTool,
        /// Measured points by name.
        markers: IndexMap<String, RawMarker>,
        /// Fixed points of the cell, in the measurement frame, from which distances are measured, by name.
        anchors: IndexMap<String, [f64; 3]>,
        /// Acceleration of gravity in base axes, m/s2 whatever the units; by default (0, 0, -9.81).
        gravity: Option<[f64; 3]>,
        /// Mass of each body, by the frame it moves with.
        bodies: IndexMap<String, RawBody>,
        /// Materials by name.
        materials: IndexMap<String, RawMaterial>,
        /// Beam cross-sections by name.
        sections: IndexMap<String, RawSection>,
        /// Elastic nodes by name: a point of a body. A frame's name stands for its origin on its own body.
        nodes: IndexMap<String, RawNode>,
        /// Beams by name, from node to node.
        beams: IndexMap<String, RawBeam>,
        /// Stiffness of joints, by the joint's frame.
        joint_stiffness: IndexMap<String, RawJointStiffness>,
        /// Stiffness of the pedestal under frame 0; rigid where absent.
        base_stiffness: Option<RawBaseStiffness>,
        /// Springs and gravity compensators between two bodies, by name.
        springs: IndexMap<String, RawSpring>,
        /// Effects that have been switched on.
        effects: Vec<RawEffect>,
        /// Takagi-Sugeno compliance of the tool, in place of what gives above or added to it.
        fuzzy: Option<RawFuzzy>,
        /// Which parameters are free in calibration, how far they may be off.
        calibration: RawCalibration,
    }
}

raw! {
    /// A frame placed in its antecedent by Ry(beta) Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r)
    /// (Khalil and Kleinfinger 1986, with Hayati's beta in front).
    pub struct RawFrame {
        /// The frame it is placed in; `0` is the base.
        #[schemars(schema_with = "name")]
        antecedent: Option<String>,
        /// How it moves in its antecedent; `fixed` where absent.
        joint: Option<JointKind>,
        /// The actuated variable that moves it.
        #[schemars(schema_with = "name")]
        variable: Option<String>,
        /// +1 or -1: sense in which the controller counts the variable.
        direction: Option<f64>,
        /// True when nothing drives it but the closed loop it belongs to.
        passive: bool,
        /// This frame turns about the axis of another frame of the same antecedent: it shares that frame's
        /// beta, gamma, b, alpha and d, errors included.
        #[schemars(schema_with = "name")]
        coaxial: Option<String>,
        /// Hayati's rotation about y, applied first.
        beta: Option<f64>,
        /// Rotation about the antecedent's z.
        gamma: Option<f64>,
        /// Translation along the antecedent's z.
        b: Option<f64>,
        /// Rotation about x.
        alpha: Option<f64>,
        /// Translation along x.
        d: Option<f64>,
        /// Rotation about z; for a revolute joint the constant added to the joint variable.
        theta: Option<f64>,
        /// Translation along z; for a prismatic joint the constant added to the joint variable.
        r: Option<f64>,
        /// Zero of the joint variable, as calibrated: added to the variable before couplings and loops see it.
        offset: Option<f64>,
        /// Least and greatest value of the joint variable.
        limits: Option<[f64; 2]>,
    }
}

/// How a frame moves in its antecedent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JointKind {
    /// About its z axis.
    Revolute,
    /// Along its z axis.
    Prismatic,
    /// Not at all.
    Fixed,
}

raw! {
    /// A closed loop, cut at a joint: two frames that meet.
    pub struct RawLoop {
        /// The two frames that meet, on the two sides of the cut.
        #[schemars(schema_with = "names")]
        frames: Option<[String; 2]>,
        /// `planar` when all axes are parallel (closed in the plane, by the lengths d), else `spatial`.
        kind: Option<LoopKind>,
        /// What meets: the whole `frame`, or its `origin` only (a ball joint; in the plane, a pin).
        meet: Option<Meet>,
        /// Assembly branch: rough values of the loop's passive joints, by frame, at `at`.
        branch: IndexMap<String, f64>,
        /// Values of the actuated variables at which `branch` was read; middle of the limits, or zero, where absent.
        at: IndexMap<String, f64>,
        /// Gap up to which an over-constrained spatial loop counts as closed (it is then closed in the least-squares
        /// sense). Zero where absent: the loop must close.
        gap: Option<f64>,
    }
}

/// In which space a loop is closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LoopKind {
    /// In the plane normal to its parallel axes.
    Planar,
    /// In space.
    Spatial,
}

/// What coincides at the cut of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Meet {
    /// Origin and axes.
    Frame,
    /// The origin alone.
    Origin,
}

raw! {
    /// A linear actuator that turns a joint through a triangle:
    /// (stroke variable + stroke)^2 = l1^2 + l3^2 + 2 l1 l3 cos(kappa + lambda - joint), 0 < kappa + lambda - joint < 180 deg.
    pub struct RawActuator {
        /// Kind of actuator.
        kind: Option<ActuatorKind>,
        /// The frame whose joint it turns.
        #[schemars(schema_with = "name")]
        joint: Option<String>,
        /// The actuated variable: the length between its two pins.
        #[schemars(schema_with = "name")]
        variable: Option<String>,
        /// Angle of the pin on the moving body.
        kappa: Option<f64>,
        /// Angle of the pin on the antecedent body.
        lambda: Option<f64>,
        /// Distance from the joint to the pin on the moving body.
        l1: Option<f64>,
        /// Distance from the joint to the pin on the antecedent body.
        l3: Option<f64>,
        /// Zero of the stroke variable.
        stroke: Option<f64>,
        /// Least and greatest value of the variable.
        limits: Option<[f64; 2]>,
        /// Axial stiffness of the screw, in the stiffness unit; rigid where absent.
        axial: Option<RawStiffness>,
        /// How the screw's force reaches the bodies; `pins` where `axial` is finite or identifiable.
        path: Option<LoadPath>,
    }
}

/// How the force of a ball screw or cylinder reaches the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LoadPath {
    /// Along the line between its two pins; the joint itself is a free hinge.
    Pins,
    /// As a torque at the joint: its axial spring is lumped there, in series with the joint's own.
    Joint,
}

/// Kind of actuator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ActuatorKind {
    /// A ball screw or cylinder between two pins.
    SliderCrank,
}

raw! {
    /// A pose: position and rotation vector.
    pub struct RawPlacement {
        /// Position, in the length unit.
        at: Option<[f64; 3]>,
        /// Rotation vector, in the angle unit.
        rotation: Option<[f64; 3]>,
    }
}

raw! {
    /// The tool centre point, in a frame.
    pub struct RawTool {
        /// The frame it moves with.
        #[schemars(schema_with = "name")]
        frame: Option<String>,
        /// Position in that frame.
        at: Option<[f64; 3]>,
        /// Rotation vector of the tool's axes in that frame.
        rotation: Option<[f64; 3]>,
    }
}

raw! {
    /// A measured point, in a frame.
    pub struct RawMarker {
        /// The frame it moves with; the tool's where absent.
        #[schemars(schema_with = "name")]
        frame: Option<String>,
        /// Position in that frame.
        at: Option<[f64; 3]>,
    }
}

raw! {
    /// Mass of a body.
    pub struct RawBody {
        /// Mass.
        mass: Option<f64>,
        /// Centre of mass in the body's frame.
        com: Option<[f64; 3]>,
    }
}

raw! {
    /// An isotropic material.
    pub struct RawMaterial {
        /// Young's modulus, in the pressure unit.
        young: Option<f64>,
        /// Poisson's ratio; gives the shear modulus E / (2 (1 + nu)).
        poisson: Option<f64>,
        /// Shear modulus, instead of `poisson`.
        shear: Option<f64>,
        /// Density, kg/m3 whatever the units.
        density: Option<f64>,
        /// Coefficient of thermal expansion, 1/K.
        expansion: Option<f64>,
    }
}

raw! {
    /// A beam's cross-section: by dimensions (`shape` and what it needs) or by A, Iy, Iz, J.
    pub struct RawSection {
        /// Shape, when given by dimensions.
        shape: Option<SectionShape>,
        /// Outer size along the beam's local y.
        width: Option<f64>,
        /// Outer size along the beam's local z.
        height: Option<f64>,
        /// Wall thickness of a box or tube; web of an I.
        wall: Option<f64>,
        /// Flange thickness of an I.
        flange: Option<f64>,
        /// Outer diameter of a tube or rod.
        diameter: Option<f64>,
        /// Area, length unit squared.
        area: Option<f64>,
        /// Second moment of area about local y, length unit to the fourth.
        iy: Option<f64>,
        /// Second moment of area about local z, length unit to the fourth.
        iz: Option<f64>,
        /// Torsion constant, length unit to the fourth.
        j: Option<f64>,
        /// Shear area along local y (Timoshenko).
        shear_y: Option<f64>,
        /// Shear area along local z (Timoshenko).
        shear_z: Option<f64>,
    }
}

/// Shape of a section given by dimensions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SectionShape {
    /// Hollow rectangle: width, height, wall.
    Box,
    /// Hollow circle: diameter, wall.
    Tube,
    /// Full rectangle: width, height.
    Rectangle,
    /// Full circle: diameter.
    Rod,
    /// I section: width, height, wall (web), flange.
    I,
}

raw! {
    /// An elastic node: a point of a body.
    pub struct RawNode {
        /// The body, by the frame it moves with; `0` is the ground.
        #[schemars(schema_with = "name")]
        body: Option<String>,
        /// The frame at whose origin the node lies; the body's own where absent.
        #[schemars(schema_with = "name")]
        at: Option<String>,
        /// Where it lies in that frame, if not at the origin, in the length unit.
        point: Option<[f64; 3]>,
        /// How the ground holds it, beside what the joints do.
        support: Option<Support>,
    }
}

/// How the ground holds a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Support {
    /// In all six degrees of freedom.
    Fixed,
    /// Its position; it can turn.
    Pinned,
}

raw! {
    /// A beam between two nodes of one body.
    pub struct RawBeam {
        /// First node.
        #[schemars(schema_with = "name")]
        from: Option<String>,
        /// Second node.
        #[schemars(schema_with = "name")]
        to: Option<String>,
        /// Section, by name.
        #[schemars(schema_with = "name")]
        section: Option<String>,
        /// Section at the second node of a tapered beam.
        #[schemars(schema_with = "name")]
        section_to: Option<String>,
        /// Material, by name.
        #[schemars(schema_with = "name")]
        material: Option<String>,
        /// Frame whose z axis is the beam's local z (the normal of the plane in which Iz bends).
        #[schemars(schema_with = "name")]
        normal: Option<String>,
        /// Beam theory; `euler-bernoulli` where absent.
        theory: Option<BeamTheory>,
        /// Number of elements the beam is cut into; 1 where absent.
        elements: Option<u32>,
        /// What its ends do not hold: hinges and slides between the beam and its nodes.
        release: RawRelease,
    }
}

raw! {
    /// Directions in which the ends of a beam are free of their nodes, in the beam's own axes.
    pub struct RawRelease {
        /// At the first node.
        from: Vec<LocalAxis>,
        /// At the second node.
        to: Vec<LocalAxis>,
    }
}

/// A direction of a beam's own axes: x from its first node to its second, z as `normal` says, y across both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LocalAxis {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
    /// About x.
    Rx,
    /// About y.
    Ry,
    /// About z: a hinge in the plane in which Iz bends.
    Rz,
}

/// Beam theory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BeamTheory {
    /// Shear neglected.
    EulerBernoulli,
    /// With shear areas.
    Timoshenko,
}

raw! {
    /// A stiffness: its value (or compliance), and whether measurements may change it.
    pub struct RawStiffness {
        /// Stiffness; `.inf` is rigid, 0 is free.
        value: Option<f64>,
        /// Compliance, instead of `value`, in the inverse unit.
        compliance: Option<f64>,
        /// Whether calibration may identify it; false where absent.
        identifiable: bool,
        /// Bounds of the stiffness.
        bounds: Option<[f64; 2]>,
    }
}

raw! {
    /// Springs of a joint about its frame's axes: axial ka, radial kr, axial rotational kar, radial rotational krr.
    /// What is absent is rigid, but for kar (ka of a prismatic joint) of a passive joint, which is free.
    pub struct RawJointStiffness {
        /// Node of the moving body at which the joint sits; by default the one nearest to the frame's origin.
        #[schemars(schema_with = "name")]
        at: Option<String>,
        /// Along the axis.
        ka: Option<RawStiffness>,
        /// Across the axis.
        kr: Option<RawStiffness>,
        /// About the axis.
        kar: Option<RawStiffness>,
        /// About the two directions across the axis.
        krr: Option<RawStiffness>,
    }
}

raw! {
    /// Springs of the pedestal along and about the base axes; what is absent is rigid.
    pub struct RawBaseStiffness {
        /// Along x.
        kx: Option<RawStiffness>,
        /// Along y.
        ky: Option<RawStiffness>,
        /// Along z.
        kz: Option<RawStiffness>,
        /// About x.
        krx: Option<RawStiffness>,
        /// About y.
        kry: Option<RawStiffness>,
        /// About z.
        krz: Option<RawStiffness>,
    }
}

raw! {
    /// A spring between points of two bodies.
    pub struct RawSpring {
        /// The two bodies, by the frames they move with.
        #[schemars(schema_with = "names")]
        bodies: Option<[String; 2]>,
        /// The anchor on each body, in that body's frame at joint value zero of the constants, length unit.
        anchors: Option<[[f64; 3]; 2]>,
        /// Spring rate.
        rate: Option<RawStiffness>,
        /// Length at which the spring carries no force.
        free_length: Option<f64>,
        /// Force at `preload_length`, instead of `free_length`.
        preload: Option<f64>,
        /// Length at which `preload` acts.
        preload_length: Option<f64>,
        /// `full`: force and stiffness; `stiffness`: only the stiffness it adds (the rest being in the controller).
        acts: Option<SpringAction>,
    }
}

/// What of a spring enters the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SpringAction {
    /// Force and stiffness.
    Full,
    /// Stiffness only.
    Stiffness,
}

raw! {
    /// A Takagi-Sugeno model (order zero) of the compliance of a point of the tool: strong triangular partitions that
    /// saturate outside, product conjunction.
    pub struct RawFuzzy {
        /// File that holds all the rest, relative to this file and in its units; nothing stands beside it then.
        file: Option<String>,
        /// Joints (by frame) or variables that the compliance depends on.
        #[schemars(schema_with = "names")]
        inputs: Vec<String>,
        /// The marker whose displacement it gives, loaded there; the tool centre point by default.
        #[schemars(schema_with = "name")]
        at: Option<String>,
        /// Added to what the springs and beams of this description give, instead of standing in their place.
        adds: bool,
        /// Components of the compliance by name: displacement (x, y, z, rx, ry, rz), a dot, load (fx, .., mz), in base
        /// axes. Those not named are zero.
        components: IndexMap<String, RawFuzzyComponent>,
    }
}

raw! {
    /// A component of a fuzzy compliance.
    pub struct RawFuzzyComponent {
        /// Modal values of each input's sets, ascending, in the units of the input.
        modes: Vec<Vec<f64>>,
        /// Conclusion of each rule, in the units of displacement over load; the last input's sets count fastest.
        conclusions: Vec<f64>,
    }
}

raw! {
    /// An effect that has been switched on.
    pub struct RawEffect {
        /// Its name in the catalogue of effects.
        effect: Option<String>,
        /// Where it sits: `joint:2`, `link:3`, `actuator:screw2`, `frame:4`, `base`, `tool`, `instrument`.
        site: Option<String>,
        /// Its parameters, SI.
        parameters: IndexMap<String, f64>,
    }
}

raw! {
    /// Which parameters are free in calibration and how far they may be off. Parameters are named `<owner>.<symbol>`.
    pub struct RawCalibration {
        /// Parameters to free beyond the rule (`3.theta`).
        free: Vec<String>,
        /// Parameters to hold although the rule frees them.
        fixed: Vec<String>,
        /// How far a length is commonly off (one sigma); 1 mm where absent.
        length_tolerance: Option<f64>,
        /// How far an angle is commonly off (one sigma); 1 mrad where absent.
        angle_tolerance: Option<f64>,
        /// The same for single parameters.
        tolerances: IndexMap<String, f64>,
        /// Bounds of single parameters, in the file's units; the declared value lies within them.
        bounds: IndexMap<String, [f64; 2]>,
    }
}
