//! `plan`: which configurations to measure.

mod design;

use std::path::Path;
use std::time::Instant;

use nalgebra::{Point3, Vector3};

use design::Campaigned;

use super::designed::sheet as table_of;
use super::identifiability::{reduction, what};
use super::pose::loaded_configurations;
use super::simulate::observed;
use crate::Error;
use crate::cli::args::Plan;
use crate::cli::boxes::{keep_out, space};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{known_parameters, markers, numbers, ranges, within, wrench};
use crate::description::campaign::{Campaign, Reading, WRENCH};
use crate::description::table::Sheet;
use crate::description::units::Units;
use crate::diagnostic::Diagnostic;
use crate::estimation::What;
use crate::files::{LoadedCampaign, LoadedRobot, writable_table};
use crate::math::distinct;
use crate::model::Model;
use crate::observation::{DEFLECTION, Observes, POSITION};
use crate::planning::{self, Optimality, Planned, PlanningError, Request, Sight, plan};
use crate::plausibility::misread;
use crate::render::plan as render;
use crate::results;
use crate::simulation::joint_box;

pub fn run(command: &Plan, session: &Session) -> Result<Output, Error> {
    let seed = session.seed();
    check(command)?;
    let Some(criterion) = Optimality::named(&command.criterion) else {
        let message = format!("--criterion: unknown `{}`", command.criterion);
        return Err(Error::unknown(message, &command.criterion, Optimality::NAMES));
    };
    let (scaling, tolerance) = reduction(&command.reduction)?;
    let asked = what(&command.what)?;
    let basis = Basis::read(command, session, seed)?;
    let loaded = basis.robot();
    let mut diagnostics = basis.diagnostics().to_vec();
    let (model, units) = (&loaded.model, &loaded.raw.units);
    known_parameters(model, command.reduction.hold.iter().map(String::as_str))?;
    let (measured, stated) = (basis.measured(), basis.stated());
    let length = units.length.factor();
    let tests = test_poses(command, session, loaded, &mut diagnostics)?;
    let observes = kind_of_readings(command, model, stated, asked)?;
    let differences = stated.is_some_and(Campaign::holds_differences).then_some(DEFLECTION);
    let usual = What::of(observes);
    let what = asked.unwrap_or(What { elastic: usual.elastic || differences.is_some(), ..usual });
    let loads = loads(command, units, differences.unwrap_or(observes))?;
    let (within, warnings) = ranges("--range", loaded, joint_box(model, command.share), &command.range)?;
    diagnostics.extend(warnings);
    let (tested_within, warnings) = ranges("--test-range", loaded, within.clone(), &command.test_range)?;
    diagnostics.extend(warnings);
    let request = Request {
        tested_within,
        within,
        count: command.poses,
        what,
        observes,
        markers: basis.markers(&command.markers)?,
        loads,
        repeats: command.repeats,
        sigma: stated.and_then(|m| m.sigma).map_or(command.noise * 1e-3, |sigma| sigma.into_iter().fold(0.0, f64::max)),
        sigma_orientation: stated.and_then(|m| m.sigma_orientation).unwrap_or(command.orientation_noise.to_radians()),
        estimate: stated.map_or([command.unknown_base, command.unknown_tool], |m| [m.estimate_base, m.estimate_tool]),
        criterion,
        sight: sight(command, length)?,
        workspace: command.workspace.as_deref().map(|text| space("--workspace", text, length)).transpose()?,
        apart: command.apart * length,
        tests,
        measured: measured.cloned(),
        design: basis.design().map(|own| own.design.clone()),
        hold: command.reduction.hold.iter().filter_map(|name| model.registry.slot(name)).collect(),
        scaling,
        tolerance,
        seed,
        settings: planning::Settings { prior: command.prior, ..planning::Settings::default() },
    };
    let mut output = carry_out(command, session, loaded, &request, basis.design())?;
    output.diagnostics = diagnostics;
    // A plan saves no description: what would be refused elsewhere is a doubt here.
    let judged = request.measured.as_ref().map(|measured| misread(model, measured));
    output.judged(judged.unwrap_or_default(), true)
}

/// Wrenches (N, N.m) under which is measured; deflections need one.
fn loads(command: &Plan, units: &Units, observes: Observes) -> Result<Vec<[f64; 6]>, Error> {
    if observes.is_difference() && command.wrench.is_empty() {
        let message = format!("{}s: nothing loads the robot", observes.name());
        return Err(Error::input(message, "give --wrench FX,FY,FZ,MX,MY,MZ"));
    }
    command.wrench.iter().map(|text| wrench(units, text)).collect()
}

/// Where what is planned for comes from.
enum Basis {
    /// A campaign file that says what can be read.
    Design(Box<Campaigned>),
    /// Readings of points, to which others are added.
    Readings(Box<LoadedCampaign>),
    /// A robot alone.
    Robot(Box<LoadedRobot>),
}

impl Basis {
    /// What the command names, with what the robot must not touch.
    fn read(command: &Plan, session: &Session, seed: u64) -> Result<Self, Error> {
        let mut basis = match (planned_for(command, session, seed)?, &command.add_to) {
            (Some(own), _) => Self::Design(own.into()),
            // A campaign may leave elements out.
            (None, Some(name)) => Self::Readings(session.reader.campaign(name, Some(&command.robot))?.into()),
            (None, None) => Self::Robot(session.reader.robot(&command.robot)?.into()),
        };
        let robot = match &mut basis {
            Self::Design(own) => &mut own.robot,
            Self::Readings(own) => &mut own.robot,
            Self::Robot(own) => own,
        };
        keep_out(&command.keep_out, robot)?;
        Ok(basis)
    }

    fn robot(&self) -> &LoadedRobot {
        match self {
            Self::Design(own) => &own.robot,
            Self::Readings(own) => &own.robot,
            Self::Robot(own) => own,
        }
    }

    fn diagnostics(&self) -> &[Diagnostic] {
        match self {
            Self::Design(own) => &own.diagnostics,
            Self::Readings(own) => &own.diagnostics,
            Self::Robot(own) => &own.diagnostics,
        }
    }

    fn design(&self) -> Option<&Campaigned> {
        if let Self::Design(own) = self { Some(own) } else { None }
    }

    /// The readings made already.
    fn measured(&self) -> Option<&Campaign> {
        match self {
            Self::Design(own) => own.measured.as_ref(),
            Self::Readings(own) => Some(&own.campaign),
            Self::Robot(_) => None,
        }
    }

    /// The campaign that states noise and unknowns.
    fn stated(&self) -> Option<&Campaign> {
        self.design().map(|own| &own.design.campaign).or(self.measured())
    }

    /// The markers to read: those of a campaign, unless others are named for a robot.
    fn markers(&self, named: &[String]) -> Result<Vec<Option<usize>>, Error> {
        match self {
            Self::Design(own) => Ok(used(own.design.ways.iter().flatten())),
            Self::Readings(own) if named.is_empty() => Ok(used(own.campaign.readings.iter())),
            _ => markers(&self.robot().model, named),
        }
    }
}

/// What a campaign file says of the readings to come: of the one that is to be planned for, or of the one to which is added where
/// it holds more than readings of points.
fn planned_for(command: &Plan, session: &Session, seed: u64) -> Result<Option<Campaigned>, Error> {
    let (name, robot) = match &command.add_to {
        None if !session.reader.is_campaign(&command.robot) => {
            let of_campaign = [
                ("--session", command.session.is_some()),
                ("--placement", command.placement.is_some()),
                ("--placements", command.placements.is_some()),
            ];
            return match of_campaign.into_iter().find(|(_, is_given)| *is_given) {
                Some((flag, _)) => Err(Error::input(
                    format!("{flag}, and `{}` is no campaign", command.robot),
                    format!("leave {flag} out, or give a campaign file"),
                )),
                None => Ok(None),
            };
        }
        Some(_) if session.reader.is_campaign(&command.robot) => {
            return Err(Error::input(
                format!("--add-to, and `{}` is a campaign", command.robot),
                "leave --add-to out: what is measured of a campaign counts",
            ));
        }
        None => {
            let stated = [
                ("--observes", command.observes.is_some()),
                ("--unknown-base", command.unknown_base),
                ("--unknown-tool", command.unknown_tool),
            ];
            if let Some((flag, _)) = stated.into_iter().find(|(_, is_given)| *is_given) {
                let message = format!("{flag}, and `{}` is a campaign, which says what is read", command.robot);
                return Err(Error::input(message, format!("leave {flag} out")));
            }
            (&command.robot, None)
        }
        Some(name) => (name, Some(command.robot.as_str())),
    };
    let file = session.reader.design(name, robot)?;
    let unmeasured = file.unmeasured();
    let loaded = match unmeasured.iter().any(|one| !one) || unmeasured.is_empty() {
        true if unmeasured.contains(&true) => {
            return design::partly_measured(command, &file, [Some(name), robot], session).map(Some);
        }
        true => Some(session.reader.campaign(name, robot)?),
        false => None,
    };
    // Points seen by an instrument are planned as without a campaign.
    let is_plain = |campaign: &Campaign| {
        let one = |reading: &Reading| {
            reading.observes == campaign.observes
                && !reading.observes.ignores_arrangement()
                && reading.payload.is_none()
        };
        !campaign.sessions.is_several() && !campaign.observes.touches() && campaign.readings.iter().all(one)
    };
    match &loaded {
        Some(loaded) if is_plain(&loaded.campaign) && command.add_to.is_some() && command.session.is_none() => Ok(None),
        _ => design::campaigned(command, &file, loaded, seed).map(Some),
    }
}

/// A configuration (rad and m) and the wrench (N and N.m) that loads it.
type LoadedConfiguration = (Vec<f64>, [f64; 6]);

/// Configurations at which the error after compensation counts; none where no file is given.
fn test_poses(
    command: &Plan,
    session: &Session,
    loaded: &LoadedRobot,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<Vec<LoadedConfiguration>, Error> {
    let Some(path) = &command.test else { return Ok(Vec::new()) };
    let (rows, warnings) = loaded_configurations(session, loaded, path)?;
    diagnostics.extend(warnings);
    if rows.is_empty() {
        return Err(Error::input("--test: the file has no rows", "give at least one configuration"));
    }
    Ok(rows)
}

/// Plans, and writes the configurations.
fn carry_out(
    command: &Plan,
    session: &Session,
    loaded: &LoadedRobot,
    request: &Request,
    planned_for: Option<&Campaigned>,
) -> Result<Output, Error> {
    let model = &loaded.model;
    let started = Instant::now();
    let bar = session.terminal.bar(Some(100), "{spinner} choosing configurations {bar:30} {percent} %");
    let mut planned = plan(model, request, &mut |share| bar.set_position((100.0 * share) as u64)).map_err(refused)?;
    drop(bar);
    if request.criterion == Optimality::TestError && !planned.error.is_finite() {
        return Err(Error::input(
            "these readings do not determine where the tool is: the position error after compensation is unbounded",
            "choose configurations by the parameters themselves: `--criterion D`; or add readings of lengths",
        ));
    }
    if let Some(measured) = &request.measured {
        rename(&mut planned, &measured.poses);
    }
    let result = results::Plan::new(model, request, &planned, started.elapsed().as_secs_f64());
    let assumed = planned_for.map_or("", |own| own.assumed.as_str());
    let mut output = Output::new(assumed.to_string() + &render::plan(&result, session.terminal.screen), &result)?;
    if let Some(path) = &command.table {
        let table = match planned_for {
            Some(own) => {
                let rows = design::rows(own, &planned);
                table_of(&rows).file(path, 0..rows.len())?
            }
            None => table(loaded, &planned, path)?,
        };
        output.table("configurations to measure", path, table);
    }
    Ok(output)
}

/// What a reading is: as the campaign to which readings are added says, as asked, or as suits what is to be identified.
fn kind_of_readings(
    command: &Plan,
    model: &Model,
    measured: Option<&Campaign>,
    asked: Option<What>,
) -> Result<Observes, Error> {
    match (measured, command.observes) {
        (Some(measured), _) => Ok(measured.observes),
        (None, Some(name)) => observed(model, name),
        (None, None) if asked.is_some_and(|what| what.elastic && !what.geometric) => Ok(DEFLECTION),
        (None, None) => Ok(POSITION),
    }
}

/// Markers of readings.
fn used<'a>(readings: impl Iterator<Item = &'a Reading>) -> Vec<Option<usize>> {
    distinct(readings.map(|reading| reading.marker))
}

fn point(flag: &str, text: &str) -> Result<Vector3<f64>, Error> {
    Ok(Vector3::from_column_slice(&numbers(flag, text, &[3])?))
}

/// From where reflectors are seen.
fn sight(command: &Plan, length: f64) -> Result<Option<Sight>, Error> {
    let Some(text) = &command.instrument else { return Ok(None) };
    let facing = command.facing.as_deref().map(|text| point("--facing", text)).transpose()?;
    let facing = facing.unwrap_or_else(Vector3::z);
    if facing.norm() == 0.0 {
        return Err(Error::input("--facing 0,0,0", "give a direction"));
    }
    let instrument = Point3::from(point("--instrument", text)? * length);
    Ok(Some(Sight { instrument, cone: command.cone.to_radians(), facing: facing.normalize() }))
}

/// Names that the campaign does not have, counted on from its own.
fn rename(planned: &mut Planned, known: &[String]) {
    let number = |name: &String| name.strip_prefix('p').and_then(|number| number.parse::<usize>().ok());
    let last = known.iter().filter_map(number).max().unwrap_or(0);
    for (k, name) in planned.campaign.poses.iter_mut().enumerate() {
        *name = format!("p{:03}", last.saturating_add(k + 1));
    }
}

fn check(command: &Plan) -> Result<(), Error> {
    for (flag, count) in [("--poses", command.poses), ("--repeats", command.repeats)] {
        if !(1..=1000).contains(&count) {
            return Err(Error::input(format!("{flag} {count}"), "give a number from 1 to 1000"));
        }
    }
    within("--noise", command.noise, |v| v > 0.0 && v <= 1e6, "give a number of mm above 0")?;
    within(
        "--orientation-noise",
        command.orientation_noise,
        |v| v > 0.0 && v <= 360.0,
        "give a number of deg above 0",
    )?;
    within("--share", command.share, |v| v > 0.0 && v <= 1.0, "give a number above 0, at most 1")?;
    within("--cone", command.cone, |v| v > 0.0 && v <= 180.0, "give the half opening in deg, above 0, at most 180")?;
    within("--apart", command.apart, |v| (0.0..=1e9).contains(&v), "give a distance from 0")?;
    Ok(command.table.as_deref().map_or(Ok(()), writable_table)?)
}

fn refused(error: PlanningError) -> Error {
    let remedy = match &error {
        PlanningError::TooFew { least, .. } => format!(
            "give --poses {least} or more, take tolerances for known with --prior, or hold parameters with --hold"
        ),
        PlanningError::TooFewAllowed { .. } => {
            "widen --cone, --workspace, --range or --share, move the instrument, or make what is kept out of smaller"
                .into()
        }
        PlanningError::NoTest { .. } => "widen --test-range, or give poses with --test".into(),
        PlanningError::TooNear { .. } => "lower --apart, or ask for fewer".into(),
        PlanningError::NothingSeen => "load the robot with --wrench, or plan other readings".into(),
        PlanningError::Calibration(_) => "plan for what the description can be fitted for, with --what".into(),
        PlanningError::Test { .. } => "give test poses that the robot can take".into(),
        _ => return Error::from(error),
    };
    Error::input(error.to_string(), remedy)
}

/// One row a configuration, in the description's units; loads where there are any.
fn table(loaded: &LoadedRobot, planned: &Planned, file: &Path) -> Result<Vec<u8>, Error> {
    let (units, stations) = (&loaded.raw.units, &planned.stations);
    let mut sheet = Sheet::new();
    sheet.texts("pose", |row| planned.campaign.poses[row].clone());
    for (k, variable) in loaded.model.variables.iter().enumerate() {
        sheet.column(&variable.name, move |row| format!("{:.4}", stations[row].q[k] / units.of(variable.kind())));
    }
    if stations.iter().any(|station| station.load != [0.0; 6]) {
        for (k, name) in WRENCH.into_iter().enumerate() {
            let unit = if k < 3 { units.force.factor() } else { units.torque.factor() };
            sheet.column(name, move |row| (stations[row].load[k] / unit).to_string());
        }
    }
    Ok(sheet.file(file, 0..stations.len())?)
}
