//! Families of effects: what can be said of a cause when neither its site nor its law is certain.

use super::reading_context::Condition;
use super::site::SiteKind;
use crate::settings::named;

named! {
    /// A kind of cause.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum Family {
        /// A compliance: own weight, a payload, an applied wrench.
        Elastic "elastic",
        /// A joint stands elsewhere, by its own angle or another's.
        Kinematic "kinematic",
        /// What was done before counts: the last move, the side of approach.
        History "history",
        /// It goes with time.
        Time "time",
        /// It goes with temperature.
        Temperature "temperature",
        /// The instrument.
        Instrument "instrument",
        /// Constants of the description.
        Geometry "geometry",
        /// Single readings.
        Gross "gross",
    }
}

impl Family {
    /// That of an effect which reads these conditions and sits there.
    pub fn by_default(reads: &[Condition], sits_at: SiteKind) -> Self {
        match (reads.first(), sits_at) {
            (Some(Condition::Time), _) => Self::Time,
            (Some(Condition::Temperature), _) => Self::Temperature,
            (Some(Condition::Approach | Condition::LastMove), _) => Self::History,
            (None, SiteKind::Instrument) => Self::Instrument,
            (Some(Condition::GearRatio) | None, _) => Self::Kinematic,
        }
    }

    /// Something of the kind, in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Elastic => "a compliance under load",
            Self::Kinematic => "something that goes with the joints' positions",
            Self::History => "something that depends on the moves before",
            Self::Time => "something that goes with time",
            Self::Temperature => "something that goes with temperature",
            Self::Instrument => "something of the instrument",
            Self::Geometry => "a constant of the geometry",
            Self::Gross => "single readings",
        }
    }
}
