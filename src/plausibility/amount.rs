//! Whether there are enough readings to say anything.

use super::evidence::{Evidence, Limits};
use crate::description::campaign::{Amount, Campaign, Sharing};
use crate::diagnostic::{Code, Diagnostic, nearest};

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
        format!("the readings come from {from}: too few to tell a sound robot from any other")
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
        .flat_map(|(by, noun)| thin(campaign, by, noun, limits))
        .collect()
}

fn thin(campaign: &Campaign, by: Sharing, noun: &str, limits: &Limits) -> Vec<Diagnostic> {
    let names = campaign.sessions.parts(by);
    let said = |(part, name): (usize, &&str)| {
        let readings = campaign.readings.iter().filter(|reading| reading.session.part(by) == part);
        let rows: usize = readings.map(|reading| reading.observes.rows()).sum();
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
    names.iter().enumerate().filter_map(said).collect()
}
