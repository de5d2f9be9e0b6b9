//! `plan` for a campaign file: what it says can be read at a configuration, in a chosen session and placement, and where what it
//! leaves unknown is about.

use crate::Error;
use crate::cli::args::Plan;
use crate::cli::commands::designed::{Cells, Wanted, blank, plain, variety};
use crate::description::campaign::raw::RawCampaign;
use crate::description::campaign::{Campaign, InSession, Reading, Sharing, names};
use crate::diagnostic::Diagnostic;
use crate::estimation::{RegistrationSettings, registered};
use crate::files::{Design as CampaignFile, LoadedRobot};
use crate::model::Model;
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
        Some(loaded) => continued(command, file, loaded),
        None => begun(command, file, seed),
    }
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
    let wanted = Wanted {
        markers: &command.markers,
        repeats: 1,
        wrenches: &[],
        placements: command.placements.unwrap_or(1),
        runs: &[],
        given: None,
    };
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
    let design = Design { ways, campaign, values };
    Ok(Campaigned { robot: loaded.robot, measured: None, design, raw, diagnostics: loaded.diagnostics, assumed })
}

/// Readings are added to those of the file, in the session and the placement asked for, else in the last.
fn continued(command: &Plan, file: &CampaignFile, loaded: crate::files::LoadedCampaign) -> Result<Campaigned, Error> {
    let mut campaign = loaded.campaign;
    let (last, session) = sessions(command, &mut campaign.sessions.names)?;
    let is_new = session > last;
    let arranged = file.robot.model.arranged(&campaign);
    let settings = RegistrationSettings::default();
    let (mut values, _) = registered(&arranged, &campaign, &arranged.registry.nominal(), &settings)?;
    if is_new {
        begin(&arranged, &campaign, [last, session], &mut values);
    }
    let placement = placement(command, &campaign)?;
    let from = if is_new { last } else { session };
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
    let robot = LoadedRobot { model: arranged, ..loaded.robot };
    let mut assumed = String::new();
    if campaign.sessions.is_several() {
        assumed += &format!("planned for session {}\n", campaign.sessions.names[session]);
    }
    if let Some(placement) = placement {
        assumed += &format!("planned for placement {placement}\n");
    }
    let design = Design { ways, values, campaign: campaign.clone() };
    Ok(Campaigned {
        robot,
        measured: Some(campaign),
        design,
        raw: file.raw.clone(),
        diagnostics: loaded.diagnostics,
        assumed,
    })
}

/// The last session of the readings and the one that is planned for, which may be a new one, by index.
fn sessions(command: &Plan, names: &mut Vec<String>) -> Result<(usize, usize), Error> {
    if let (true, Some(name)) = (names.iter().all(String::is_empty), &command.session) {
        return Err(Error::input(
            format!("--session {name}: the readings name no sessions"),
            "leave --session out, or name the session of the readings in a column `session`",
        ));
    }
    let last = names.len().saturating_sub(1);
    let session = match &command.session {
        None => last,
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
    let rows = |(k, station): (usize, &crate::planning::Station)| {
        let mut cells = Cells::from([("pose".to_string(), planned.campaign.poses[k].clone())]);
        for (variable, q) in model.variables.iter().zip(&station.q) {
            cells.insert(variable.name.clone(), format!("{:.4}", q / units.of(variable.kind())));
        }
        let mut named: Vec<Cells> = Vec::new();
        for reading in &campaigned.design.ways[station.way] {
            let own = names(campaign, std::slice::from_ref(reading));
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
