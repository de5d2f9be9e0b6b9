//! How often the diagnosis finds what was withheld.

use indexmap::IndexMap;
use serde::Serialize;

use super::examined::Examined;
use super::reliability::{Rates, Reliability, rates, reliability};
use super::truth::Kind;

/// Gap over the noise that divides small from plain.
const PLAIN: f64 = 1.5;

/// One class of campaigns.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Class {
    /// Campaigns.
    pub count: usize,
    /// Right answers ([`Examined::is_right`]).
    pub right: usize,
    /// Right sites as well.
    pub sites: usize,
}

/// The figures of all campaigns.
#[derive(Debug, Clone, Serialize)]
pub struct Score {
    /// By kind and gap: below and above 1.5 times the noise.
    pub classes: IndexMap<String, Class>,
    /// True effect, named first (of several: the named one that fits, else the first), count.
    pub confusion: IndexMap<String, IndexMap<String, usize>>,
    /// Mean size of the groups named.
    pub group: f64,
    /// Mean promised and realised shrinkage where something was named.
    pub shrinkage: [f64; 2],
    /// Share of realised shrinkages within the promised 95 % intervals.
    pub coverage: f64,
    /// Campaigns where something was named.
    pub named: usize,
    /// Outliers: true, found of these, found in all.
    pub outliers: [usize; 3],
    /// Rates by kind, over all and by robot and noise.
    pub rates: Vec<Rates>,
    /// How often a cause named with a law is right, by the stability and by the probability that is said of it.
    pub reliability: Reliability,
}

/// Counts.
pub fn score(all: &[Examined]) -> Score {
    let mut classes: IndexMap<String, Class> = IndexMap::new();
    let mut confusion: IndexMap<String, IndexMap<String, usize>> = IndexMap::new();
    let mut outliers = [0; 3];
    for one in all {
        let kind = one.truth.kind.name();
        let gap = if one.truth.gap < PLAIN { "below" } else { "above" };
        let parts = if one.truth.kind == Kind::Null {
            vec![kind.to_string()]
        } else {
            vec![kind.to_string(), format!("{kind}, {gap} 1.5")]
        };
        for part in parts {
            let class = classes.entry(part).or_default();
            class.count += 1;
            class.right += usize::from(one.is_right());
            class.sites += usize::from(one.is_at_site());
        }
        let first = one.named.first().map_or("-".to_string(), |named| named.effect.clone());
        if one.truth.causes.is_empty() {
            *confusion.entry("none".into()).or_default().entry(first.clone()).or_default() += 1;
        }
        for cause in &one.truth.causes {
            let fits = one.named.iter().any(|named| named.holds(&cause.effect));
            let unused = one.named.iter().find(|n| !one.truth.causes.iter().any(|c| n.holds(&c.effect)));
            let named = match (fits, unused) {
                (true, _) => cause.effect.clone(),
                (false, Some(other)) => other.effect.clone(),
                (false, None) => "-".into(),
            };
            *confusion.entry(cause.effect.clone()).or_default().entry(named).or_default() += 1;
        }
        outliers[0] += one.truth.outliers.len();
        outliers[1] += one.truth.outliers.iter().filter(|row| one.outliers.contains(row)).count();
        outliers[2] += one.outliers.len();
    }
    classes.sort_keys();
    confusion.sort_keys();
    let named: Vec<&Examined> = all.iter().filter(|one| !one.named.is_empty()).collect();
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len().max(1) as f64;
    Score {
        classes,
        confusion,
        group: mean(named.iter().flat_map(|one| one.named.iter().map(|n| n.group() as f64)).collect()),
        shrinkage: [
            mean(named.iter().map(|one| one.promised).collect()),
            mean(named.iter().map(|one| one.realised).collect()),
        ],
        coverage: mean(named.iter().map(|one| f64::from(u8::from(one.keeps_promise()))).collect()),
        named: named.len(),
        outliers,
        rates: rates(all),
        reliability: reliability(all),
    }
}
