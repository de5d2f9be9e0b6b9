//! What the tool carries, stated with a mass or a centre in another unit, on the other side, or in other rows: springs take up part of it,
//! and the rest is left.

use rayon::prelude::*;

use super::evidence::{Evidence, Limits};
use super::meant::{AsDeclared, alike};
use super::readings::AS_GOOD;
use super::shown::number;
use crate::description::campaign::Campaign;
use crate::description::elastic::Payload;
use crate::diagnostic::{Code, Diagnostic};

/// What may have been meant instead of the payloads as declared.
#[derive(Debug, Clone, Copy)]
enum Meant {
    /// Their masses times a factor, and what the number then is.
    Mass(f64, &'static str),
    /// Their centres of mass times a factor, and what the number then is.
    Com(f64, &'static str),
    /// Their centres on the other side: negated along this axis, or along all.
    Mirrored(Option<usize>),
    /// Two of them, by index in the campaign's list, exchanged in the rows; one behind its end is none.
    Exchanged(usize, usize),
}

/// Pound, kg.
const POUND: f64 = 0.453_592_37;
/// Standard gravity, m/s2.
const GRAVITY: f64 = 9.80665;

/// Powers of ten, pounds and weights for masses; units of length and senses for centres.
const MEANT: [Meant; 16] = [
    Meant::Mass(0.1, "a decimal sign in another place"),
    Meant::Mass(10.0, "a decimal sign in another place"),
    Meant::Mass(1e-3, "a mass in g"),
    Meant::Mass(1e3, "a mass in t"),
    Meant::Mass(POUND, "a mass in lb"),
    Meant::Mass(1.0 / POUND, "a mass in kg where lb were meant"),
    Meant::Mass(1.0 / GRAVITY, "a weight in N"),
    Meant::Mass(GRAVITY, "a mass divided by gravity"),
    Meant::Com(10.0, "a centre in cm"),
    Meant::Com(0.1, "a centre in mm where cm were meant"),
    Meant::Com(1e3, "a centre in m"),
    Meant::Com(25.4, "a centre in inches"),
    Meant::Mirrored(None),
    Meant::Mirrored(Some(0)),
    Meant::Mirrored(Some(1)),
    Meant::Mirrored(Some(2)),
];

/// What to do about payloads in other rows, or with their centre on the other side.
const ROWS: &str = "look at `payloads:` and at the column `payload`: which row carried what, and where its centre is in the tool's axes";

/// Payloads up to which each two of them, and each of them and none, are exchanged.
const MOST_EXCHANGED: usize = 4;

impl Meant {
    /// All that a campaign admits.
    fn all(campaign: &Campaign) -> Vec<Self> {
        let carried: Vec<Payload> = campaign.readings.iter().filter_map(|reading| reading.payload).collect();
        let is_off = |axis: usize| carried.iter().any(|payload| payload.com[axis] != 0.0);
        let axes = (0..3).filter(|axis| is_off(*axis)).count();
        let shows = |meant: &Self| match *meant {
            Self::Mass(..) => carried.iter().any(|payload| payload.mass > 0.0),
            Self::Com(..) => axes > 0,
            // Along a single axis it is that of all.
            Self::Mirrored(None) => axes > 0,
            Self::Mirrored(Some(axis)) => axes > 1 && is_off(axis),
            Self::Exchanged(..) => true,
        };
        let own = campaign.payloads.len();
        // In every row the same payload is carried, or none.
        let varies = campaign.readings.iter().any(|reading| reading.payload != campaign.readings[0].payload);
        let most = if varies && own <= MOST_EXCHANGED { own } else { 0 };
        let pairs = (0..most).flat_map(|a| (a + 1..=most).map(move |b| Self::Exchanged(a, b)));
        MEANT.into_iter().filter(shows).chain(pairs).collect()
    }

    fn apply(self, campaign: &Campaign) -> Campaign {
        let mut meant = campaign.clone();
        let of = |index: usize| campaign.payloads.get(index).map(|(_, payload)| *payload);
        for reading in &mut meant.readings {
            match (self, &mut reading.payload) {
                (Self::Mass(factor, _), Some(payload)) => payload.mass *= factor,
                (Self::Com(factor, _), Some(payload)) => payload.com *= factor,
                (Self::Mirrored(None), Some(payload)) => payload.com *= -1.0,
                (Self::Mirrored(Some(axis)), Some(payload)) => payload.com[axis] *= -1.0,
                (Self::Exchanged(a, b), own) if *own == of(a) => *own = of(b),
                (Self::Exchanged(a, b), own) if *own == of(b) => *own = of(a),
                _ => {}
            }
        }
        meant
    }

    fn with(self, campaign: &Campaign) -> String {
        let name = |index: usize| campaign.payloads.get(index).map_or("none", |(name, _)| name.as_str());
        match self {
            Self::Mass(factor, _) => format!("the payload's mass times {}", number(factor)),
            Self::Com(factor, _) => format!("the payload's centre of mass times {}", number(factor)),
            Self::Mirrored(None) => "the payload's centre of mass negated".into(),
            Self::Mirrored(Some(axis)) => format!("{} of the payload's centre of mass negated", ["x", "y", "z"][axis]),
            Self::Exchanged(a, b) => format!("the payloads `{}` and `{}` exchanged", name(a), name(b)),
        }
    }

    fn question(self) -> &'static str {
        match self {
            Self::Mass(_, question) | Self::Com(_, question) => question,
            Self::Mirrored(_) => "a centre measured from the other side, or in other axes",
            Self::Exchanged(..) => "names exchanged in the column `payload`",
        }
    }

    /// Whether it is a matter of units.
    fn is_unit(self) -> bool {
        matches!(self, Self::Mass(..) | Self::Com(..))
    }
}

/// Where calibration leaves more than the noise, the same with the payload as it may be meant, on some of the configurations. It is named where
/// nothing but noise is left, or a small part of the error: springs that are off leave much with any payload.
pub(super) fn as_declared(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let all = Meant::all(campaign);
    let Some(declared) = (!all.is_empty()).then(|| AsDeclared::new(evidence, limits)).flatten() else {
        return Vec::new();
    };
    let left = |meant: Meant| declared.decisive(model, &meant.apply(&declared.campaign));
    let mut tried: Vec<(Meant, f64)> =
        all.into_par_iter().filter_map(|meant| left(meant).map(|there| (meant, there))).collect();
    tried.sort_by(|a, b| a.1.total_cmp(&b.1));
    let Some(&(best, there)) = tried.first() else { return Vec::new() };
    let with = |meant: Meant| meant.with(campaign);
    let as_good = tried.iter().skip(1).filter(|(_, error)| *error <= AS_GOOD * there);
    let others = alike(as_good.map(|(meant, error)| (with(*meant), *error, meant.question())));
    let fall = declared.fall(there);
    let message = format!("{}: {}?{others}", fall.words(&with(best)), best.question());
    let remedy = "look at `mass` and `com` under `payloads:`, and at `units:`; weigh what the tool carried; or are springs that are held off by \
                  as much?";
    // Springs that are off stand in for another mass, and for no other rows.
    let diagnostic = match best.is_unit() {
        true => Diagnostic::warning(message).code(Code::WrongUnits).remedy(remedy),
        false => Diagnostic::error(message).code(Code::Misread).remedy(ROWS),
    };
    vec![fall.put(diagnostic)]
}
