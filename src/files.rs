//! Robots and campaigns from disk or from the bundled set: the one place that opens files.

use std::io::Read;
use std::path::{Path, PathBuf};

use include_dir::{Dir, include_dir};

use crate::description::campaign::raw::{OneOrMany, RawCampaign};
use crate::description::campaign::{self, Campaign};
use crate::description::raw::RawRobot;
use crate::description::resolve::resolve_explained;
use crate::description::robot::Robot;
use crate::description::table::{Dialect, read_table};
use crate::description::units::Units;
use crate::description::urdf;
use crate::description::yaml::{self, Document};
use crate::kinematics::{AssemblyError, Geometry};
use crate::model::{Model, build};
use crate::remark::{Place as Location, Remark, nearest};

static ROBOTS: Dir = include_dir!("$CARGO_MANIFEST_DIR/robots");
static CAMPAIGNS: Dir = include_dir!("$CARGO_MANIFEST_DIR/campaigns");

/// A robot read from a file: its description, whole, and its model.
#[derive(Debug, Clone)]
pub struct LoadedRobot {
    /// The description in the file's units, a URDF merged in.
    pub raw: RawRobot,
    /// The resolved description.
    pub robot: Robot,
    /// The compiled model.
    pub model: Model,
    /// Warnings.
    pub remarks: Vec<Remark>,
}

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
    pub remarks: Vec<Remark>,
}

/// Most bytes of a description or campaign file.
const MOST_BYTES: u64 = 20 << 20;

/// Names of the bundled robots.
pub fn bundled_robots() -> Vec<String> {
    let mut names: Vec<String> = ROBOTS
        .files()
        .filter(|file| file.path().extension().is_some_and(|e| e == "yaml"))
        .filter_map(|file| Some(file.path().file_stem()?.to_str()?.to_string()))
        .collect();
    names.sort();
    names
}

/// Where a file's text comes from: the disk, or the bundled set.
enum Place {
    Disk(PathBuf),
    Bundled(PathBuf),
}

impl Place {
    fn name(&self) -> String {
        match self {
            Self::Disk(path) => path.display().to_string(),
            Self::Bundled(path) => format!("bundled:{}", path.display()),
        }
    }

    fn beside(&self, file: &str) -> Self {
        match self {
            Self::Disk(path) => Self::Disk(path.parent().unwrap_or(Path::new("")).join(file)),
            Self::Bundled(path) => Self::Bundled(path.parent().unwrap_or(Path::new("")).join(file)),
        }
    }

    fn text(&self) -> Result<String, Vec<Remark>> {
        let name = self.name();
        let bytes =
            match self {
                Self::Disk(path) => {
                    let told = |error: std::io::Error| vec![unreadable(path, &error)];
                    let mut bytes = Vec::new();
                    // One byte more than is allowed tells that there is more; a device has no length to ask for.
                    let file = std::fs::File::open(path).map_err(told)?;
                    let read = file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(told)?;
                    if read as u64 > MOST_BYTES {
                        return Err(vec![Remark::error(format!("`{name}` has more than {MOST_BYTES} bytes")).remedy(
                            "a description or campaign file is small; readings belong in the CSV that it names",
                        )]);
                    }
                    bytes
                }
                Self::Bundled(path) => {
                    let file = ROBOTS.get_file(path).or_else(|| CAMPAIGNS.get_file(path));
                    file.ok_or_else(|| vec![Remark::error(format!("`{name}` is not bundled"))])?.contents().to_vec()
                }
            };
        yaml::text_of(&name, &bytes).map_err(|remark| vec![remark])
    }

    fn is_urdf(&self) -> bool {
        let (Self::Disk(path) | Self::Bundled(path)) = self;
        path.extension().is_some_and(|extension| extension == "urdf" || extension == "xml")
    }
}

/// Why a file cannot be read, with the nearest file name beside it where there is none.
fn unreadable(path: &Path, error: &std::io::Error) -> Remark {
    let shown = path.display();
    if error.kind() != std::io::ErrorKind::NotFound {
        return if path.is_dir() {
            Remark::error(format!("`{shown}` is a folder, and a file is needed"))
        } else {
            Remark::error(format!("`{shown}` cannot be read: {error}"))
        };
    }
    let remark = Remark::error(format!("there is no file `{shown}`"));
    let folder = match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
        Some(parent) => parent,
        None => return remark,
    };
    if !folder.is_dir() {
        return remark.remedy(format!("there is no folder `{}` either", folder.display()));
    }
    let (Ok(entries), Some(wanted)) = (std::fs::read_dir(folder), path.file_name().and_then(|name| name.to_str()))
    else {
        return remark;
    };
    let mut names: Vec<String> =
        entries.take(10_000).flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    match nearest(wanted, names.iter().map(String::as_str)) {
        Some(near) => remark.remedy(format!("did you mean `{}`?", path.with_file_name(near).display())),
        None => remark,
    }
}

/// Reads a robot by bundled name, or from a `.yaml` or `.urdf` file.
///
/// # Errors
/// Every fault found, located.
pub fn load_robot(name: &str) -> Result<LoadedRobot, Vec<Remark>> {
    load_robot_without(&find_robot(name, None)?, &[])
}

fn find_robot(name: &str, campaign: Option<&Place>) -> Result<Place, Vec<Remark>> {
    let looks_like_file =
        name.contains(['/', '\\']) || [".yaml", ".yml", ".urdf", ".xml"].iter().any(|end| name.ends_with(end));
    if !looks_like_file {
        if bundled_robots().iter().any(|known| known == name) {
            return Ok(Place::Bundled(PathBuf::from(format!("{name}.yaml"))));
        }
        let beside = campaign.map_or_else(|| Place::Disk(PathBuf::from(name)), |campaign| campaign.beside(name));
        if !matches!(&beside, Place::Disk(path) if path.exists()) {
            let bundled = bundled_robots();
            let remedy = match nearest(name, bundled.iter().map(String::as_str)) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("bundled: {}; or give the path of a .yaml or .urdf file", bundled.join(", ")),
            };
            return Err(vec![Remark::error(format!("there is no bundled robot `{name}`")).remedy(remedy)]);
        }
        return Ok(beside);
    }
    Ok(campaign.map_or_else(|| Place::Disk(PathBuf::from(name)), |campaign| campaign.beside(name)))
}

fn load_robot_without(place: &Place, without: &[(String, Option<Location>)]) -> Result<LoadedRobot, Vec<Remark>> {
    let text = place.text()?;
    if place.is_urdf() {
        let (raw, remarks) = import(place, &text)?;
        return finish(raw, None, remarks, without);
    }
    let (raw, document, mut remarks) = yaml::read::<RawRobot>(&place.name(), &text);
    let Some(mut raw) = raw else { return Err(remarks) };
    if let Some(file) = raw.urdf.take() {
        let urdf_place = place.beside(&file);
        match urdf_place.text().and_then(|text| import(&urdf_place, &text)) {
            Ok((imported, mut said)) => {
                remarks.append(&mut said);
                raw = merge(imported, raw);
            }
            Err(mut said) => {
                let missing = said.iter_mut().filter(|remark| remark.place.is_none());
                missing.for_each(|remark| remark.place = document.place_of_value(&["urdf"]));
                remarks.append(&mut said);
                return Err(remarks);
            }
        }
    }
    finish(raw, Some(&document), remarks, without)
}

/// Reads a URDF; what concerns the whole of it is told at its start.
fn import(place: &Place, text: &str) -> Result<(RawRobot, Vec<Remark>), Vec<Remark>> {
    let name = place.name();
    urdf::import(&name, text).map_err(|mut said| {
        let unplaced = said.iter_mut().filter(|remark| remark.place.is_none());
        unplaced.for_each(|remark| remark.place = Some(Location::in_text(&name, text, 0..0)));
        said
    })
}

/// A description in YAML laid over what a URDF gave: single keys of a frame override, whole entries elsewhere.
fn merge(imported: RawRobot, over: RawRobot) -> RawRobot {
    let (length, angle) = (over.units.length.factor(), over.units.angle.factor());
    let mut merged = over.clone();
    let mut frames = imported.frames;
    for frame in frames.values_mut() {
        // From SI into the units of the file that is merged in.
        let joint_unit =
            if frame.joint == Some(crate::description::raw::JointKind::Prismatic) { length } else { angle };
        for value in [&mut frame.beta, &mut frame.gamma, &mut frame.alpha, &mut frame.theta].into_iter().flatten() {
            *value /= angle;
        }
        for value in [&mut frame.b, &mut frame.d, &mut frame.r].into_iter().flatten() {
            *value /= length;
        }
        frame.offset = frame.offset.map(|v| v / joint_unit);
        frame.limits = frame.limits.map(|limits| limits.map(|v| v / joint_unit));
    }
    for (name, given) in over.frames {
        let frame = frames.entry(name).or_default();
        macro_rules! take { ($($key:ident),*) => { $(if given.$key.is_some() { frame.$key = given.$key; })* } }
        take!(antecedent, joint, variable, direction, coaxial, beta, gamma, b, alpha, d, theta, r, offset, limits);
        frame.passive |= given.passive;
    }
    merged.frames = frames;
    merged.robot = over.robot.or(imported.robot);
    if over.tool == Default::default() {
        merged.tool = imported.tool;
        merged.tool.at = merged.tool.at.map(|at| at.map(|v| v / length));
        merged.tool.rotation = merged.tool.rotation.map(|r| r.map(|v| v / angle));
    }
    let mut couplings = imported.couplings;
    couplings.extend(over.couplings);
    merged.couplings = couplings;
    for (name, mut body) in imported.bodies {
        body.mass = body.mass.map(|mass| mass / over.units.mass.factor());
        body.com = body.com.map(|com| com.map(|v| v / length));
        merged.bodies.entry(name).or_insert(body);
    }
    merged
}

fn finish(
    mut raw: RawRobot,
    document: Option<&Document>,
    mut remarks: Vec<Remark>,
    without: &[(String, Option<Location>)],
) -> Result<LoadedRobot, Vec<Remark>> {
    let locate = |path: &[&str]| document.and_then(|document| document.place_of_value(path));
    let explained = |path: &[&str]| document.is_some_and(|document| document.explains_absence(path));
    let (robot, mut said) = resolve_explained(&raw, &locate, &explained);
    remarks.append(&mut said);
    let Some(mut robot) = robot.filter(|_| !remarks.iter().any(Remark::is_error)) else { return Err(remarks) };
    // The description was checked as it stands in its file; what is left out cannot add a fault of its own.
    let known = elements(&raw);
    let mut reduced = false;
    for (name, place) in without {
        if leave_out(&mut raw, name) {
            reduced = true;
        } else {
            let remark =
                Remark::warning(format!("`without: {name}` leaves nothing out: the robot has no such element"));
            remarks.push(remark.at(place.clone()).suggest(name, known.iter().map(String::as_str)));
        }
    }
    if reduced {
        match resolve_explained(&raw, &locate, &explained) {
            (Some(reduced), _) => robot = reduced,
            (None, mut said) => {
                remarks.append(&mut said);
                return Err(remarks);
            }
        }
    }
    let model = match build(&robot) {
        Ok(model) => model,
        Err(said) => {
            // The model tells of a loop by its name.
            let named = |remark: &Remark| {
                let rest = remark.message.strip_prefix("loop ")?;
                let name =
                    raw.loops.keys().filter(|name| rest.starts_with(name.as_str())).max_by_key(|name| name.len());
                document?.place_of_key(&["loops", name?])
            };
            let located = said.into_iter().map(|remark| match remark.place {
                Some(_) => remark,
                None => {
                    let place = named(&remark).or_else(|| document?.place_of_key(&["loops"]));
                    remark.at(place)
                }
            });
            return Err(remarks.into_iter().chain(located).collect());
        }
    };
    if let Err(error) = Geometry::nominal(&model) {
        let path: Vec<&str> = match &error {
            AssemblyError::Loop { name, .. } => {
                // Loops that close together are named together.
                let first = raw.loops.keys().filter(|known| name.starts_with(known.as_str())).max_by_key(|n| n.len());
                vec!["loops", first.unwrap_or(name)]
            }
            AssemblyError::SliderCrank { name, .. } => vec!["actuators", name],
            _ => vec!["frames"],
        };
        let remedy = match &error {
            AssemblyError::SliderCrank { .. } => {
                "check l1, l3 and `limits` of the actuator, and `at` of the loops: the triangle must close there"
            }
            _ => "check lengths and constants of the loop, and give `branch` and `at` from a configuration that closes",
        };
        remarks.push(
            Remark::error(error.to_string())
                .at(document.and_then(|document| document.place_of_key(&path)))
                .remedy(remedy),
        );
        return Err(remarks);
    }
    Ok(LoadedRobot { raw, robot, model, remarks })
}

/// Names that `without:` may hold.
fn elements(raw: &RawRobot) -> Vec<String> {
    let named = raw.springs.keys().chain(raw.beams.keys()).chain(raw.bodies.keys()).cloned();
    let joints = raw.joint_stiffness.keys().map(|joint| format!("joint:{joint}"));
    named.chain(joints).chain(raw.effects.iter().filter_map(|effect| effect.effect.clone())).collect()
}

/// Leaves a named element (spring, beam, joint stiffness `joint:2`, body, effect) out of a description, what calibration
/// says of it too. Whether there was one.
fn leave_out(raw: &mut RawRobot, name: &str) -> bool {
    let joint = name.strip_prefix("joint:").unwrap_or(name).to_string();
    let stiffness = raw.joint_stiffness.shift_remove(&joint).is_some();
    let spring = raw.springs.shift_remove(name).is_some();
    let other = raw.beams.shift_remove(name).is_some() || raw.bodies.shift_remove(name).is_some();
    let before = raw.effects.len();
    raw.effects.retain(|effect| effect.effect.as_deref() != Some(name));
    let owners: Vec<String> = [(stiffness, format!("joint{joint}")), (spring, name.to_string())]
        .into_iter()
        .filter(|o| o.0)
        .map(|o| o.1)
        .collect();
    let stays = |parameter: &str| {
        let symbols = ["ka", "kr", "kar", "krr", "stiffness"];
        parameter
            .rsplit_once('.')
            .is_none_or(|(owner, symbol)| !(symbols.contains(&symbol) && owners.iter().any(|gone| gone == owner)))
    };
    raw.calibration.free.retain(|parameter| stays(parameter));
    raw.calibration.fixed.retain(|parameter| stays(parameter));
    raw.calibration.tolerances.retain(|parameter, _| stays(parameter));
    raw.calibration.bounds.retain(|parameter, _| stays(parameter));
    stiffness || spring || other || raw.effects.len() < before
}

/// Reads a campaign file, its robot (or the one given instead) and its measurements.
///
/// # Errors
/// Every fault found, located.
pub fn load_campaign(file: &str, robot: Option<&str>) -> Result<LoadedCampaign, Vec<Remark>> {
    let path_given = Path::new(file);
    let mut path = PathBuf::from(file);
    if path.is_dir() {
        path.push("campaign.yaml");
    }
    let bundled = PathBuf::from(file).join("campaign.yaml");
    let place = if !path.exists() && CAMPAIGNS.get_file(&bundled).is_some() {
        Place::Bundled(bundled)
    } else {
        Place::Disk(path)
    };
    let text = place.text().map_err(|mut said| {
        if path_given.exists() {
            return said;
        }
        let known: Vec<&str> = CAMPAIGNS.dirs().filter_map(|dir| dir.path().to_str()).collect();
        if let Some(first) = said.first_mut()
            && first.remedy.is_none()
        {
            first.remedy = Some(match nearest(file, known.iter().copied()) {
                Some(near) => format!("did you mean the bundled campaign `{near}`?"),
                None if known.is_empty() => "give a campaign file, or its folder".into(),
                None => format!("give a campaign file, its folder, or a bundled campaign: {}", known.join(", ")),
            });
        }
        said
    })?;
    let (raw, document, mut remarks) = yaml::read::<RawCampaign>(&place.name(), &text);
    let Some(raw) = raw else { return Err(remarks) };
    let locate = |path: &[&str]| document.place_of_value(path);
    remarks.append(&mut campaign::faults(&raw, &locate, &|path| document.explains_absence(path)));
    let without: Vec<_> =
        raw.without.iter().enumerate().map(|(k, name)| (name.clone(), locate(&["without", &k.to_string()]))).collect();
    let robot_place = match (robot, &raw.robot) {
        (Some(name), _) => find_robot(name, None),
        (None, Some(name)) => find_robot(name, Some(&place)),
        (None, None) if document.explains_absence(&["robot"]) => Err(Vec::new()),
        (None, None) => {
            Err(vec![Remark::error("the campaign names no robot").remedy("add `robot:`, a bundled name or a file")])
        }
    };
    // What is not located within the robot's own file is the fault of the line that names it.
    let robot = robot_place.and_then(|place| load_robot_without(&place, &without)).map_err(|mut said| {
        if robot.is_none() {
            said.iter_mut()
                .filter(|remark| remark.place.is_none())
                .for_each(|remark| remark.place = locate(&["robot"]));
        }
        said
    });
    let robot = match robot {
        Ok(robot) => robot,
        Err(mut said) => {
            remarks.append(&mut said);
            // Columns cannot be checked without the robot's variables; that the files are there can.
            for (path, place) in table_files(&raw, &place, &document, &mut remarks) {
                if let Err(remark) = open(&place) {
                    remarks.push(remark.at(locate(&path.iter().map(String::as_str).collect::<Vec<_>>())));
                }
            }
            return Err(remarks);
        }
    };
    let mut tables = Vec::new();
    let files = table_files(&raw, &place, &document, &mut remarks);
    let expected = campaign::expected_columns(&raw, &robot.robot);
    let dialect = Dialect { delimiter: raw.csv.delimiter, decimal: raw.csv.decimal.unwrap_or('.') };
    let most = raw.csv.max_rows.unwrap_or(1_000_000);
    // With a fault in what says how the files are read, their faults would be echoes.
    let readable = ["observes", "columns", "ignore", "csv"].iter().all(|key| !document.holds_fault(&[key]));
    for (path, place) in files {
        let read = match open(&place) {
            Ok(bytes) if readable => {
                read_table(&place.name(), bytes, &expected, &raw.columns, &raw.ignore, &dialect, most)
            }
            Ok(_) => continue,
            Err(remark) => Err(vec![remark.at(locate(&path.iter().map(String::as_str).collect::<Vec<_>>()))]),
        };
        match read {
            Ok(table) => tables.push(table),
            Err(mut said) => remarks.append(&mut said),
        }
    }
    let anchors_sound = !document.holds_fault(&["anchors"]);
    if !anchors_sound && remarks.iter().any(Remark::is_error) {
        return Err(remarks);
    }
    match campaign::resolve(&raw, &locate, &robot.robot, &tables) {
        Ok((campaign, mut said)) if !remarks.iter().any(Remark::is_error) => {
            remarks.append(&mut said);
            remarks.extend(robot.remarks.iter().cloned());
            Ok(LoadedCampaign { raw, campaign, robot, remarks })
        }
        Ok((_, mut said)) | Err(mut said) => {
            remarks.append(&mut said);
            Err(remarks)
        }
    }
}

/// The files of measurements and the paths that name them; complains when there are none.
fn table_files(
    raw: &RawCampaign,
    place: &Place,
    document: &Document,
    remarks: &mut Vec<Remark>,
) -> Vec<(Vec<String>, Place)> {
    let files: Vec<(Vec<String>, Place)> = match &raw.measurements {
        Some(OneOrMany::One(file)) => vec![(vec!["measurements".into()], place.beside(file))],
        Some(OneOrMany::Many(files)) => files
            .iter()
            .enumerate()
            .map(|(k, file)| (vec!["measurements".into(), k.to_string()], place.beside(file)))
            .collect(),
        None => Vec::new(),
    };
    if files.is_empty() && !document.explains_absence(&["measurements"]) {
        remarks.push(
            Remark::error("the campaign names no measurements")
                .at(document.place_of_value(&["measurements"]))
                .remedy("add `measurements: file.csv`"),
        );
    }
    files
}

/// Opens a file of measurements.
fn open(place: &Place) -> Result<Box<dyn Read>, Remark> {
    match place {
        Place::Disk(path) if path.is_dir() => {
            Err(Remark::error(format!("`{}` is a folder, and a CSV file is needed", place.name())))
        }
        Place::Disk(path) => match std::fs::File::open(path) {
            Ok(file) => Ok(Box::new(file)),
            Err(error) => Err(unreadable(path, &error)),
        },
        Place::Bundled(path) => match CAMPAIGNS.get_file(path) {
            Some(found) => Ok(Box::new(found.contents())),
            None => Err(Remark::error(format!("`{}` is not bundled", place.name()))),
        },
    }
}

/// Units in which a robot's values are spoken of.
pub fn units(robot: &LoadedRobot) -> Units {
    robot.raw.units
}

/// Whether a file can be written there, as far as can be said without writing.
///
/// # Errors
/// Why it cannot.
pub fn writable(path: &Path) -> Result<(), Remark> {
    let shown = path.display();
    if path.is_dir() {
        return Err(Remark::error(format!("`{shown}` cannot be written: it is a folder")).remedy("give a file's name"));
    }
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            let folder = folder.display();
            Err(Remark::error(format!("`{shown}` cannot be written: there is no folder `{folder}`"))
                .remedy("make the folder, or give another"))
        }
        _ => Ok(()),
    }
}

/// Writes files, all of them whole or none at all: each beside its target first, then in its place.
///
/// # Errors
/// What the system said, and of which file.
pub fn write_whole(files: &[(&Path, &str)]) -> Result<(), String> {
    let mut beside: Vec<(PathBuf, &Path)> = Vec::new();
    let mut outcome = Ok(());
    for (path, text) in files {
        let mut part = path.as_os_str().to_owned();
        part.push(format!(".{}.part", std::process::id()));
        let part = PathBuf::from(part);
        // A device or a pipe is written as it is: nothing can be moved into its place.
        let special = std::fs::metadata(path).is_ok_and(|known| !known.is_file());
        let written = if special { std::fs::write(path, text) } else { std::fs::write(&part, text) };
        if !special {
            beside.push((part, path));
        }
        if let Err(error) = written {
            outcome = Err(format!("`{}` cannot be written: {error}", path.display()));
            break;
        }
    }
    for (part, path) in &beside {
        if outcome.is_ok()
            && let Err(error) = std::fs::rename(part, path)
        {
            outcome = Err(format!("`{}` cannot be written: {error}", path.display()));
        }
    }
    if outcome.is_err() {
        for (part, _) in &beside {
            // It may have been moved already, or never made.
            let _ = std::fs::remove_file(part);
        }
    }
    outcome
}
