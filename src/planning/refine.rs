//! The joints of chosen stations moved while that helps: a pattern search, one station after the other.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::criterion::Target;
use super::exchange::{Candidate, Design};
use super::information::Information;
use super::place::Rules;
use crate::kinematics::Placements;

/// Moves the stations of a design; the loss at the end.
pub fn refine(
    rules: &Rules,
    information: &Information,
    target: &Target,
    design: &mut Design,
    random: &mut ChaCha8Rng,
) -> f64 {
    let mut placements = Placements::default();
    let mut loss = target.loss(&design.information());
    let settings = &rules.request.settings;
    for step in settings.steps {
        for k in 0..design.chosen.len() {
            let m = design.without(k);
            for _ in 0..settings.moves {
                let current = &design.chosen[k].station;
                let mut directions: Vec<Vec<f64>> = Vec::new();
                for variable in 0..current.q.len() {
                    for sign in [1.0, -1.0] {
                        directions.push((0..current.q.len()).map(|j| if j == variable { sign } else { 0.0 }).collect());
                    }
                }
                for _ in 0..settings.directions {
                    directions.push(current.q.iter().map(|_| 2.0 * random.random::<f64>() - 1.0).collect());
                }
                let mut trials = Vec::new();
                for direction in directions {
                    let moved = current.q.iter().zip(&direction).zip(&rules.request.within);
                    let q: Vec<f64> =
                        moved.map(|((q, d), [low, high])| (q + step * d * (high - low)).clamp(*low, *high)).collect();
                    trials.extend(rules.station(&mut placements, &q, current.load, current.way));
                }
                let blocks = information.blocks(&trials);
                let Ok(blocks) = blocks else { break };
                let pool: Vec<Candidate> =
                    trials.into_iter().zip(blocks).map(|(station, block)| Candidate { station, block }).collect();
                match design.best(target, &m, &pool, k) {
                    Some((better, new)) if new < loss - settings.worth => {
                        design.chosen[k] = pool[better].clone();
                        loss = new;
                    }
                    _ => break,
                }
            }
        }
    }
    loss
}
