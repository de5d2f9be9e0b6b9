//! What a campaign's readings say that can hardly be meant.

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;

use super::amount::SAME_CONFIGURATION;
use super::columns::joint_column;
use super::noise_doubts::of_no_reading;
use super::raw::RawCampaign;
use super::source::Source;
use super::unused::unused;
use super::{Campaign, OrderBy, Payload};
use crate::description::limits::{READINGS, beyond};
use crate::description::resolve::Locate;
use crate::description::robot::{Robot, Variable};
use crate::description::table::Table;
use crate::description::units::Units;
use crate::diagnostic::{Code, Diagnostic, Place};
use crate::math::{distinct, extremes, median};

/// Variables beyond their limits, a name for two configurations, deflections that nothing causes (an error).
pub fn doubts(
    campaign: &Campaign,
    raw: &RawCampaign,
    locate: Locate,
    robot: &Robot,
    sources: &[Source],
) -> Vec<Diagnostic> {
    let units = &raw.units;
    let place = |reading: usize, column: &str| place(sources, campaign.readings[reading].row, column);
    let mut diagnostics = Vec::new();
    // A path may have no joints.
    let has_all =
        |source: &Source| robot.variables.iter().all(|variable| source.table.has(&joint_column(raw, &variable.name)));
    if sources.iter().all(has_all) {
        let configurations = (0..campaign.readings.len()).map(|reading| campaign.configuration(reading));
        diagnostics.extend(beyond(&robot.variables, units, READINGS, configurations, place));
    }
    let suspect = [
        one_name_for_two(campaign, units, robot, &place),
        back_in_time(campaign, sources, &place),
        other_times(campaign, robot, &place),
        copies(campaign, sources),
        held_out_and_fitted(campaign, &place),
        two_temperatures(campaign, &place),
    ];
    diagnostics.extend(suspect.into_iter().flatten().map(|doubt| doubt.code(Code::SuspectReadings)));
    diagnostics.extend(of_no_reading(campaign, raw, locate, sources));
    diagnostics.extend(one_side(campaign, robot, &place));
    diagnostics.extend(without_predecessor(campaign));
    diagnostics
        .extend(campaign.payloads.iter().filter_map(|(name, payload)| heavy_or_far(name, payload, robot, locate)));
    diagnostics.extend(weightless(campaign, robot, locate));
    diagnostics.extend(unused(campaign, raw, locate));
    let mut differences = campaign.readings.iter().filter(|reading| reading.observes.is_difference()).peekable();
    let name = differences.peek().map(|reading| reading.observes.name());
    if let Some(name) = name
        && differences.all(|reading| !reading.is_loaded())
    {
        let diagnostic =
            Diagnostic::error(format!("{name}s are observed, and no reading is loaded")).at(locate(&["observes"]));
        diagnostics.push(diagnostic.remedy("give the load of each reading in columns fx, fy, fz, mx, my, mz"));
    }
    diagnostics
}

/// Greatest mass of a payload, kg: the strongest industrial arms carry 2.3 t.
const HEAVIEST: f64 = 3e3;
/// Greatest distance of its centre of mass from the frame that carries it, m: tools are seldom longer than an arm.
const FARTHEST: f64 = 3.0;

/// A payload that no arm carries, or that is heavier than all bodies of this one together.
fn heavy_or_far(name: &str, payload: &Payload, robot: &Robot, locate: Locate) -> Option<Diagnostic> {
    let (mass, far) = (payload.mass, payload.com.norm());
    let own: f64 = robot.elastic.bodies.iter().map(|body| body.mass).sum();
    let is_weighed = robot.elastic.bodies.len() >= robot.variables.len() && own > 0.0;
    let (message, key) = if mass > HEAVIEST {
        (format!("payload `{name}` has a mass of {mass:.0} kg"), "mass")
    } else if is_weighed && mass > own {
        let message = format!(
            "payload `{name}` has a mass of {mass:.1} kg, more than all bodies of the robot together ({own:.1} kg)"
        );
        (message, "mass")
    } else if far > FARTHEST {
        (format!("the centre of mass of payload `{name}` lies {far:.2} m from its frame"), "com")
    } else {
        return None;
    };
    let diagnostic = Diagnostic::warning(message).at(locate(&["payloads", name, key]));
    Some(diagnostic.remedy("check the value and the unit"))
}

/// Payloads of which nothing shows, since nothing weighs anything.
fn weightless(campaign: &Campaign, robot: &Robot, locate: Locate) -> Option<Diagnostic> {
    let carried = campaign.readings.iter().filter_map(|reading| reading.payload).any(|payload| payload.mass > 0.0);
    (carried && robot.elastic.gravity.norm() == 0.0).then(|| {
        Diagnostic::warning("payloads have no weight: gravity of the description is zero")
            .at(locate(&["payloads"]))
            .remedy("state `gravity` in the description, in base axes: [0, 0, -9.81] m/s2 of a robot on the floor")
    })
}

/// Readings of which the order is numbered and not what was reached before them, beyond the first configurations of sessions.
fn without_predecessor(campaign: &Campaign) -> Option<Diagnostic> {
    let conditions = &campaign.conditions;
    let moves = conditions.last_move.first().filter(|_| conditions.order == OrderBy::Numbers)?;
    let unknown: HashSet<usize> = moves
        .iter()
        .zip(&campaign.readings)
        .filter(|(moved, _)| !moved.is_finite())
        .map(|(_, reading)| reading.pose)
        .collect();
    let all: HashSet<usize> = campaign.readings.iter().map(|reading| reading.pose).collect();
    let firsts = distinct(campaign.readings.iter().map(|reading| reading.session)).len();
    (unknown.len() > firsts && unknown.len() < all.len()).then(|| {
        let text = format!(
            "{} of {} configurations have no known predecessor: laws of the last move cannot explain their readings",
            unknown.len(),
            all.len()
        );
        let remedy = "give every configuration that was reached a number in the order, those without a reading too; or leave these readings out \
                      where such laws are judged";
        Diagnostic::warning(text).code(Code::Doubtful).remedy(remedy)
    })
}

/// The first pose whose readings have different joints, and how many more there are.
fn one_name_for_two(
    campaign: &Campaign,
    units: &Units,
    robot: &Robot,
    place: &impl Fn(usize, &str) -> Option<Place>,
) -> Option<Diagnostic> {
    let mut first: Vec<Option<usize>> = vec![None; campaign.poses.len()];
    // By configuration: a reading that differs from the first one, and the variable in which it does.
    let mut differing: IndexMap<usize, (usize, usize)> = IndexMap::new();
    for (index, reading) in campaign.readings.iter().enumerate() {
        let before = *first[reading.pose].get_or_insert(index);
        let (here, there) = (campaign.configuration(index), campaign.configuration(before));
        if let Some(variable) = here.iter().zip(there).position(|(a, b)| (a - b).abs() > SAME_CONFIGURATION) {
            differing.entry(reading.pose).or_insert((index, variable));
        }
    }
    let (&pose, &(index, variable)) = differing.first()?;
    let before = first[pose]?;
    let Variable { name, is_angle, .. } = &robot.variables[variable];
    let (unit, factor) = if *is_angle {
        (units.angle.symbol(), units.angle.factor())
    } else {
        (units.length.symbol(), units.length.factor())
    };
    let [here, there] = [index, before].map(|reading| campaign.configuration(reading)[variable] / factor);
    let more = if differing.len() > 1 { format!("; so have {} more", differing.len() - 1) } else { String::new() };
    let pose = &campaign.poses[pose];
    let message = format!(
        "the pose `{pose}` has rows with different joints: `{name}` is {here:.4} {unit}, and {there:.4} {unit} before{more}"
    );
    let diagnostic =
        Diagnostic::warning(message).at(place(index, name)).related(place(before, name), "first given here");
    Some(diagnostic.remedy("give each configuration a name of its own: readings of one name count as taken together"))
}

/// Share of the steps from one time to the next that go back, above which rows are in no order of time: half of them do where rows are
/// mixed, and few where a clock or a session began anew.
const MIXED: f64 = 0.25;

/// Times that run backwards within a session, in the order that the readings state, else in that of their rows: readings are taken one
/// after the other. Rows without a stated order that are mixed are put into that of their times.
fn back_in_time(
    campaign: &Campaign,
    sources: &[Source],
    place: &impl Fn(usize, &str) -> Option<Place>,
) -> Option<Diagnostic> {
    let times = campaign.conditions.time.as_ref()?;
    let is_numbered = campaign.conditions.order == OrderBy::Numbers;
    let mut timed: Vec<usize> = (0..campaign.readings.len()).filter(|&index| times[index].is_finite()).collect();
    if is_numbered {
        let number = |index: usize| number(sources, campaign.readings[index].row, "order").unwrap_or(f64::INFINITY);
        timed.sort_by(|&a, &b| number(a).total_cmp(&number(b)));
    }
    let mut last: IndexMap<(usize, usize), f64> = IndexMap::new();
    let mut back: Vec<(usize, f64)> = Vec::new();
    let mut steps = 0;
    for index in timed {
        let session = campaign.readings[index].session;
        let time = times[index];
        let Some(before) = last.insert((session.session, session.station), time).filter(|before| time != *before)
        else {
            continue;
        };
        steps += 1;
        back.extend((time < before).then_some((index, before - time)));
    }
    let &(index, by) = back.first()?;
    let falls_always = steps >= FEW && back.len() == steps;
    if !is_numbered && steps >= FEW && back.len() as f64 > MIXED * steps as f64 && !falls_always {
        return None;
    }
    let more = if back.len() > 1 { format!(", and {} times more", back.len() - 1) } else { String::new() };
    let (what, remedy) = match is_numbered {
        true => (
            "`order` says which came first, `time` what drifts",
            "if a clock or a session began anew, name the sessions; else correct the times",
        ),
        false => (
            "readings are put into its order",
            "if a clock or a session began anew, name the sessions; else sort the rows, or give `order`",
        ),
    };
    let diagnostic = match falls_always {
        true => Diagnostic::warning(format!("`time` falls from each reading to the next: {what}"))
            .remedy("if the clock counts down, turn its sign: what drifts would have the wrong one"),
        false => Diagnostic::warning(format!("`time` goes back by {by} s{more}: {what}")).remedy(remedy),
    };
    Some(diagnostic.at(place(index, "time")).figure("times", back.len() as f64))
}

/// Median time between configurations above which it is doubted, s: they take seconds to minutes, which in milliseconds look like hours.
const APART: f64 = 3600.0;
/// Configurations from which a median says something.
const FEW: usize = 8;

/// Median over moves of the speed of the joint that turned fastest above which times are doubted, rad/s: three turns a second, though an
/// arm that is measured stands still in between. A judgement.
const FASTEST: f64 = 20.0;

/// Times that look like milliseconds, or like minutes or hours that are taken for seconds.
fn other_times(
    campaign: &Campaign,
    robot: &Robot,
    place: &impl Fn(usize, &str) -> Option<Place>,
) -> Option<Diagnostic> {
    let times = campaign.conditions.time.as_ref()?;
    let mut first: IndexMap<usize, (f64, usize)> = IndexMap::new();
    for (index, (reading, &time)) in
        campaign.readings.iter().zip(times).enumerate().filter(|(_, (_, time))| time.is_finite())
    {
        first.entry(reading.pose).or_insert((time, index));
    }
    let mut all: Vec<(f64, usize)> = first.into_values().collect();
    if all.len() < FEW {
        return None;
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let gaps = || all.windows(2).map(|pair| pair[1].0 - pair[0].0);
    let remedy = "state its unit (`units: {time: s}`; min, h); milliseconds are divided by 1000 first";
    if let Some(middle) = median(&mut gaps().collect::<Vec<_>>()).filter(|gap| *gap > APART) {
        let hours = middle / 3600.0;
        let message =
            format!("`time` passes {hours:.1} h from one configuration to the next (median): is it in milliseconds?");
        return Some(Diagnostic::warning(message).at(place(0, "time")).figure("hours", hours).remedy(remedy));
    }
    let turned = |pair: &[(f64, usize)]| {
        let [before, after] = [pair[0].1, pair[1].1].map(|index| campaign.configuration(index));
        let angles = robot.variables.iter().zip(before.iter().zip(after)).filter(|(variable, _)| variable.is_angle);
        angles.map(|(_, (before, after))| (after - before).abs()).fold(0.0, f64::max)
    };
    let speeds = all.windows(2).zip(gaps()).filter(|(_, gap)| *gap > 0.0).map(|(pair, gap)| turned(pair) / gap);
    let middle = median(&mut speeds.collect::<Vec<_>>()).filter(|speed| *speed > FASTEST)?;
    let message = format!(
        "by `time` the fastest joint turns at {:.0} deg/s from one configuration to the next (median): is it in minutes or hours?",
        middle.to_degrees()
    );
    Some(Diagnostic::warning(message).at(place(0, "time")).figure("deg_per_s", middle.to_degrees()).remedy(remedy))
}

/// Sides of approach that are the same in all readings: what depends on them does not show.
fn one_side(campaign: &Campaign, robot: &Robot, place: &impl Fn(usize, &str) -> Option<Place>) -> Option<Diagnostic> {
    let is_one = |sides: &Vec<f64>| {
        let mut known = sides.iter().filter(|side| **side == 1.0 || **side == -1.0);
        known.next().is_some_and(|first| known.all(|side| side == first))
    };
    let all = campaign.conditions.approach.iter().zip(&robot.variables);
    let given: Vec<(&str, bool)> =
        all.filter_map(|(sides, variable)| Some((variable.name.as_str(), is_one(sides.as_ref()?)))).collect();
    let named: Vec<String> =
        given.iter().filter(|(_, is_one)| *is_one).map(|(name, _)| format!("approach.{name}")).collect();
    let first = named.first()?;
    let what = if named.len() == 1 { "holds" } else { "hold" };
    let message = format!("`{}` {what} one side alone: a backlash there does not show", named.join("`, `"));
    Some(
        Diagnostic::warning(message)
            .at(place(0, first))
            .remedy("approach some configurations from the other side, or leave the column out"),
    )
}

/// Readings that are held out at configurations that are fitted as well: what they leave is no error of unseen configurations.
fn held_out_and_fitted(campaign: &Campaign, place: &impl Fn(usize, &str) -> Option<Place>) -> Option<Diagnostic> {
    let all = campaign.readings.iter().filter(|reading| reading.check == Some(true)).count();
    let seen = campaign.held_out_and_fitted(|index| campaign.readings[index].check);
    let both = seen.len();
    let index = seen.first().copied().filter(|_| 2 * both > all)?;
    let message = format!("{both} of {all} readings that are held out stand at configurations that are fitted as well");
    let diagnostic = Diagnostic::warning(message).at(place(index, "set"));
    Some(diagnostic.remedy("hold whole configurations out: what is left of these is no error of unseen readings"))
}

/// Least share of the readings that are copies of others before it is warned of: single ones are chance, of coarse readings.
const COPIED: f64 = 0.1;

/// Least number of configurations with copies that are warned of where all readings of a configuration that was read again are copies:
/// rows were pasted. Coarse readings of a home position agree by chance, at one configuration.
const PASTED: usize = 3;

/// Readings that agree with another one to the last digit, in everything that was measured, or but for digits that were cut: noise
/// never does.
fn copies(campaign: &Campaign, sources: &[Source]) -> Option<Diagnostic> {
    let is_many = |copied: &Vec<usize>| copied.len() as f64 >= COPIED * campaign.readings.len() as f64;
    let (exact, repeated) = exact_copies(campaign);
    let configurations: HashSet<usize> = exact.iter().map(|&index| campaign.readings[index].pose).collect();
    let are_pasted = configurations.len() >= PASTED && exact.len() == repeated;
    let found = Some((exact, "to the last digit")).filter(|(copied, _)| are_pasted || is_many(copied));
    let (copied, how) = found.or_else(|| {
        Some((near_copies(campaign), "but for digits that were cut")).filter(|(copied, _)| is_many(copied))
    })?;
    let first = campaign.readings[*copied.first()?].row;
    let count = copied.len();
    let place = place(sources, first, "x").or_else(|| place(sources, first, "pose"));
    let message = format!("{count} of {} readings are copies of others {how}", campaign.readings.len());
    Some(
        Diagnostic::warning(message)
            .at(place)
            .remedy("list each file once: copies count twice and make intervals too narrow"),
    )
}

/// By index, in order; and how many readings are of a configuration that was read before.
fn exact_copies(campaign: &Campaign) -> (Vec<usize>, usize) {
    let (mut seen, mut read) = (HashSet::new(), HashSet::new());
    let mut copied: Vec<usize> = Vec::new();
    let mut repeated = 0;
    let times = campaign.conditions.time.as_ref();
    for (index, reading) in campaign.readings.iter().enumerate() {
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        let measured = &reading.measured[..reading.observes.columns().len()];
        let time = times.and_then(|times| times.get(index)).map(|time| time.to_bits());
        let what = (reading.observes.name(), reading.marker, reading.target, bits(&reading.wrench), time);
        if measured.is_empty() {
            continue;
        }
        let joints = bits(campaign.configuration(index));
        repeated += usize::from(!read.insert((joints.clone(), what.clone())));
        if !seen.insert((joints, bits(measured), what)) {
            copied.push(index);
        }
    }
    (copied, repeated)
}

/// Joints within this (rad, m) are those of one configuration: two thousandths of a degree, files are seldom rounded more.
const ONE_CONFIGURATION: f64 = 3.5e-5;
/// Values within this part of their standard deviation are one: all three of two independent readings are so once in 45,000.
const ONE_VALUE: f64 = 0.05;

/// Readings whose joints and values are those of another one but for rounding, by index, in order; of those that state their noise and
/// have three values and more. Repeats have the same joints to the last digit. Joints are compared by cells: of two near a border some
/// are missed.
fn near_copies(campaign: &Campaign) -> Vec<usize> {
    let times = campaign.conditions.time.as_ref();
    let mut known: HashMap<_, Vec<usize>> = HashMap::new();
    let mut copied = Vec::new();
    for (index, reading) in campaign.readings.iter().enumerate() {
        let rows = reading.observes.columns().len();
        if rows < 3 || rows != reading.observes.rows() || !reading.noise.is_stated[0] {
            continue;
        }
        let cells: Vec<i64> =
            (campaign.configuration(index).iter()).map(|value| (value / ONE_CONFIGURATION).round() as i64).collect();
        let load = reading.wrench.map(f64::to_bits);
        let time = times.and_then(|times| times.get(index)).map(|time| time.to_bits());
        let others =
            known.entry((cells, reading.observes.name(), reading.marker, reading.target, load, time)).or_default();
        let sigmas = reading.observes.sigmas(&reading.noise);
        let is_one = |other: &usize| {
            let values = reading.measured.iter().zip(&campaign.readings[*other].measured);
            let is_repeat = campaign.configuration(index) == campaign.configuration(*other);
            !is_repeat && values.zip(sigmas).take(rows).all(|((a, b), sigma)| (a - b).abs() < ONE_VALUE * sigma)
        };
        if others.iter().any(is_one) {
            copied.push(index);
        }
        others.push(index);
    }
    copied
}

/// Widest range of the temperatures of one campaign, K: twice what a hall has between winter and summer.
const TEMPERATURES: f64 = 60.0;
/// Least temperature of a campaign, degC, at which no arm is measured: what reads like more is in kelvin or degrees Fahrenheit.
const HOT: f64 = 60.0;
/// Temperatures next to which cells that are exactly 0 are missing values, not temperatures.
const WARM: f64 = 5.0;

/// Temperatures of which some are missing values written as 0, or in another unit.
fn two_temperatures(campaign: &Campaign, place: &impl Fn(usize, &str) -> Option<Place>) -> Option<Diagnostic> {
    let all = campaign.conditions.temperature.as_ref()?;
    let zeros = all.iter().filter(|value| **value == 0.0).count();
    let [low, high] = extremes(all.iter().copied().filter(|value| *value != 0.0 && value.is_finite()));
    let (message, wrong) = if zeros > 0 && low > WARM {
        let message =
            format!("`temperature` is 0 in {zeros} of {} readings, and {low:.1} to {high:.1} in the others", all.len());
        (message, all.iter().position(|value| *value == 0.0)?)
    } else if high - low > TEMPERATURES {
        let message = format!("`temperature` goes from {low:.1} to {high:.1}");
        (message, all.iter().position(|value| *value == high)?)
    } else if low.is_finite() && low > HOT {
        let message = format!("`temperature` is {low:.1} to {high:.1}: hotter than any hall, if it is in degC");
        let remedy = "give degC: kelvin less 273.15, or Fahrenheit less 32, over 1.8";
        return Some(Diagnostic::warning(message).at(place(0, "temperature")).remedy(remedy));
    } else {
        return None;
    };
    let diagnostic = Diagnostic::warning(message).at(place(wrong, "temperature"));
    Some(diagnostic.remedy("give all of them in one unit, and leave out readings without one"))
}

/// The table and its row of a row of all files, counted from 1.
fn table_of<'s>(sources: &'s [Source], row: usize) -> Option<(&'s Table, usize)> {
    let mut row = row.checked_sub(1)?;
    for Source { table, .. } in sources {
        if row < table.row_count() {
            return Some((table, row));
        }
        row -= table.row_count();
    }
    None
}

/// A number of a row of all files.
fn number(sources: &[Source], row: usize, column: &str) -> Option<f64> {
    let (table, row) = table_of(sources, row)?;
    table.numbers(column)?.get(row).copied().filter(|value| value.is_finite())
}

/// Where the column of a row stands, rows counted from 1 through all tables.
fn place(sources: &[Source], row: usize, column: &str) -> Option<Place> {
    let (table, row) = table_of(sources, row)?;
    table.place(row, column)
}
