//! How an answer stands to the truth: right, false names, open.

use serde::Serialize;

use super::examine::{Answer, Named};
use super::tied::Signals;
use super::truth::{Kind, Truth, TruthCause};
use crate::prediction::PredictionError;

/// What the diagnosis found in one campaign, and how it does on a fresh one.
#[derive(Debug, Clone, Serialize)]
pub struct Examined {
    /// What was behind it.
    pub truth: Truth,
    /// Verdict in a word; `refused` where the readings were.
    pub verdict: &'static str,
    /// What speaks against the readings being what they are said to be, by codes.
    pub doubted: Vec<String>,
    /// Causes named, in the order found, without outliers.
    pub named: Vec<Named>,
    /// Rows found to be outliers.
    pub outliers: Vec<usize>,
    /// Shrinkage promised, and its 95 % interval.
    pub promised: f64,
    /// Its interval, where it has one.
    pub promised_ci95: Option<[f64; 2]>,
    /// Shrinkage on the fresh campaign.
    pub realised: f64,
    /// Root mean square on the fresh campaign, calibrated only and as diagnosed, m.
    pub fresh: [f64; 2],
    /// s.
    pub seconds: f64,
}

impl Answer {
    /// Opens the truth.
    pub fn open(self, truth: Truth) -> Examined {
        Examined {
            truth,
            verdict: self.verdict,
            doubted: self.doubted,
            named: self.named,
            outliers: self.outliers,
            promised: self.promised.0,
            promised_ci95: self.promised.1,
            realised: 1.0 - self.fresh[1] / self.fresh[0],
            fresh: self.fresh,
            seconds: self.seconds,
        }
    }

    /// Opens the truth of a campaign that was diagnosed with its true effect taken out of the catalogue.
    pub fn open_left_out(self, truth: Truth) -> Examined {
        self.open(Truth { kind: Kind::LeftOut, ..truth })
    }
}

impl Examined {
    /// True causes that the catalogue has.
    fn known(&self) -> &[TruthCause] {
        match self.truth.kind {
            Kind::Unknown | Kind::Trap | Kind::LeftOut => &[],
            // The first is known, the second is not.
            Kind::Mixture => self.truth.causes.get(..1).unwrap_or_default(),
            Kind::Single | Kind::Pair | Kind::Triple | Kind::Null => &self.truth.causes,
        }
    }

    /// Whether all true effects were named: the only one first, several in any order.
    pub fn is_hit(&self) -> bool {
        let causes = self.known();
        let wanted = if self.truth.causes.len() == 1 { 1 } else { self.named.len() };
        !causes.is_empty()
            && causes.iter().all(|cause| self.named.iter().take(wanted).any(|named| named.holds(&cause.effect)))
    }

    /// Whether all true effects were named at their sites.
    pub fn is_at_site(&self) -> bool {
        self.is_hit() && self.known().iter().all(|c| self.named.iter().any(|named| named.is_at(&c.effect, &c.site)))
    }

    /// True causes that can be named: what no catalogue has goes by names that no effect has.
    fn nameable(&self) -> &[TruthCause] {
        match self.truth.kind {
            Kind::Trap | Kind::LeftOut => &[],
            _ => &self.truth.causes,
        }
    }

    /// Whether a named cause is a true one, or in a small enough group with it.
    pub fn is_true(&self, named: &Named) -> bool {
        self.nameable().iter().any(|cause| named.is_at(&cause.effect, &cause.site))
    }

    /// Whether a named cause is itself a true one.
    pub fn is_itself(&self, named: &Named) -> bool {
        self.nameable().iter().any(|cause| cause.effect == named.effect && cause.site == named.site)
    }

    /// Whether a named cause is an effect of the catalogue that is neither true nor tied with what is.
    pub fn is_false(&self, named: &Named) -> bool {
        named.is_of_catalogue() && !self.is_true(named) && !named.tied
    }

    /// Notes which of the effects named are tied with a true cause.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn compare(&mut self, signals: &Signals) -> Result<(), PredictionError> {
        for named in self.named.iter_mut().filter(|named| named.is_of_catalogue()) {
            let members: Vec<_> = named.members().map(|(e, s)| signals.are_reproduced_by(e, s)).collect();
            named.tied = members.into_iter().collect::<Result<Vec<bool>, _>>()?.contains(&true);
        }
        Ok(())
    }

    /// Whether any name is false.
    pub fn has_false_name(&self) -> bool {
        self.named.iter().any(|named| self.is_false(named))
    }

    /// Whether a named cause claims no law: a family, or a curve at a site where a true cause sits. Where the truth
    /// names no site, at any.
    fn claims_no_law(&self, named: &Named) -> bool {
        let is_there = |cause: &TruthCause| cause.site.is_empty() || cause.site == named.site;
        named.is_family() || named.is_free && self.truth.causes.iter().any(is_there)
    }

    /// Whether the answer is open: no effect of the catalogue, and no curve elsewhere.
    pub fn is_open(&self) -> bool {
        self.named.iter().all(|named| self.claims_no_law(named))
    }

    /// Whether the answer is right: hits of known kinds; of mixtures the known one, and no false name; no false name for
    /// what is unknown; no cause at all for nulls; open or tied where the effect was left out; readings that are not what
    /// they are said to be are refused, doubted, or nothing is named.
    pub fn is_right(&self) -> bool {
        match self.truth.kind {
            Kind::Null => self.named.is_empty() && self.verdict != "refused",
            Kind::Unknown => !self.has_false_name(),
            Kind::LeftOut => self.named.iter().all(|named| named.tied || self.claims_no_law(named)),
            Kind::Mixture => self.is_hit() && !self.has_false_name(),
            Kind::Trap => self.named.is_empty() || !self.doubted.is_empty(),
            Kind::Single | Kind::Pair | Kind::Triple => self.is_hit(),
        }
    }

    /// Whether the realised shrinkage lies in the promised interval.
    pub fn keeps_promise(&self) -> bool {
        self.promised_ci95.is_some_and(|[low, high]| (low..=high).contains(&self.realised))
    }
}
