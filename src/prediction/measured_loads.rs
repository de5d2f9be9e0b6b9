//! Loads on joints as they were measured, where a campaign says `loads: {joints: measured}`: what they deflect more, or less, than
//! the loads of the description.
//!
//! A joint deflects by its compliance times its load. The structure is deflected by the described loads; what the measured
//! load of a joint differs by is added as a motion of that joint. The described load is that of the lengths as described
//! ([`super::fill_holding_loads`]), in a calibration that of the lengths that it finds ([`super::with_holding_loads`]).

use nalgebra::Vector3;

use super::columns::ReadingRows;
use super::reading::{Predicted, ReadingAt};
use crate::description::campaign::Campaign;
use crate::description::robot::Motion;
use crate::kinematics::{By, shift};
use crate::math::left_jacobian;
use crate::model::Model;
use crate::observation::{PointDerivative, Twist};
use crate::parameter::Slot;
use crate::state::{FrameTwistPlan, FrameTwists, Mechanics, State};

/// A joint of which loads were measured.
#[derive(Debug, Clone)]
struct MeasuredJoint {
    variable: usize,
    /// Its compliance; none where the description holds none of its own.
    compliance: Option<Slot>,
    /// Gain and offset of its sensor: what is known or assumed, and the parameter where there is one.
    sensor: [(f64, Option<Slot>); 2],
}

/// Joints of which loads were measured.
#[derive(Debug, Clone, Default)]
pub(super) struct MeasuredLoads {
    joints: Vec<MeasuredJoint>,
}

/// A load (N.m, N) and its derivatives by gain and offset of the sensor.
struct SensedLoad {
    load: f64,
    by_sensor: [f64; 2],
}

impl MeasuredJoint {
    fn load(&self, campaign: &Campaign, index: usize, values: &[f64]) -> Option<SensedLoad> {
        let shown = campaign.conditions.torques.get(self.variable)?.as_ref()?.get(index).copied();
        let shown = shown.filter(|shown| shown.is_finite())?;
        let [gain, offset] = self.sensor.map(|(known, slot)| slot.map_or(known, |slot| values[slot]));
        // The motor supplies what holds the load.
        let load = (offset - shown) / gain;
        Some(SensedLoad { load, by_sensor: [-load / gain, 1.0 / gain] })
    }

    /// The same, less the load that the description puts on the joint.
    fn excess(&self, campaign: &Campaign, index: usize, values: &[f64]) -> Option<SensedLoad> {
        let described = campaign.conditions.described_loads.get(self.variable)?.get(index).copied()?;
        let measured = self.load(campaign, index, values)?;
        Some(SensedLoad { load: measured.load - described, ..measured })
    }
}

impl MeasuredLoads {
    /// Those of a campaign.
    pub fn new(model: &Model, campaign: &Campaign) -> Self {
        let is_measured = |variable: &usize| campaign.conditions.torques.get(*variable).is_some_and(Option::is_some);
        let joint = |variable: usize| {
            let drives = |motion: Motion| matches!(motion, Motion::Variable { index, .. } if index == variable);
            let compliance = model.frames.iter().find(|frame| drives(frame.motion));
            let compliance = compliance.and_then(|frame| model.axial_compliance(frame));
            let own = campaign.load_sensor(&model.variables[variable].name);
            let known = campaign.sensor_values(own);
            let value = |k: usize| (known[k], own.and_then(|own| model.target_values(own).get(k).copied().flatten()));
            MeasuredJoint { variable, compliance, sensor: [value(0), value(1)] }
        };
        Self { joints: (0..model.variables.len()).filter(is_measured).map(joint).collect() }
    }

    /// Puts measured loads in the place of described ones, by variable; `rate` turns them into loads of joints.
    pub fn replace(&self, at: &ReadingAt, loads: &mut [f64], rate: &[f64]) {
        for joint in &self.joints {
            if let Some(measured) = joint.load(at.campaign, at.index, at.mechanics.geometry.values()) {
                loads[joint.variable] = measured.load / rate[joint.variable];
            }
        }
    }
}

/// How measured loads move measured points; shared between threads.
pub(super) struct LoadMotions {
    loads: MeasuredLoads,
    plan: FrameTwistPlan,
    /// Asked columns: the joint, and whether by its compliance (0), its gain (1) or its offset (2).
    columns: Vec<(usize, usize, usize)>,
}

impl LoadMotions {
    /// Of a campaign; none where no load was measured that deflects anything.
    pub fn new(mechanics: &Mechanics, campaign: &Campaign, frames: Vec<usize>, slots: &[Slot]) -> Option<Self> {
        let mut loads = MeasuredLoads::new(mechanics.geometry.model, campaign);
        loads.joints.retain(|joint| joint.compliance.is_some());
        let by: Vec<By> = loads.joints.iter().map(|joint| By::Variable(joint.variable)).collect();
        let mut columns = Vec::new();
        for (k, joint) in loads.joints.iter().enumerate() {
            let own = [joint.compliance, joint.sensor[0].1, joint.sensor[1].1];
            for (which, slot) in own.into_iter().enumerate() {
                let asked = slots.iter().position(|asked| Some(*asked) == slot);
                columns.extend(asked.map(|column| (column, k, which)));
            }
        }
        let plan = mechanics.twist_plan(frames, &by);
        (!loads.joints.is_empty()).then_some(Self { loads, plan, columns })
    }

    /// Workspace of one thread.
    pub fn twists(&self) -> FrameTwists {
        self.plan.twists()
    }

    /// Motions of the frames at a placed configuration.
    pub fn evaluate(&self, mechanics: &Mechanics, state: &mut State, out: &mut FrameTwists) {
        mechanics.evaluate_twists(state, &self.plan, None, out);
    }

    /// Motion of the point of a reading by a joint, measurement frame.
    fn moved(at: &ReadingAt, twists: &FrameTwists, joint: usize) -> Twist {
        let column = &twists.of(at.point.at.frame)[joint];
        let base = at.base().rotation;
        let arm = at.state.placements.frames[at.point.at.frame].rotation * at.point.at.point;
        Twist::new(base * shift(column, &arm), base * Vector3::new(column[3], column[4], column[5]))
    }

    /// Adds what measured loads deflect more than described ones; the rotation vector by which they turn.
    pub fn add(&self, at: &ReadingAt, twists: &FrameTwists, predicted: &mut Predicted) -> Vector3<f64> {
        let values = at.mechanics.geometry.values();
        let mut sum = Twist::zero();
        for (k, joint) in self.loads.joints.iter().enumerate() {
            let excess = joint.excess(at.campaign, at.index, values);
            let Some((excess, slot)) = excess.zip(joint.compliance) else { continue };
            let moved = Self::moved(at, twists, k);
            sum.displacement += moved.displacement * (values[slot] * excess.load);
            sum.rotation += moved.rotation * (values[slot] * excess.load);
        }
        predicted.move_by(&Twist::new(sum.displacement * at.scale(), sum.rotation));
        sum.rotation
    }

    /// Adds derivatives by compliances, gains and offsets; `turned` is what [`LoadMotions::add`] gave.
    pub fn differentiate(
        &self,
        at: &ReadingAt,
        twists: &FrameTwists,
        predicted: &Predicted,
        turned: &Vector3<f64>,
        rows: &mut ReadingRows,
    ) {
        let values = at.mechanics.geometry.values();
        for &(column, k, which) in &self.columns {
            let joint = &self.loads.joints[k];
            let excess = joint.excess(at.campaign, at.index, values);
            let Some((excess, slot)) = excess.zip(joint.compliance) else { continue };
            let amount = match which {
                0 => excess.load,
                _ => values[slot] * excess.by_sensor[which - 1],
            };
            let moved = Self::moved(at, twists, k);
            let rotation = left_jacobian(turned) * moved.rotation * amount;
            let by = PointDerivative::of_deflection(Twist::new(moved.displacement * amount, rotation));
            rows.add(column, &predicted.point, by);
        }
    }
}
