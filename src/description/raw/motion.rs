//! What moves: frames, loops, actuators, and the points that are measured.

use indexmap::IndexMap;
#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{RawStiffness, absent};
#[cfg(feature = "cli")]
use super::{name, names};
use crate::settings::named;

raw! {
    /// A frame placed in its antecedent by Ry(beta) Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r)
    /// (Khalil and Kleinfinger 1986, with Hayati's beta in front), or as a row of a table of Denavit and Hartenberg where
    /// the description's `convention` says so: `modified-dh` Rx(alpha) Tx(a) Rz(theta) Tz(d),
    /// `classical-dh` Rz(theta) Tz(d) Tx(a) Rx(alpha).
    pub struct RawFrame {
        /// The frame it is placed in; `0` is the base.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        antecedent: Option<String>,
        /// How it moves in its antecedent; `fixed` where absent.
        joint: Option<JointKind>,
        /// The actuated variable that moves it.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        variable: Option<String>,
        /// +1 or -1: sense in which the controller counts the variable.
        direction: Option<f64>,
        /// True when nothing drives it but the closed loop it belongs to.
        passive: bool,
        /// This frame turns about the axis of another frame of the same antecedent: it shares that frame's
        /// beta, gamma, b, alpha and d, errors included.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        coaxial: Option<String>,
        /// Hayati's rotation about y, applied first.
        beta: Option<f64>,
        /// Rotation about the antecedent's z.
        gamma: Option<f64>,
        /// Translation along the antecedent's z.
        b: Option<f64>,
        /// Rotation about x.
        alpha: Option<f64>,
        /// Translation along x. In a table of Denavit and Hartenberg: along z; the variable of a prismatic joint is added.
        d: Option<f64>,
        /// In a table of Denavit and Hartenberg alone: translation along x.
        a: Option<f64>,
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

named! {
    /// How the constants of frames are read.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
    #[cfg_attr(feature = "cli", derive(JsonSchema))]
    #[serde(rename_all = "kebab-case")]
    pub enum Convention {
        /// Khalil and Kleinfinger 1986: `beta gamma b alpha d theta r`.
        KhalilKleinfinger "khalil-kleinfinger",
        /// Craig's table: `alpha a theta d`, alpha and a being those of the body before; `beta gamma b` may be added.
        ModifiedDh "modified-dh",
        /// The table of Denavit and Hartenberg as in Paul or Spong: `theta d a alpha`, frame i at the far end of body i.
        ClassicalDh "classical-dh",
    }
}

/// How a frame moves in its antecedent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
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
        #[cfg_attr(feature = "cli", schemars(schema_with = "names"))]
        frames: Option<[String; 2]>,
        /// `planar` when all axes are parallel (closed in the plane, by the lengths d), else `spatial`.
        kind: Option<LoopKind>,
        /// What meets: the whole `frame`, or its `origin` only (a ball joint; in the plane, a pin).
        meet: Option<Meet>,
        /// Assembly branch: rough values of the loop's passive joints, by frame, at `at`.
        branch: IndexMap<String, f64>,
        /// Values of the actuated variables at which `branch` was read; middle of the limits, or zero, where absent.
        at: IndexMap<String, f64>,
        /// Gap up to which an over-constrained spatial loop counts as closed: it is closed in the least-squares sense, since
        /// errors of its constants cannot all be taken up by its passive joints. 10 mm (0.01 rad) where absent.
        gap: Option<f64>,
    }
}

/// In which space a loop is closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LoopKind {
    /// In the plane normal to its parallel axes.
    Planar,
    /// In space.
    Spatial,
}

/// What coincides at the cut of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
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
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        joint: Option<String>,
        /// The actuated variable: the length between its two pins.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LoadPath {
    /// Along the line between its two pins; the joint itself is a free hinge.
    Pins,
    /// As a torque at the joint: its axial spring is lumped there, in series with the joint's own.
    Joint,
}

/// Kind of actuator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
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
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        frame: Option<String>,
        /// Position in that frame.
        at: Option<[f64; 3]>,
        /// Rotation vector of the tool's axes in that frame.
        rotation: Option<[f64; 3]>,
    }
}

raw! {
    /// A box along the axes of the base frame 0 through which no link may pass: from and to along each axis, open where absent
    /// or infinite.
    pub struct RawKeepOut {
        /// Along x.
        x: Option<[f64; 2]>,
        /// Along y.
        y: Option<[f64; 2]>,
        /// Along z.
        z: Option<[f64; 2]>,
    }
}

raw! {
    /// A measured point, in a frame.
    pub struct RawMarker {
        /// The frame it moves with; the tool's where absent.
        #[cfg_attr(feature = "cli", schemars(schema_with = "name"))]
        frame: Option<String>,
        /// Position in that frame.
        at: Option<[f64; 3]>,
    }
}
