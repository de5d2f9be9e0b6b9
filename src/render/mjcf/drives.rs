//! Position actuators, and the effects that they hold.

use std::collections::BTreeMap;

use super::scale::Servo;
use super::writer::{Writer, escaped};
use crate::description::frame::{FrameIndex, Motion};
use crate::model::{Model, SwitchedOn};

/// What effects do to a joint: it goes to (1 + ratio) of where it is sent, and `shift` beyond (rad, m).
#[derive(Clone, Copy, Default)]
struct Error {
    ratio: f64,
    shift: f64,
}

impl Writer<'_> {
    /// A position actuator for each variable, in their order; its control is the controller's value.
    pub fn actuators(&mut self, model: &Model) {
        let robot = self.robot;
        let errors = self.errors(model);
        let error = |joint: FrameIndex| errors.get(&joint).copied().unwrap_or_default();
        self.line(1, "<actuator>");
        for (variable, own) in robot.variables.iter().enumerate() {
            let name = escaped(&own.name);
            for (joint, frame) in robot.frames.iter().enumerate() {
                let Motion::Variable { index, direction } = frame.motion else { continue };
                if index == variable {
                    let Error { ratio, shift } = error(joint);
                    let zero = (1.0 + ratio) * direction * frame.offset + direction * shift;
                    let acts = format!("joint=\"{}\" gear=\"{direction}\"", self.name(joint));
                    self.actuator(&name, &acts, self.scale.servo(frame.joint), 1.0 + ratio, zero);
                }
            }
            for (which, screw) in robot.actuators.iter().enumerate().filter(|(_, screw)| screw.variable == variable) {
                let zero = screw.constants[0] + error(screw.joint).shift;
                let acts = format!("tendon=\"{}\"", escaped(&screw.name));
                self.actuator(&name, &acts, self.scale.screw(robot, which, screw), 1.0, zero);
            }
        }
        self.line(1, "</actuator>");
    }

    /// Drives what it acts on to `factor` times its control and `zero`.
    fn actuator(&mut self, name: &str, acts: &str, servo: Servo, factor: f64, zero: f64) {
        let Servo { gain, damping, .. } = servo;
        let (by_control, constant) = (gain * factor, gain * zero);
        self.line(
            2,
            format!(
                "<general name=\"{name}\" {acts} biastype=\"affine\" gainprm=\"{by_control}\" \
                 biasprm=\"{constant} {} {}\"/>",
                -gain, -damping
            ),
        );
    }

    /// Errors of the joints that an actuator drives, by frame; effects that are none of these are lost.
    fn errors(&mut self, model: &Model) -> BTreeMap<FrameIndex, Error> {
        let mut errors: BTreeMap<FrameIndex, Error> = BTreeMap::new();
        let mut lost = Vec::new();
        for SwitchedOn { entry, shifts, .. } in &model.effects {
            let joint = entry.site.frame;
            let motion = self.robot.frames.get(joint).map(|frame| frame.motion);
            match (entry.effect.name(), motion) {
                ("joint-offset", Some(Motion::Variable { .. } | Motion::Actuator(_))) => {
                    errors.entry(joint).or_default().shift += shifts.iter().map(|(_, shift)| shift).sum::<f64>();
                }
                ("gear-ratio", Some(Motion::Variable { .. })) => {
                    errors.entry(joint).or_default().ratio += entry.amounts.get("ratio").copied().unwrap_or_default();
                }
                (name, _) => lost.push(format!("`{name}@{}`", entry.site.name)),
            }
        }
        if !lost.is_empty() {
            self.lost.push(format!("effects ({})", lost.join(", ")));
        }
        errors
    }
}
