//! A campaign from its files: the campaign itself, its robot and its measurements, every fault located.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::allowed::not_allowed;
use super::calibrated::{without_conditions, without_constants};
use super::place::{CAMPAIGNS, KEYS_OF_CAMPAIGN, Place, inside, open};
use super::reader::Reader;
use super::readings::{Asked, read};
use super::robot::{LoadedRobot, Without, find_robot, kept, read_robot};
use super::schema_line::name_schema;
use super::tables::{Files, Made, check_table_files, tables, unopened};
use crate::description::campaign::raw::{RawCampaign, RawEntry, StandsOn};
use crate::description::campaign::{self, Campaign, Configuration, References, Sharing};
use crate::description::limits::READINGS;
use crate::description::table::Table;
use crate::description::yaml::{self, Document};
use crate::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::effects::Family;
use crate::model::usually_calibrated;
use crate::noise::fill_noise;
use crate::observation::Kinds;
use crate::prediction::fill_holding_loads;

/// A campaign read from its files, with its robot.
#[derive(Debug, Clone)]
pub struct LoadedCampaign {
    /// The campaign file.
    pub raw: RawCampaign,
    /// The campaign.
    pub campaign: Campaign,
    /// Its robot.
    pub robot: LoadedRobot,
    /// Warnings, the robot's included.
    pub diagnostics: Vec<Diagnostic>,
}

impl LoadedCampaign {
    /// A warning where readings lie outside the range of those by which the robot's description was fitted.
    pub fn outside(&self) -> Option<Diagnostic> {
        let robot = &self.robot;
        let goes_with_time =
            robot.model.effects.iter().any(|own| own.entry.effect.family(&own.entry.nonlinear) == Family::Time);
        robot.raw.validity.as_ref()?.outside_of(&robot.model.variable_names(), &self.campaign, goes_with_time)
    }
}

impl Reader {
    /// Reads a campaign file or a bundled campaign, its robot (or the one given instead) and its measurements.
    ///
    /// # Errors
    /// Every fault found, located.
    pub fn campaign(&self, file: &str, robot: Option<&str>) -> Result<LoadedCampaign, Diagnostics> {
        Ok(read_campaign(self, file, robot, &[])?)
    }

    /// Whether a name given for a robot or a campaign is a campaign's: a folder with a `campaign.yaml`, a bundled campaign, or
    /// a file with a key that only campaigns have. Nothing is checked, so that a file with faults is reported as what it was meant to be.
    pub fn is_campaign(&self, file: &str) -> bool {
        let place = find_campaign(file);
        matches!(place, Place::Bundled(_))
            || Path::new(file).join("campaign.yaml").is_file()
            || place.text(self).is_ok_and(|text| {
                text.lines()
                    .any(|line| line.split_once(':').is_some_and(|(key, _)| KEYS_OF_CAMPAIGN.contains(&key.trim_end())))
            })
    }
}

/// Reads a campaign file or a bundled campaign, its robot (or the one given instead) and its measurements;
/// [`Reader::campaign`] without memory.
///
/// # Errors
/// Every fault found, located.
///
/// ```
/// let loaded = elastogeo::files::load_campaign("kr270-simulated", None)?;
/// let campaign = &loaded.campaign;
/// assert_eq!((campaign.poses.len(), campaign.readings.len()), (30, 270)); // 3 markers, 3 repeats
/// assert_eq!(campaign.configuration(0).len(), loaded.robot.model.variables.len());
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn load_campaign(file: &str, robot: Option<&str>) -> Result<LoadedCampaign, Diagnostics> {
    Reader::default().campaign(file, robot)
}

/// A campaign file as it is written, and its robot.
pub(super) struct Described {
    pub raw: RawCampaign,
    pub document: Document,
    pub place: Place,
    /// Faults and warnings of the file itself.
    pub diagnostics: Vec<Diagnostic>,
    pub robot: Result<LoadedRobot, Vec<Diagnostic>>,
}

/// Reads a campaign file and its robot, or the one given instead; no measurements.
pub(super) fn described(reader: &Reader, file: &str, robot: Option<&str>) -> Result<Described, Vec<Diagnostic>> {
    let place = find_campaign(file);
    let text = place.text(reader).map_err(|found| with_remedy(found, file))?;
    let (raw, document, mut diagnostics) = yaml::read::<RawCampaign>(&place.name(), &text);
    name_schema(&mut diagnostics, "campaign");
    if let Some(key) = key_of_robot(&document) {
        let diagnostic = Diagnostic::error("this is the description of a robot, and no campaign");
        let remedy = format!(
            "write a campaign: `robot: {}`, `observes: position`, `measurements: readings.csv`; `check` takes either",
            place.name()
        );
        return Err(vec![diagnostic.at(document.place_of_key(&[key])).remedy(remedy)]);
    }
    let Some(raw) = raw else { return Err(diagnostics) };
    let locate = |path: &[&str]| document.place_of_value(path);
    let effects: Vec<&str> = reader.catalogue.names().collect();
    let explained = |path: &[&str]| document.explains_absence(path);
    diagnostics.append(&mut campaign::faults(&raw, &effects, &reader.kinds, &locate, &explained));
    let names = raw.without.iter().enumerate().map(|(k, name)| (name.clone(), locate(&["without", &k.to_string()])));
    // Of another robot than the campaign's own only what both have is left out.
    let own =
        raw.robot.as_ref().filter(|own| robot.is_some_and(|given| given != own.as_str()) && !raw.without.is_empty());
    let own = own.and_then(|own| read_robot(reader, &find_robot(own, Some(&place)).ok()?, &Without::default()).ok());
    let without = Without { names: names.collect(), own: own.map(|own| own.raw) };
    let robot_place = match (robot, &raw.robot) {
        (Some(name), _) => find_robot(name, None),
        (None, Some(name)) => find_robot(name, Some(&place)),
        (None, None) if document.explains_absence(&["robot"]) => Err(Vec::new()),
        (None, None) => {
            Err(vec![Diagnostic::error("the campaign names no robot").remedy("add `robot:`, a bundled name or a file")])
        }
    };
    // What is not located within the robot's own file is the fault of the line that names it.
    let robot = robot_place.and_then(|place| read_robot(reader, &place, &without)).map_err(|mut reported| {
        if robot.is_none() {
            reported
                .iter_mut()
                .filter(|diagnostic| diagnostic.place.is_none())
                .for_each(|diagnostic| diagnostic.place = locate(&["robot"]));
        }
        reported
    });
    Ok(Described { raw, document, place, diagnostics, robot })
}

/// Reads a campaign; `made` has tables by the position of their entry, in the place of files.
pub(super) fn read_campaign(
    reader: &Reader,
    file: &str,
    robot: Option<&str>,
    made: &[Option<Made>],
) -> Result<LoadedCampaign, Vec<Diagnostic>> {
    let Described { raw, document, place, mut diagnostics, robot } = described(reader, file, robot)?;
    let robot = match robot {
        Ok(robot) => robot,
        Err(mut reported) => {
            diagnostics.append(&mut reported);
            check_table_files(reader, &raw, &place, &document, &mut diagnostics);
            return Err(diagnostics);
        }
    };
    let files = Files { place: &place, document: &document, made };
    let tables = tables(reader, &raw, &files, &robot, &mut diagnostics);
    let anchors_sound = !document.holds_fault(&["anchors"]);
    if !anchors_sound && diagnostics.iter().any(Diagnostic::is_error) {
        return Err(diagnostics);
    }
    let read: Vec<(RawEntry, &Table)> = tables.iter().map(|(entry, table)| (entry.clone(), table)).collect();
    let is_apart = matches!(raw.estimate.base.0, Some(Sharing::PerSession));
    let of_pose = is_apart.then(|| sessions_of_poses(&read));
    let references = references(reader, &raw, &place, &document, of_pose.as_ref(), &mut diagnostics);
    let at = document.place_of_value(&["references"]);
    let with_order = tables.iter().any(|(_, table)| table.has("order"));
    let mut loaded = resolved(&reader.kinds, raw, &document, robot, &read, diagnostics)?;
    let unnumbered = references.unnumbered().filter(|_| is_apart && !with_order);
    let doubts = references.of_another_campaign(&loaded.campaign.poses).into_iter().chain(unnumbered);
    loaded.diagnostics.extend(doubts.map(|found| found.at(at.clone())));
    loaded.campaign.references = references;
    // What is not measured does not scatter.
    if made.is_empty() {
        fill_noise(&loaded.robot.model, &mut loaded.campaign);
    }
    Ok(loaded)
}

/// A campaign of these tables; what was found before counts.
pub(super) fn resolved(
    kinds: &Kinds,
    raw: RawCampaign,
    document: &Document,
    robot: LoadedRobot,
    tables: &[(RawEntry, &Table)],
    mut diagnostics: Vec<Diagnostic>,
) -> Result<LoadedCampaign, Vec<Diagnostic>> {
    let locate = |path: &[&str]| document.place_of_value(path);
    let is_sound = !diagnostics.iter().any(Diagnostic::is_error);
    let mut campaign = kept(campaign::resolve(&raw, &locate, &robot.robot, kinds, tables), &mut diagnostics)?;
    if !is_sound {
        return Err(diagnostics);
    }
    diagnostics.extend(robot.diagnostics.iter().cloned());
    let robot = LoadedRobot { model: robot.model.arranged(&campaign), ..robot };
    if raw.calibrate.is_none() {
        campaign.calibrate = usually_calibrated(&robot.model, &campaign);
    }
    diagnostics.extend(without_constants(&raw, &robot.robot, &robot.model, &locate));
    diagnostics.extend(without_conditions(&robot.model, &campaign));
    // What cannot be assembled here is reported by the command that predicts it.
    let _ = fill_holding_loads(&robot.model, &mut campaign);
    let rows = (0..campaign.readings.len()).map(|reading| campaign.configuration(reading));
    diagnostics.extend(not_allowed(&robot.model, &raw.units, READINGS, rows, |_, _| None));
    Ok(LoadedCampaign { raw, campaign, robot, diagnostics })
}

/// A key that descriptions of robots have and campaigns have not, in a file that has none of a campaign's.
fn key_of_robot(document: &Document) -> Option<&'static str> {
    let has = |keys: &[&'static str]| keys.iter().copied().find(|key| document.has(&[key]));
    has(&["frames", "urdf", "ur_kinematics"]).filter(|_| has(KEYS_OF_CAMPAIGN).is_none())
}

/// A campaign file, the one in a folder, or a bundled campaign.
fn find_campaign(file: &str) -> Place {
    let mut path = PathBuf::from(file);
    if path.is_dir() {
        path.push("campaign.yaml");
    }
    let bundled = PathBuf::from(file).join("campaign.yaml");
    if !path.exists() && CAMPAIGNS.get_file(&bundled).is_some() { Place::Bundled(bundled) } else { Place::Disk(path) }
}

/// The diagnostics of a campaign file that could not be read, with what to give instead.
fn with_remedy(mut found: Vec<Diagnostic>, file: &str) -> Vec<Diagnostic> {
    let path = Path::new(file);
    let Some(first) = found.first_mut() else { return found };
    if path.is_dir() {
        first.remedy.get_or_insert_with(|| format!("`campaign.yaml` is sought there; {}", inside(path)));
    } else if !path.exists() && first.remedy.is_none() {
        let known: Vec<&str> = CAMPAIGNS.dirs().filter_map(|dir| dir.path().to_str()).collect();
        first.remedy = Some(match nearest(file, known.iter().copied()) {
            Some(near) => format!("did you mean the bundled campaign `{near}`?"),
            None if known.is_empty() => "give a campaign file, or its folder".into(),
            None => format!("give a campaign file, its folder, or a bundled campaign: {}", known.join(", ")),
        });
    }
    found
}

/// The fixed reflectors of a campaign.
fn references(
    reader: &Reader,
    raw: &RawCampaign,
    place: &Place,
    document: &Document,
    of_pose: Option<&HashMap<Configuration, &str>>,
    diagnostics: &mut Vec<Diagnostic>,
) -> References {
    let mut found = References::default();
    for (k, entry) in raw.references.iter().flat_map(|all| &all.0).enumerate() {
        let number = k.to_string();
        let paths = [&["references", &number, "file"][..], &["references", "file"], &["references", &number]];
        let path = paths.into_iter().find(|path| document.has(path)).unwrap_or(&["references"]);
        let entry = campaign::completed_reference(raw, entry);
        let units = entry.units(raw.units);
        let asked = Asked {
            expected: campaign::reference_columns(&units),
            variables: Vec::new(),
            units: &units,
            entry: &entry,
        };
        found.beside_base |= entry.on == Some(StandsOn::Pedestal);
        let file = place.next_to(&entry.file);
        let table = match open(reader, &file) {
            Ok(bytes) => read(&asked, vec![(file.name(), bytes)]),
            Err(diagnostic) => Err(vec![unopened(diagnostic, document.place_of_value(path))]),
        };
        match table {
            Ok(table) => found.append(&table, &units, entry.session.as_deref(), of_pose),
            Err(mut faults) => diagnostics.append(&mut faults),
        }
    }
    found
}

/// Sessions of the configurations that tables name, of those that are of one.
fn sessions_of_poses<'t>(tables: &'t [(RawEntry, &'t Table)]) -> HashMap<Configuration, &'t str> {
    let mut found: HashMap<Configuration, Option<&str>> = HashMap::new();
    for (entry, table) in tables {
        let sessions = table.texts("session");
        for row in 0..table.row_count() {
            let of_row = sessions.and_then(|all| all.get(row)).or(entry.session.as_deref());
            let Some(session) = of_row else { continue };
            for configuration in Configuration::of(table, row) {
                let known = found.entry(configuration).or_insert(Some(session));
                *known = known.filter(|known| *known == session);
            }
        }
    }
    found.into_iter().filter_map(|(configuration, session)| Some((configuration, session?))).collect()
}
