//! Noise from the distances between markers on one body, which no motion of the robot changes.

use std::collections::{BTreeSet, HashMap};
use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::Vector3;

use super::{NoiseEstimate, WRONG};
use crate::description::campaign::{Campaign, LoadPoint, Reading};
use crate::description::raw::JointKind;
use crate::math::{distinct, median};
use crate::model::Model;

/// One sigma of a coordinate from the scatter of distances between markers of one body over the configurations: a distance
/// between two points of equal, independent noise scatters by the square root of 2 times as much. None where no two markers of
/// a body are measured at two configurations or more of a session, where tool and markers are of a session. Deflection within the
/// body counts as noise.
pub fn rigid_markers(model: &Model, campaign: &Campaign) -> Option<NoiseEstimate> {
    let body = |marker: usize| {
        let mut frame = model.markers[marker].frame;
        while frame != 0 && model.frames[frame].joint == JointKind::Fixed {
            frame = model.frames[frame].antecedent;
        }
        frame
    };
    // Of each configuration and marker, the sum of its readings and their number.
    let mut points: HashMap<(usize, usize), (Vector3<f64>, f64)> = HashMap::new();
    // Loaded each at its own marker, two readings are of two deflections.
    let is_alike = |reading: &&Reading| reading.wrench == [0.0; 6] || reading.load_point != LoadPoint::Measured;
    let absolute = campaign.readings.iter().filter(|reading| !reading.observes.is_difference());
    for reading in absolute.filter(is_alike) {
        let (Some(marker), Some(at)) = (reading.marker, reading.observes.measured_position(&reading.measured)) else {
            continue;
        };
        let known = points.entry((reading.pose, marker)).or_insert((Vector3::zeros(), 0.0));
        *known = (known.0 + at, known.1 + 1.0);
    }
    // Which mounting of the markers each configuration is of.
    let mut mounted = vec![0; campaign.poses.len()];
    campaign.readings.iter().for_each(|of| mounted[of.pose] = of.session.part(campaign.sessions.tool));
    let mountings: BTreeSet<usize> = mounted.iter().copied().collect();
    let markers: Vec<usize> = distinct(points.keys().map(|(_, marker)| *marker));
    // From the mean and from the median, which wrong readings do not move.
    let (mut deviations, mut degrees_of_freedom) = ([Vec::new(), Vec::new()], 0.0);
    for (k, &one) in markers.iter().enumerate() {
        for &other in markers[k + 1..].iter().filter(|other| body(**other) == body(one)) {
            let distance = |pose: usize| {
                let [a, b] =
                    [one, other].map(|marker| points.get(&(pose, marker)).map(|(sum, count)| (sum / *count, *count)));
                let ((a, of_a), (b, of_b)) = (a?, b?);
                // As noisy as one reading of each would be.
                Some(((a - b).norm(), (0.5 * (1.0 / of_a + 1.0 / of_b)).sqrt()))
            };
            for &mounting in &mountings {
                let poses = (0..campaign.poses.len()).filter(|&pose| mounted[pose] == mounting);
                let found: Vec<(f64, f64)> = poses.filter_map(distance).collect();
                let count = found.len() as f64;
                let mean = found.iter().map(|(distance, _)| distance).sum::<f64>() / count.max(1.0);
                let middle = median(&mut found.iter().map(|(distance, _)| *distance).collect::<Vec<f64>>());
                if count > 1.0 {
                    // A difference of two points of equal noise.
                    for (own, centre) in deviations.iter_mut().zip([mean, middle.unwrap_or(mean)]) {
                        own.extend(found.iter().map(|(distance, part)| (distance - centre) / part * FRAC_1_SQRT_2));
                    }
                    degrees_of_freedom += count - 1.0;
                }
            }
        }
    }
    let [about_mean, about_median] = deviations.map(|own| NoiseEstimate::of(own, degrees_of_freedom));
    let robust = about_median.filter(|robust| about_mean.is_some_and(|mean| mean.sigma > WRONG * robust.sigma));
    robust.or(about_mean)
}
