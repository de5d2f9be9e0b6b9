//! What the parts of the elastic structure are built with: its parameters in the registry, its vertices, the bodies' frames.

use nalgebra::Vector3;

use super::structure::{Edge, Spot, Structure, Vertex, nearest};
use super::{Fault, Model};
use crate::description::elastic::Stiffness;
use crate::description::parameters::{Number, Owner, Stiffness as Row};
use crate::description::raw::JointKind;
use crate::description::robot::{FrameIndex, Robot};
use crate::elements::VertexIndex;
use crate::parameter::{Group, Kind, Parameter, Slot};

/// Compliance by which what is declared rigid is commonly off, m/N and rad/(N.m): a start for effects.
const COMMON: [f64; 2] = [1e-9, 1e-7];
pub(super) struct Builder<'a> {
    pub(super) robot: &'a Robot,
    pub(super) model: &'a mut Model,
    pub(super) structure: Structure,
    pub(super) edges: Vec<Edge>,
    pub(super) only_closing: Vec<Edge>,
    pub(super) faults: Vec<Fault>,
}

impl Builder<'_> {
    /// Adds a parameter; `calibration` narrows its bounds, states its common error, frees it or holds it.
    fn add(&mut self, mut parameter: Parameter) -> Slot {
        let calibration = &self.robot.calibration;
        let Parameter { name, nominal, inverted, bounds, .. } = &parameter;
        let (nominal, inverted) = (*nominal, *inverted);
        if let Some(&[low, high]) = calibration.bounds.get(name) {
            let [low, high] = if inverted { [1.0 / high, 1.0 / low] } else { [low, high] };
            parameter.bounds = [bounds[0].max(low), bounds[1].min(high)];
        }
        if let Some(&stated) = calibration.tolerances.get(&parameter.name) {
            parameter.tolerance = if inverted && nominal != 0.0 { stated * nominal * nominal } else { stated };
        }
        let listed = |names: &[String]| names.contains(&parameter.name);
        parameter.free = (parameter.free || listed(&calibration.free)) && !listed(&calibration.fixed);
        self.model.registry.add(parameter)
    }

    /// Adds a stiffness as it is held.
    pub(super) fn stiffness(&mut self, name: String, given: Stiffness, tolerance: f64) -> Slot {
        let Stiffness { kind, nominal, identifiable: free, bounds, inverted } = given;
        let group = Group::Elastic;
        self.add(Parameter { name, kind, group, nominal, bounds, tolerance, free, closing: false, inverted })
    }

    /// A compliance as declared, rigid where it is not.
    pub(super) fn compliance<R>(&mut self, owner: Owner, row: &Row<R>, given: Option<Stiffness>) -> Slot {
        let given = given.unwrap_or(Stiffness::undeclared(row.kind.inverse()));
        let common = COMMON[usize::from(given.kind == Kind::RotationalCompliance)];
        let tolerance = if given.nominal > 0.0 { 0.3 * given.nominal } else { common };
        self.stiffness(owner.parameter(row.symbol), given, tolerance)
    }

    /// A parameter that is written as it is computed with.
    pub(super) fn plain(&mut self, name: String, kind: Kind, value: f64, bounds: [f64; 2], tolerance: f64) -> Slot {
        let (group, free, closing, inverted) = (Group::Elastic, false, false, false);
        self.add(Parameter { name, kind, group, nominal: value, bounds, tolerance, free, closing, inverted })
    }

    pub(super) fn number<R>(&mut self, owner: Owner, row: &Number<R>, value: f64) -> Slot {
        self.plain(owner.parameter(row.symbol), row.kind, value, row.bounds(value), row.tolerance(value))
    }

    /// The frame that moves a frame's body.
    pub(super) fn root(&self, mut frame: FrameIndex) -> FrameIndex {
        while frame != 0 && self.robot.frames[frame].joint == JointKind::Fixed {
            frame = self.robot.frames[frame].antecedent;
        }
        frame
    }

    pub(super) fn vertex(&mut self, name: impl Into<String>, spot: Spot) -> VertexIndex {
        self.structure.vertices.push(Vertex { name: name.into(), spot });
        self.structure.vertices.len() - 1
    }

    pub(super) fn carrier(&self, frame: FrameIndex, at: &Vector3<f64>) -> VertexIndex {
        nearest(&self.structure.bodies[frame], at, |vertex| self.structure.at_home(vertex))
    }
}
