//! What `compensator` finds: mounting and spring of a gravity compensator. Each value with its unit.

use serde::Serialize;

use super::units::{deg, mm, unit};
use crate::estimation::compensator::{Elasticity, FromDeflections, JointCompliance, Mounting, Triangle, Value, Way};
use crate::model::Model;
use crate::parameter::Parameter;

/// A number with the half width of its 95 % interval; `None` where that is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimated {
    /// The value, in `unit`.
    pub value: f64,
    /// Half width of the 95 % interval, in `unit`; `None` where it is unknown.
    pub ci95: Option<f64>,
    /// Unit of the value and the interval.
    pub unit: &'static str,
}

/// A number or vector with its unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WithUnit<T> {
    /// The value, in `unit`.
    pub value: T,
    /// Unit of the value.
    pub unit: &'static str,
}

/// Compliance of the joint at an angle (deg), 1e-6 rad/(N.m): given and fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CompliancePoint {
    /// Angle of the joint, deg.
    pub q: f64,
    /// Compliance of the joint given, or found from the deflections, at this angle.
    pub k2: f64,
    /// Half width of its 95 % interval, where known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ci95: Option<f64>,
    /// Number of deflections at the angle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub readings: Option<usize>,
    /// Compliance at this angle by the law of the spring, fitted to those of all angles.
    pub fitted: f64,
    /// By the fit in one step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub one_step: Option<f64>,
}

/// A compliance of another joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OtherCompliance {
    /// Name of the parameter.
    pub name: String,
    /// Its value, as the description states it (compliance or stiffness), with interval and unit.
    #[serde(flatten)]
    pub found: Estimated,
}

/// One way from deflections to the compensator.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompensatorWay {
    /// Compliance of the joint without the spring, 1e-6 rad/(N.m).
    pub k2_0: Estimated,
    /// Compliance of the spring, 1e-6 m/N.
    pub kc: Estimated,
    /// Free length of the spring, mm.
    pub s0: Estimated,
    /// The other compliances fitted with them.
    pub others: Vec<OtherCompliance>,
    /// Root mean square of the compliances by angle less the law.
    pub rms: WithUnit<f64>,
    /// Root mean square residual of the deflections, by coordinate.
    pub residual: WithUnit<f64>,
}

/// Whether the law goes through the compliances by angle, by their own uncertainty: Fisher's F.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LawMisfit {
    /// Mean square of the compliances about the law over that of the readings.
    pub ratio: f64,
    /// Degrees of freedom of the two mean squares.
    pub degrees_of_freedom: [f64; 2],
    /// Probability of a ratio as great where the law holds.
    pub p: f64,
}

/// Both ways from the same deflections.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BothWays {
    /// Compliances by angle (eq. 12), then the law through them (eq. 13).
    pub two_steps: CompensatorWay,
    /// Everything in one fit of the deflections.
    pub one_step: CompensatorWay,
    /// Root mean square residual with a compliance for each angle, without a law.
    pub residual_by_angle: WithUnit<f64>,
    /// `None` of three angles, through which every law goes.
    pub misfit: Option<LawMisfit>,
}

/// Compliances of the joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompliancePoints {
    /// Units of the angles and of the compliances.
    pub unit: &'static str,
    /// By angle.
    pub rows: Vec<CompliancePoint>,
}

/// What `compensator` finds: what was measured is there.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Compensator {
    /// Lever.
    #[serde(rename = "L", skip_serializing_if = "Option::is_none")]
    pub lever: Option<Estimated>,
    /// Offset of the joint's axis from the spring's anchor, across the lever at joint angle 0, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ax: Option<Estimated>,
    /// The same along the lever at joint angle 0, mm.
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
    /// Distance of the spring's anchor from the joint's axis, mm: the hypotenuse of `ax` and `ay`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub a: Option<WithUnit<f64>>,
    /// Angle phi of the spring's law, deg: its length at joint angle q is sqrt(a^2 + L^2 + 2 a L cos(phi + q)).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phi: Option<WithUnit<f64>>,
    /// Compliances of the joint by its angle, given or found and fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compliances: Option<CompliancePoints>,
    /// Of what the spring leaves of the compliances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms: Option<WithUnit<f64>>,
    /// From deflections, in two steps (which `k2_0`, `kc` and `s0` are) and in one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deflections: Option<BothWays>,
}

impl Compensator {
    /// From what was measured or given: where the spring is hung, its triangle, compliances of the joint, and the spring.
    pub fn new(
        mounting: Option<&Mounting>,
        triangle: Option<&Triangle>,
        compliances: &[JointCompliance],
        elasticity: Option<&Elasticity>,
    ) -> Self {
        let anchor = mounting.and_then(|mounting| mounting.anchor);
        let fitted = triangle.zip(elasticity).map(|(triangle, elasticity)| {
            let row = |k: &JointCompliance| CompliancePoint {
                q: deg(k.angle),
                k2: k.compliance * 1e6,
                ci95: k.ci95.map(|ci95| ci95 * 1e6),
                readings: None,
                one_step: None,
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
            deflections: None,
        }
    }

    /// From deflections, with the names of a model.
    pub fn from_deflections(model: &Model, found: &FromDeflections) -> Self {
        let of = |way: &Way| CompensatorWay {
            k2_0: scaled(way.elasticity.joint, "1e-6 rad/(N.m)", 1e-6),
            kc: scaled(way.elasticity.spring, "1e-6 m/N", 1e-6),
            s0: scaled(way.elasticity.free_length, "mm", 1e-3),
            others: way.others.iter().map(|(slot, value)| other(&model.registry[*slot], *value)).collect(),
            rms: WithUnit { value: way.elasticity.rms * 1e6, unit: "1e-6 rad/(N.m)" },
            residual: WithUnit { value: mm(way.residual), unit: "mm" },
        };
        let given: Vec<JointCompliance> = found.angles.iter().map(|at| at.compliance).collect();
        let mut all = Self::new(None, Some(&found.triangle), &given, Some(&found.two_steps.elasticity));
        let rows = all.compliances.iter_mut().flat_map(|of| &mut of.rows);
        for (row, at) in rows.zip(&found.angles) {
            row.readings = Some(at.readings);
            row.one_step = Some(found.one_step.elasticity.compliance(&found.triangle, at.compliance.angle) * 1e6);
        }
        all.deflections = Some(BothWays {
            two_steps: of(&found.two_steps),
            one_step: of(&found.one_step),
            residual_by_angle: WithUnit { value: mm(found.residual), unit: "mm" },
            misfit: found.misfit.map(|of| LawMisfit { ratio: of.ratio, degrees_of_freedom: of.degrees, p: of.p }),
        });
        all
    }
}

fn other(parameter: &Parameter, value: Value) -> OtherCompliance {
    let (unit, size) = unit(parameter.shown_kind());
    let ci95 = value.ci95.map(|width| parameter.shown_width(value.value, width) / size);
    let found = Estimated { value: parameter.shown(value.value) / size, ci95, unit };
    OtherCompliance { name: parameter.name.clone(), found }
}

fn scaled(value: Value, unit: &'static str, size: f64) -> Estimated {
    Estimated { value: value.value / size, ci95: value.ci95.map(|ci95| ci95 / size), unit }
}
