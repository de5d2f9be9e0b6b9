//! Gravity, masses and centres of mass of the description that are not those of the robot: it hangs, or stands on a wall or a slope,
//! two bodies are exchanged, a centre is on the other side, a decimal sign in another place.

use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;

use super::evidence::{Evidence, Limits};
use super::meant::{AsDeclared, alike};
use super::readings::AS_GOOD;
use super::shown::number;
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{RegistrationSettings, registered, row_sigmas};
use crate::math::{least_squares, orthonormal, project_off};
use crate::model::Model;
use crate::prediction::{Linearised, Predictor};

/// What may have been meant instead of the weights as declared; bodies by index in the structure's masses.
#[derive(Debug, Clone, Copy)]
enum Meant {
    /// Gravity, base frame, m/s2.
    Gravity(Vector3<f64>),
    /// Two bodies exchanged: their masses, their centres, or both.
    Exchanged(usize, usize, Part),
    /// The mass of a body times a factor.
    Mass(usize, f64),
    /// The centre of a body negated along this axis.
    Mirrored(usize, usize),
}

/// What of two bodies is exchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    Masses,
    Centres,
    Both,
}

/// Hypotheses fitted anew: the best in first order.
const FITTED: usize = 8;
/// A decimal sign in another place.
const DECIMALS: [f64; 2] = [10.0, 0.1];
/// Bodies up to which each two are exchanged.
const MOST_EXCHANGED: usize = 12;

impl Meant {
    /// All that a model admits, but for gravity in any direction.
    fn all(model: &Model) -> Vec<Self> {
        let gravity = model.structure.gravity;
        let axes = (0..3).flat_map(|axis| [1.0, -1.0].map(|sign| sign * gravity.norm() * Vector3::ith(axis, 1.0)));
        // Nearer than a few degrees it is the same, and a tilt.
        let is_elsewhere = |other: &Vector3<f64>| other.dot(&gravity) < 0.99 * gravity.norm_squared();
        let mut all: Vec<Self> = axes.filter(is_elsewhere).map(Self::Gravity).collect();
        let value = |body: usize, k: usize| model.registry[model.structure.masses[body].slot + k].nominal;
        let bodies = 0..model.structure.masses.len();
        let weighs = |body: &usize| value(*body, 0) > 0.0;
        for body in bodies.clone().filter(weighs) {
            all.extend(DECIMALS.map(|factor| Self::Mass(body, factor)));
            all.extend((0..3).filter(|&axis| value(body, axis + 1) != 0.0).map(|axis| Self::Mirrored(body, axis)));
        }
        if bodies.len() <= MOST_EXCHANGED {
            let pairs = bodies.clone().flat_map(|a| (a + 1..bodies.end).map(move |b| (a, b)));
            all.extend(
                pairs.flat_map(|(a, b)| {
                    [Part::Masses, Part::Centres, Part::Both].map(|part| Self::Exchanged(a, b, part))
                }),
            );
        }
        all
    }

    /// Changes a model, and the values of all its parameters, so.
    fn apply(self, model: &mut Model, values: &mut [f64]) {
        let slot = |body: usize| model.structure.masses[body].slot;
        match self {
            Self::Gravity(gravity) => model.structure.gravity = gravity,
            Self::Mass(body, factor) => values[slot(body)] *= factor,
            Self::Mirrored(body, axis) => values[slot(body) + 1 + axis] *= -1.0,
            Self::Exchanged(a, b, part) => {
                let of = match part {
                    Part::Masses => 0..1,
                    Part::Centres => 1..4,
                    Part::Both => 0..4,
                };
                of.for_each(|k| values.swap(slot(a) + k, slot(b) + k));
            }
        }
        for mass in &model.structure.masses {
            (mass.slot..mass.slot + 4).for_each(|slot| model.registry.all_mut()[slot].nominal = values[slot]);
        }
    }

    /// A model of which this holds.
    fn of(self, model: &Model) -> Model {
        let (mut meant, mut values) = (model.clone(), model.registry.nominal());
        self.apply(&mut meant, &mut values);
        meant
    }

    fn with(self, model: &Model) -> String {
        let name = |body: usize| model.frames[model.structure.masses[body].frame].name.as_str();
        match self {
            Self::Gravity(gravity) => {
                let from = model.structure.gravity.angle(&gravity).to_degrees();
                format!("`gravity: {}` ({from:.0} deg from that of the description)", written(&gravity))
            }
            Self::Exchanged(a, b, part) => {
                let what = match part {
                    Part::Masses => "the masses of bodies",
                    Part::Centres => "the centres of mass of bodies",
                    Part::Both => "the bodies",
                };
                format!("{what} `{}` and `{}` exchanged", name(a), name(b))
            }
            Self::Mass(body, factor) => format!("the mass of body `{}` times {}", name(body), number(factor)),
            Self::Mirrored(body, axis) => {
                format!("{} of the centre of mass of body `{}` negated", ["x", "y", "z"][axis], name(body))
            }
        }
    }

    fn question(self) -> &'static str {
        match self {
            Self::Gravity(_) => "is its sign wrong, or does the robot hang, or stand on a wall or a slope",
            Self::Exchanged(..) => "rows of `bodies:` exchanged",
            Self::Mass(..) => "a decimal sign in another place",
            Self::Mirrored(..) => "a centre measured from the other side, or in other axes",
        }
    }

    fn remedy(self) -> String {
        match self {
            Self::Gravity(gravity) => format!(
                "`gravity` is the acceleration in axes of the base: `gravity: {}`, as of a robot so mounted",
                written(&gravity)
            ),
            _ => "look at `bodies:`: the mass of each and its centre, in axes of its frame, against the maker's data"
                .into(),
        }
    }
}

fn written(gravity: &Vector3<f64>) -> String {
    // Adding zero takes the sign of what rounds to none.
    let component = |k: usize| ((100.0 * gravity[k]).round() / 100.0 + 0.0).to_string();
    format!("[{}, {}, {}]", component(0), component(1), component(2))
}

/// Readings in standard deviations to first order about the registered description, without what the parameters of a calibration can take
/// up: with wrong weights the calibration itself may have run far off.
struct FirstOrder<'a> {
    declared: &'a AsDeclared<'a>,
    sigmas: DVector<f64>,
    /// What the parameters span.
    basis: DMatrix<f64>,
}

impl<'a> FirstOrder<'a> {
    fn new(model: &Model, declared: &'a AsDeclared, values: &[f64]) -> Option<Self> {
        let sigmas = DVector::from_vec(row_sigmas(&declared.campaign));
        let predictor = Predictor::new(model, &declared.campaign, declared.slots.clone()).ok()?;
        let found = predictor.linearised(values).ok()?;
        let width = declared.slots.len();
        let columns = DMatrix::from_fn(sigmas.len(), width, |row, k| found.jacobian[row * width + k] / sigmas[row]);
        Some(Self { declared, basis: orthonormal(&columns, None), sigmas })
    }

    fn left(&self, model: &Model, values: &[f64]) -> Option<DVector<f64>> {
        let mut found = Linearised::default();
        let predictor = Predictor::new(model, &self.declared.campaign, Vec::new()).ok()?;
        predictor.linearise(values, false, &mut found).ok()?;
        let residual = DVector::from_vec(found.residual).component_div(&self.sigmas);
        residual.iter().all(|value| value.is_finite()).then(|| project_off(&residual, &self.basis))
    }
}

/// Step of the difference quotients by the direction of gravity, rad: what carries weight is linear in it, but for springs that meet
/// stops.
const TILT: f64 = 0.02;
/// Least share by which a step of the direction lowers what is left, in first order, to be followed.
const LOWERED: f64 = 0.1;

/// The direction of gravity that leaves least, by two Gauss-Newton steps on the sphere, the springs fitted anew between them.
fn tilted(model: &Model, declared: &AsDeclared, start: &[f64]) -> Option<Meant> {
    let mut own = model.clone();
    let mut values = start.to_vec();
    let size = own.structure.gravity.norm();
    for step in 0..2 {
        let gravity = own.structure.gravity;
        let first = FirstOrder::new(&own, declared, &values)?;
        let here = first.left(&own, &values)?;
        let down = gravity.normalize();
        let across = down.cross(&Vector3::ith(down.iamin(), 1.0)).normalize();
        let sides = [across, down.cross(&across)];
        let turned = |by: Vector3<f64>| size * (down + by).normalize();
        let column = |side: &Vector3<f64>| {
            let mut moved = own.clone();
            moved.structure.gravity = turned(TILT * side);
            Some((first.left(&moved, &values)? - &here) / TILT)
        };
        let columns = DMatrix::from_columns(&[column(&sides[0])?, column(&sides[1])?]);
        let by = least_squares(&columns, &-&here);
        if step == 0 && (&here + &columns * &by).norm() > (1.0 - LOWERED) * here.norm() {
            return None;
        }
        own.structure.gravity = turned(sides[0] * by[0] + sides[1] * by[1]);
        values = declared.fitted(&own, &declared.campaign)?.values;
    }
    Some(Meant::Gravity(own.structure.gravity))
}

/// Where calibration leaves more than the noise, the same with the weights as they may be meant, on some of the configurations: those that
/// leave least in first order are fitted.
pub(super) fn as_declared(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let model = evidence.model;
    let weighs = !model.structure.masses.is_empty() || evidence.campaign.readings.iter().any(|of| of.payload.is_some());
    if model.structure.gravity.norm() == 0.0 || !weighs {
        return Vec::new();
    }
    let named = AsDeclared::new(evidence, limits).and_then(|declared| otherwise(model, &declared));
    named.into_iter().collect()
}

fn otherwise(model: &Model, declared: &AsDeclared) -> Option<Diagnostic> {
    let registered = registered(model, &declared.campaign, &model.registry.nominal(), &RegistrationSettings::default());
    let (start, _) = registered.ok()?;
    let first = FirstOrder::new(model, declared, &start)?;
    let here = first.left(model, &start)?.norm();
    let left = |meant: Meant| {
        let (mut own, mut values) = (model.clone(), start.clone());
        meant.apply(&mut own, &mut values);
        first.left(&own, &values).map(|left| (meant, left.norm())).filter(|(_, left)| *left < here)
    };
    let mut all: Vec<(Meant, f64)> = Meant::all(model).into_par_iter().filter_map(left).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    let tilted = tilted(model, declared, &start);
    // Gravity turned round bends too much for the first order.
    let axes = Meant::all(model).into_iter().filter(|meant| matches!(meant, Meant::Gravity(_)));
    all.retain(|(meant, _)| !matches!(meant, Meant::Gravity(_)));
    let others = all.into_iter().take(FITTED).map(|(meant, _)| meant);
    let chosen: Vec<Meant> = tilted.into_iter().chain(axes).chain(others).collect();
    let fitted = |meant: Meant| Some((meant, declared.decisive(&meant.of(model), &declared.campaign)?));
    let mut tried: Vec<(Meant, f64)> = chosen.into_par_iter().filter_map(fitted).collect();
    tried.sort_by(|a, b| a.1.total_cmp(&b.1));
    let &(best, there) = tried.first()?;
    let as_good = tried.iter().skip(1).filter(|(_, error)| *error <= AS_GOOD * there);
    let others = alike(as_good.map(|(meant, error)| (meant.with(model), *error, meant.question())));
    let fall = declared.fall(there);
    let message = format!("{}: {}?{others}", fall.words(&best.with(model)), best.question());
    Some(fall.put(Diagnostic::error(message).code(Code::Misread).remedy(best.remedy())))
}
