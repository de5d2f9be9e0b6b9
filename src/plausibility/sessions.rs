//! Whether readings of several sessions, or files, share a base and a tool as the campaign says.

use nalgebra::Point3;

use super::again::fitted;
use super::evidence::{Evidence, Limits};
use super::shown::mm;
use super::trial::typical;
use crate::description::campaign::{Campaign, InSession, Reading, Sharing};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Calibration, RegistrationSettings, registered};
use crate::kinematics::Geometry;
use crate::math::{distinct, mean_rms_max};
use crate::model::Model;

/// Readings by session, by station where all are of one session, or by file where neither is named.
pub(super) struct Parts {
    /// Of each reading.
    pub of: Vec<usize>,
    pub names: Vec<String>,
    /// What parts are called.
    pub noun: &'static str,
    /// What a part of the campaign file shares so is called.
    of_each: &'static str,
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
            of_each: "session",
            cure: "",
        });
    }
    if sessions.stations.len() > 1 {
        return Some(Parts {
            of: campaign.readings.iter().map(|reading| reading.session.station).collect(),
            names: sessions.stations.clone(),
            noun: "stations",
            of_each: "station",
            cure: "",
        });
    }
    let of_row = |row: usize| sessions.files.iter().rposition(|(_, first)| *first <= row).unwrap_or(0);
    (sessions.files.len() > 1).then(|| Parts {
        of: campaign.readings.iter().map(|reading| of_row(reading.row)).collect(),
        names: sessions.files.iter().map(|(name, _)| name.clone()).collect(),
        noun: "files",
        of_each: "session",
        cure: "name the session of each file (`measurements: [{file: .., session: ..}]`), and ",
    })
}

/// What is estimated by session where it is shared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Base,
    Tool,
    Both,
}

impl Part {
    fn has_base(self) -> bool {
        self != Self::Tool
    }

    fn has_tool(self) -> bool {
        self != Self::Base
    }

    /// What is reported of it.
    fn words(self) -> &'static str {
        match self {
            Self::Base => "base",
            Self::Tool => "tool",
            Self::Both => "base and tool",
        }
    }

    /// The keys that cure it, for parts of the campaign of one kind.
    fn keys(self, of_each: &str) -> String {
        match self {
            Self::Base => format!("base: per-{of_each}"),
            Self::Tool => format!("tool: per-{of_each}"),
            Self::Both => format!("base: per-{of_each}, tool: per-{of_each}"),
        }
    }
}

pub(super) fn agree(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    differ(evidence, limits).into_iter().collect()
}

/// Readings with a base, a tool or both of its own for each part.
struct Tried {
    part: Part,
    /// What registration leaves, m.
    error: f64,
    apart: Apart,
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
    let left = |model: &Model, campaign: &Campaign| {
        let (values, residual) = registered(model, campaign, &model.registry.nominal(), &settings).ok()?;
        Some((typical(campaign, &residual, limits)?, values))
    };
    let (shared, _) = left(&model.arranged(campaign), campaign)?;
    let tried = |part: Part| {
        let own = separated(campaign, &parts, part)?;
        let model = model.arranged(&own);
        let (error, values) = left(&model, &own)?;
        Some(Tried { part, error, apart: apart(&model, &own, &values, &parts, part)? })
    };
    let noise = mean_rms_max(campaign.readings.iter().map(|reading| reading.noise.position[0]))[1];
    let one = [Part::Base, Part::Tool].into_iter().filter_map(tried).min_by(|a, b| a.error.total_cmp(&b.error));
    // One of the two is the plainer word: both are reported where that leaves less by as much again.
    let least = one.as_ref().map_or(f64::INFINITY, |one| one.error);
    let both = (least > limits.sessions_fall * noise).then(|| tried(Part::Both)).flatten();
    let fall = limits.sessions_fall.powi(2);
    let is_plainly = |both: &Tried| shared >= fall * both.error && least >= limits.sessions_fall * both.error;
    let found = both.filter(is_plainly).or(one)?;
    let is_apart = found.apart.greatest() >= limits.sessions_apart * noise;
    (shared >= limits.sessions_fall * found.error && is_apart)
        .then(|| reported(&found, shared, &parts, ("registration", true)))
}

/// The same after a calibration: the robot's own errors hide from a registration what they do not hide from it.
pub(super) fn agree_calibrated(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let has_lengths = campaign.holds_lengths();
    let is_noise =
        |found: &Calibration| (campaign.sigma.is_some() || !has_lengths) && found.noise_ratio < limits.sessions_fall;
    let Some(found) = evidence.found.filter(|found| found.converged() && !is_noise(found)) else { return Vec::new() };
    let Some(parts) = parts(campaign).filter(|_| !campaign.is_difference() && campaign.estimate_base) else {
        return Vec::new();
    };
    // Of differences a base shows its rotation alone.
    let is_placed = |part: usize| {
        let mut own = campaign.readings.iter().zip(&parts.of).filter(|(_, of)| **of == part);
        own.any(|(reading, _)| !reading.observes.is_difference())
    };
    if !(0..parts.names.len()).all(is_placed) {
        return Vec::new();
    }
    let tried = |part: Part| {
        let own = separated(campaign, &parts, part)?;
        let arranged = model.arranged(&own);
        let slots = found.slots.iter().filter_map(|&slot| arranged.registry.slot(&model.registry[slot].name));
        let again = fitted(&arranged, &own, &found.held_out, Some(slots.collect()))?;
        let apart = apart(&arranged, &own, &again.values, &parts, part)?;
        Some(Tried { part, error: left(campaign, &again), apart })
    };
    let stated = mean_rms_max(campaign.readings.iter().map(|reading| reading.noise.position[0]))[1];
    let shared = left(campaign, found);
    let best = [Part::Base, Part::Tool].into_iter().filter_map(tried).min_by(|a, b| a.error.total_cmp(&b.error));
    let is_reported = |best: &Tried| {
        // Where no noise is stated what is left is the greatest that it can be.
        let noise = if campaign.sigma.is_some() { stated } else { best.error };
        let is_apart = !has_lengths || best.apart.greatest() >= limits.sessions_apart * noise;
        shared >= limits.sessions_fall * best.error && is_apart
    };
    let reported = |best: Tried| reported(&best, shared, &parts, ("calibration", has_lengths));
    best.filter(is_reported).filter(|_| differ(evidence, limits).is_none()).map(reported).into_iter().collect()
}

/// What a calibration leaves of a campaign: the error of its lengths, m; of one of angles or torques alone over the noise.
pub(super) fn left(campaign: &Campaign, found: &Calibration) -> f64 {
    if campaign.holds_lengths() { found.after.fit.distance[1] } else { found.noise_ratio }
}

/// The same in words.
pub(super) fn left_words(campaign: &Campaign, left: f64) -> String {
    words_of(left, campaign.holds_lengths())
}

fn words_of(left: f64, is_length: bool) -> String {
    if is_length { format!("{} mm", mm(left)) } else { format!("{left:.2} times the noise") }
}

fn reported(found: &Tried, shared: f64, parts: &Parts, (fit, has_lengths): (&str, bool)) -> Diagnostic {
    let (what, key, apart) = (found.part.words(), found.part.keys(parts.of_each), &found.apart);
    let of_each = parts.of_each;
    let [one, other] = apart.parts.map(|part| parts.names.get(part).map_or("", String::as_str));
    let message = format!(
        "{} differ by {} (`{one}` and `{other}`): with a {what} of its own for each, {fit} leaves {} instead of {}: estimate {what} per {of_each}?",
        parts.noun,
        apart.words(has_lengths),
        if has_lengths { mm(found.error) } else { format!("{:.2}", found.error) },
        words_of(shared, has_lengths),
    );
    let remedy = format!(
        "{}write `estimate: {{{key}}}` into the campaign; or look for a {of_each} that was set up differently",
        parts.cure
    );
    let figures =
        [("base_mm", apart.base.map(|[m, _]| 1e3 * m)), ("base_deg", apart.base.map(|[_, rad]| rad.to_degrees()))];
    let of_tool =
        [("tool_mm", apart.tool.map(|[m, _]| 1e3 * m)), ("tool_deg", apart.tool.map(|[_, rad]| rad.to_degrees()))];
    let mut diagnostic = Diagnostic::warning(message).code(Code::SessionsDiffer).remedy(remedy);
    for (name, value) in figures.into_iter().chain(of_tool) {
        if let Some(value) = value {
            diagnostic = diagnostic.figure(name, value);
        }
    }
    if !has_lengths {
        return diagnostic.figure("shared", shared).figure("separate", found.error);
    }
    diagnostic
        .figure("apart_mm", 1e3 * apart.greatest())
        .figure("shared_mm", 1e3 * shared)
        .figure("separate_mm", 1e3 * found.error)
}

/// The campaign with a base, a tool or both for each part; `None` where each has its own already, or nothing says that it is
/// unknown.
fn separated(campaign: &Campaign, parts: &Parts, part: Part) -> Option<Campaign> {
    let mut own = campaign.clone();
    if part.has_base() {
        if own.sessions.base != Sharing::All {
            return None;
        }
        (own.sessions.base, own.estimate_base) = (Sharing::PerSession, true);
    }
    if part.has_tool() {
        if own.sessions.tool != Sharing::All || !own.estimate_tool {
            return None;
        }
        own.sessions.tool = Sharing::PerSession;
    }
    own.sessions.names = (0..parts.names.len()).map(|k| format!("part{k}")).collect();
    for (reading, &session) in own.readings.iter_mut().zip(&parts.of) {
        reading.session = InSession { session, ..reading.session };
    }
    Some(own)
}

/// How far the bases, and the tools, of two parts are apart: m, and the angle of the rotation between them, rad.
struct Apart {
    parts: [usize; 2],
    /// Root mean square over where readings of both bases would be.
    base: Option<[f64; 2]>,
    /// The greatest of the points that both have measured.
    tool: Option<[f64; 2]>,
}

impl Apart {
    /// The greater of the two, m.
    fn greatest(&self) -> f64 {
        self.base.into_iter().chain(self.tool).map(|[distance, _]| distance).fold(0.0, f64::max)
    }

    /// Of readings without lengths by their angles alone.
    fn words(&self, has_lengths: bool) -> String {
        let of = |[distance, angle]: [f64; 2], of: &str| {
            if !has_lengths {
                return format!("{:.3} deg in the {of}", angle.to_degrees());
            }
            // A tool that is a point has no orientation.
            let turned = if angle > 0.0 { format!(" and {:.3} deg", angle.to_degrees()) } else { String::new() };
            format!("{} mm{turned} in the {of}", mm(distance))
        };
        let base = self.base.map(|base| of(base, "base"));
        base.into_iter().chain(self.tool.map(|tool| of(tool, "tool"))).collect::<Vec<_>>().join(", ")
    }
}

/// The two parts that are farthest apart.
fn apart(model: &Model, campaign: &Campaign, values: &[f64], parts: &Parts, part: Part) -> Option<Apart> {
    let geometry = Geometry::new(model, values).ok()?;
    let of = |session: usize| InSession { session, station: 0 };
    let measured = |reading: &Reading| reading.observes.measured_position(&reading.measured);
    let used: Vec<usize> = distinct(parts.of.iter().copied());
    // Of each reading, from its own base.
    let points: Vec<(usize, Point3<f64>)> = campaign
        .readings
        .iter()
        .zip(&parts.of)
        .filter_map(|(reading, &k)| {
            let base = geometry.placement(model.base_slot(reading.session));
            Some((k, base.inverse() * Point3::from(measured(reading)?)))
        })
        .collect();
    let bases = |i: usize, j: usize| {
        let [one, other] = [i, j].map(|k| geometry.placement(model.base_slot(of(k))));
        let own = points.iter().filter(|(k, _)| [i, j].contains(k));
        let distance = mean_rms_max(own.map(|(_, point)| (one * point - other * point).norm()))[1];
        [distance, (one.rotation.inverse() * other.rotation).angle()]
    };
    let markers =
        |k: usize| distinct(campaign.readings.iter().zip(&parts.of).filter(|(_, of)| **of == k).map(|(r, _)| r.marker));
    let tools = |i: usize, j: usize| {
        let others = markers(j);
        let at = |marker: Option<usize>, k: usize| geometry.point(model.point_slot(marker, of(k)));
        let both = markers(i).into_iter().filter(|marker| others.contains(marker));
        let distance = both.map(|marker| (at(marker, i) - at(marker, j)).norm()).fold(0.0, f64::max);
        let [one, other] = [i, j].map(|k| geometry.placement(model.tool_slot(of(k))).rotation);
        [distance, if campaign.sees_orientation() { (one.inverse() * other).angle() } else { 0.0 }]
    };
    let pairs = used.iter().enumerate().flat_map(|(at, &i)| used[at + 1..].iter().map(move |&j| [i, j]));
    let between = |parts: [usize; 2]| Apart {
        parts,
        base: part.has_base().then(|| bases(parts[0], parts[1])),
        tool: part.has_tool().then(|| tools(parts[0], parts[1])),
    };
    pairs.map(between).max_by(|a, b| a.greatest().total_cmp(&b.greatest()))
}
