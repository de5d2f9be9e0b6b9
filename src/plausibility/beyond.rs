//! Numbers of a campaign that no instrument has and no robot bears: mostly a matter of units.

use super::evidence::{Evidence, Limits};
use super::shown::number;
use crate::description::campaign::{Campaign, Reading};
use crate::diagnostic::{Code, Diagnostic, Place};
use crate::math::norm;
use crate::model::Model;

/// A number of a reading that is judged.
struct Judged {
    /// What it is, with its unit behind the number.
    what: &'static str,
    unit: &'static str,
    /// Its value in that unit, where the reading has one.
    of: fn(&Reading) -> Option<f64>,
    /// Greatest one that is believed.
    most: f64,
    /// Of what that is.
    limit: &'static str,
    remedy: &'static str,
    figure: &'static str,
}

/// Noise and loads within reason: one warning for each that is not, at the reading where it is greatest.
pub(super) fn within_reason(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    judged(evidence.model, limits).iter().filter_map(|judged| beyond(evidence, judged)).collect()
}

/// Lengths of the robot from which noise is not even that of readings in another unit: a millimetre taken for a metre is about one of them.
const FAR_BEYOND: f64 = 10.0;

/// Whether the stated noise of some lengths is so far beyond the robot's own that these readings place nothing.
pub(super) fn is_noise_beyond(model: &Model, campaign: &Campaign) -> bool {
    let most = FAR_BEYOND * model.reach();
    campaign.readings.iter().filter_map(noise_of_lengths).any(|sigma| sigma > most)
}

/// The greatest noise that a reading states of its lengths, m.
fn noise_of_lengths(reading: &Reading) -> Option<f64> {
    let is_stated = reading.noise.is_stated[0] && reading.observes.length_rows() > 0;
    is_stated.then(|| reading.noise.position.iter().copied().fold(0.0, f64::max))
}

fn judged(model: &Model, limits: &Limits) -> [Judged; 4] {
    let (reach, weight) = (model.reach(), weight(model));
    let force = if weight > 0.0 { limits.force.min(limits.force_of_weight * weight) } else { limits.force };
    let noise = "give one standard deviation, in the campaign's units (`instrument: {sigma: ..}`, the column `sigma`)";
    let load = "check the value, and the units of force and torque: a force of a tool seldom exceeds the weight that an arm carries";
    [
        Judged {
            what: "the stated noise of a coordinate",
            unit: "m",
            of: noise_of_lengths,
            most: reach,
            limit: "the lengths of the robot together are",
            remedy: noise,
            figure: "sigma_m",
        },
        Judged {
            what: "the stated noise of an orientation",
            unit: "rad",
            of: |reading| {
                (reading.noise.is_stated[1] && reading.observes.angle_rows() > 0).then_some(reading.noise.orientation)
            },
            most: limits.loosest_angle,
            limit: "a direction is known at all up to",
            remedy: noise,
            figure: "sigma_rad",
        },
        Judged {
            what: "a force on the tool",
            unit: "N",
            of: |reading| Some(norm(&reading.wrench[..3])),
            most: force,
            limit: "an arm bears",
            remedy: load,
            figure: "force_N",
        },
        Judged {
            what: "a moment on the tool",
            unit: "N.m",
            of: |reading| Some(norm(&reading.wrench[3..])),
            most: force * reach,
            limit: "the greatest force at the end of the arm makes",
            remedy: load,
            figure: "moment_Nm",
        },
    ]
}

/// A warning where a number goes beyond what is believed.
fn beyond(evidence: &Evidence, judged: &Judged) -> Option<Diagnostic> {
    let campaign = evidence.campaign;
    let of_all = campaign.readings.iter().filter_map(|reading| Some((reading, (judged.of)(reading)?)));
    let mut beyond: Vec<(&Reading, f64)> = of_all.filter(|(_, value)| *value > judged.most).collect();
    // A stable order: of equal ones the first.
    beyond.sort_by(|a, b| b.1.total_cmp(&a.1));
    let &(reading, value) = beyond.first()?;
    let Judged { what, unit, most, limit, .. } = judged;
    let message = format!(
        "{what} is {} {unit} at most, implausible in {} of {} readings: {limit} {} {unit}",
        number(value),
        beyond.len(),
        campaign.readings.len(),
        number(*most)
    );
    let place = campaign.file(reading).filter(|_| reading.line > 0).map(|file| Place::line_of(file, reading.line));
    let diagnostic = Diagnostic::warning(message).code(Code::Doubtful).at(place);
    Some(diagnostic.remedy(judged.remedy).figure(judged.figure, value))
}

/// Weight of the bodies of a robot as described, N; 0 where it declares none, or no gravity.
fn weight(model: &Model) -> f64 {
    let mass: f64 = model.structure.masses.iter().map(|body| model.registry[body.slot].nominal).sum();
    mass * model.structure.gravity.norm()
}
