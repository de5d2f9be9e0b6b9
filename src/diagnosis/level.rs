//! How fine a claim is, and how often it holds over half of the configurations.

use serde::Serialize;

/// How fine a claim is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// Only the family.
    Family,
    /// Family and site; the law is not known.
    Site,
    /// Family, site and law.
    Law,
}

/// Frequencies over half-samples with which the best hypothesis has the same family, site and law as the cause, from 0 to
/// below 1: one failure in as many again is never excluded.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stability {
    /// The same family.
    pub family: f64,
    /// The same family at the same site.
    pub site: f64,
    /// The same effect at the same site.
    pub law: f64,
    /// The same family at the same site, or at that of something that cannot be distinguished from the cause.
    pub group: f64,
    /// The same effect at the same site, or one that cannot be distinguished from it.
    pub group_law: f64,
}

impl Stability {
    /// Of what is claimed.
    pub fn of(self, level: Level) -> f64 {
        match level {
            Level::Family => self.family,
            Level::Site => self.site,
            Level::Law => self.law,
        }
    }
}

/// What speaks for a law, on readings that were not fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Support {
    /// Share of the gap above the noise that it takes away.
    pub of_gap: f64,
    /// Share of what the best free curve at its site takes away; `None` where there is none.
    pub of_free: Option<f64>,
    /// Share of what an error free in every configuration carries at its site; `None` where the readings of a configuration tell
    /// no sites apart, or the causes leave only noise.
    pub of_site: Option<f64>,
    /// Least gain where a range, a session or a load was left out, over that of folds drawn at random; `None` where none can be left
    /// out.
    pub elsewhere: Option<f64>,
    /// Share of the error at its site that it misses, by what neighbours in what it goes with share of the rest.
    pub missed: f64,
    /// Whether all that are claimed leave nothing but noise that is known.
    pub leaves_noise: bool,
}
