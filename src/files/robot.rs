//! A robot from its file: read, resolved, compiled and put together once, every fault located.

use std::path::{Path, PathBuf};

use super::change::{elements, leave_out};
use super::place::{KEYS_OF_CAMPAIGN, Place, bundled_robots};
use super::reader::Reader;
use super::schema_line::name_schema;
use super::start::{whole_urdf, with_ur_kinematics, with_urdf};
use crate::description::convention::{declared_path, khalil_kleinfinger};
use crate::description::raw::{Convention, JointKind, RawFuzzy, RawRobot};
use crate::description::resolve::{doubtful_sizes, doubtful_urdf, resolve_explained};
use crate::description::robot::{FrameIndex, Robot};
use crate::description::ur_kinematics::{self, is_ur_kinematics};
use crate::description::validity::State;
use crate::description::yaml::{self, Document};
use crate::diagnostic::{Diagnostic, Diagnostics, Place as Location, nearest};
use crate::kinematics::{AssemblyError, Gap, Geometry, Placements};
use crate::math::wrapped;
use crate::model::{Fault, Model, build, contradictions};
use crate::prediction::FittedUncertainty;

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
    pub diagnostics: Vec<Diagnostic>,
}

impl LoadedRobot {
    /// How certain predicted positions are, where the description says how its parameters were fitted.
    pub fn uncertainty(&self) -> Option<FittedUncertainty> {
        self.raw.calibration.fit.as_ref().map(|fit| FittedUncertainty::new(&self.model, fit))
    }

    /// A warning where a state lies outside the range of the readings by which the description was fitted.
    pub fn outside<'a>(&self, states: impl Iterator<Item = State<'a>>) -> Option<Diagnostic> {
        self.raw.validity.as_ref()?.outside(&self.model.variable_names(), states)
    }
}

impl Reader {
    /// Reads a robot by bundled name, or from a `.yaml` or `.urdf` file.
    ///
    /// # Errors
    /// Every fault found, located.
    pub fn robot(&self, name: &str) -> Result<LoadedRobot, Diagnostics> {
        self.robot_leaving_out(name, &[])
    }

    /// Reads a robot with named elements left out, as a campaign's `without` does.
    ///
    /// # Errors
    /// Every fault found, located.
    ///
    /// ```
    /// let reader = elastogeo::files::Reader::default();
    /// let whole = reader.robot("kuka-kr270")?.model;
    /// let without = reader.robot_leaving_out("kuka-kr270", &["compensator"])?.model;
    /// assert!(without.registry.all().len() < whole.registry.all().len());
    /// # Ok::<(), elastogeo::Error>(())
    /// ```
    pub fn robot_leaving_out(&self, name: &str, without: &[&str]) -> Result<LoadedRobot, Diagnostics> {
        let names = without.iter().map(|name| ((*name).to_string(), None)).collect();
        Ok(read_robot(self, &find_robot(name, None)?, &Without { names, own: None })?)
    }

    /// Reads a description from its text, as if it stood at `path`: a URDF or rules that it names are sought next to that.
    ///
    /// # Errors
    /// Every fault found, located.
    ///
    /// ```
    /// use std::path::Path;
    ///
    /// let text = "
    /// units: {length: mm, angle: deg}
    /// frames:
    ///   1: {antecedent: 0, joint: revolute, variable: q1}
    ///   E: {antecedent: 1, d: 400}
    /// tool: {frame: E}
    /// ";
    /// let robot = elastogeo::files::Reader::default().robot_text(Path::new("arm.yaml"), text)?;
    /// let length = robot.model.registry.slot("E.d").map(|slot| robot.model.registry[slot].nominal);
    /// assert_eq!(length, Some(0.4)); // m
    /// # Ok::<(), elastogeo::Error>(())
    /// ```
    pub fn robot_text(&self, path: &Path, text: &str) -> Result<LoadedRobot, Diagnostics> {
        Ok(from_yaml(self, &Place::Disk(path.into()), text, &Without::default())?)
    }
}

/// Reads a robot by bundled name, or from a `.yaml` or `.urdf` file; [`Reader::robot`] without memory.
///
/// # Errors
/// Every fault found, located.
///
/// ```
/// let robot = elastogeo::files::load_robot("kuka-ir663")?;
/// let names: Vec<&str> = robot.model.variables.iter().map(|variable| variable.name.as_str()).collect();
/// assert_eq!(names, ["q1", "stroke2", "stroke8", "q4", "q5", "q7"]);
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn load_robot(name: &str) -> Result<LoadedRobot, Diagnostics> {
    Reader::default().robot(name)
}

pub(super) fn find_robot(name: &str, campaign: Option<&Place>) -> Result<Place, Vec<Diagnostic>> {
    let looks_like_file = name.contains(['/', '\\'])
        || [".yaml", ".yml", ".urdf", ".xml", ".xacro"].iter().any(|end| name.ends_with(end));
    if !looks_like_file {
        if bundled_robots().iter().any(|known| known == name) {
            return Ok(Place::Bundled(PathBuf::from(format!("{name}.yaml"))));
        }
        let nearby = campaign.map_or_else(|| Place::Disk(PathBuf::from(name)), |campaign| campaign.next_to(name));
        if !matches!(&nearby, Place::Disk(path) if path.exists()) {
            let bundled = bundled_robots();
            let remedy = match nearest(name, bundled.iter().map(String::as_str)) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("bundled: {}; or give the path of a .yaml or .urdf file", bundled.join(", ")),
            };
            return Err(vec![Diagnostic::error(format!("there is no bundled robot `{name}`")).remedy(remedy)]);
        }
        return Ok(nearby);
    }
    Ok(campaign.map_or_else(|| Place::Disk(PathBuf::from(name)), |campaign| campaign.next_to(name)))
}

/// What a campaign leaves out.
#[derive(Debug, Default)]
pub(super) struct Without {
    /// Names, and where they stand.
    pub names: Vec<(String, Option<Location>)>,
    /// The campaign's own robot where another one is read. What only the own one has need not be left out of the other, and
    /// an effect that was diagnosed and is not the own one's stays in.
    pub own: Option<RawRobot>,
}

pub(super) fn read_robot(reader: &Reader, place: &Place, without: &Without) -> Result<LoadedRobot, Vec<Diagnostic>> {
    let text = place.text(reader)?;
    if place.is_urdf() {
        let (raw, diagnostics) = whole_urdf(place, &text)?;
        return finish(raw, &Located { document: None, rules: None, declared: None }, diagnostics, without, reader);
    }
    if is_ur_kinematics(&text) {
        let (raw, diagnostics) = ur_kinematics::read(&place.name(), &text)?;
        return finish(raw, &Located { document: None, rules: None, declared: None }, diagnostics, without, reader);
    }
    from_yaml(reader, place, &text, without)
}

fn from_yaml(reader: &Reader, place: &Place, text: &str, without: &Without) -> Result<LoadedRobot, Vec<Diagnostic>> {
    let (raw, document, mut diagnostics) = yaml::read::<RawRobot>(&place.name(), text);
    name_schema(&mut diagnostics, "robot");
    let has = |key: &&&str| document.has(&[key]);
    if let Some(key) = KEYS_OF_CAMPAIGN.iter().find(has).filter(|_| !document.has(&["frames"])) {
        let diagnostic = Diagnostic::error("this is a campaign, and no description of a robot");
        let remedy = "give the description that it names under `robot:`";
        return Err(vec![diagnostic.at(document.place_of_key(&[key])).remedy(remedy)]);
    }
    let Some(mut raw) = raw else { return Err(diagnostics) };
    for start in [with_ur_kinematics, with_urdf] {
        raw = kept(start(reader, place, raw, &document), &mut diagnostics)?;
    }
    let rules = kept(rules(reader, place, &mut raw, &document), &mut diagnostics)?;
    let (locate, explained) =
        (|path: &[&str]| document.place_of_value(path), |path: &[&str]| document.explains_absence(path));
    let (written, faults) = khalil_kleinfinger(&raw, &locate, &explained);
    diagnostics.extend(faults);
    let located = Located { document: Some(&document), rules: rules.as_ref(), declared: Some(&raw) };
    finish(written, &located, diagnostics, without, reader)
}

/// What was read, what is reported of it kept behind what was; all of that as the error where nothing was.
pub(super) fn kept<T>(
    read: Result<(T, Vec<Diagnostic>), Vec<Diagnostic>>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<T, Vec<Diagnostic>> {
    let (found, reported) = read.map_or_else(|reported| (None, reported), |(found, reported)| (Some(found), reported));
    diagnostics.extend(reported);
    found.ok_or_else(|| std::mem::take(diagnostics))
}

/// Puts the rules of the file that `fuzzy` names in its place; the file's text, if there is one, and what is reported of it.
fn rules(
    reader: &Reader,
    place: &Place,
    raw: &mut RawRobot,
    document: &Document,
) -> Result<(Option<Document>, Vec<Diagnostic>), Vec<Diagnostic>> {
    let Some(given) = &mut raw.fuzzy else { return Ok((None, Vec::new())) };
    let Some(file) = given.file.take() else { return Ok((None, Vec::new())) };
    let here = || document.place_of_value(&["fuzzy", "file"]);
    if *given != RawFuzzy::default() {
        let diagnostic = Diagnostic::error("`fuzzy` names a file and has other keys").at(here());
        return Err(vec![diagnostic.remedy("put all of it into the file, or leave `file` out")]);
    }
    let text = place.next_to(&file);
    let name = text.name();
    let text = text.text(reader).map_err(|reported| {
        reported
            .into_iter()
            .map(|diagnostic| if diagnostic.place.is_none() { diagnostic.at(here()) } else { diagnostic })
            .collect::<Vec<_>>()
    })?;
    let (found, rules, mut reported) = yaml::read::<RawFuzzy>(&name, &text);
    name_schema(&mut reported, "rules");
    let Some(found) = found else { return Err(reported) };
    if found.file.is_some() {
        let diagnostic = Diagnostic::error("a file of rules cannot name another").at(rules.place_of_key(&["file"]));
        reported.push(diagnostic.remedy("name that one in the description"));
        return Err(reported);
    }
    *given = found;
    Ok((Some(rules), reported))
}

/// Texts that a description was read from.
struct Located<'a> {
    document: Option<&'a Document>,
    /// That of `fuzzy`, where it is a file of its own.
    rules: Option<&'a Document>,
    /// The description as declared, where that is not as Khalil and Kleinfinger write it.
    declared: Option<&'a RawRobot>,
}

impl<'a> Located<'a> {
    /// The text in which a path stands, and the path there.
    fn text<'b, 'c>(&self, path: &'b [&'c str]) -> Option<(&'a Document, &'b [&'c str])> {
        match (self.rules, path) {
            (Some(rules), ["fuzzy", inner @ ..]) => Some((rules, inner)),
            _ => Some((self.document?, path)),
        }
    }

    /// The path as the description declares it.
    fn declared<'p>(&'p self, path: &[&'p str]) -> Vec<&'p str> {
        let Some(declared) = self.declared else { return path.to_vec() };
        let frame = path.get(1).and_then(|name| declared.frames.get(*name));
        let convention = declared.convention.unwrap_or(Convention::KhalilKleinfinger);
        declared_path(convention, path, frame.and_then(|frame| frame.antecedent.as_deref()))
    }

    fn value(&self, path: &[&str]) -> Option<Location> {
        self.text(&self.declared(path)).and_then(|(text, path)| text.place_of_value(path))
    }

    fn key(&self, path: &[&str]) -> Option<Location> {
        self.text(&self.declared(path)).and_then(|(text, path)| text.place_of_key(path))
    }

    /// A fault at its value where that `is_of_value`, else at its key.
    fn located(&self, Fault { path, diagnostic, .. }: Fault, is_of_value: impl Fn(&[&str]) -> bool) -> Diagnostic {
        let path: Vec<&str> = path.iter().map(String::as_str).collect();
        diagnostic.at(if is_of_value(&path) { self.value(&path) } else { self.key(&path) })
    }

    fn explains(&self, path: &[&str]) -> bool {
        self.text(&self.declared(path)).is_some_and(|(text, path)| text.explains_absence(path))
    }
}

/// Leaves out what a campaign leaves out; whether there was any, with warnings of names that the robot does not have.
fn leave_elements_out(raw: &mut RawRobot, without: &Without, diagnostics: &mut Vec<Diagnostic>) -> bool {
    let known = elements(raw);
    let mut reduced = false;
    for (name, place) in &without.names {
        if leave_out(raw, name, without.own.as_ref()) {
            reduced = true;
        } else if !without.own.as_ref().is_some_and(|own| leave_out(&mut own.clone(), name, None)) {
            let diagnostic =
                Diagnostic::warning(format!("`without: {name}` leaves nothing out: the robot has no such element"));
            diagnostics.push(diagnostic.at(place.clone()).suggest(name, known.iter().map(String::as_str)));
        }
    }
    reduced
}

fn finish(
    mut raw: RawRobot,
    texts: &Located,
    mut diagnostics: Vec<Diagnostic>,
    without: &Without,
    reader: &Reader,
) -> Result<LoadedRobot, Vec<Diagnostic>> {
    let locate = |path: &[&str]| texts.value(path);
    let explained = |path: &[&str]| texts.explains(path);
    let (robot, mut reported) = resolve_explained(&raw, &locate, &explained);
    diagnostics.append(&mut reported);
    let Some(mut robot) = robot.filter(|_| !diagnostics.iter().any(Diagnostic::is_error)) else {
        return Err(diagnostics);
    };
    match texts.document {
        Some(_) => diagnostics.extend(doubtful_sizes(&raw, &robot, &locate)),
        // A URDF has no units but its own.
        None => diagnostics.extend(doubtful_urdf(&raw, &robot, &locate)),
    }
    // The description was checked as it stands in its file; what is left out cannot add a fault of its own.
    if leave_elements_out(&mut raw, without, &mut diagnostics) {
        match resolve_explained(&raw, &locate, &explained) {
            (Some(reduced), _) => robot = reduced,
            (None, mut found) => {
                diagnostics.append(&mut found);
                return Err(diagnostics);
            }
        }
    }
    let model = match build(&robot, reader.catalogue.clone()) {
        Ok(model) => model,
        Err(faults) => {
            let located = |fault: Fault| texts.located(fault, |path| path.first() == Some(&"effects"));
            return Err(diagnostics.into_iter().chain(faults.into_iter().map(located)).collect());
        }
    };
    for (k, switched_on) in model.effects.iter().enumerate() {
        if let Some(doubt) = switched_on.entry.doubt(&model) {
            let message = format!("effect {} of `effects:`: {}", k + 1, doubt.message);
            diagnostics.push(Diagnostic { message, ..doubt }.at(locate(&["effects", &k.to_string()])));
        }
    }
    let contradicted = contradictions(&raw, &model);
    if !contradicted.is_empty() {
        let located = contradicted.into_iter().map(|fault| texts.located(fault, |_| true));
        return Err(diagnostics.into_iter().chain(located).collect());
    }
    match Geometry::nominal(&model) {
        Ok(geometry) => {
            diagnostics.extend(open_loops(&raw, &geometry, texts));
            if let Some(error) = declared_singular(&geometry) {
                diagnostics.push(unassembled(&error, texts));
                return Err(diagnostics);
            }
            diagnostics.extend(other_assemblies(&raw, &geometry, texts));
        }
        Err(error) => {
            diagnostics.push(unassembled(&error, texts));
            return Err(diagnostics);
        }
    }
    Ok(LoadedRobot { raw, robot, model, diagnostics })
}

/// Gap (m or rad) of a description by round numbers.
const ROUNDED: f64 = 1e-4;

/// A warning on each over-constrained loop that does not close where its branch is declared and whose description does not say so;
/// calibrated constants leave such gaps.
fn open_loops(raw: &RawRobot, geometry: &Geometry, texts: &Located) -> Vec<Diagnostic> {
    let is_said = |name: &str| raw.loops.get(name).is_some_and(|own| own.gap.is_some());
    let open = geometry.open_loops().filter(|(name, gap)| gap.greatest() > ROUNDED && !is_said(name));
    let warning = |(name, gap): (&str, Gap)| {
        let message = format!("loop `{name}` stays {gap} open, and is closed in the least-squares sense");
        let remedy = "check lengths and constants of the loop; declare `gap` where that is meant";
        Diagnostic::warning(message).at(texts.key(&["loops", name])).remedy(remedy)
    };
    if raw.calibration.fit.is_some() { Vec::new() } else { open.map(warning).collect() }
}

/// A loop whose branch is declared where two assemblies meet: no configuration can then be placed.
fn declared_singular(geometry: &Geometry) -> Option<AssemblyError> {
    let error = geometry.place(&geometry.model.middle(), &mut Placements::default()).err()?;
    matches!(&error, AssemblyError::Singular { inputs, .. } if inputs.is_empty()).then_some(error)
}

/// Angle between where a branch is declared and where it closes from which it may be another one, rad: rough values are read to some 20 deg.
const ANOTHER: f64 = std::f64::consts::FRAC_PI_4;

/// A warning on each loop that closes with a joint far from where its branch is declared: loops close in more than one way.
fn other_assemblies(raw: &RawRobot, geometry: &Geometry, texts: &Located) -> Vec<Diagnostic> {
    let frames = &geometry.model.frames;
    let off = |[declared, found]: [f64; 2]| wrapped(found - declared).abs();
    let is_angle = |frame: FrameIndex| frames[frame].joint == JointKind::Revolute;
    let mut far: Vec<(&str, FrameIndex, [f64; 2])> =
        geometry.assembled().filter(|&(_, frame, values)| is_angle(frame) && off(values) > ANOTHER).collect();
    far.sort_by(|a, b| off(b.2).total_cmp(&off(a.2)));
    let mut warned: Vec<&str> = Vec::new();
    far.retain(|(name, ..)| {
        !warned.contains(name) && {
            warned.push(name);
            true
        }
    });
    let unit = raw.units.angle;
    let shown = |angle: f64| format!("{:.1} {}", wrapped(angle) / unit.factor(), unit.symbol());
    let warning = |&(name, frame, [declared, found]): &(&str, FrameIndex, [f64; 2])| {
        let joint = &frames[frame].name;
        let given = raw.loops.get(name).is_some_and(|own| own.branch.contains_key(joint));
        let said = if given { "its `branch` says" } else { "its `branch` says nothing of it, which is taken for" };
        let message = format!(
            "loop `{name}` closes with joint `{joint}` at {}, and {said} {}: loops close in more than one way",
            shown(found),
            shown(declared)
        );
        let remedy = format!(
            "if that is the assembly of the robot, write `branch: {{{joint}: {:.1}, ..}}`; else give all passive joints of the loop, and `at`, as they are in a configuration of the robot",
            wrapped(found) / unit.factor()
        );
        Diagnostic::warning(message).at(texts.key(&["loops", name])).remedy(remedy)
    };
    far.iter().map(warning).collect()
}

/// What to look at in a description that cannot be assembled.
fn unassembled(error: &AssemblyError, texts: &Located) -> Diagnostic {
    let path: Vec<&str> = match error {
        AssemblyError::Loop { name, .. } | AssemblyError::Singular { name, .. } => vec!["loops", name],
        AssemblyError::SliderCrank { name, .. } => vec!["actuators", name],
        _ => vec!["frames"],
    };
    let remedy = match error {
        AssemblyError::SliderCrank { .. } => {
            "check l1, l3 and `limits` of the actuator, and `at` of the loops: the triangle must close there"
        }
        AssemblyError::Singular { .. } => {
            "give `branch` and `at` from another configuration: there nothing tells its assemblies apart"
        }
        _ => "check lengths and constants of the loop, and give `branch` and `at` from a configuration that closes",
    };
    Diagnostic::error(error.to_string()).at(texts.key(&path)).remedy(remedy)
}
