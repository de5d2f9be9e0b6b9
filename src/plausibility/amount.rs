//! Whether there are enough readings to say anything.

use super::evidence::{Evidence, Limits};
use crate::description::campaign::{Amount, Sharing};
use crate::description::robot::Variable;
use crate::diagnosis::VerdictSettings;
use crate::diagnostic::{Code, Diagnostic, nearest};
use crate::math::extremes;

/// A warning of too few configurations, or too few readings for so many fitted parameters.
pub(super) fn too_little(amount: &Amount, fitted: usize, limits: &Limits) -> Option<Diagnostic> {
    let Amount { configurations, rows } = *amount;
    let is_few = configurations < limits.fewest_configurations;
    let per_parameter = rows as f64 / fitted.max(1) as f64;
    if !is_few && per_parameter >= limits.rows_per_parameter {
        return None;
    }
    let message = if is_few {
        let from = match configurations {
            1 => "one configuration".into(),
            several => format!("{several} different configurations"),
        };
        format!("the readings come from {from}: too few for any conclusion")
    } else {
        format!(
            "{rows} residuals of different readings for {fitted} fitted parameters: errors of readings that were not seen can be far \
             greater than those that are left"
        )
    };
    let diagnostic = Diagnostic::warning(message)
        .code(Code::TooLittleData)
        .remedy("measure more configurations that differ (`plan` chooses them), or hold parameters (`--hold`)")
        .figure("configurations", configurations as f64)
        .figure("rows", rows as f64)
        .figure("parameters", fitted as f64);
    Some(diagnostic)
}

/// A warning of an error that hardly any configuration tells.
pub(super) fn few_held_out(held_out: &Amount) -> Option<Diagnostic> {
    let configurations = held_out.configurations;
    let from =
        if configurations == 1 { "one configuration".into() } else { format!("{configurations} configurations") };
    (configurations > 0 && configurations < VerdictSettings::default().fewest_held_out).then(|| {
        Diagnostic::warning(format!("the errors of readings that the fit did not see come from {from} alone"))
            .code(Code::Doubtful)
            .remedy("hold out more of them (the column `set`), or let the program choose: `--train` with a number")
            .figure("configurations", configurations as f64)
    })
}

/// Rotations (rad) and shifts (m) below which a joint stood still: a tenth of a degree, a millimetre.
pub(super) const STANDING: [f64; 2] = [2e-3, 1e-3];

/// A warning of joints that moved in none of the readings to fit, while others did.
pub(super) fn of_each_joint(evidence: &Evidence, _: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let fitted = || (0..campaign.readings.len()).filter(|&index| campaign.readings[index].check != Some(true));
    let stands = |(k, variable): (usize, &Variable)| {
        let [low, high] = extremes(fitted().map(|index| campaign.configuration(index)[k]));
        let [angle, length] = STANDING;
        (high - low < if variable.is_angle { angle } else { length }).then(|| format!("`{}`", variable.name))
    };
    let standing: Vec<String> = model.variables.iter().enumerate().filter_map(stands).collect();
    if standing.is_empty() || standing.len() == model.variables.len() || fitted().next().is_none() {
        return Vec::new();
    }
    let message = format!(
        "never moved: {}; how the robot is elsewhere, and how certain, these readings do not say",
        standing.join(", ")
    );
    let remedy = "measure configurations in which they move, or use the description only where they stand now";
    vec![Diagnostic::warning(message).code(Code::WeakDirection).remedy(remedy)]
}

/// Unknowns of a base or tool of its own.
const OF_A_BODY: f64 = 6.0;

/// Sessions and stations with a base or tool of their own that have hardly more readings than these have unknowns: a name that is
/// misspelt in a few rows fits whatever they hold.
pub(super) fn of_sessions(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let campaign = evidence.campaign;
    let sessions = &campaign.sessions;
    let own = [(campaign.estimate_base, sessions.base), (campaign.estimate_tool, sessions.tool)];
    let shared = |wanted: Sharing| own.iter().any(|(is_estimated, by)| *is_estimated && *by == wanted);
    [(Sharing::PerSession, "session"), (Sharing::PerStation, "station")]
        .into_iter()
        .filter(|(by, _)| shared(*by))
        .flat_map(|(by, noun)| thin(evidence, by, noun, limits))
        .collect()
}

fn thin(evidence: &Evidence, by: Sharing, noun: &str, limits: &Limits) -> Vec<Diagnostic> {
    let campaign = evidence.campaign;
    let is_fitted = |index: usize| evidence.found.is_none_or(|found| !found.holds_out(index));
    let names = campaign.sessions.parts(by);
    let described = |(part, name): (usize, &&str)| {
        let all = campaign.readings.iter().enumerate();
        let fitted = all.filter(|(index, reading)| reading.session.part(by) == part && is_fitted(*index));
        let rows: usize = fitted.map(|(_, reading)| reading.observes.rows()).sum();
        if rows == 0 || rows as f64 >= limits.rows_per_parameter * OF_A_BODY {
            return None;
        }
        let others = names.iter().filter(|other| *other != name).copied();
        let remedy = nearest(name, others).map_or_else(
            || format!("measure more in this {noun}, or let it share the base and tool of another"),
            |other| format!("did you mean the {noun} `{other}`? Else measure more in it"),
        );
        let message =
            format!("{noun} `{name}` has {rows} residuals for a base or tool of its own: they fit whatever they hold");
        Some(Diagnostic::warning(message).remedy(remedy).figure("rows", rows as f64))
    };
    names.iter().enumerate().filter_map(described).collect()
}
