//! `convert --as dh`, `dh-modified`, `mastering`: a description as a table in the terms of a controller.

use crate::Error;
use crate::cli::args::{Convert, WriteAs};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::description::robot::Motion;
use crate::diagnostic::Diagnostic;
use crate::kinematics::{Geometry, denavit_hartenberg};
use crate::model::Model;
use crate::render::controller_terms as tables;

/// Writes a table in such a format.
///
/// # Errors
/// An arm that has no such parameters, another robot as the nominal one, a file's ending that is none of a table.
pub fn controller_terms(command: &Convert, format: WriteAs, session: &Session) -> Result<Output, Error> {
    let (to, remedy) = (&command.to, "end the name in .csv or .xlsx");
    if !matches!(to.extension().and_then(|extension| extension.to_str()), Some("csv" | "xlsx")) {
        return Err(Error::input(format!("`{}`: a table is written", to.display()), remedy));
    }
    let loaded = session.reader.robot(&command.robot)?;
    let nominal = command.nominal.as_deref().map(|name| session.reader.robot(name)).transpose()?;
    let variables = |model: &Model| model.variables.iter().map(|own| own.name.clone()).collect::<Vec<_>>();
    if let Some(other) = nominal.as_ref().filter(|other| variables(&other.model) != variables(&loaded.model)) {
        let [theirs, ours] = [&other.model, &loaded.model].map(|model| variables(model).join(", "));
        let message = format!("--nominal has the variables {theirs}, and the robot {ours}");
        return Err(Error::input(message, "give the uncalibrated description of the same robot"));
    }
    let parameters = |model: &Model| {
        denavit_hartenberg(&Geometry::nominal(model)?).map_err(|why| {
            let remedy = "the joints that carry the tool must stand in series, each with a variable; `--as mastering` writes zeros alone";
            Error::input(format!("`{}` has no parameters of Denavit and Hartenberg: {why}", model.name), remedy)
        })
    };
    let table = match (format, &nominal) {
        (WriteAs::Mastering, Some(nominal)) => tables::mastering(&loaded.model, &nominal.model, to)?,
        (WriteAs::Mastering, None) => {
            let remedy = "give --nominal, the description that the controller works with";
            return Err(Error::input("--as mastering: zeros need a reference description", remedy));
        }
        (of, _) => {
            let other = nominal.as_ref().map(|nominal| parameters(&nominal.model)).transpose()?;
            tables::dh(&parameters(&loaded.model)?, other.as_ref(), of == WriteAs::DhModified, to)?
        }
    };
    let mut output =
        Output::new(format!("wrote {}\n", to.display()), &serde_json::json!({"wrote": to.display().to_string()}))?;
    output.diagnostics = loaded.diagnostics;
    if let (WriteAs::Mastering, Some(nominal)) = (format, &nominal) {
        output.diagnostics.extend(without_row(&loaded.model, &nominal.model));
    }
    if !loaded.model.effects.is_empty() {
        let names: Vec<&str> = loaded.model.effects.iter().map(|on| on.entry.effect.name()).collect();
        let message = format!("the table does not hold the description's effects: {}", names.join(", "));
        output.diagnostics.push(Diagnostic::warning(message).remedy("`compensate` corrects a path by them"));
    }
    output.tables.push((to.clone(), table));
    Ok(output)
}

/// Zeros of joints that a coupling moves, which no variable has.
fn without_row(model: &Model, nominal: &Model) -> Option<Diagnostic> {
    let zero = |model: &Model, name: &str| {
        let frame = model.frames.iter().find(|frame| frame.name == name)?;
        Some(model.registry[frame.moving_slot()].nominal)
    };
    let coupled = model.frames.iter().filter(|frame| matches!(frame.motion, Motion::Coupling(_)));
    let own = coupled.filter(|frame| zero(model, &frame.name) != zero(nominal, &frame.name));
    let names: Vec<String> = own.map(|frame| format!("`{}`", frame.name)).collect();
    let message =
        format!("the table does not hold the zero of {}, which a coupling moves: no variable has it", names.join(", "));
    (!names.is_empty()).then(|| Diagnostic::warning(message).remedy("`compensate` corrects a path by it"))
}
