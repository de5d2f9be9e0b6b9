//! How a hypothesis is said.

use super::hypothesis::Hypothesis;
use super::reordered::{Order, Reordered};
use super::sensors::SensorAngles;
use super::shown::{near, number, recorded};
use super::turned::{Angles, Turned};
use crate::description::campaign::Campaign;
use crate::model::Model;

/// How a hypothesis is said.
#[derive(Debug, Clone, PartialEq)]
pub struct Words {
    /// What is read otherwise: "`q4` negated".
    pub with: String,
    /// What the mistake may have been, as a question.
    pub question: String,
    /// What to do.
    pub remedy: String,
    /// Whether it is a matter of units.
    pub is_unit: bool,
}

impl Words {
    fn new(with: impl Into<String>, question: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { with: with.into(), question: question.into(), remedy: remedy.into(), is_unit: false }
    }

    /// Of a matter of units.
    fn unit(with: impl Into<String>, question: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { is_unit: true, ..Self::new(with, question, remedy) }
    }
}

/// The words of a hypothesis.
pub fn words_of(hypothesis: &Hypothesis, model: &Model, campaign: &Campaign) -> Words {
    let joint = |k: usize| model.variables[k].name.as_str();
    let marker = |k: usize| model.markers[k].name.as_str();
    match *hypothesis {
        Hypothesis::Negated(k) => negated(joint(k)),
        Hypothesis::Swapped(a, b) => swapped([a, b].map(joint)),
        Hypothesis::SwappedKinds(a, b, _) => swapped([a, b].map(joint)),
        Hypothesis::QuarterTurns(k, quarters) => quarter_turns(joint(k), quarters),
        Hypothesis::Reordered(way) => reordered(way, model),
        Hypothesis::Coupled(first, sign) => coupled(joint(first + 1), joint(first), sign),
        Hypothesis::JointAngles(meant, read) => joint_angles(meant, read),
        Hypothesis::AngleOf(k, meant, read) => angle_of(joint(k), meant, read),
        Hypothesis::JointLengths(factor) => joint_lengths(factor),
        Hypothesis::LengthOf(k, factor) => length_of(joint(k), factor),
        Hypothesis::ReadingUnit(factor) => reading_unit(factor),
        Hypothesis::Scale(factor) => scale(factor),
        Hypothesis::AxisUnit(a, factor) => Words::unit(
            format!("{} of the readings times {}", axis(a), number(factor)),
            "is that column in another unit, or its decimal sign in another place?",
            "write all coordinates in the unit that `units:` states",
        ),
        Hypothesis::DirectionsReversed(target) => {
            directions(target.and_then(|target| campaign.targets.get(target)).map(|target| target.name.as_str()))
        }
        Hypothesis::DirectionsMirrored(a) => Words::new(
            format!("{} of the measured directions negated", axis(a)),
            "does that axis of the sensor point the other way?",
            format!("turn the sign of the column of {}", axis(a)),
        ),
        Hypothesis::DirectionsExchanged(a, b) => Words::new(
            format!("{} and {} of the measured directions exchanged", axis(a), axis(b)),
            "are these axes of the sensor exchanged?",
            "name the columns right",
        ),
        Hypothesis::Sensors(way) => sensors(way, campaign),
        Hypothesis::Reaction => reaction(),
        Hypothesis::Moments(factor) => moments(factor),
        Hypothesis::Forces(factor) => forces(factor),
        Hypothesis::Turned(way) => turned(way),
        Hypothesis::Mirrored(..) if campaign.estimate_base && !campaign.is_difference() => Words::new(
            "one axis of the readings mirrored",
            "a left-handed frame, or two axes exchanged?",
            "give the readings in a right-handed frame: negate one coordinate, or name the columns right",
        ),
        Hypothesis::Mirrored(a, _) => Words::new(
            format!("{} of the readings negated", axis(a)),
            "a left-handed frame?",
            "give the readings in a right-handed frame",
        ),
        Hypothesis::Exchanged(a, b, _) => Words::new(
            format!("{} and {} of the readings exchanged", axis(a), axis(b)),
            "columns swapped, or a left-handed frame?",
            "name the columns right, in the table or under `columns:`",
        ),
        Hypothesis::Shifted(by, whole) => shifted(by, whole),
        Hypothesis::Markers(a, b) => Words::new(
            format!("the markers `{}` and `{}` exchanged", marker(a), marker(b)),
            "markers swapped?",
            MARKERS,
        ),
        Hypothesis::MarkersMoved(by) => Words::new(
            format!("`{}` read as `{}`, and so on", marker(0), marker(by % model.markers.len().max(1))),
            "names of the markers shifted?",
            MARKERS,
        ),
        Hypothesis::Anchors(a, b) => {
            let name = |k: usize| campaign.targets.get(k).map_or("", |target| target.name.as_str());
            Words::new(
                format!("the anchors `{}` and `{}` exchanged", name(a), name(b)),
                "anchors swapped?",
                "name the anchors right in the column `anchor`, or under `anchors:`",
            )
        }
        Hypothesis::DescriptionAngles(factor) => description_angles(factor),
        Hypothesis::FrameAfter => convention("after", "classical-dh"),
        Hypothesis::FrameBefore(_) => convention("before", "modified-dh"),
        Hypothesis::Unknown { base, tool } => unknown(base, tool),
    }
}

/// What to do about names of markers.
const MARKERS: &str = "name the markers right in the column `marker`, or in the description";

fn axis(k: usize) -> &'static str {
    ["x", "y", "z"][k.min(2)]
}

/// Of one sensor's target, or of all.
fn directions(target: Option<&str>) -> Words {
    let with = match target {
        Some(target) => format!("the directions that `{target}` measured reversed"),
        None => "measured directions reversed".into(),
    };
    Words::new(
        with,
        "does the sensor show the reaction to gravity, upwards, has it two axes exchanged, or does `gravity` of the description point up?",
        "give the direction in which gravity pulls, in right-handed axes: negate gx, gy and gz, or name the columns right; look at `gravity` \
         of the description",
    )
}

/// Of the two angles of directions.
fn sensors(way: SensorAngles, campaign: &Campaign) -> Words {
    let [first, second] = SensorAngles::columns(campaign);
    match way {
        SensorAngles::Unit(meant, read) => Words::unit(
            format!("`{first}` and `{second}` read as {}", meant.name()),
            format!("are they in {}, and declared in {}?", meant.name(), read.name()),
            "state the angle unit of the table under `units:` of the campaign, or convert the columns",
        ),
        SensorAngles::Exchanged => swapped([first, second]),
    }
}

fn reaction() -> Words {
    Words::new(
        "the wrenches reversed",
        "are they those of the robot on the load cell?",
        "give the force and torque that act on the robot: negate their columns",
    )
}

fn negated(joint: &str) -> Words {
    let remedy =
        format!("turn the sign of the column `{joint}`, or write `direction: -1` at its joint in the description");
    Words::new(format!("`{joint}` negated"), "wrong sign?", remedy)
}

fn swapped([a, b]: [&str; 2]) -> Words {
    let remedy = "name the columns right, in the table or under `columns:`";
    Words::new(format!("`{a}` and `{b}` exchanged"), "columns swapped?", remedy)
}

fn quarter_turns(joint: &str, quarters: i8) -> Words {
    let degrees = if quarters == 3 { -90 } else { 90 * i32::from(quarters) };
    Words::new(
        format!("{degrees:+} deg added to `{joint}`"),
        "another zero of that joint?",
        format!("correct `theta` of the frame that `{joint}` turns by {degrees:+} deg, or the column"),
    )
}

fn coupled(this: &str, other: &str, sign: i8) -> Words {
    let [back, sum] = if sign > 0 { ["-", "sum"] } else { ["+", "difference"] };
    Words::new(
        format!("`{this}` replaced by `{this}` {back} `{other}`"),
        format!("does the controller report the {sum} of both joints?"),
        format!("write `{this}` {back} `{other}` into the column `{this}`"),
    )
}

fn joint_angles(meant: Angles, read: Angles) -> Words {
    let [written, declared] = [meant, read].map(Angles::name);
    let remedy = match meant {
        Angles::Degrees | Angles::Radians => "state the angle unit of the table under `units:` of the campaign",
        _ => "convert the joint columns to deg or rad, and state that under `units:` of the campaign",
    };
    Words::unit(
        format!("joint angles read as {written}"),
        format!("are the joint columns in {written}, and declared in {declared}?"),
        remedy,
    )
}

fn joint_lengths(factor: f64) -> Words {
    Words::unit(
        format!("the sliding joints times {}", number(factor)),
        format!("are their columns {}?", recorded(factor)),
        "state the length unit of the table under `units:` of the campaign",
    )
}

/// What to do about one joint column in another unit than the others.
fn own_unit(joint: &str) -> String {
    format!("write the column `{joint}` in the unit that `units:` of the campaign states for all of them")
}

fn angle_of(joint: &str, meant: Angles, read: Angles) -> Words {
    let [written, declared] = [meant, read].map(Angles::name);
    Words::unit(
        format!("`{joint}` alone read as {written}"),
        format!("is that column in {written}, and declared in {declared}?"),
        own_unit(joint),
    )
}

fn length_of(joint: &str, factor: f64) -> Words {
    Words::unit(
        format!("`{joint}` alone times {}", number(factor)),
        format!("is that column {}?", recorded(factor)),
        own_unit(joint),
    )
}

fn reading_unit(factor: f64) -> Words {
    Words::unit(
        format!("the readings times {}", number(factor)),
        format!("are they {}?", recorded(factor)),
        "state the length unit of the table under `units:` of the campaign; if that is right, look at `units:` of the description",
    )
}

fn scale(factor: f64) -> Words {
    let off = 1e2 * (factor.recip() - 1.0);
    Words::unit(
        format!("the readings times {factor:.5}"),
        format!("is the instrument's scale off by {off:.2} %, or are all lengths of the description?"),
        "check the instrument on a scale bar, and the lengths of the description; where one length is known for certain, estimate the \
         scale (`estimate: {scale: true}`)",
    )
}

fn moments(factor: f64) -> Words {
    if factor < 0.0 {
        return Words::new(
            "the moments of the wrenches reversed",
            "of the robot on the load cell, or about another point?",
            "give the moments that act on the robot at the tool: negate their columns",
        );
    }
    Words::unit(
        format!("moments times {factor}"),
        format!("are they in another unit than forces, by {factor}?"),
        "state `torque` under `units:` as the file has it",
    )
}

fn forces(factor: f64) -> Words {
    if factor < 0.0 {
        return Words::new(
            "the forces of the wrenches reversed",
            "of the robot on the load cell?",
            "give the forces that act on the robot: negate their columns",
        );
    }
    let named = [(9.80665, "kgf"), (4.4482216152605, "lbf"), (10.0, "daN")];
    let name = named.iter().find(|(own, _)| near(factor, *own)).map_or("another unit", |(_, name)| name);
    Words::unit(
        format!("forces times {}", number(factor)),
        format!("are they in {name}, and moments in N.m?"),
        "give forces in the unit that `force` under `units:` says",
    )
}

fn shifted(by: isize, whole: bool) -> Words {
    let what = if whole { "configuration" } else { "row" };
    let place = if by > 0 { "after" } else { "before" };
    let [which, count] = match by.unsigned_abs() {
        1 => [format!("the {what}"), "one".into()],
        by => [format!("the {what} {by} places"), by.to_string()],
    };
    Words::new(
        format!("the joints of {which} {place} at each reading"),
        format!("rows shifted by {count}?"),
        "put joints and readings of one configuration into one row; look for a row that is missing in one of two files",
    )
}

fn description_angles(factor: f64) -> Words {
    let [written, declared] = if factor > 1.0 { ["rad", "deg"] } else { ["deg", "rad"] };
    Words::unit(
        format!("the angles of the description read as {written}"),
        format!("are its constants in {written}, and declared in {declared}?"),
        "state the angle unit under `units:` of the description",
    )
}

fn convention(place: &str, table: &str) -> Words {
    Words::new(
        format!("`alpha` and `d` of each frame at the frame {place} it"),
        "a table of another convention?",
        format!("declare how the table is written: `convention: {table}`"),
    )
}

fn unknown(base: bool, tool: bool) -> Words {
    let (what, keys) = match (base, tool) {
        (true, true) => ("base and tool", "base: true, tool: true"),
        (true, false) => ("the base", "base: true"),
        _ => ("the tool", "tool: true"),
    };
    Words::new(
        format!("{what} estimated"),
        "not where the description says?",
        format!("write `estimate: {{{keys}}}` into the campaign"),
    )
}

/// The words of another order of the joint columns.
fn reordered(way: Reordered, model: &Model) -> Words {
    let name = |k: usize| model.variables.get(k).map_or("", |variable| variable.name.as_str());
    let last = model.variables.len().saturating_sub(1);
    let (with, question) = match way.order {
        Order::Reversed => ("the joint columns in reverse order".into(), "are joints numbered from the tool?"),
        Order::MovedOn(by) => (
            format!("`{}` read from the column `{}`, and so on", name(0), name(by)),
            if by == 1 || by == last { "an external axis at the other end?" } else { "columns shifted?" },
        ),
    };
    let remedy = "name the columns right, in the table or under `columns:`".into();
    Words { with, question: question.into(), remedy, is_unit: false }
}

/// The words of another convention of orientations.
fn turned(way: Turned) -> Words {
    let (with, question, remedy) = match way {
        Turned::Inverse => (
            "the measured rotations inverted".into(),
            "of the base in the body, a conjugate quaternion or a transposed matrix?",
            "give the orientation of the body in the instrument's frame",
        ),
        Turned::Unit(meant, read) | Turned::AnglesUnit(meant, read) => {
            let is_vector = matches!(way, Turned::Unit(..));
            let what = if is_vector { "measured rotations" } else { "the angles of the orientations" };
            let with = format!("{what} read as {}", meant.name());
            let question = format!("are they in {}, and declared in {}?", meant.name(), read.name());
            let remedy =
                "state the angle unit of the table under `units:` of the campaign, or convert the columns".into();
            return Words { with, question, remedy, is_unit: true };
        }
        Turned::Reversed => (
            "the three angles of the orientations in the reverse order".into(),
            "columns of A, B, C exchanged with those about x, y, z, or two of a quaternion exchanged?",
            "name the columns right under `columns:`",
        ),
        Turned::Xyz => (
            "the angles of the orientations about x, y', z''".into(),
            "another sequence of axes?",
            "convert them to a rotation vector or a quaternion, or declare the sequence under `columns:`",
        ),
        Turned::Zyz | Turned::ZyzDown => (
            "the angles of the orientations about z, y', z''".into(),
            "another sequence of axes?",
            "convert them to a rotation vector or a quaternion, or declare the sequence under `columns:`",
        ),
        Turned::Vector => (
            "the angles of the orientations read as a rotation vector".into(),
            "columns of a rotation vector?",
            "name them `rx, ry, rz` under `columns:`",
        ),
        Turned::Zyx => (
            "the rotation vectors read as angles about z, y', x''".into(),
            "columns of A, B, C?",
            "declare the angles under `columns:`",
        ),
        Turned::RollPitchYaw => (
            "the rotation vectors read as roll, pitch and yaw".into(),
            "angles about the fixed x, y, z?",
            "declare the angles under `columns:`",
        ),
        Turned::ScalarFirst | Turned::ScalarLast => (
            format!(
                "the quaternions read with the scalar {}",
                if way == Turned::ScalarFirst { "first" } else { "last" }
            ),
            "components in another order?",
            "name each component right under `columns:`",
        ),
    };
    Words { with, question: question.into(), remedy: remedy.into(), is_unit: false }
}
