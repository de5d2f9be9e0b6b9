//! What `compensator` finds: mounting and spring of a gravity compensator. Each value with its unit.

use serde::Serialize;

use super::units::{deg, mm};
use crate::estimation::compensator::{self, Elasticity, JointCompliance, Mounting, Triangle};

/// A number with the half width of its 95 % interval; `None` where that is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimated {
    pub value: f64,
    pub ci95: Option<f64>,
    pub unit: &'static str,
}

/// A number or vector with its unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WithUnit<T> {
    pub value: T,
    pub unit: &'static str,
}

/// Compliance of the joint at an angle (deg), 1e-6 rad/(N.m): given and fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CompliancePoint {
    pub q: f64,
    pub k2: f64,
    pub fitted: f64,
}

/// Compliances of the joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompliancePoints {
    pub unit: &'static str,
    pub rows: Vec<CompliancePoint>,
}

/// What `compensator` finds: what was measured is there.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Compensator {
    /// Lever.
    #[serde(rename = "L", skip_serializing_if = "Option::is_none")]
    pub lever: Option<Estimated>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ax: Option<Estimated>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ay: Option<Estimated>,
    /// Compliance of the joint without spring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k2_0: Option<Estimated>,
    /// Compliance of the spring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kc: Option<Estimated>,
    /// Free length of the spring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub s0: Option<Estimated>,
    /// A point of the joint's axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre: Option<WithUnit<[f64; 3]>>,
    /// Direction of the joint's axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// Scatter of the points about the circles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma: Option<WithUnit<Option<f64>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub a: Option<WithUnit<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phi: Option<WithUnit<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compliances: Option<CompliancePoints>,
    /// Of what the spring leaves of the compliances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms: Option<WithUnit<f64>>,
}

impl Compensator {
    /// From what was measured or given: where the spring is hung, its triangle, compliances of the joint, and the spring.
    pub fn new(
        mounting: Option<&Mounting>,
        triangle: Option<&Triangle>,
        compliances: &[JointCompliance],
        elasticity: Option<&Elasticity>,
    ) -> Self {
        let scaled = |value: compensator::Value, unit, size: f64| Estimated {
            value: value.value / size,
            ci95: value.ci95.map(|ci95| ci95 / size),
            unit,
        };
        let anchor = mounting.and_then(|mounting| mounting.anchor);
        let fitted = triangle.zip(elasticity).map(|(triangle, elasticity)| {
            let row = |k: &JointCompliance| CompliancePoint {
                q: deg(k.angle),
                k2: k.compliance * 1e6,
                fitted: elasticity.compliance(triangle, k.angle) * 1e6,
            };
            CompliancePoints { unit: "deg, 1e-6 rad/(N.m)", rows: compliances.iter().map(row).collect() }
        });
        Self {
            lever: mounting.map(|mounting| scaled(mounting.lever, "mm", 1e-3)),
            ax: anchor.map(|[ax, _]| scaled(ax, "mm", 1e-3)),
            ay: anchor.map(|[_, ay]| scaled(ay, "mm", 1e-3)),
            k2_0: elasticity.map(|found| scaled(found.joint, "1e-6 rad/(N.m)", 1e-6)),
            kc: elasticity.map(|found| scaled(found.spring, "1e-6 m/N", 1e-6)),
            s0: elasticity.map(|found| scaled(found.free_length, "mm", 1e-3)),
            centre: mounting.map(|mounting| {
                let centre = mounting.circle.centre * 1e3;
                WithUnit { value: [centre.x, centre.y, centre.z], unit: "mm" }
            }),
            axis: mounting.map(|mounting| {
                let axes = &mounting.circle.axes;
                [axes[(0, 2)], axes[(1, 2)], axes[(2, 2)]]
            }),
            sigma: mounting.map(|mounting| WithUnit { value: mounting.sigma.map(mm), unit: "mm" }),
            a: triangle.map(|triangle| WithUnit { value: mm(triangle.base()), unit: "mm" }),
            phi: triangle.map(|triangle| WithUnit { value: deg(triangle.phase()), unit: "deg" }),
            compliances: fitted,
            rms: elasticity.map(|found| WithUnit { value: found.rms * 1e6, unit: "1e-6 rad/(N.m)" }),
        }
    }
}
