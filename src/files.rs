//! Robots and campaigns from disk or from the bundled set: the one place that opens files.

use std::path::{Path, PathBuf};

use include_dir::{Dir, include_dir};

use crate::description::campaign::raw::{OneOrMany, RawCampaign};
use crate::description::campaign::{self, Campaign};
use crate::description::raw::RawRobot;
use crate::description::resolve::resolve;
use crate::description::robot::Robot;
use crate::description::table::{Dialect, Table, read_table};
use crate::description::units::Units;
use crate::description::urdf;
use crate::description::yaml::{self, Document};
use crate::kinematics::{AssemblyError, Geometry};
use crate::model::{Model, build};
use crate::remark::{Remark, nearest};

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
        let bytes = match self {
            Self::Disk(path) => {
                let told = |error: std::io::Error| vec![Remark::error(format!("`{name}` cannot be read: {error}"))];
                let size = std::fs::metadata(path).map_err(told)?.len();
                if size > MOST_BYTES {
                    return Err(vec![Remark::error(format!(
                        "`{name}` has {size} bytes; a description has at most {MOST_BYTES}"
                    ))]);
                }
                std::fs::read(path).map_err(told)?
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
        if !Path::new(name).is_file() {
            let bundled = bundled_robots();
            let remedy = match nearest(name, bundled.iter().map(String::as_str)) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("bundled: {}; or give the path of a .yaml or .urdf file", bundled.join(", ")),
            };
            return Err(vec![Remark::error(format!("there is no bundled robot `{name}`")).remedy(remedy)]);
        }
    }
    Ok(campaign.map_or_else(|| Place::Disk(PathBuf::from(name)), |campaign| campaign.beside(name)))
}

fn load_robot_without(place: &Place, without: &[String]) -> Result<LoadedRobot, Vec<Remark>> {
    let text = place.text()?;
    if place.is_urdf() {
        let (raw, remarks) = urdf::import(&place.name(), &text)?;
        return finish(raw, None, remarks, without);
    }
    let (raw, document, mut remarks) = yaml::read::<RawRobot>(&place.name(), &text);
    let Some(mut raw) = raw else { return Err(remarks) };
    if let Some(file) = raw.urdf.take() {
        let urdf_place = place.beside(&file);
        match urdf_place.text().and_then(|text| urdf::import(&urdf_place.name(), &text)) {
            Ok((imported, mut said)) => {
                remarks.append(&mut said);
                raw = merge(imported, raw);
            }
            Err(mut said) => {
                if let Some(first) = said.first_mut()
                    && first.place.is_none()
                {
                    first.place = document.place_of_value(&["urdf"]);
                }
                remarks.append(&mut said);
                return Err(remarks);
            }
        }
    }
    finish(raw, Some(&document), remarks, without)
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
    raw: RawRobot,
    document: Option<&Document>,
    mut remarks: Vec<Remark>,
    without: &[String],
) -> Result<LoadedRobot, Vec<Remark>> {
    let locate = |path: &[&str]| document.and_then(|document| document.place_of_value(path));
    let mut raw = raw;
    for name in without {
        if let Err(remark) = leave_out(&mut raw, name) {
            remarks.push(remark);
        }
    }
    let (robot, mut said) = resolve(&raw, &locate);
    let faulty = remarks.iter().any(Remark::is_error);
    if faulty {
        // What a faulty entry would have given is missing only because of the fault, which has been told.
        said.retain(|remark| !remark.message.contains("lacks") && !remark.message.contains(" has no "));
    }
    remarks.append(&mut said);
    let Some(robot) = robot.filter(|_| !remarks.iter().any(Remark::is_error)) else { return Err(remarks) };
    let model = build(&robot).map_err(|said| remarks.iter().cloned().chain(said).collect::<Vec<_>>())?;
    if let Err(error) = Geometry::nominal(&model) {
        let path: Vec<String> = match &error {
            AssemblyError::Loop { name, .. } => vec!["loops".into(), name.split('`').next().unwrap_or_default().into()],
            AssemblyError::SliderCrank { name, .. } => vec!["actuators".into(), name.clone()],
            _ => vec!["frames".into()],
        };
        let path: Vec<&str> = path.iter().map(String::as_str).collect();
        let remark = Remark::error(error.to_string()).at(locate(&path));
        remarks.push(remark.remedy(
            "check lengths and constants of the loop, and give `branch` and `at` from a configuration that closes",
        ));
        return Err(remarks);
    }
    Ok(LoadedRobot { raw, robot, model, remarks })
}

/// Leaves a named element (spring, beam, joint stiffness `joint:2`, effect) out of a description.
fn leave_out(raw: &mut RawRobot, name: &str) -> Result<(), Remark> {
    let joint = name.strip_prefix("joint:").unwrap_or(name).to_string();
    let found = raw.springs.shift_remove(name).is_some()
        || raw.beams.shift_remove(name).is_some()
        || raw.joint_stiffness.shift_remove(&joint).is_some()
        || raw.bodies.shift_remove(name).is_some();
    let before = raw.effects.len();
    raw.effects.retain(|effect| effect.effect.as_deref() != Some(name));
    if found || raw.effects.len() < before {
        return Ok(());
    }
    let valid: Vec<&str> = raw.springs.keys().chain(raw.beams.keys()).map(String::as_str).collect();
    Err(Remark::warning(format!("`without: {name}` names nothing in the description")).suggest(name, valid))
}

/// Reads a campaign file, its robot (or the one given instead) and its measurements.
///
/// # Errors
/// Every fault found, located.
pub fn load_campaign(file: &str, robot: Option<&str>) -> Result<LoadedCampaign, Vec<Remark>> {
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
        let known: Vec<&str> = CAMPAIGNS.dirs().filter_map(|dir| dir.path().to_str()).collect();
        if let Some(first) = said.first_mut() {
            first.remedy = Some(format!("give a campaign file, or a bundled campaign: {}", known.join(", ")));
        }
        said
    })?;
    let (raw, document, mut remarks) = yaml::read::<RawCampaign>(&place.name(), &text);
    let Some(raw) = raw else { return Err(remarks) };
    let locate = |path: &[&str]| document.place_of_value(path);
    let robot_place = match (robot, &raw.robot) {
        (Some(name), _) => find_robot(name, None),
        (None, Some(name)) => find_robot(name, Some(&place)).map_err(|mut said| {
            said.iter_mut().for_each(|remark| remark.place = locate(&["robot"]));
            said
        }),
        (None, None) => Err(vec![
            Remark::error("the campaign names no robot")
                .at(locate(&["robot"]))
                .remedy("add `robot:`, a bundled name or a file"),
        ]),
    };
    let robot = robot_place.and_then(|place| load_robot_without(&place, &raw.without));
    let robot = match robot {
        Ok(robot) => robot,
        Err(mut said) => {
            remarks.append(&mut said);
            return Err(remarks);
        }
    };
    let mut tables = Vec::new();
    match read_tables(&raw, &place, &robot.robot, &locate) {
        Ok(read) => tables = read,
        Err(mut said) => remarks.append(&mut said),
    }
    if remarks.iter().any(Remark::is_error) {
        return Err(remarks);
    }
    match campaign::resolve(&raw, &locate, &robot.robot, &tables) {
        Ok((campaign, mut said)) => {
            remarks.append(&mut said);
            remarks.extend(robot.remarks.iter().cloned());
            Ok(LoadedCampaign { raw, campaign, robot, remarks })
        }
        Err(mut said) => {
            remarks.append(&mut said);
            Err(remarks)
        }
    }
}

fn read_tables(
    raw: &RawCampaign,
    place: &Place,
    robot: &Robot,
    locate: &dyn Fn(&[&str]) -> Option<crate::remark::Place>,
) -> Result<Vec<Table>, Vec<Remark>> {
    let files: Vec<&String> = match &raw.measurements {
        Some(OneOrMany::One(file)) => vec![file],
        Some(OneOrMany::Many(files)) => files.iter().collect(),
        None => Vec::new(),
    };
    if files.is_empty() {
        return Err(vec![
            Remark::error("the campaign names no measurements")
                .at(locate(&["measurements"]))
                .remedy("add `measurements: file.csv`"),
        ]);
    }
    let expected = campaign::expected_columns(raw, robot);
    let dialect = Dialect { delimiter: raw.csv.delimiter, decimal: raw.csv.decimal.unwrap_or('.') };
    let most = raw.csv.max_rows.unwrap_or(1_000_000);
    let mut tables = Vec::new();
    let mut remarks = Vec::new();
    for file in files {
        let place = place.beside(file);
        let name = place.name();
        let read = match &place {
            Place::Disk(path) => match std::fs::File::open(path) {
                Ok(open) => read_table(&name, open, &expected, &raw.columns, &raw.ignore, &dialect, most),
                Err(error) => {
                    Err(vec![Remark::error(format!("`{name}` cannot be read: {error}")).at(locate(&["measurements"]))])
                }
            },
            Place::Bundled(path) => match CAMPAIGNS.get_file(path) {
                Some(found) => {
                    read_table(&name, found.contents(), &expected, &raw.columns, &raw.ignore, &dialect, most)
                }
                None => Err(vec![Remark::error(format!("`{name}` is not bundled")).at(locate(&["measurements"]))]),
            },
        };
        match read {
            Ok(table) => tables.push(table),
            Err(mut said) => remarks.append(&mut said),
        }
    }
    if remarks.is_empty() { Ok(tables) } else { Err(remarks) }
}

/// Units in which a robot's values are spoken of.
pub fn units(robot: &LoadedRobot) -> Units {
    robot.raw.units
}

/// Writes a file whole or not at all: beside the target first, then in its place.
///
/// # Errors
/// What the system said.
pub fn write_whole(path: &Path, text: &str) -> std::io::Result<()> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    let beside = PathBuf::from(beside);
    let written = std::fs::write(&beside, text).and_then(|()| std::fs::rename(&beside, path));
    if written.is_err() {
        let _ = std::fs::remove_file(&beside);
    }
    written
}
