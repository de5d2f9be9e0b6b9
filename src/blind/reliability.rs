//! Rates with their intervals, and whether what the diagnosis says of its certainty holds.

use serde::Serialize;

use super::examine::Named;
use super::examined::Examined;
use super::truth::Truth;
use crate::diagnosis::Level;
use crate::math::quantiles::normal95;

/// Ends of the bins of stability and probability.
const ENDS: [f64; 7] = [0.0, 0.3, 0.5, 0.7, 0.9, 0.97, 1.0];

/// How often something holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rate {
    /// Times that it holds.
    pub count: usize,
    /// Times that it could.
    pub of: usize,
    /// Share; `None` where it could not.
    pub share: Option<f64>,
    /// 95 % interval of the share. Source: Wilson, *Probable inference*, J. Am. Stat. Assoc. 22, 1927.
    pub ci95: [f64; 2],
}

impl Rate {
    /// Of so many times that something holds or does not.
    pub fn of(times: impl Iterator<Item = bool>) -> Self {
        let (mut count, mut of) = (0, 0);
        for holds in times {
            of += 1;
            count += usize::from(holds);
        }
        if of == 0 {
            return Self { count, of, share: None, ci95: [0.0, 1.0] };
        }
        let (n, share, z2) = (of as f64, count as f64 / of as f64, normal95().powi(2));
        let middle = (share + 0.5 * z2 / n) / (1.0 + z2 / n);
        let half = (share * (1.0 - share) * z2 / n + 0.25 * (z2 / n).powi(2)).sqrt() / (1.0 + z2 / n);
        Self { count, of, share: Some(share), ci95: [(middle - half).max(0.0), (middle + half).min(1.0)] }
    }
}

/// Rates of campaigns of one kind.
#[derive(Debug, Clone, Serialize)]
pub struct Rates {
    /// Kind.
    pub kind: String,
    /// Which of them: all; those of a robot and a kind of readings; those of a kind of noise, stated or not.
    pub among: String,
    /// Campaigns whose answer is right, with the sites of known causes.
    pub right: Rate,
    /// Campaigns with a false name.
    pub false_names: Rate,
    /// Campaigns whose answer is open.
    pub open: Rate,
    /// Of the campaigns where something is named: those whose shrinkage keeps the promise.
    pub kept: Rate,
}

/// Sets to which a campaign belongs, by place in tables and name.
fn sets(truth: &Truth) -> Vec<(usize, String)> {
    let noises = truth.instrument.iter().flat_map(|instrument| {
        let stated = if instrument.is_stated { "noise stated" } else { "noise not stated" };
        [(2, format!("{} noise", instrument.noise)), (3, stated.to_string())]
    });
    let own = [(0, "all".to_string()), (1, format!("{} {}", truth.robot, truth.observes))];
    own.into_iter().chain(noises).collect()
}

/// Rates by kind, over all and by robot and noise.
pub fn rates(all: &[Examined]) -> Vec<Rates> {
    let mut keys: Vec<(&'static str, (usize, String))> = Vec::new();
    for Examined { truth, .. } in all {
        keys.extend(sets(truth).into_iter().map(|set| (truth.kind.name(), set)));
    }
    keys.sort();
    keys.dedup();
    let one = |(kind, set): (&str, (usize, String))| {
        let is_own = |one: &&Examined| one.truth.kind.name() == kind && sets(&one.truth).contains(&set);
        let own: Vec<&Examined> = all.iter().filter(is_own).collect();
        let has_sites = |one: &Examined| one.is_at_site() || !one.is_hit();
        Rates {
            right: Rate::of(own.iter().map(|one| one.is_right() && has_sites(one))),
            false_names: Rate::of(own.iter().map(|one| one.has_false_name())),
            open: Rate::of(own.iter().map(|one| one.is_open())),
            kept: Rate::of(own.iter().filter(|one| !one.named.is_empty()).map(|one| one.keeps_promise())),
            kind: kind.into(),
            among: set.1,
        }
    };
    keys.into_iter().map(one).collect()
}

/// Causes whose figure lies in a range.
#[derive(Debug, Clone, Serialize)]
pub struct Bin {
    /// Least and, left out but for 1, greatest figure.
    pub range: [f64; 2],
    /// Mean figure.
    pub mean: f64,
    /// How many of them are right.
    pub right: Rate,
}

/// What is said of the certainty of causes that are named with a law, and how often they are right.
#[derive(Debug, Clone, Serialize)]
pub struct Reliability {
    /// By stability; right is a true cause at its site, or one that is tied with it or in a group of at most three.
    pub stability: Vec<Bin>,
    /// By probability; right is the true cause at its site, itself.
    pub probability: Vec<Bin>,
    /// Mean squared difference of probability and outcome (1 right, 0 not); `None` where nothing is named.
    pub brier: Option<f64>,
}

/// Counts over all causes that are named with a law.
pub fn reliability(all: &[Examined]) -> Reliability {
    let laws = || {
        let is_law = |named: &&Named| named.level == Level::Law && named.is_of_catalogue();
        all.iter().flat_map(move |one| one.named.iter().filter(is_law).map(move |named| (one, named)))
    };
    let stability: Vec<(f64, bool)> =
        laws().filter_map(|(one, named)| Some((named.stability?, !one.is_false(named)))).collect();
    let probability: Vec<(f64, bool)> =
        laws().filter_map(|(one, named)| Some((named.probability?, one.is_itself(named)))).collect();
    let squared = |(p, is_right): &(f64, bool)| (p - f64::from(u8::from(*is_right))).powi(2);
    let brier = probability.iter().map(squared).sum::<f64>() / probability.len() as f64;
    Reliability {
        stability: bins(&stability),
        brier: (!probability.is_empty()).then_some(brier),
        probability: bins(&probability),
    }
}

fn bins(all: &[(f64, bool)]) -> Vec<Bin> {
    let ranges = ENDS.windows(2).map(|ends| [ends[0], ends[1]]);
    let bin = |range: [f64; 2]| {
        let is_in = |figure: f64| figure >= range[0] && (figure < range[1] || range[1] == 1.0);
        let own: Vec<&(f64, bool)> = all.iter().filter(|(figure, _)| is_in(*figure)).collect();
        let mean = own.iter().map(|(figure, _)| figure).sum::<f64>() / own.len().max(1) as f64;
        Bin { range, mean, right: Rate::of(own.iter().map(|(_, is_right)| *is_right)) }
    };
    ranges.map(bin).filter(|bin| bin.right.of > 0).collect()
}
