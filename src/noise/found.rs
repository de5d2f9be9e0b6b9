//! The noise of a campaign that states none, where its readings show it without the robot.

use super::{NoiseEstimate, Repeated, reference_noise, repeats, rigid_markers};
use crate::description::campaign::{Campaign, NoiseOrigin};
use crate::model::Model;

/// Degrees of freedom from which a noise counts as known. 50 give it to 10 % (1/sqrt(2 n)).
pub const LEAST_FREEDOM: f64 = 50.0;
/// Least noise that readings show, m: below it they were computed, and what scatters are digits that were rounded.
const COMPUTED: f64 = 1e-7;

/// Greatest noise that readings show, as a share of the robot's lengths and strokes: cameras measure a robot to 0.2 mm/m, draw wires to half a
/// millimetre. What scatters by more is not noise: rows that are exchanged, markers that are not where they are said to be. A judgement.
const COARSEST: f64 = 1e-3;

/// Gives a campaign that states no noise of lengths the one that its readings show without the robot, the greatest where several
/// do: scatter of distances between markers of one body, of readings repeated in place, of fixed reflectors
/// ([`rigid_markers`], [`repeats()`], [`reference_noise`]). From fewer than [`LEAST_FREEDOM`] degrees of freedom none is taken, and
/// where some readings state theirs none either.
pub fn fill_noise(model: &Model, campaign: &mut Campaign) {
    let of_lengths = || campaign.readings.iter().filter(|reading| reading.observes.length_rows() > 0);
    if campaign.sigma.is_some() || of_lengths().any(|reading| reading.noise.is_stated[0]) {
        return;
    }
    let shown = [
        (NoiseOrigin::RigidMarkers, rigid_markers(model, campaign)),
        (NoiseOrigin::Repeats, repeats(campaign, Repeated::InPlace, |_, _| 1.0)),
        (NoiseOrigin::References, reference_noise(&campaign.references).map(|seen| seen.noise)),
    ];
    let is_known = |found: &NoiseEstimate| {
        found.degrees_of_freedom >= LEAST_FREEDOM
            && found.sigma.is_finite()
            && found.sigma > COMPUTED
            && found.sigma < COARSEST * model.reach()
    };
    let known = shown.into_iter().filter_map(|(from, found)| Some((from, found.filter(is_known)?)));
    let Some((from, found)) = known.max_by(|a, b| a.1.sigma.total_cmp(&b.1.sigma)) else { return };
    campaign.sigma = Some([found.sigma; 3]);
    campaign.noise_origin = from;
    for reading in campaign.readings.iter_mut().filter(|reading| reading.observes.length_rows() > 0) {
        reading.noise.position = [found.sigma; 3];
        reading.noise.is_stated[0] = true;
        if !reading.noise.is_stated[1] {
            // As where a file states that of positions only.
            reading.noise.orientation = found.sigma;
        }
    }
}
