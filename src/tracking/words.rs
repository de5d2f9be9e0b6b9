//! What a change means on the machine, in words.

use super::monitor::{Event, Shape};
use crate::description::raw::JointKind;
use crate::model::Model;
use crate::parameter::{Group, Kind};
use crate::settings::named;

/// What a changed parameter is on the machine.
pub fn meaning(model: &Model, name: &str) -> String {
    let Some(slot) = model.registry.slot(name) else { return format!("`{name}`") };
    if let Some(frame) = model.frames.iter().find(|frame| frame.moves() && frame.moving_slot() == slot) {
        return format!("the zero of joint {}", frame.name);
    }
    let parameter = &model.registry[slot];
    // Frames on one axis share slots: the first has them.
    let frame = model.frames.iter().find(|frame| frame.slots.contains(&slot)).map(|frame| &frame.name);
    let actuator = || model.actuators.iter().find(|actuator| (actuator.slot..actuator.slot + 5).contains(&slot));
    let owner = frame.or_else(|| actuator().map(|actuator| &actuator.name)).map_or(name, String::as_str);
    match (parameter.group, parameter.kind) {
        (Group::Elastic, _) => format!("the elasticity `{name}`"),
        (Group::Effect, _) => format!("the amount of an effect, `{name}`"),
        (_, Kind::Length) => format!("a length at frame {owner}"),
        (_, Kind::Angle) => format!("an angle between axes at frame {owner}"),
        _ => format!("`{name}`"),
    }
}

/// Whether a parameter is the zero of a joint that turns or slides.
fn is_zero(model: &Model, name: &str) -> bool {
    let slot = model.registry.slot(name);
    model
        .frames
        .iter()
        .any(|frame| frame.moves() && Some(frame.moving_slot()) == slot && frame.joint != JointKind::Fixed)
}

named! {
    /// What happened to a robot at a check.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum EventKind {
        /// A constant has jumped.
        Step "step",
        /// A constant grows.
        Growth "growth",
        /// Something that is no constant.
        Effect "effect",
    }
}

/// What happened, and in words what is likely behind it.
pub fn likely(model: &Model, names: &[&str], event: &Event) -> (EventKind, String) {
    let all_zeros = !names.is_empty() && names.iter().all(|name| is_zero(model, name));
    let one = names.len() == 1;
    let of: Vec<String> = names.iter().map(|name| meaning(model, name)).collect();
    let of = of.join(", ");
    match event.shape {
        Shape::Residuals => (
            EventKind::Effect,
            "the calibrated model explains the readings worse than before; no constant of it has changed".into(),
        ),
        Shape::Line { .. } if event.bent => {
            (EventKind::Growth, format!("{of} grows or shrinks at another rate than before, or no longer"))
        }
        Shape::Line { .. } => (
            EventKind::Growth,
            format!("{of} grows or shrinks steadily: wear, settling, a screw that works loose, or slow heating"),
        ),
        Shape::Step { .. } if event.worse => (
            EventKind::Effect,
            "constants have changed and the fit leaves more than before: an effect that the description does not have"
                .into(),
        ),
        Shape::Step { .. } if one && all_zeros => {
            (EventKind::Step, format!("{of} has jumped: a collision or a slip at this joint, or new mastering"))
        }
        Shape::Step { .. } if all_zeros => {
            (EventKind::Step, format!("{of} have jumped: a collision, or new mastering"))
        }
        Shape::Step { .. } if one => {
            (EventKind::Step, format!("{of} has jumped: a bent or exchanged part, or a collision"))
        }
        Shape::Step { .. } => (
            EventKind::Step,
            format!("several constants have jumped ({of}): a heavy collision, an exchanged part, or an effect"),
        ),
    }
}
