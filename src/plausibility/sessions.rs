//! Whether readings of several sessions, or files, share a base and a tool as the campaign says.

use nalgebra::Vector3;

use super::evidence::{Evidence, Limits};
use super::trial::typical;
use super::words::mm;
use crate::description::campaign::{Campaign, InSession, Sharing};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{RegistrationSettings, registered};
use crate::math::mean_rms_max;

/// Readings by session, or by file where no session is named.
pub(super) struct Parts {
    /// Of each reading.
    pub of: Vec<usize>,
    pub names: Vec<String>,
    /// What parts are called.
    pub noun: &'static str,
    /// What the campaign has to say so that parts have a base or tool of their own.
    cure: &'static str,
}

pub(super) fn parts(campaign: &Campaign) -> Option<Parts> {
    let sessions = &campaign.sessions;
    if sessions.names.len() > 1 {
        return Some(Parts {
            of: campaign.readings.iter().map(|reading| reading.session.session).collect(),
            names: sessions.names.clone(),
            noun: "sessions",
            cure: "",
        });
    }
    let of_row = |row: usize| sessions.files.iter().rposition(|(_, first)| *first <= row).unwrap_or(0);
    (sessions.files.len() > 1).then(|| Parts {
        of: campaign.readings.iter().map(|reading| of_row(reading.row)).collect(),
        names: sessions.files.iter().map(|(name, _)| name.clone()).collect(),
        noun: "files",
        cure: "name the session of each file (`measurements: [{file: .., session: ..}]`), and ",
    })
}

/// What is estimated by session where it is shared.
#[derive(Clone, Copy)]
enum Part {
    Base,
    Tool,
}

pub(super) fn agree(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    differ(evidence, limits).into_iter().collect()
}

/// Says by how much sessions differ, where a base or a tool of their own takes away most of what registration leaves.
pub(super) fn differ(evidence: &Evidence, limits: &Limits) -> Option<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let parts = parts(campaign).filter(|_| !campaign.is_difference())?;
    let is_measured = |k: usize| {
        let reading = &campaign.readings[k];
        reading.observes.measured_position(&reading.measured).is_some()
    };
    if !(0..campaign.readings.len()).all(is_measured) {
        return None;
    }
    let settings = RegistrationSettings { starts: 2, finalists: 1, last_iterations: 50, ..Default::default() };
    let left = |campaign: &Campaign| {
        let model = model.arranged(campaign);
        let (_, residual) = registered(&model, campaign, &model.registry.nominal(), &settings).ok()?;
        Some((typical(campaign, &residual, limits)?, residual))
    };
    let (shared, residual) = left(campaign)?;
    let tried = |part: Part| {
        let own = separated(campaign, &parts, part)?;
        let (error, own) = left(&own)?;
        let apart = apart(campaign, &residual, &own, &parts)?;
        Some((part, error, apart))
    };
    let found = [Part::Base, Part::Tool].into_iter().filter_map(tried);
    let (part, error, apart) = found.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let noise = campaign.readings.iter().map(|reading| reading.noise.position[0]);
    let noise = mean_rms_max(noise)[1];
    if shared < limits.sessions_fall * error || apart.0 < limits.sessions_apart * noise {
        return None;
    }
    let (what, key) = match part {
        Part::Base => ("base", "base: per-session"),
        Part::Tool => ("tool", "tool: per-session"),
    };
    let (distance, [one, other]) = apart;
    let message = format!(
        "{} differ by {} mm (`{}` and `{}`): with a {what} of its own for each, registration leaves {} instead of {} mm: estimate {what} per session?",
        parts.noun,
        mm(distance),
        parts.names.get(one)?,
        parts.names.get(other)?,
        mm(error),
        mm(shared),
    );
    let remedy = format!(
        "{}write `estimate: {{{key}}}` into the campaign; or look for a session that was set up differently",
        parts.cure
    );
    Some(
        Diagnostic::warning(message)
            .code(Code::SessionsDiffer)
            .remedy(remedy)
            .figure("apart_mm", 1e3 * distance)
            .figure("shared_mm", 1e3 * shared)
            .figure("separate_mm", 1e3 * error),
    )
}

/// The campaign with a base, or a tool, for each part; `None` where each has its own already, or nothing says that it is
/// unknown.
fn separated(campaign: &Campaign, parts: &Parts, part: Part) -> Option<Campaign> {
    let mut own = campaign.clone();
    let shared = match part {
        Part::Base => &mut own.sessions.base,
        Part::Tool => &mut own.sessions.tool,
    };
    if *shared != Sharing::All {
        return None;
    }
    *shared = Sharing::PerSession;
    match part {
        Part::Base => own.estimate_base = true,
        Part::Tool if !own.estimate_tool => return None,
        Part::Tool => {}
    }
    own.sessions.names = (0..parts.names.len()).map(|k| format!("part{k}")).collect();
    for (reading, &session) in own.readings.iter_mut().zip(&parts.of) {
        reading.session = InSession { session, ..reading.session };
    }
    Some(own)
}

/// The greatest distance (m) between the mean displacements of two parts, and which they are.
fn apart(campaign: &Campaign, shared: &[f64], own: &[f64], parts: &Parts) -> Option<(f64, [usize; 2])> {
    let mut sums = vec![(Vector3::zeros(), 0.0); parts.names.len()];
    let both = campaign.by_reading(shared, 1).zip(campaign.by_reading(own, 1));
    for (((_, one), (_, other)), &part) in both.zip(&parts.of) {
        let (Some(one), Some(other)) = (one.get(..3), other.get(..3)) else { continue };
        sums[part].0 += Vector3::from_column_slice(one) - Vector3::from_column_slice(other);
        sums[part].1 += 1.0;
    }
    let means: Vec<(usize, Vector3<f64>)> = sums
        .iter()
        .enumerate()
        .filter(|(_, (_, count))| *count > 0.0)
        .map(|(k, (sum, count))| (k, sum / *count))
        .collect();
    let pairs = means.iter().enumerate().flat_map(|(k, a)| means[k + 1..].iter().map(move |b| (a, b)));
    pairs.map(|((i, a), (j, b))| ((a - b).norm(), [*i, *j])).max_by(|a, b| a.0.total_cmp(&b.0))
}
