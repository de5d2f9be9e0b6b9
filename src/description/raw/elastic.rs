//! Elasticity and mass: bodies, sections, nodes, beams, springs, and the fuzzy compliance in their place.

use indexmap::IndexMap;
#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::absent;
#[cfg(feature = "cli")]
use super::{name, names};
use crate::description::form::forms;

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
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
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        body: Option<String>,
        /// The frame at whose origin the node lies; the body's own where absent.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        at: Option<String>,
        /// Where it lies in that frame, if not at the origin, in the length unit.
        point: Option<[f64; 3]>,
        /// How the ground holds it, in addition to the joints.
        support: Option<Support>,
    }
}

/// How the ground holds a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
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
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        from: Option<String>,
        /// Second node.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        to: Option<String>,
        /// Section, by name.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        section: Option<String>,
        /// Section at the second node of a tapered beam.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        section_to: Option<String>,
        /// Material, by name.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        material: Option<String>,
        /// Frame whose z axis, made square to the beam, is its local z (the normal of the plane in which Iz bends); its x axis where z lies
        /// along the beam. That of the first node's body where absent.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
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
    /// Where x and y differ, krx and kry stand for kr, and krrx and krry for krr.
    /// What is absent is rigid, but for kar (ka of a prismatic joint) of a passive joint, which is free.
    pub struct RawJointStiffness {
        /// Node of the moving body at which the joint sits; by default the one nearest to the frame's origin.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        at: Option<String>,
        /// Along the axis.
        ka: Option<RawStiffness>,
        /// Across the axis.
        kr: Option<RawStiffness>,
        /// About the axis.
        kar: Option<RawStiffness>,
        /// About the two directions across the axis.
        krr: Option<RawStiffness>,
        /// Across the axis, along the frame's x, instead of `kr`.
        krx: Option<RawStiffness>,
        /// Across the axis, along the frame's y, instead of `kr`.
        kry: Option<RawStiffness>,
        /// About the frame's x, instead of `krr`.
        krrx: Option<RawStiffness>,
        /// About the frame's y, instead of `krr`.
        krry: Option<RawStiffness>,
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
        #[cfg_attr(feature = "cli", schemars(schema_with = "names"))]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
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
        /// File that holds the model, relative to this file and in its units; no other key is given with it.
        file: Option<String>,
        /// Joints (by frame) or variables that the compliance depends on.
        #[cfg_attr(feature = "cli", schemars(schema_with = "names"))]
        inputs: Vec<String>,
        /// The marker whose displacement it gives, loaded there; the tool centre point by default.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        at: Option<String>,
        /// Frame whose axes the components have, turning with it; the base's by default.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        axes: Option<String>,
        /// Added to what the springs and beams of this description give, instead of standing in their place.
        adds: bool,
        /// Components of the compliance by name: displacement (x, y, z, rx, ry, rz), a dot, load (fx, .., mz). Those not
        /// named are zero.
        components: IndexMap<String, RawFuzzyComponent>,
        /// Springs of this description (`joint2.kar`) whose stiffness depends on the inputs: conclusions are stiffnesses,
        /// whose compliances are weighted. What is declared for them elsewhere is not used.
        springs: IndexMap<String, RawFuzzyComponent>,
    }
}

raw! {
    /// Rules of a component of a fuzzy compliance, or of a spring: a grid of sets (`modes` and `conclusions`) or a `tree`.
    pub struct RawFuzzyComponent {
        /// Modal values of each input's sets, ascending, in the units of the input.
        modes: Vec<Vec<f64>>,
        /// Conclusion of each rule, in the units of displacement over load (of springs: of stiffness); the last input's sets
        /// count fastest.
        conclusions: Vec<f64>,
        /// Rules by splits, each along one input.
        tree: Option<RawBranch>,
    }
}

/// A branch of a tree of rules.
// Read by hand, so that what is wrong in a split is said of its key.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(untagged)]
pub enum RawBranch {
    /// A rule: its conclusion.
    Conclusion(f64),
    /// Further rules.
    Split(Box<RawSplit>),
}

/// A split along one input: the weight goes linearly from one branch to the other.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RawSplit {
    /// One of `inputs`.
    #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
    pub input: String,
    /// Value up to which only `below` holds, in the units of the input.
    pub from: f64,
    /// Value from which only `above` holds.
    pub to: f64,
    /// What holds at small values.
    pub below: RawBranch,
    /// What holds at large values.
    pub above: RawBranch,
}

impl RawFuzzyComponent {
    /// Number of its rules.
    pub fn rules(&self) -> usize {
        self.tree.as_ref().map_or(self.conclusions.len(), RawBranch::rules)
    }
}

forms! {
    RawBranch: "a conclusion (a number), or a split {input, from, to, below, above}",
    number value => RawBranch::Conclusion(value),
    map split: Box<RawSplit> => RawBranch::Split(split)
}

impl RawBranch {
    fn rules(&self) -> usize {
        match self {
            Self::Conclusion(_) => 1,
            Self::Split(split) => split.below.rules() + split.above.rules(),
        }
    }
}

/// A body fixed to the tool.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RawPayload {
    /// Its mass.
    #[cfg_attr(feature = "cli", schemars(required))]
    pub mass: Option<f64>,
    /// Its centre of mass in the frame.
    #[serde(default)]
    pub com: [f64; 3],
    /// The frame; that of the tool where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
}
