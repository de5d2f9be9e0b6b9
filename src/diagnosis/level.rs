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
