//! Bodies that the tool can carry, of a description or of a campaign: their weight turns with gravity.

use indexmap::IndexMap;
use nalgebra::Vector3;

use super::collector::GREATEST;
use super::sizes::CENTRED;
use crate::description::elastic::Payload;
use crate::description::raw::RawPayload;
use crate::description::robot::Robot;
use crate::description::units::{Length, Units};
use crate::diagnostic::{Code, Diagnostic, Locate};

/// What is wrong with a body without a mass.
pub fn no_mass(name: &str) -> String {
    format!("`payloads.{name}` lacks `mass`")
}

/// Those declared, each at a frame of the tool's body.
pub fn payloads(
    declared: &IndexMap<String, RawPayload>,
    units: &Units,
    robot: &Robot,
    locate: Locate,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<(String, Payload)> {
    let mut payloads = Vec::new();
    for (name, payload) in declared {
        // Nobody knows the centre of mass of what a tool carries to so little, unless it is said to be in the frame itself.
        let near = Vector3::from(payload.com).norm() * units.length.factor();
        if near > 0.0 && near < CENTRED && units.length != Length::Metre {
            let unit = units.length.symbol();
            let far = near / units.length.factor();
            let message = format!("the centre of mass of payload `{name}` lies {far:.3} {unit} from its frame");
            let warning = Diagnostic::warning(message).code(Code::Implausible).at(locate(&["payloads", name, "com"]));
            diagnostics.push(warning.remedy(format!("centres are in {unit}: if it is in m, write it in {unit}")));
        }
        let mut fault = |key: &str, message: String, remedy: &str| {
            diagnostics.push(Diagnostic::error(message).at(locate(&["payloads", name, key])).remedy(remedy));
        };
        let frame = match &payload.frame {
            None => Some(robot.tool.frame),
            Some(named) => robot.frames.iter().position(|frame| frame.name == *named),
        };
        // That it is missing is reported by who knows what else of the file is at fault.
        let mass = payload.mass.unwrap_or_default() * units.mass.factor();
        let com = Vector3::from(payload.com) * units.length.factor();
        if !(0.0..=GREATEST).contains(&mass) || !(0.0..=GREATEST).contains(&com.norm()) {
            fault(
                "mass",
                format!("payload `{name}`: mass and centre must be finite, the mass not negative"),
                "correct them",
            );
        }
        // A faulty one is known by its name: rows that carry it are no faults of their own.
        payloads.push((name.clone(), Payload { mass, com, frame: frame.unwrap_or(robot.tool.frame) }));
        match frame {
            Some(frame) if robot.body(frame) == robot.body(robot.tool.frame) => {}
            Some(frame) => fault(
                "frame",
                format!(
                    "payload `{name}` hangs on `{}`, which is not the tool's body: what a row loads is the tool alone",
                    robot.frames[frame].name
                ),
                "give a mass on another body under `bodies:` of the description, and readings without it in a campaign of \
                 their own; or name a frame that is fixed to the tool",
            ),
            None => {
                let named = payload.frame.clone().unwrap_or_default();
                let diagnostic = Diagnostic::error(format!("payload `{name}`: unknown frame `{named}`"));
                let frames = robot.frames.iter().map(|frame| frame.name.as_str());
                diagnostics.push(diagnostic.at(locate(&["payloads", name, "frame"])).suggest(&named, frames));
            }
        }
    }
    payloads
}
