//! `convert`: a description as YAML, URDF, or in a format of other programs.

use std::path::Path;

use super::controller_terms::controller_terms;
use super::schema::file_name;
use crate::Error;
use crate::cli::args::{Convert, SchemaOf, WriteAs};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::description::campaign::Campaign;
use crate::description::convention::as_declared;
use crate::description::raw::RawRobot;
use crate::description::{ur_kinematics, urdf, yaml};
use crate::diagnostic::{Code, Diagnostic};
use crate::files::{LoadedRobot, moved_to, schema_line, source_urdf};
use crate::model::{EffectEntry, Model};
use crate::prediction::{PredictionError, residuals};
use crate::render::mjcf::mjcf;

pub fn run(command: &Convert, session: &Session) -> Result<Output, Error> {
    let format = command.write_as.map_or_else(|| by_ending(&command.to), Ok)?;
    crate::files::writable(&command.to)?;
    if matches!(format, WriteAs::Dh | WriteAs::DhModified | WriteAs::Mastering) {
        return controller_terms(command, format, session);
    }
    if command.nominal.is_some() {
        return Err(Error::input("--nominal, and no table is written", "add --as dh, dh-modified or mastering"));
    }
    let loaded = session.reader.robot(&command.robot)?;
    let (text, diagnostics) = match format {
        WriteAs::UrKinematics => {
            let hash = loaded.raw.ur_kinematics.as_ref().and_then(|keys| keys.hash.as_deref());
            ur_kinematics::write(&loaded.robot, hash)?
        }
        WriteAs::Mjcf => mjcf(&loaded.robot, &loaded.model).map_err(PredictionError::from)?,
        WriteAs::Yaml => as_yaml(&loaded.raw, &command.to)?,
        _ => as_urdf(&loaded.raw)?,
    };
    let warnings = format!("wrote {}\n", command.to.display());
    let mut output = Output::new(warnings, &serde_json::json!({"wrote": command.to.display().to_string()}))?;
    output.diagnostics = loaded.diagnostics.into_iter().chain(diagnostics).collect();
    output.files.push((command.to.clone(), text));
    Ok(output)
}

/// The format that a file's ending alone says.
fn by_ending(to: &Path) -> Result<WriteAs, Error> {
    match to.extension().and_then(|extension| extension.to_str()) {
        Some("yaml" | "yml") => Ok(WriteAs::Yaml),
        Some("urdf") => Ok(WriteAs::Urdf),
        Some("xml") => Err(Error::input(
            format!("`{}`: it may be an MJCF or a URDF", to.display()),
            "say `--as mjcf` or `--as urdf` (in Python `format=\"mjcf\"`), or end the name in .urdf",
        )),
        _ => Err(Error::input(
            format!("`{}`: format unknown", to.display()),
            "end the name in .yaml or .urdf, or say `--as yaml|urdf|mjcf|ur-kinematics` (in Python `format=`)",
        )),
    }
}

/// Refuses, before anything is computed, a file that could not be written in the end.
pub fn can_write(to: &Path) -> Result<(), Error> {
    if !matches!(to.extension().and_then(|extension| extension.to_str()), Some("yaml" | "yml" | "urdf" | "xml")) {
        return Err(unknown_format(to));
    }
    Ok(crate::files::writable(to)?)
}

/// What a description that is written must predict.
pub struct Expected<'a> {
    pub campaign: &'a Campaign,
    /// Measured less predicted, of all readings (m, rad); `None` where they need only be predicted.
    pub residual: Option<&'a [f64]>,
    /// The model that was fitted and its values, by which what belongs to the campaign is predicted.
    pub fitted: (&'a Model, &'a [f64]),
}

/// Greatest difference (m, rad) between what a description predicts before it is written and when it is read back: numbers
/// are written with all their digits, and what is left is the rounding of loops closed anew.
const SAME: f64 = 1e-8;

/// Where a description that is read back would stand: in the folder that the command runs in.
const READ_BACK: &str = "written.yaml";

/// Why a description, written and read back, could not be used: it is predicted with before anything is put in its place.
pub fn unusable(raw: &RawRobot, session: &Session, expected: &Expected) -> Result<Option<Diagnostic>, Error> {
    let (text, _) = written(raw, Path::new(READ_BACK))?;
    Ok(fault(&text, session, expected).map(|why| {
        Diagnostic::error(format!("the description with these values could not be used: {why}"))
            .code(Code::UnusableResult)
            .remedy("hold the parameters behind it (--hold), state bounds under `calibration:`, or measure more")
    }))
}

/// Why a description does not predict what is expected, if it does not.
fn fault(text: &str, session: &Session, expected: &Expected) -> Option<String> {
    let robot = match session.reader.robot_text(Path::new(READ_BACK), text) {
        Ok(robot) => robot,
        Err(found) => return found.iter().find(|diagnostic| diagnostic.is_error()).map(|error| error.message.clone()),
    };
    let model = robot.model.arranged(expected.campaign);
    let values = model.nominal_at(expected.fitted.0, expected.fitted.1);
    let found = match residuals(&model, expected.campaign, &values) {
        Ok(found) => found,
        Err(error) => return Some(error.to_string()),
    };
    if found.iter().any(|r| !r.is_finite()) {
        return Some("what it predicts is not finite".into());
    }
    let differences = expected.residual?.iter().zip(&found).map(|(a, b)| (a - b).abs());
    let greatest = differences.fold(0.0, f64::max);
    (greatest > SAME).then(|| format!("it predicts readings up to {greatest:.1e} m or rad away from the fit"))
}

/// A description written and read back; `None` where it cannot be read.
pub fn read_back(raw: &RawRobot, session: &Session) -> Result<Option<LoadedRobot>, Error> {
    let (text, _) = written(raw, Path::new(READ_BACK))?;
    Ok(session.reader.robot_text(Path::new(READ_BACK), &text).ok())
}

/// Root mean square error (m) that a description, written and read back, leaves of certain readings of a campaign, by their index;
/// `None` where they cannot be predicted. What is `left_out` of the description is switched on as it was found.
pub fn leaves(
    raw: &RawRobot,
    session: &Session,
    expected: &Expected,
    left_out: &[EffectEntry],
    used: impl Fn(usize) -> bool,
) -> Result<Option<f64>, Error> {
    let Some(robot) = read_back(raw, session)? else { return Ok(None) };
    let mut model = robot.model;
    left_out.iter().for_each(|entry| model.switch_on(entry.clone()));
    let model = model.arranged(expected.campaign);
    let values = model.nominal_at(expected.fitted.0, expected.fitted.1);
    Ok(error(&model, &values, expected.campaign, used))
}

/// Root mean square error (m) that a model leaves of certain readings, by their index; `None` where they cannot be predicted.
pub fn error(model: &Model, values: &[f64], campaign: &Campaign, used: impl Fn(usize) -> bool) -> Option<f64> {
    let found = residuals(model, campaign, values).ok()?;
    let (mut first, mut squares, mut count) = (0, 0.0, 0.0);
    for (index, reading) in campaign.readings.iter().enumerate() {
        let lengths = reading.observes.length_rows();
        if lengths > 0 && used(index) {
            squares += found.get(first..first + lengths)?.iter().map(|left| left * left).sum::<f64>();
            count += 1.0;
        }
        first += reading.observes.rows();
    }
    (count > 0.0).then(|| (squares / count).sqrt())
}

/// A description as the text of a file, in the format that its name asks for.
pub fn written(raw: &RawRobot, to: &Path) -> Result<(String, Vec<Diagnostic>), Error> {
    match to.extension().and_then(|extension| extension.to_str()) {
        Some("yaml" | "yml") => as_yaml(raw, to),
        Some("urdf" | "xml") => as_urdf(raw),
        _ => Err(unknown_format(to)),
    }
}

fn unknown_format(to: &Path) -> Error {
    Error::input(format!("`{}`: format unknown", to.display()), "end the name in .yaml or .urdf")
}

fn as_yaml(raw: &RawRobot, to: &Path) -> Result<(String, Vec<Diagnostic>), Error> {
    let line = schema_line(to, file_name(SchemaOf::Robot));
    Ok((line + &yaml::write(&as_declared(&moved_to(raw, to)))?, Vec::new()))
}

fn as_urdf(raw: &RawRobot) -> Result<(String, Vec<Diagnostic>), Error> {
    match source_urdf(raw) {
        Some((name, Ok(text))) => Ok(urdf::export_into(raw, &name, &text)?),
        Some((name, Err(why))) => {
            let (text, mut diagnostics) = urdf::export(raw)?;
            let why = why.first().map_or("", |diagnostic| diagnostic.message.as_str());
            let message = format!("shapes, inertias, efforts and velocities of `{name}` are not kept: {why}");
            diagnostics.push(Diagnostic::warning(message).remedy("correct `urdf: {file: ..}` in the description"));
            Ok((text, diagnostics))
        }
        None => Ok(urdf::export(raw)?),
    }
}
