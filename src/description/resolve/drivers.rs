//! Which key of the file drives each joint: exactly one for every joint that moves.

use super::super::frame::{Frame, FrameIndex, Motion};
use super::super::raw::{JointKind, RawRobot};
use super::collector::Collector;

/// What drives a joint, and the path that says so.
pub struct Driver {
    pub motion: Motion,
    path: Vec<String>,
}

impl Driver {
    pub fn path(&self) -> Vec<&str> {
        self.path.iter().map(String::as_str).collect()
    }
}

/// Drivers of each frame.
pub struct Drivers(pub Vec<Vec<Driver>>);

impl Drivers {
    pub fn add(&mut self, frame: FrameIndex, motion: Motion, path: &[&str]) {
        self.0[frame].push(Driver { motion, path: path.iter().map(ToString::to_string).collect() });
    }
}

/// Frame by name, the base left out.
pub fn find(frames: &[Frame], name: &str) -> Option<FrameIndex> {
    frames.iter().position(|frame| frame.name == name).filter(|&index| index != 0)
}

/// Names of all frames but the base.
pub fn frame_names(frames: &[Frame]) -> impl Iterator<Item = &str> {
    frames.iter().skip(1).map(|frame| frame.name.as_str())
}

/// Every joint that moves has one driver, a fixed one none.
pub fn one_driver_each(raw: &RawRobot, frames: &[Frame], drivers: &Drivers, diagnostics: &mut Collector) {
    let mut positions = 0..raw.couplings.len() + 1;
    let driver_faulty = diagnostics.explained(&["actuators"])
        || diagnostics.explained(&["couplings"])
        || positions.any(|k| diagnostics.explained(&["couplings", &k.to_string()]))
        || diagnostics.couplings_failed
        || raw
            .actuators
            .keys()
            .any(|name| ["joint", "variable"].iter().any(|key| diagnostics.explained(&["actuators", name, key])));
    for (frame, drivers) in frames.iter().zip(&drivers.0).skip(1) {
        let name = &frame.name;
        match drivers.as_slice() {
            [] if driver_faulty
                || ["variable", "passive"].iter().any(|key| diagnostics.explained(&["frames", name, key])) => {}
            [_] if frame.joint == JointKind::Fixed && diagnostics.explained(&["frames", name, "joint"]) => {}
            [] if frame.joint != JointKind::Fixed && raw.frames.contains_key(name) => {
                diagnostics.reject(&["frames", name], format!("nothing moves joint `{name}`"), "give it a `variable`, an actuator, a coupling, or `passive: true` within a closed loop (or `joint: fixed`)");
            }
            [driver] if frame.joint == JointKind::Fixed => {
                let remedy = format!("add `joint: revolute` (or `prismatic`) to frame `{name}`");
                diagnostics.reject(&driver.path(), format!("`{name}` is fixed, and yet something moves it"), remedy);
            }
            [first, second, ..] => {
                let message = format!("joint `{name}` is moved by two things");
                diagnostics.conflict(
                    &second.path(),
                    message,
                    &first.path(),
                    "it is already moved here",
                    "keep one of: variable, actuator, coupling, passive",
                );
            }
            _ => {}
        }
    }
}
