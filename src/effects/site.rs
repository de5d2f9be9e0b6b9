//! Where an effect can sit.

use crate::description::raw::JointKind;
use crate::description::robot::{FrameIndex, Motion};
use crate::model::Model;

/// Kinds of site.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SiteKind {
    /// `frame:<n>`
    Frame,
    /// `joint:<n>`: one that an actuated variable moves.
    Joint,
    /// `link:<n>`: the body that moves with frame n.
    Link,
    /// `actuator:<name>`
    Actuator,
    /// `base`
    Base,
    /// `tool`
    Tool,
    /// `instrument`
    Instrument,
}

/// A site on a robot.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Site {
    /// As written: `joint:2`, `base`.
    pub name: String,
    /// Its kind.
    pub kind: SiteKind,
    /// Its frame, of a frame, joint or link; the driven joint's of an actuator.
    pub frame: FrameIndex,
    /// The variable that moves the joint, or the actuator's.
    pub variable: usize,
    /// The actuator, by index in [`Model::actuators`].
    pub actuator: usize,
}

/// Sites of a kind on a robot.
pub fn sites_of(model: &Model, kind: SiteKind) -> Vec<Site> {
    let site =
        |name: String, frame: usize, variable: usize, actuator: usize| Site { name, kind, frame, variable, actuator };
    let frames = || model.frames.iter().enumerate().skip(1);
    match kind {
        SiteKind::Frame => frames().map(|(index, frame)| site(format!("frame:{}", frame.name), index, 0, 0)).collect(),
        SiteKind::Joint => frames()
            .filter_map(|(index, frame)| {
                let variable = match frame.motion {
                    Motion::Variable { index, .. } => index,
                    Motion::Actuator(_) => model.actuators.iter().find(|actuator| actuator.joint == index)?.variable,
                    _ => return None,
                };
                Some(site(format!("joint:{}", frame.name), index, variable, 0))
            })
            .collect(),
        SiteKind::Link => frames()
            .filter(|(_, frame)| frame.joint != JointKind::Fixed)
            .map(|(index, frame)| site(format!("link:{}", frame.name), index, 0, 0))
            .collect(),
        SiteKind::Actuator => model
            .actuators
            .iter()
            .enumerate()
            .map(|(index, actuator)| {
                site(format!("actuator:{}", actuator.name), actuator.joint, actuator.variable, index)
            })
            .collect(),
        SiteKind::Base => vec![site("base".into(), 0, 0, 0)],
        SiteKind::Tool => vec![site("tool".into(), model.tool.0, 0, 0)],
        SiteKind::Instrument => vec![site("instrument".into(), 0, 0, 0)],
    }
}
