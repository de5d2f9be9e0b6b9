//! `plan` for a campaign file: what it says can be read at a configuration, in a chosen session and placement, and where what it
//! leaves unknown is about.

use crate::Error;
use crate::cli::args::Plan;
use crate::cli::commands::designed::{
    Cells, Wanted, all_rows, blank, holds_differences, plain, sheet as table_of, variety,
};
use crate::cli::session::Session;
use crate::description::campaign::raw::{RawCampaign, RawEntry};
use crate::description::campaign::{Campaign, InSession, Payload, Reading, Sharing, WRENCH, names};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{RegistrationSettings, registered};
use crate::files::{Design as CampaignFile, LoadedCampaign, LoadedRobot};
use crate::model::Model;
use crate::noise::fill_noise;
use crate::observation::MOST_ROWS;
use crate::planning::{Design, Planned};
use crate::prediction::target_values;
use crate::simulation::{generator, lay_out};

/// A campaign file as it is planned for.
pub struct Campaigned {
    /// Its robot, with the parameters of the arrangement.
    pub robot: LoadedRobot,
    /// The readings made already.
    pub measured: Option<Campaign>,
    /// What can be read.
    pub design: Design,
    pub raw: RawCampaign,
    pub diagnostics: Vec<Diagnostic>,
    /// Where what is touched is assumed to be.
    pub assumed: String,
}

/// Reads what can be planned for a campaign file.
pub fn campaigned(
    command: &Plan,
    file: &CampaignFile,
    loaded: Option<crate::files::LoadedCampaign>,
    seed: u64,
) -> Result<Campaigned, Error> {
    match loaded {
        Some(loaded) => {
            let model = file.robot.model.arranged(&loaded.campaign);
            let values = model.registry.nominal();
            continued(command, file, Continued { measured: loaded.campaign.clone(), loaded, model, values })
        }
        None => begun(command, file, seed),
    }
}

/// A campaign of which something is measured.
struct Continued {
    /// What it says, with rows for what is not measured where there are files of that.
    loaded: LoadedCampaign,
    /// The readings made.
    measured: Campaign,
    /// Its robot, with the parameters of the arrangement of all.
    model: Model,
    /// Values of these from which registration starts.
    values: Vec<f64>,
}

/// A load of a deflection before the plan says which, N.
const SOME_LOAD: [f64; 6] = [0.0, 0.0, -1.0, 0.0, 0.0, 0.0];

/// What is read at each configuration of a plan for a campaign.
fn wanted<'c>(command: &'c Plan, file: &CampaignFile, raw: &RawCampaign) -> Wanted<'c> {
    Wanted {
        markers: &command.markers,
        repeats: 1,
        wrenches: if holds_differences(file, raw) { std::slice::from_ref(&SOME_LOAD) } else { &[] },
        placements: command.placements.unwrap_or(1),
        runs: &[],
        given: None,
    }
}

/// Reads what can be planned for a campaign some of whose files hold no readings yet: their sessions, kinds, contacts and payloads count
/// as those of the others.
pub fn partly_measured(
    command: &Plan,
    file: &CampaignFile,
    [name, robot]: [Option<&str>; 2],
    session: &Session,
) -> Result<Campaigned, Error> {
    let raw = plain(&file.raw);
    let wanted = wanted(command, file, &raw);
    let unmeasured = file.unmeasured();
    let middle = file.robot.model.middle();
    let own = raw.entries().into_iter().zip(&unmeasured);
    let count = own.map(|(entry, is_own)| if *is_own { variety(file, &raw, &entry, &wanted) } else { 0 });
    let configurations: Vec<Vec<Vec<f64>>> = count.map(|count| vec![middle.clone(); count]).collect();
    let mut tables = Vec::new();
    for rows in all_rows(file, &raw, &wanted, &configurations) {
        let rows: Vec<Cells> = rows.into_iter().map(|row| as_evaluated(&file.raw, &file.robot.model, row)).collect();
        tables.push(table_of(&rows).csv(0..rows.len())?);
    }
    let mut loaded = file.continued(&session.reader, [name, robot], &raw, tables)?;
    loaded.diagnostics.retain(|diagnostic| diagnostic.code != Code::SuspectReadings);
    let is_made = |reading: &Reading| {
        let index = loaded.campaign.files.iter().position(|(_, end)| reading.row <= *end);
        index.and_then(|index| unmeasured.get(index)).is_some_and(|is_own| !is_own)
    };
    let mut measured = loaded.campaign.select(|_, reading| is_made(reading));
    fill_noise(&file.robot.model, &mut measured);
    if measured.noise_origin != loaded.campaign.noise_origin {
        loaded.campaign.state_noise(measured.sigma, measured.sigma_orientation);
        loaded.campaign.noise_origin = measured.noise_origin;
    }
    let model = file.robot.model.arranged(&loaded.campaign);
    let mut values = model.registry.nominal();
    let is_read = |target: usize| measured.readings.iter().any(|reading| reading.target == Some(target));
    let mut laid = values.clone();
    lay_out(&model, &loaded.campaign, true, &mut laid, &mut generator(session.seed()))?;
    let unread = (0..loaded.campaign.targets.len()).filter(|target| !is_read(*target));
    let parameters = unread.flat_map(|target| &loaded.campaign.targets[target].values);
    for slot in parameters.filter_map(|value| model.registry.slot(value.parameter.as_ref()?)) {
        values[slot] = laid[slot];
    }
    let entries = file.raw.measurements.iter().flat_map(|all| &all.0).zip(&unmeasured);
    let names: Vec<&str> = entries.filter(|(_, own)| **own).map(|(entry, _)| entry.file.as_str()).collect();
    let mut found = continued(command, file, Continued { loaded, measured, model, values })?;
    found.assumed.insert_str(0, &format!("nothing is measured yet of {}\n", names.join(", ")));
    Ok(found)
}

/// A row of a table whose joints stand in the columns at which the campaign is evaluated, and whose pose is none of those measured.
fn as_evaluated(raw: &RawCampaign, model: &Model, row: Cells) -> Cells {
    let prefix = raw.joints.map(|source| source.prefix());
    let named = |(name, cell): (String, String)| match prefix {
        Some(prefix) if model.variables.iter().any(|variable| variable.name == name) => {
            (format!("{prefix}.{name}"), cell)
        }
        _ if name == "pose" => (name, format!("to be measured {cell}")),
        _ => (name, cell),
    };
    row.into_iter().map(named).collect()
}

/// Nothing is measured yet: what is unknown stands where the file says that it is about, or where there is room for it.
fn begun(command: &Plan, file: &CampaignFile, seed: u64) -> Result<Campaigned, Error> {
    if let Some(name) = command.session.as_ref().or(command.placement.as_ref()) {
        return Err(Error::input(
            format!("`{name}`: nothing is measured yet"),
            "leave --session and --placement out; --placements says how often a fixture is put down",
        ));
    }
    let raw = plain(&file.raw);
    let wanted = wanted(command, file, &raw);
    let entries = raw.entries();
    let middle = file.robot.model.middle();
    let configurations: Vec<Vec<Vec<f64>>> =
        entries.iter().map(|entry| vec![middle.clone(); variety(file, &raw, entry, &wanted)]).collect();
    let loaded = blank(file, raw.clone(), &wanted, &configurations)?;
    let (model, campaign) = (&loaded.robot.model, loaded.campaign);
    let mut values = model.registry.nominal();
    lay_out(model, &campaign, true, &mut values, &mut generator(seed))?;
    let ways = ways(&campaign, |_| true);
    let assumed = places(model, &campaign, &values, &file.robot);
    let files = files_of(&file.raw, &campaign, &ways);
    let design = Design { ways, files, campaign, values };
    Ok(Campaigned { robot: loaded.robot, measured: None, design, raw, diagnostics: loaded.diagnostics, assumed })
}

/// Readings are added to those of the file, in the session and the placement asked for, else in the last.
fn continued(command: &Plan, file: &CampaignFile, own: Continued) -> Result<Campaigned, Error> {
    let Continued { loaded, mut measured, mut model, mut values } = own;
    let mut campaign = loaded.campaign;
    let known = campaign.sessions.names.len();
    let (last, session) = sessions(command, &mut campaign.sessions.names, &measured)?;
    if campaign.sessions.names.len() > known {
        let nominal = file.robot.model.arranged(&campaign);
        values = nominal.nominal_at(&model, &values);
        model = nominal;
        measured.sessions = campaign.sessions.clone();
    }
    let settings = RegistrationSettings::default();
    (values, _) = registered(&model, &measured, &values, &settings)?;
    let is_read = measured.readings.iter().any(|reading| reading.session.session == session);
    if !is_read {
        begin(&model, &campaign, [last, session], &mut values);
    }
    let placement = placement(command, &campaign)?;
    let from = if session < known { session } else { last };
    let is_own = |reading: &Reading| {
        let member = campaign.target_of(reading).and_then(|target| target.member.1.as_ref());
        let is_there = member.is_none_or(|[_, member]| Some(member) == placement.as_ref());
        reading.session.session == from && (is_there || reading.observes.target_column().is_none())
    };
    let mut ways = ways(&campaign, is_own);
    if ways.is_empty() {
        return Err(Error::input(
            "no reading is of this session and placement",
            "name others with --session and --placement, or touch the fixture there a few times first",
        ));
    }
    ways.iter_mut().flatten().for_each(|reading| reading.session.session = session);
    ways.extend(not_yet_carried(&file.raw, &campaign, &ways));
    let robot = LoadedRobot { model, ..loaded.robot };
    let mut assumed = String::new();
    if campaign.sessions.is_several() {
        assumed += &format!("planned for session {}\n", campaign.sessions.names[session]);
    }
    if let Some(placement) = placement {
        assumed += &format!("planned for placement {placement}\n");
    }
    let files = files_of(&file.raw, &campaign, &ways);
    let design = Design { ways, files, values, campaign };
    Ok(Campaigned {
        robot,
        measured: Some(measured),
        design,
        raw: file.raw.clone(),
        diagnostics: loaded.diagnostics,
        assumed,
    })
}

/// The file to which each reading of each way belongs, as the campaign names it: that of its row, or for a session that has files of its
/// own one of those. Nothing where there is one file.
fn files_of(raw: &RawCampaign, campaign: &Campaign, ways: &[Vec<Reading>]) -> Vec<Vec<Option<String>>> {
    let entries = raw.measurements.as_ref().map_or(&[][..], |all| &all.0);
    let of = |reading: &Reading| {
        let entry = entries.get(campaign.files.iter().position(|(_, end)| reading.row <= *end)?)?;
        let session = campaign.sessions.names.get(reading.session.session)?;
        let is_of_session = |entry: &RawEntry| entry.session.as_ref().is_none_or(|own| own == session);
        let alike =
            || entries.iter().find(|other| other.session.as_ref() == Some(session) && other.observes == entry.observes);
        let entry = if is_of_session(entry) { Some(entry) } else { alike() };
        entry.filter(|_| entries.len() > 1).map(|entry| entry.file.clone())
    };
    ways.iter().map(|way| way.iter().map(of).collect()).collect()
}

/// The last session of the readings and the one that is planned for, which may be a new one, by index: the one asked for, else the first
/// of which nothing is measured yet, else the last.
fn sessions(command: &Plan, names: &mut Vec<String>, measured: &Campaign) -> Result<(usize, usize), Error> {
    let is_read = |session: usize| measured.readings.iter().any(|reading| reading.session.session == session);
    if let (true, Some(name)) = (names.iter().all(String::is_empty), &command.session) {
        return Err(Error::input(
            format!("--session {name}: the readings name no sessions"),
            "leave --session out, or name the session of the readings in a column `session`",
        ));
    }
    let last = (0..names.len()).rev().find(|session| is_read(*session)).unwrap_or_default();
    let session = match &command.session {
        None => (0..names.len()).find(|session| !is_read(*session)).unwrap_or(last),
        Some(name) => names.iter().position(|known| known == name).unwrap_or_else(|| {
            names.push(name.clone());
            names.len() - 1
        }),
    };
    Ok((last, session))
}

/// A new session begins about where the last one ended.
fn begin(model: &Model, campaign: &Campaign, sessions: [usize; 2], values: &mut [f64]) {
    let [from, to] = sessions.map(|session| InSession { session, station: 0 });
    let of_tool = 6 + 3 * model.markers.len();
    for (shared, count, [from, to]) in [
        (campaign.sessions.base, 6, [model.base_slot(from), model.base_slot(to)]),
        (campaign.sessions.tool, of_tool, [model.tool_slot(from), model.tool_slot(to)]),
    ] {
        if shared == Sharing::PerSession {
            values.copy_within(from..from + count, to);
        }
    }
}

/// The placement of fixtures that is planned for: the one asked for, else the last of the readings, if they have any.
fn placement(command: &Plan, campaign: &Campaign) -> Result<Option<String>, Error> {
    let members =
        campaign.targets.iter().filter_map(|target| target.member.1.as_ref().map(|[_, member]| member.as_str()));
    let members: Vec<&str> = members.collect();
    match &command.placement {
        Some(name) if !members.contains(&name.as_str()) => {
            let message = format!("--placement `{name}`: the readings have no such placement");
            Err(Error::unknown(message, name, members.iter().copied()))
        }
        Some(name) => Ok(Some(name.clone())),
        None => Ok(members.last().map(ToString::to_string)),
    }
}

/// What is read together at one configuration: of the configurations whose readings are all as asked, each set once, without
/// those that are part of another.
fn ways(campaign: &Campaign, is_own: impl Fn(&Reading) -> bool) -> Vec<Vec<Reading>> {
    type Key = (&'static str, Option<usize>, Option<usize>, InSession);
    let key = |reading: &Reading| -> Key { (reading.observes.name(), reading.marker, reading.target, reading.session) };
    let mut all: Vec<Vec<Reading>> = Vec::new();
    for pose in 0..campaign.poses.len() {
        let mut way: Vec<Reading> = Vec::new();
        for reading in campaign.readings.iter().filter(|reading| reading.pose == pose && is_own(reading)) {
            if way.iter().all(|known| key(known) != key(reading) || known.payload != reading.payload) {
                way.push(Reading { measured: [0.0; MOST_ROWS], check: None, line: 0, ..*reading });
            }
        }
        way.sort_by_key(key);
        let has = |way: &[Reading], one: &Reading| {
            way.iter().any(|known| key(known) == key(one) && known.payload == one.payload)
        };
        let is_within = |part: &[Reading], whole: &[Reading]| part.iter().all(|one| has(whole, one));
        if way.is_empty() || all.iter().any(|known| is_within(&way, known)) {
            continue;
        }
        all.retain(|known| !is_within(known, &way));
        all.push(way);
    }
    all
}

/// The same with each payload that the campaign file declares and no row carries; a file may say of all its rows what they carry.
fn not_yet_carried(raw: &RawCampaign, campaign: &Campaign, ways: &[Vec<Reading>]) -> Vec<Vec<Reading>> {
    let entries = raw.measurements.as_ref().map_or(&[][..], |all| &all.0);
    let is_open = |reading: &Reading| {
        let entry = campaign.files.iter().position(|(_, end)| reading.row <= *end).and_then(|k| entries.get(k));
        entry.is_some_and(|entry| entry.payload.is_none())
    };
    let is_new = |(name, payload): &&(String, Payload)| {
        raw.payloads.contains_key(name) && campaign.readings.iter().all(|reading| reading.payload != Some(*payload))
    };
    let open: Vec<&Vec<Reading>> = ways.iter().filter(|way| way.iter().all(is_open)).collect();
    let mut more: Vec<Vec<Reading>> = Vec::new();
    for (_, payload) in campaign.payloads.iter().filter(is_new) {
        for way in &open {
            let own: Vec<Reading> = way.iter().map(|reading| Reading { payload: Some(*payload), ..*reading }).collect();
            // Of ways that differ by what they carry alone one is enough.
            if !more.contains(&own) {
                more.push(own);
            }
        }
    }
    more
}

/// Where fixtures and anchors of unknown place are assumed to be, in the robot's units.
fn places(model: &Model, campaign: &Campaign, values: &[f64], robot: &LoadedRobot) -> String {
    let length = robot.raw.units.length;
    let mut assumed = String::new();
    for (index, target) in campaign.targets.iter().enumerate().filter(|(_, target)| target.is_estimated()) {
        if !target.is_anchor() && !target.is_contact() {
            continue;
        }
        let own = target_values(model, campaign, index, values);
        let numbers: Vec<String> = target
            .values
            .iter()
            .zip(own)
            .map(|(value, own)| match value.kind {
                crate::parameter::Kind::Length => format!("{:.4}", own / length.factor()).trim_end_matches('0').into(),
                _ => format!("{own:.3}"),
            })
            .collect();
        assumed += &format!("{} is assumed at {} {}\n", target.name, numbers.join(", "), length.symbol());
    }
    assumed
}

/// Cells of the rows of the campaign's file for each station: its names, and its joints in the campaign's units. What a row cannot
/// name together, as two anchors, has a row each.
pub fn rows(campaigned: &Campaigned, planned: &Planned) -> Vec<Cells> {
    let (campaign, model, units) = (&campaigned.design.campaign, &campaigned.robot.model, campaigned.raw.units);
    let all = || campaigned.design.ways.iter().flatten().map(|reading| reading.observes.is_difference());
    let is_mixed = all().any(|is| is) && all().any(|is| !is);
    let is_loaded = planned.stations.iter().any(|station| station.load != [0.0; 6]);
    let rows = |(k, station): (usize, &crate::planning::Station)| {
        let mut cells = Cells::from([("pose".to_string(), planned.campaign.poses[k].clone())]);
        for (variable, q) in model.variables.iter().zip(&station.q) {
            cells.insert(variable.name.clone(), format!("{:.4}", q / units.of(variable.kind())));
        }
        let mut named: Vec<Cells> = Vec::new();
        let files = campaigned.design.files[station.way].iter();
        for (reading, file) in campaigned.design.ways[station.way].iter().zip(files) {
            let mut own = names(campaign, std::slice::from_ref(reading));
            if is_loaded {
                let load = if is_mixed && !reading.observes.is_difference() { [0.0; 6] } else { station.load };
                let unit = |k: usize| if k < 3 { units.force.factor() } else { units.torque.factor() };
                own.extend(
                    WRENCH
                        .into_iter()
                        .zip(load)
                        .enumerate()
                        .map(|(k, (name, v))| (name.into(), (v / unit(k)).to_string())),
                );
            }
            own.extend(file.iter().map(|file| ("file".to_owned(), file.clone())));
            let agrees = |row: &Cells| own.iter().all(|(name, value)| row.get(name).is_none_or(|known| known == value));
            match named.iter_mut().find(|row| agrees(row)) {
                Some(row) => row.extend(own),
                None => named.push(own),
            }
        }
        named
            .into_iter()
            .map(|own| cells.iter().map(|(a, b)| (a.clone(), b.clone())).chain(own).collect::<Cells>())
            .collect::<Vec<_>>()
    };
    planned.stations.iter().enumerate().flat_map(rows).collect()
}
