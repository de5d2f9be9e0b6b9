//! Other ways to read the same files: the mistakes that are made on the way from the controller and the instrument into a
//! table. Each is a change of the campaign, or of the description's values, that undoes the mistake.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Vector3;

use super::changes::{ROW, each, mirror, move_rows, shifted, take_back};
use super::evidence::Limits;
use super::reordered::{Reordered, TURNS};
use super::sensors::{SensorAngles, is_mounted, read_directions, reverse};
use super::turned::{Angles, Turned};
use crate::description::campaign::{Campaign, Reading};
use crate::description::robot::Variable;
use crate::math::distinct;
use crate::model::Model;
use crate::parameter::{Group, Kind, Slot};

/// What is read otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hypothesis {
    /// A joint counts the other way: sign of its column, or direction in the description.
    Negated(usize),
    /// The columns of two joints are exchanged.
    Swapped(usize, usize),
    /// The same of one that slides and one that turns, with lengths over angles of the columns as in [`Reordered::turn`].
    SwappedKinds(usize, usize, f64),
    /// The columns of all joints are in another order.
    Reordered(Reordered),
    /// The column of the joint after this one holds the sum of both, or (-1) their difference.
    Coupled(usize, i8),
    /// The zero of a joint lies so many quarter turns off.
    QuarterTurns(usize, i8),
    /// All angles of joints are in the unit before, declared in the one after.
    JointAngles(Angles, Angles),
    /// The angle of one joint is in the unit before, declared in the one after.
    AngleOf(usize, Angles, Angles),
    /// All lengths of joints are in another unit: times the factor.
    JointLengths(f64),
    /// The length of one joint is in another unit: times the factor.
    LengthOf(usize, f64),
    /// Measured lengths times a factor.
    ReadingUnit(f64),
    /// Values along one axis times a factor.
    AxisUnit(usize, f64),
    /// All measured lengths by a factor that is no unit: the instrument's scale, or that of the whole description.
    Scale(f64),
    /// A measured axis points the other way; orientations too, or as they are.
    Mirrored(usize, bool),
    /// Two measured axes are exchanged; orientations too, or as they are.
    Exchanged(usize, usize, bool),
    /// Measured directions point the other way, of all sensors or of one target's: gravity up. With the mounting of the sensor unknown
    /// a reflection of its axes is the same.
    DirectionsReversed(Option<usize>),
    /// An axis of measured directions points the other way, of sensors whose axes are those of their body.
    DirectionsMirrored(usize),
    /// Two axes of measured directions are exchanged, of the same.
    DirectionsExchanged(usize, usize),
    /// The two angles of measured directions are written otherwise.
    Sensors(SensorAngles),
    /// The wrench is that of the robot on its surroundings, not on the robot.
    Reaction,
    /// Moments of the wrench times a factor, its forces as they are.
    Moments(f64),
    /// Forces of the wrench times a factor, its moments as they are.
    Forces(f64),
    /// Measured orientations are written by another convention.
    Turned(Turned),
    /// Rows of joints belong to readings so many further up (below zero) or down; whole configurations, or single rows.
    Shifted(isize, bool),
    /// Two markers are exchanged.
    Markers(usize, usize),
    /// Each marker is the one so many places after it, those at the end the first ones.
    MarkersMoved(usize),
    /// Two anchors of distances are exchanged, by index of their targets.
    Anchors(usize, usize),
    /// Angles of the description times a factor.
    DescriptionAngles(f64),
    /// Lengths `d` and angles `alpha` of the description belong to the frame after theirs: a classical table read as a modified one.
    FrameAfter,
    /// They belong to the frame before theirs: a modified table read as a classical one. The last row then placed the tool, and
    /// its twist is this many quarter turns; its length is zero, as of every wrist whose last two axes meet.
    FrameBefore(i8),
    /// Base or tool, or both, are not where the description says, and are estimated.
    Unknown {
        /// The base.
        base: bool,
        /// The tool and the markers.
        tool: bool,
    },
}

/// Radians in a degree.
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Factors between the units in which lengths are recorded and declared: m, cm, mm, um, inches and feet.
pub const LENGTH_FACTORS: [f64; 12] =
    [1e3, 1e-3, 25.4, 1.0 / 25.4, 10.0, 0.1, 100.0, 0.01, 39.37007874015748, 0.0254, 304.8, 1.0 / 304.8];

/// Of one column of readings: a unit of its own, or a decimal sign in another place.
const AXIS_FACTORS: [f64; 6] = [10.0, 0.1, 1e3, 1e-3, 25.4, 1.0 / 25.4];

/// By how many rows a table of joints and one of readings are shifted against each other: a line of a heading more, or two.
const SHIFTS: [isize; 4] = [1, -1, 2, -2];

/// Of moments about the other sense, or recorded in N.mm, or in kN.m, where N.m are declared, and the reverse.
const MOMENT_FACTORS: [f64; 3] = [-1.0, 1e-3, 1e3];

/// Of forces of the other sense, or recorded in kgf, lbf or daN with moments in N.m. Springs that are fitted take up what both share.
const FORCE_FACTORS: [f64; 4] = [-1.0, 9.80665, 4.4482216152605, 10.0];

impl Hypothesis {
    /// All that a campaign of a robot admits. Of deflections what reverses them, since nothing passive gives way against its load;
    /// axes or markers exchanged, which a spring that is missing in the description can look like, are to leave nothing but noise.
    pub fn all(model: &Model, campaign: &Campaign) -> Vec<Self> {
        if campaign.readings.is_empty() {
            return Vec::new();
        }
        if campaign.is_difference() {
            let exchanged = handedness(campaign).into_iter().chain(exchanged_markers(model));
            let any = |part: std::ops::Range<usize>| {
                let mut readings = campaign.readings.iter();
                readings.any(|reading| reading.wrench[part.clone()].iter().any(|component| *component != 0.0))
            };
            // Moments alone are reversed, and scaled, with all else.
            let both = any(0..3) && any(3..6);
            let [moments, forces] = [&MOMENT_FACTORS[..], &FORCE_FACTORS[..]].map(|all| if both { all } else { &[] });
            let parts = moments.iter().map(|&factor| Self::Moments(factor));
            let parts = parts.chain(forces.iter().map(|&factor| Self::Forces(factor)));
            return std::iter::once(Self::Reaction).chain(parts).chain(exchanged).chain(axis_units()).collect();
        }
        let mut all = Self::of_joints(model, campaign);
        if model.variables.iter().any(|variable| variable.is_angle) {
            all.extend([1.0 / DEGREE, DEGREE].map(Self::DescriptionAngles));
        }
        let measures = |reading: &Reading| reading.observes.measured_position(&reading.measured).is_some();
        let with_positions = campaign.readings.iter().any(measures);
        if campaign.readings.iter().any(|reading| !reading.observes.columns().is_empty()) {
            all.extend(LENGTH_FACTORS.map(Self::ReadingUnit));
        }
        if with_positions {
            all.extend(handedness(campaign));
            all.extend(axis_units());
        }
        let is_direction = |reading: &&Reading| reading.observes.reversed(&reading.measured).is_some();
        let sensors = distinct(campaign.readings.iter().filter(is_direction).map(|reading| reading.target));
        if !sensors.is_empty() {
            all.push(Self::DirectionsReversed(None));
        }
        if sensors.len() > 1 {
            all.extend(sensors.into_iter().flatten().map(|target| Self::DirectionsReversed(Some(target))));
        }
        // Of a sensor mounted anyhow a reflection is that of all axes.
        if campaign.readings.iter().any(|reading| is_direction(&reading) && is_mounted(campaign, reading)) {
            all.extend((0..3).map(Self::DirectionsMirrored));
            all.extend(pairs(3).map(|(a, b)| Self::DirectionsExchanged(a, b)));
        }
        all.extend(SensorAngles::all(campaign).map(Self::Sensors));
        if campaign.readings.iter().any(has_rotation) {
            all.extend(Turned::ALL.map(Self::Turned));
        }
        if !campaign.estimate_tool {
            let count = model.markers.len();
            all.extend(exchanged_markers(model));
            // Of two they are the same as exchanged.
            all.extend((1..count).filter(|_| count > 2).map(Self::MarkersMoved));
        }
        let is_distance = |reading: &&Reading| reading.observes.needs_anchor();
        let anchors = distinct(campaign.readings.iter().filter(is_distance).filter_map(|reading| reading.target));
        all.extend(pairs(anchors.len()).map(|(a, b)| Self::Anchors(anchors[a], anchors[b])));
        let choices = [(true, false), (false, true), (true, true)];
        let is_new = |(base, tool): (bool, bool)| {
            !(base && campaign.estimate_base || tool && campaign.estimate_tool) && (!base || with_positions)
        };
        all.extend(choices.into_iter().filter(|of| is_new(*of)).map(|(base, tool)| Self::Unknown { base, tool }));
        if is_table(model) {
            all.push(Self::FrameAfter);
            all.extend([0, 1, -1].map(Self::FrameBefore));
        }
        all
    }

    /// Other ways to read the joints of a campaign: their signs, columns, zeros, units and rows.
    pub fn of_joints(model: &Model, campaign: &Campaign) -> Vec<Self> {
        let joints = 0..model.variables.len();
        let angles = || joints.clone().filter(|&k| model.variables[k].is_angle);
        let mut all: Vec<Self> = joints.clone().map(Self::Negated).collect();
        all.extend(pairs(joints.len()).flat_map(|(a, b)| swapped(model, a, b)));
        all.extend(angles().flat_map(|k| [1, 2, 3].map(|quarters| Self::QuarterTurns(k, quarters))));
        let is_declared = |(_, read): &(Angles, Angles)| {
            campaign.angle_unit.is_none_or(|unit| (unit / read.size() - 1.0).abs() < 1e-9)
        };
        if angles().count() > 0 {
            // Of angles within a turn they would be those of an arm that hardly moves.
            let is_beyond_turn =
                |(meant, _): &(Angles, Angles)| *meant != Angles::Milliradians || turns_over(model, campaign);
            let mistaken = Angles::MISTAKEN.into_iter().filter(is_declared).filter(is_beyond_turn);
            all.extend(mistaken.map(|(meant, read)| Self::JointAngles(meant, read)));
        }
        if angles().count() > 1 {
            let of = |k: usize| {
                Angles::EXCHANGED
                    .into_iter()
                    .filter(is_declared)
                    .map(move |(meant, read)| Self::AngleOf(k, meant, read))
            };
            all.extend(angles().flat_map(of));
        }
        let lengths = || joints.clone().filter(|&k| !model.variables[k].is_angle);
        if lengths().count() > 0 {
            all.extend(LENGTH_FACTORS.map(Self::JointLengths));
        }
        if lengths().count() > 1 {
            all.extend(lengths().flat_map(|k| LENGTH_FACTORS.map(|factor| Self::LengthOf(k, factor))));
        }
        all.extend(Reordered::all(model).into_iter().map(Self::Reordered));
        let coupled = (1..joints.len()).filter(|&k| model.variables[k].is_angle && model.variables[k - 1].is_angle);
        all.extend(coupled.flat_map(|k| [1, -1].map(|sign| Self::Coupled(k - 1, sign))));
        // Of few configurations what a shift leaves over is fitted whatever it is.
        if campaign.poses.len() < Limits::default().fewest_configurations {
            return all;
        }
        all.extend(SHIFTS.map(|by| Self::Shifted(by, false)));
        if campaign.readings.len() > campaign.poses.len() {
            all.extend(SHIFTS.map(|by| Self::Shifted(by, true)));
        }
        all
    }

    /// Zeros of two joints at once that lie quarter turns off: most often those of a shoulder and an elbow.
    pub fn two_zeros(model: &Model) -> Vec<Vec<Self>> {
        let turns = |k: usize| [1, 2, 3].map(|quarters| Self::QuarterTurns(k, quarters));
        let is_angle = |k: usize| model.variables[k].is_angle;
        let both = pairs(model.variables.len()).filter(|&(a, b)| is_angle(a) && is_angle(b));
        both.flat_map(|(a, b)| turns(a).into_iter().flat_map(move |one| turns(b).map(|other| vec![one, other])))
            .collect()
    }

    /// One joint that counts the other way and has its zero quarter turns off, as an angle that is measured from the vertical and not from the
    /// horizontal.
    pub fn counted_from_elsewhere(model: &Model) -> Vec<Vec<Self>> {
        let angles = (0..model.variables.len()).filter(|&k| model.variables[k].is_angle);
        angles.flat_map(|k| [1, 2, 3].map(|quarters| vec![Self::Negated(k), Self::QuarterTurns(k, quarters)])).collect()
    }

    /// Changes a campaign and the description's values so.
    pub fn apply(&self, model: &Model, campaign: &mut Campaign, values: &mut [f64]) {
        match *self {
            Self::Negated(joint) => each(campaign, |q| q[joint] = -q[joint]),
            Self::Swapped(a, b) => each(campaign, |q| q.swap(a, b)),
            Self::SwappedKinds(slides, turns, turn) => each(campaign, |q| {
                (q[slides], q[turns]) = (q[turns] / turn, q[slides] * turn);
            }),
            Self::QuarterTurns(joint, quarters) => {
                each(campaign, |q| q[joint] += f64::from(quarters) * FRAC_PI_2);
            }
            Self::Reordered(way) => each(campaign, |q| way.apply(model, q)),
            Self::Coupled(first, sign) => each(campaign, |q| q[first + 1] -= f64::from(sign) * q[first]),
            Self::JointAngles(meant, read) => scale(model, campaign, true, meant.size() / read.size()),
            Self::AngleOf(joint, meant, read) => each(campaign, |q| q[joint] *= meant.size() / read.size()),
            Self::JointLengths(factor) => scale(model, campaign, false, factor),
            Self::LengthOf(joint, factor) => each(campaign, |q| q[joint] *= factor),
            Self::ReadingUnit(factor) | Self::Scale(factor) => multiply_lengths(campaign, factor),
            Self::AxisUnit(axis, factor) => multiply_axis(campaign, axis, factor),
            Self::Mirrored(axis, turns) => mirror(campaign, turns, |v| v[axis] = -v[axis]),
            Self::Exchanged(a, b, turns) => mirror(campaign, turns, |v| v.swap_rows(a, b)),
            Self::DirectionsReversed(target) => reverse(campaign, target),
            Self::DirectionsMirrored(axis) => read_directions(campaign, |direction| direction[axis] = -direction[axis]),
            Self::DirectionsExchanged(a, b) => read_directions(campaign, |direction| direction.swap(a, b)),
            Self::Sensors(way) => way.apply(campaign),
            Self::Reaction => multiply_wrenches(campaign, 0..6, -1.0),
            Self::Moments(factor) => multiply_wrenches(campaign, 3..6, factor),
            Self::Forces(factor) => multiply_wrenches(campaign, 0..3, factor),
            Self::Turned(way) => turn(campaign, way),
            Self::Shifted(by, whole) => *campaign = shifted(campaign, by, whole),
            Self::Markers(a, b) => rename_markers(campaign, |marker| exchanged(marker, a, b)),
            Self::Anchors(a, b) => {
                let own = campaign.readings.iter_mut().filter(|reading| reading.observes.needs_anchor());
                own.for_each(|reading| reading.target = reading.target.map(|target| exchanged(target, a, b)));
            }
            Self::MarkersMoved(by) => {
                let count = model.markers.len();
                rename_markers(campaign, |marker| if marker < count { (marker + by) % count } else { marker });
            }
            Self::DescriptionAngles(factor) => {
                own_slots(model, Kind::Angle).into_iter().for_each(|slot| values[slot] *= factor);
            }
            Self::FrameAfter => move_rows(model, values, true),
            Self::FrameBefore(quarters) => {
                move_rows(model, values, false);
                take_back(model, values, f64::from(quarters) * FRAC_PI_2);
            }
            Self::Unknown { base, tool } => {
                campaign.estimate_base |= base;
                campaign.estimate_tool |= tool;
            }
        }
    }

    /// Whether rows are moved against each other, so that it applies to the whole campaign and not to a sample of it.
    pub fn moves_rows(&self) -> bool {
        matches!(self, Self::Shifted(..))
    }

    /// Whether it changes values of the description, and nothing of the campaign.
    pub fn is_of_description(&self) -> bool {
        matches!(self, Self::DescriptionAngles(_) | Self::FrameAfter | Self::FrameBefore(_))
    }

    /// Whether it adds unknowns, so that it also takes up part of what the description's tolerances make.
    pub fn adds_unknowns(&self) -> bool {
        matches!(self, Self::Unknown { .. })
    }

    /// Whether it makes readings smaller, and with them what is left of any: another way that explains them is not behind for that.
    pub fn shrinks(&self) -> bool {
        matches!(*self, Self::ReadingUnit(factor) | Self::AxisUnit(_, factor) if factor < 1.0)
    }

    /// Whether it changes what another one changes, so that both together are a third of the same kind, or nothing.
    pub fn undoes(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
            && !matches!(self, Self::Swapped(..) | Self::Negated(_))
    }
}

/// Multiplies all lengths that are read.
fn multiply_lengths(campaign: &mut Campaign, factor: f64) {
    for reading in &mut campaign.readings {
        let lengths = reading.observes.length_rows().min(reading.observes.columns().len());
        reading.measured[..lengths].iter_mut().for_each(|value| *value *= factor);
    }
}

/// Multiplies what is read along an axis.
fn multiply_axis(campaign: &mut Campaign, axis: usize, factor: f64) {
    let of_axes = campaign.readings.iter_mut().filter(|reading| reading.observes.length_rows() == 3);
    of_axes.filter_map(|reading| reading.measured.get_mut(axis)).for_each(|value| *value *= factor);
}

/// Each axis in other units.
fn axis_units() -> impl Iterator<Item = Hypothesis> {
    (0..3).flat_map(|axis| AXIS_FACTORS.map(|factor| Hypothesis::AxisUnit(axis, factor)))
}

/// Multiplies a part of all wrenches.
fn multiply_wrenches(campaign: &mut Campaign, part: std::ops::Range<usize>, factor: f64) {
    let wrenches = campaign.readings.iter_mut().flat_map(|reading| &mut reading.wrench[part.clone()]);
    wrenches.for_each(|component| *component *= factor);
}

/// Reads all measured rotations otherwise.
fn turn(campaign: &mut Campaign, way: Turned) {
    for reading in campaign.readings.iter_mut().filter(|reading| has_rotation(reading)) {
        let own = &mut reading.measured[3..6];
        let read = way.read(&Vector3::from_column_slice(own));
        own.copy_from_slice(read.as_slice());
    }
}

/// The other one of two, and what is neither as it is.
fn exchanged(own: usize, a: usize, b: usize) -> usize {
    match own {
        own if own == a => b,
        own if own == b => a,
        other => other,
    }
}

fn rename_markers(campaign: &mut Campaign, meant: impl Fn(usize) -> usize) {
    campaign.readings.iter_mut().for_each(|reading| reading.marker = reading.marker.map(&meant));
}

/// Multiplies all joints that turn, or all that slide.
fn scale(model: &Model, campaign: &mut Campaign, is_angle: bool, factor: f64) {
    each(campaign, |q| {
        let own = q.iter_mut().zip(&model.variables).filter(|(_, variable)| variable.is_angle == is_angle);
        own.for_each(|(value, _)| *value *= factor);
    });
}

/// Whether a reading is a position and a rotation vector.
fn has_rotation(reading: &Reading) -> bool {
    reading.observes.holds_pose()
}

/// Each two markers exchanged.
fn exchanged_markers(model: &Model) -> impl Iterator<Item = Hypothesis> + use<> {
    pairs(model.markers.len()).map(|(a, b)| Hypothesis::Markers(a, b))
}

/// Each two of so many.
fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| (a, b)))
}

/// Handedness: with the base unknown all reflections are one, else each axis and each pair of axes.
fn handedness(campaign: &Campaign) -> Vec<Hypothesis> {
    let turns: &[bool] = if campaign.sees_orientation() { &[false, true] } else { &[false] };
    let each = turns.iter().flat_map(|&turns| {
        let mirrored = (0..3).map(move |axis| Hypothesis::Mirrored(axis, turns));
        mirrored.chain([(0, 1), (0, 2), (1, 2)].map(|(a, b)| Hypothesis::Exchanged(a, b, turns)))
    });
    if campaign.estimate_base && !campaign.is_difference() {
        turns.iter().map(|&turns| Hypothesis::Mirrored(1, turns)).collect()
    } else {
        each.collect()
    }
}

/// Whether the tool's chain could be a table of Denavit and Hartenberg: joints each with a row of its own.
fn is_table(model: &Model) -> bool {
    let chain = model.path(model.tool.0);
    let mut rows: Vec<Slot> = chain.iter().map(|&frame| model.frames[frame].slots[ROW[0]]).collect();
    rows.sort_unstable();
    rows.dedup();
    rows.len() == chain.len() && model.stages.is_empty() && model.actuators.is_empty()
}

/// Whether some joint turns by more than a whole turn from zero.
fn turns_over(model: &Model, campaign: &Campaign) -> bool {
    let is_over = |(value, variable): (&f64, &Variable)| variable.is_angle && value.abs() > TAU;
    let is_any = |index: usize| campaign.configuration(index).iter().zip(&model.variables).any(is_over);
    (0..campaign.readings.len()).any(is_any)
}

/// The columns of two joints exchanged; of a length and an angle in each pair of units.
fn swapped(model: &Model, a: usize, b: usize) -> Vec<Hypothesis> {
    match [a, b].map(|k| model.variables[k].is_angle) {
        [false, true] => TURNS.map(|turn| Hypothesis::SwappedKinds(a, b, turn)).into(),
        [true, false] => TURNS.map(|turn| Hypothesis::SwappedKinds(b, a, turn)).into(),
        _ => vec![Hypothesis::Swapped(a, b)],
    }
}

/// The robot's own slots of a kind, once each.
pub(super) fn own_slots(model: &Model, kind: Kind) -> Vec<Slot> {
    let mut slots: Vec<Slot> = model.frames.iter().flat_map(|frame| frame.slots).collect();
    slots.sort_unstable();
    slots.dedup();
    slots.retain(|&slot| model.registry[slot].kind == kind && model.registry[slot].group == Group::Geometry);
    slots
}

/// Sum of the lengths of a robot as described, m.
pub(super) fn total_length(model: &Model) -> f64 {
    own_slots(model, Kind::Length).iter().map(|&slot| model.registry[slot].nominal.abs()).sum()
}
