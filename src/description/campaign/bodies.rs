//! Bodies that carry an inclinometer: the frames that a campaign's files name, and how the sensor is mounted in each.

use super::Campaign;
use super::raw::{OrUnknown, RawCampaign, RawEntry};
use super::source::Source;
use super::targets::{Target, TargetValue};
use crate::description::resolve::Locate;
use crate::description::robot::{FrameIndex, Robot};
use crate::diagnostic::Diagnostic;
use crate::parameter::Kind;

/// What names the targets of such readings.
const COLUMN: &str = "inclinometer";

fn is_read(source: &Source) -> bool {
    source.kinds.iter().any(|kind| kind.ignores_arrangement())
}

/// The frame that a file's entry names, if it does and the robot has it.
fn frame(entry: &RawEntry, robot: &Robot) -> Option<FrameIndex> {
    let name = entry.body.as_ref()?;
    robot.frames.iter().position(|frame| frame.name == *name)
}

/// Frames that the files name as bodies, once each.
pub(super) fn bodies(robot: &Robot, sources: &[Source]) -> Vec<FrameIndex> {
    let mut all = Vec::new();
    for frame in sources.iter().filter(|source| is_read(source)).filter_map(|source| frame(source.entry, robot)) {
        if !all.contains(&frame) {
            all.push(frame);
        }
    }
    all
}

/// How the sensor is mounted on each body, as values of targets.
pub(super) fn mounts(raw: &RawCampaign, robot: &Robot, sources: &[Source]) -> Vec<Target> {
    let mut all: Vec<Target> = Vec::new();
    for source in sources.iter().filter(|source| is_read(source)) {
        let body = source.entry.body.clone().unwrap_or_else(|| robot.frames[robot.tool.frame].name.clone());
        if all.iter().any(|known| known.member.0 == body) {
            continue;
        }
        let angle = source.entry.units(raw.units).angle.factor();
        let owner = format!("{COLUMN}@{body}");
        let given = source.entry.mount.unwrap_or(OrUnknown::Known([0.0; 3]));
        let value = |(k, symbol): (usize, &str)| TargetValue {
            value: given.known().map_or(0.0, |mount| mount[k] * angle),
            kind: Kind::Angle,
            parameter: given.known().is_none().then(|| format!("{owner}.{symbol}")),
        };
        let values = ["rx", "ry", "rz"].into_iter().enumerate().map(value).collect();
        all.push(Target {
            name: owner,
            column: COLUMN,
            member: (body, None),
            observes: None,
            values,
            has_start: given.known().is_some(),
            is_near: false,
        });
    }
    all
}

/// Marker and target of the readings of a file's body.
pub(super) fn sensor(entry: &RawEntry, robot: &Robot, campaign: &Campaign) -> [Option<usize>; 2] {
    let frame = frame(entry, robot);
    let body = |frame: FrameIndex| campaign.bodies.iter().position(|known| *known == frame);
    let marker = frame.and_then(body).map(|index| robot.markers.len() + index);
    let name = &robot.frames[frame.unwrap_or(robot.tool.frame)].name;
    let own = |target: &Target| target.column == COLUMN && target.member.0 == *name;
    [marker, campaign.targets.iter().position(own)]
}

/// Bodies that the robot does not have, and `body:` or `mount:` where nothing reads one.
pub(super) fn faults(robot: &Robot, sources: &[Source], locate: Locate) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    for source in sources {
        let entry = source.entry;
        let is_of_joints = source.kinds.iter().all(|kind| kind.by_variable().is_some());
        if (!is_read(source) || is_of_joints) && (entry.body.is_some() || entry.mount.is_some()) {
            let message = format!("`{}`: `body:` and `mount:` are of inclinations, and it observes none", entry.file);
            let diagnostic = Diagnostic::error(message).at(locate(&["measurements"]));
            faults.push(diagnostic.remedy("take them out, or write `observes: inclination`"));
        }
        if let Some(name) = entry.body.as_ref().filter(|_| frame(entry, robot).is_none()) {
            let diagnostic = Diagnostic::error(format!("`body: {name}`: the robot has no such frame"));
            let frames = robot.frames.iter().map(|frame| frame.name.as_str());
            faults.push(diagnostic.at(locate(&["measurements"])).suggest(name, frames));
        }
    }
    faults
}

/// Columns that a file lacks of a kind that may have either of two sets. A joint with the name of one of the other set is that
/// joint.
pub(super) fn lacking_columns(robot: &Robot, sources: &[Source], locate: Locate) -> Vec<Diagnostic> {
    let is_joint = |name: &str| robot.variables.iter().any(|variable| variable.name == name);
    let mut faults = Vec::new();
    for source in sources {
        for kind in source.kinds.iter().filter(|kind| !kind.other_columns().is_empty()) {
            let sets = [kind.columns(), kind.other_columns()];
            let is_there = |name: &str| source.table.has(name) && !is_joint(name);
            if !sets.iter().any(|set| set.iter().all(|column| is_there(column.name))) {
                let names = sets.map(|set| set.iter().map(|column| column.name).collect::<Vec<_>>().join("`, `"));
                let message = format!("{} needs the columns `{}`, or `{}`", kind.name(), names[0], names[1]);
                let file = source.table.file();
                let diagnostic = Diagnostic::error(format!("{file}: {message}")).at(Source::place_of_kinds(locate));
                faults.push(diagnostic.remedy("name them under `columns:` if the file calls them otherwise"));
            }
        }
    }
    faults
}
