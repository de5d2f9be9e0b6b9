//! A campaign file and its tables against the model they are about.

use super::bodies;
use super::columns::{columns_of_joints, half_of_more_columns, kinds, kinds_of_file};
use super::contradictions::{contradictions, noise_of_some_readings};
use super::doubts::doubts;
use super::raw::{RawCampaign, RawEntry};
use super::read_targets::{constraints, targets};
use super::rows::RowReader;
use super::source::Source;
use super::stated::stated_noise;
use super::torques;
use super::{
    Campaign, Conditions, Constraint, NoiseOrigin, Payload, Reading, References, Sessions, Sharing, main_kind,
};

use crate::description::resolve::Locate;
use crate::description::robot::Robot;
use crate::description::table::Table;
use crate::diagnostic::Diagnostic;
use crate::math::distinct;
use crate::observation::{Kinds, Observes, POSITION};

/// Resolves a campaign: units, markers, targets, sessions, sets, conditions. `tables` are the files of its measurements with
/// what holds of each ([`RawCampaign::completed`]), `known` the kinds of readings that it may name.
///
/// # Errors
/// Every fault of the campaign file and of its tables, located.
pub fn resolve(
    raw: &RawCampaign,
    locate: Locate,
    robot: &Robot,
    known: &Kinds,
    tables: &[(RawEntry, &Table)],
) -> Result<(Campaign, Vec<Diagnostic>), Vec<Diagnostic>> {
    let mut diagnostics = Vec::new();
    let sources: Vec<Source> = tables
        .iter()
        .map(|(entry, table)| Source { table, entry, kinds: kinds_of_file(entry, table, known) })
        .collect();
    let all_kinds: Vec<Observes> = match sources.is_empty() {
        true => kinds(&raw.completed(&RawEntry::default()), known),
        false => sources.iter().flat_map(|source| source.kinds.iter().copied()).collect(),
    };
    let mut campaign = without_readings(raw, robot, &sources, &all_kinds, locate, &mut diagnostics);
    campaign.targets.extend(bodies::mounts(raw, robot, &sources));
    campaign.targets.extend(torques::sensors(raw, robot, &all_kinds));
    diagnostics.extend(torques::faults(raw, robot, &sources, locate));
    diagnostics.extend(bodies::faults(robot, &sources, locate));
    diagnostics.extend(bodies::lacking_columns(robot, &sources, locate));
    diagnostics.extend(half_of_more_columns(&sources));
    diagnostics.extend(columns_of_joints(&all_kinds, robot, locate));
    diagnostics.extend(contradictions(robot, &sources, locate));
    campaign.declared = constraints(raw, &mut campaign.targets, locate, &mut diagnostics);
    let mut rows = RowReader::new(raw, robot, locate);
    for source in &sources {
        diagnostics.extend(source.table.notes().iter().cloned());
        rows.append(source, &mut campaign, &mut diagnostics);
    }
    diagnostics.extend(rows.finish(&mut campaign, raw.order, locate));
    settle(&mut campaign);
    if !diagnostics.iter().any(Diagnostic::is_error) {
        diagnostics.extend(noise_of_some_readings(&campaign, raw, locate));
        diagnostics.extend(untouched(&campaign, locate));
    }
    diagnostics.extend(time_in_some(locate, tables));
    diagnostics.extend(unnamed_parts(&campaign, locate));
    if !diagnostics.iter().any(Diagnostic::is_error) {
        diagnostics.extend(doubts(&campaign, raw, locate, robot, &sources));
    }
    if diagnostics.iter().any(Diagnostic::is_error) { Err(diagnostics) } else { Ok((campaign, diagnostics)) }
}

/// What the campaign file says, before the rows of its tables are read.
fn without_readings(
    raw: &RawCampaign,
    robot: &Robot,
    sources: &[Source],
    kinds: &[Observes],
    locate: Locate,
    diagnostics: &mut Vec<Diagnostic>,
) -> Campaign {
    let stated = stated_noise(raw.instrument.as_ref(), &raw.units);
    let estimate = &raw.estimate;
    Campaign {
        name: raw.campaign.clone().unwrap_or_else(|| "campaign".into()),
        angle_unit: Some(raw.units.angle.factor()),
        observes: main_kind(kinds.iter().copied()).unwrap_or(POSITION),
        sigma: stated.sigma,
        noise_origin: NoiseOrigin::Stated,
        sigma_orientation: stated.orientation,
        estimate_base: estimate.base.0.is_some(),
        estimate_tool: estimate.tool.0.is_some(),
        estimate_scale: estimate.scale.0.is_some(),
        calibrate: raw.calibrate.clone().unwrap_or_default(),
        without: raw.without.clone(),
        targets: targets(raw, robot, sources, kinds, locate, diagnostics),
        constraints: Vec::new(),
        declared: Vec::new(),
        payloads: payloads(raw, robot, locate, diagnostics),
        bodies: bodies::bodies(robot, sources),
        references: References::default(),
        sessions: Sessions {
            base: estimate.base.0.unwrap_or_default(),
            tool: estimate.tool.0.unwrap_or_default(),
            scale: estimate.scale.0.unwrap_or_default(),
            names: Vec::new(),
            stations: Vec::new(),
            files: files(sources),
        },
        files: Vec::new(),
        poses: Vec::new(),
        variables: robot.variables.len(),
        joints: Vec::new(),
        readings: Vec::new(),
        conditions: Conditions::default(),
    }
}

/// Names of the files, and the first row of each.
fn files(sources: &[Source]) -> Vec<(String, usize)> {
    let mut first = 1;
    let file = |source: &Source| {
        let begins = first;
        first += source.table.row_count();
        (source.table.file().to_string(), begins)
    };
    sources.iter().map(file).collect()
}

/// The campaign's noise is that of its readings where they state it, and there is at least one session.
fn settle(campaign: &mut Campaign) {
    for names in [&mut campaign.sessions.names, &mut campaign.sessions.stations] {
        if names.is_empty() {
            names.push(String::new());
        }
    }
    campaign.constraints = Constraint::held(&campaign.declared, &campaign.targets, &campaign.readings);
    settle_noise(campaign);
    count_from_the_first(&mut campaign.conditions);
}

/// Times beyond this are those of a clock that counts from some date, s: three years.
const CLOCK: f64 = 1e8;

/// Times of a clock are counted from the first reading: rates hold from there, as those of a campaign that begins at 0.
fn count_from_the_first(conditions: &mut Conditions) {
    let Some(times) = &mut conditions.time else { return };
    let first = times.iter().copied().filter(|time| time.is_finite()).fold(f64::INFINITY, f64::min);
    if first.is_finite() && first > CLOCK {
        times.iter_mut().for_each(|time| *time -= first);
    }
}

/// The noise of a campaign is the root mean square of its readings' where all of them state it, in columns, in the entries of
/// their files, or with their distance.
fn settle_noise(campaign: &mut Campaign) {
    let of_lengths: Vec<&Reading> = campaign.readings.iter().filter(|of| of.observes.length_rows() > 0).collect();
    let is_stated = !of_lengths.is_empty() && of_lengths.iter().all(|reading| reading.noise.is_stated[0]);
    if is_stated && of_lengths.iter().any(|reading| Some(reading.noise.position) != campaign.sigma) {
        let count = of_lengths.len() as f64;
        let mean_square =
            |axis: usize| of_lengths.iter().map(|reading| reading.noise.position[axis].powi(2)).sum::<f64>() / count;
        campaign.sigma = Some(std::array::from_fn(|axis| mean_square(axis).sqrt()));
    }
    let of_angles: Vec<&Reading> = campaign.readings.iter().filter(|of| of.observes.angle_rows() > 0).collect();
    if !of_angles.is_empty() {
        let is_stated = of_angles.iter().all(|reading| reading.noise.is_stated[1]);
        let squares = of_angles.iter().map(|reading| reading.noise.orientation.powi(2)).sum::<f64>();
        let is_one = of_angles.iter().all(|reading| Some(reading.noise.orientation) == campaign.sigma_orientation);
        if !(is_stated && is_one) {
            campaign.sigma_orientation = is_stated.then(|| (squares / of_angles.len() as f64).sqrt());
        }
    }
}

/// The bodies that the tool carries: those of the description, which the campaign's of the same names replace, and its own.
fn payloads(
    raw: &RawCampaign,
    robot: &Robot,
    locate: Locate,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<(String, Payload)> {
    let own = crate::description::resolve::payloads(&raw.payloads, &raw.units, robot, locate, diagnostics);
    let is_other = |(name, _): &&(String, Payload)| own.iter().all(|(known, _)| known != name);
    for (name, described) in robot.payloads.iter().filter(|payload| !is_other(payload)) {
        if own.iter().any(|(known, payload)| known == name && payload.mass != described.mass) {
            let message = format!("payload `{name}` has another mass than in the description, and is the campaign's");
            let diagnostic = Diagnostic::warning(message).at(locate(&["payloads", name]));
            diagnostics
                .push(diagnostic.remedy("leave it out here, if the description's is right; or give it another name"));
        }
    }
    let described: Vec<(String, Payload)> = robot.payloads.iter().filter(is_other).cloned().collect();
    described.into_iter().chain(own).collect()
}

/// What is shared by session or station needs their names.
fn unnamed_parts(campaign: &Campaign, locate: Locate) -> Vec<Diagnostic> {
    let sessions = &campaign.sessions;
    let parts = [("base", sessions.base), ("tool", sessions.tool), ("scale", sessions.scale)];
    let unnamed = |(part, shared): (&str, Sharing)| {
        let what = match shared {
            Sharing::All => return None,
            Sharing::PerSession => "session",
            Sharing::PerStation => "station",
        };
        let lacks = sessions.parts(shared).iter().any(|name| name.is_empty());
        let message = format!("`{part}` is estimated per {what}, and some readings have no {what}");
        let remedy = format!("add a column `{what}`, or `{what}:` to each entry of `measurements`");
        (lacks && !campaign.readings.is_empty())
            .then(|| Diagnostic::error(message).at(locate(&["estimate", part])).remedy(remedy))
    };
    parts.into_iter().filter_map(unnamed).collect()
}

/// Contacts that no reading touches, of which a known distance or angle is declared.
fn untouched(campaign: &Campaign, locate: Locate) -> Option<Diagnostic> {
    let is_read = |target: &usize| campaign.readings.iter().any(|reading| reading.target == Some(*target));
    let idle = campaign.declared.iter().filter(|constraint| !campaign.constraints.contains(constraint));
    let targets = distinct(idle.flat_map(|constraint| constraint.targets).filter(|target| !is_read(target)));
    let first = campaign.targets.get(*targets.first()?).filter(|_| !campaign.readings.is_empty())?;
    let names: Vec<String> = targets.iter().map(|&target| format!("`{}`", campaign.targets[target].name)).collect();
    let (verb, what) = if names.len() == 1 { ("is", "it") } else { ("are", "them") };
    let message =
        format!("{} {verb} touched in no row: the distances and angles to {what} do not count", names.join(", "));
    let diagnostic = Diagnostic::warning(message).at(locate(&["contacts", &first.member.0]));
    Some(diagnostic.remedy("touch each contact in every placement, if its distances are to count there"))
}

/// Times count from one start: all tables have them, or none.
fn time_in_some(locate: Locate, tables: &[(RawEntry, &Table)]) -> Option<Diagnostic> {
    let with = tables.iter().map(|(_, table)| *table).find(|table| table.has("time"))?;
    let lacking = tables.iter().map(|(_, table)| *table).find(|table| !table.has("time"))?;
    let message = format!("`{}` has a column `time`, but `{}` has not", with.file(), lacking.file());
    let diagnostic = Diagnostic::error(message).at(locate(&["measurements"]));
    Some(diagnostic.remedy("give `time` in all files or in none"))
}
