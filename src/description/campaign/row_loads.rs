//! What loads the robot in a row: the wrench and where it acts, and what the tool carries.

use super::row::{Faults, OfFile, Row, unknown};
use super::{Campaign, LOAD_POINT, LoadPoint, Payload, WRENCH};
use crate::description::columns::TOOL_POINT;
use crate::description::robot::Robot;
use crate::diagnostic::Diagnostic;

/// Force and moment of a row, N and N.m.
pub fn wrench(row: &Row, faults: &mut Faults) -> [f64; 6] {
    WRENCH.iter().for_each(|column| faults.check_size(row, column, row.number(column)));
    let [force, torque] = [row.units.force.factor(), row.units.torque.factor()];
    std::array::from_fn(|k| row.number(WRENCH[k]) * if k < 3 { force } else { torque })
}

/// Where the wrench of a row is applied: at a marker or frame of the measured point's body.
pub fn load_point(row: &Row, file: &OfFile, robot: &Robot, measured: Option<usize>, faults: &mut Faults) -> LoadPoint {
    let of_row = row.text(LOAD_POINT);
    let Some(name) = of_row.or(file.entry.load_point.as_deref()) else { return LoadPoint::Measured };
    let Robot { markers, frames, tool, .. } = robot;
    let frame_of = |marker: Option<usize>| marker.map_or(tool.frame, |marker| markers[marker].frame);
    let found = match name {
        name if TOOL_POINT.contains(&name) => Some((LoadPoint::Marker(None), tool.frame)),
        name => {
            let marker = markers.iter().position(|marker| marker.name == name).map(Some);
            let frame = || frames.iter().position(|frame| frame.name == name);
            let of_marker = marker.map(|marker| (LoadPoint::Marker(marker), frame_of(marker)));
            of_marker.or_else(|| frame().map(|frame| (LoadPoint::Frame(frame), frame)))
        }
    };
    let mut push = |fault: Diagnostic| match of_row {
        Some(_) => faults.push(fault.at(row.place(LOAD_POINT))),
        None => faults.push_once(fault.at(file.place(LOAD_POINT))),
    };
    let Some((point, frame)) = found else {
        let is_on_body = |frame: usize| robot.body(frame) == robot.body(frame_of(measured));
        let of_markers = markers.iter().filter(|marker| is_on_body(marker.frame)).map(|marker| marker.name.as_str());
        let of_tool = is_on_body(tool.frame).then_some("TCP");
        let of_frames = (0..).zip(frames).filter(|(index, _)| is_on_body(*index)).map(|(_, frame)| frame.name.as_str());
        let known = of_markers.chain(of_tool).chain(of_frames);
        let diagnostic = Diagnostic::error(format!("`{LOAD_POINT}`: no marker or frame is called `{name}`"));
        push(diagnostic.suggest(name, known));
        return LoadPoint::Measured;
    };
    if robot.body(frame) != robot.body(frame_of(measured)) {
        let message = format!("`{LOAD_POINT}`: `{name}` is not on the body of the measured point");
        let remedy = "name a marker or a frame that is fixed to it: what loads another body is no wrench of the tool";
        push(Diagnostic::error(message).remedy(remedy));
    }
    point
}

/// What the tool carries in a row: as its column says, else as its file's entry says.
pub fn payload(row: &Row, file: &OfFile, campaign: &Campaign, faults: &mut Faults) -> Option<Payload> {
    let of_row = row.text("payload");
    let name = of_row.or(file.entry.payload.as_deref()).filter(|name| *name != "none")?;
    let found = campaign.payloads.iter().find(|(known, _)| known == name);
    if found.is_none() {
        let known = campaign.payloads.iter().map(|(known, _)| known.as_str());
        let none = if campaign.payloads.is_empty() { None } else { Some("none") };
        match of_row {
            Some(_) => faults.unknown(row, "payload", name, known.chain(none)),
            None => faults.push_once(unknown("payload", name, known.chain(none)).at(file.place("payload"))),
        }
    }
    found.map(|(_, payload)| *payload)
}
