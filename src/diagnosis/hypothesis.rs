//! Hypotheses: every effect at every site of the robot with every value of its nonlinear parameters.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::level::Level;
use super::result::EffectAtSite;
use super::settings::Settings;
use crate::effects::{Condition, Driver, Effect, EffectParameter, Family, Nonlinear, NonlinearValue, Site, Survey};
use crate::math::independent;
use crate::model::{Model, SiteKind};
use crate::parameter::Slot;

/// An effect at a site with values of its nonlinear parameters, and its columns in the linear problem.
#[derive(Clone)]
pub struct Hypothesis {
    /// The effect.
    pub effect: Arc<dyn Effect>,
    /// The site.
    pub site: Site,
    /// Names of the sites of which laws are parts of it ([`Effect::covers`]).
    pub covers: Vec<String>,
    /// Values of its nonlinear parameters.
    pub nonlinear: Nonlinear,
    /// Constants of the model that it frees, if it is nothing else.
    pub constants: Vec<Slot>,
    /// Names, units and scales of its parameters.
    pub parameters: Vec<EffectParameter>,
    /// Weighted columns.
    pub columns: DMatrix<f64>,
    /// Its parameters can only be positive: compliances of what the description has rigid.
    pub is_positive: bool,
    /// Number of hypotheses of this effect at this site.
    pub variants: usize,
    /// The compliance of its joint, where it changes that.
    pub compliance: Option<JointCompliance>,
}

/// The compliance of a joint at the configurations of a campaign, m/N or rad/(N.m): a spring does not push against its load.
#[derive(Clone)]
pub struct JointCompliance {
    /// The parameter that is the constant part.
    pub slot: Slot,
    /// The constant part; `None` where it is calibrated with every hypothesis.
    pub constant: Option<f64>,
    /// Configurations x parameters of the hypothesis: what one unit of each adds.
    pub by_amount: DMatrix<f64>,
}

/// Share of the change of a compliance by which the sum may be below zero: what noise and a shape that is a little off leave. A judgement.
const BELOW_ZERO: f64 = 0.1;

impl JointCompliance {
    /// Whether amounts make it negative somewhere in the campaign.
    pub fn is_negative(&self, amounts: &DVector<f64>) -> bool {
        let Some(constant) = self.constant else { return false };
        let change = &self.by_amount * amounts;
        change.min() + constant < -BELOW_ZERO * change.amax()
    }
}

impl std::fmt::Debug for Hypothesis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {:?}", self.label(), self.nonlinear.values())
    }
}

impl Hypothesis {
    /// `effect@site`
    pub fn label(&self) -> String {
        format!("{}@{}", self.effect.name(), self.site.name)
    }

    /// Effect and site by name.
    pub fn named(&self) -> EffectAtSite {
        EffectAtSite { effect: self.effect.name().into(), site: self.site.name.clone() }
    }

    /// Leaves out the constants, the amounts of a free curve and those of all joints together whose columns the nuisance or its own other columns
    /// reproduce entirely. The parameters of any other effect belong together: they are left out all or none.
    pub fn prune(&mut self, nuisance: &DMatrix<f64>) {
        let kept = independent(&self.columns, nuisance);
        let is_of_joints = self.site.kind == SiteKind::Joints;
        if self.constants.is_empty() && !self.effect.is_free_form() && !is_of_joints {
            if kept.is_empty() {
                self.parameters.clear();
            }
        } else if kept.len() < self.columns.ncols() {
            self.columns = self.columns.select_columns(&kept);
            if !self.constants.is_empty() {
                self.constants = kept.iter().map(|&k| self.constants[k]).collect();
            }
            self.parameters = kept.iter().map(|&k| self.parameters[k].clone()).collect();
        }
    }

    /// What it follows, as a column or a curve is named, `names` being those of the coordinates; `is_loaded` says whether a wrench
    /// is applied. `None` of constants.
    pub fn follows(&self, names: &[String], is_loaded: bool) -> Option<String> {
        let own = |driver: fn(usize) -> Driver| self.site.coordinate.map(|own| driver(own).written(names));
        let stated = self.nonlinear.values().into_iter().find_map(|value| match value {
            NonlinearValue::Driver(driver) => Some(driver.written(names)),
            NonlinearValue::Variable(variable) => Some(Driver::Angle(variable).written(names)),
            _ => None,
        });
        let is_joint = self.site.kind == SiteKind::Joint;
        stated.or_else(|| match (self.family(), is_joint) {
            (Family::Elastic, true) => own(if is_loaded { Driver::Load } else { Driver::OwnLoad }),
            (Family::Elastic, false) => Some(if is_loaded { "load".into() } else { "own-load".into() }),
            (Family::Kinematic, _) => own(Driver::Angle),
            (Family::History, _) if self.effect.reads().contains(&Condition::Approach) => {
                Some(format!("approach.{}", own(Driver::Angle)?))
            }
            (Family::History, true) => own(Driver::LastMove),
            (Family::History, false) => Some("moves".into()),
            (Family::Time, _) => Some(Driver::Time.written(names)),
            (Family::Temperature, _) => Some(Driver::Temperature.written(names)),
            (Family::Instrument, _) => Some("position".into()),
            (Family::Geometry | Family::Gross, _) => None,
        })
    }

    /// Whether none of its amounts can be below zero: compliances of what is rigid, and elastic laws of which the effect says so.
    pub fn is_never_negative(&self) -> bool {
        let is_of_law = || self.parameters.iter().all(|own| own.is_positive) && self.family() == Family::Elastic;
        self.is_positive || self.constants.is_empty() && is_of_law()
    }

    /// Whether its law is a free curve.
    pub fn is_free(&self) -> bool {
        self.effect.is_free_form()
    }

    /// Whether it is a curve over the position of the joint where it sits.
    pub fn is_over_own_position(&self) -> bool {
        self.knots_over_own_position().is_some()
    }

    fn knots_over_own_position(&self) -> Option<Arc<[f64]>> {
        let own = self.site.coordinate.filter(|_| self.site.kind == SiteKind::Joint)?;
        match &self.nonlinear.values()[..] {
            [NonlinearValue::Driver(Driver::Angle(variable)), NonlinearValue::Knots(at)] if *variable == own => {
                Some(at.clone())
            }
            _ => None,
        }
    }

    /// Whether, such a curve, it changes between two knots by more than a share of what the joint moves. `amounts` are those of its parameters.
    pub fn is_steeper(&self, amounts: &DVector<f64>, share: f64) -> bool {
        let Some(at) = self.knots_over_own_position() else { return false };
        let amount = |k: usize| {
            let name = format!("k{}", k + 1);
            // One that was left out is what the others are counted from.
            self.parameters.iter().zip(amounts).find(|(own, _)| own.symbol == name).map_or(0.0, |(_, amount)| *amount)
        };
        (1..at.len()).any(|k| (amount(k) - amount(k - 1)).abs() > share * (at[k] - at[k - 1]).abs())
    }

    /// What kind of thing it is.
    pub fn family(&self) -> Family {
        self.effect.family(&self.nonlinear)
    }

    /// Whether it is named by what it goes with, the last move or the load, in whatever way it does: lags and compliances.
    pub fn is_named_by_driver(&self) -> bool {
        matches!(self.family(), Family::History | Family::Elastic)
    }

    /// Whether it sits at a site, or holds laws there.
    pub fn is_of_site(&self, site: &str) -> bool {
        self.site.name == site || self.covers.iter().any(|own| own == site)
    }

    /// Whether it sits where another does, or holds laws of its family there.
    pub fn is_at(&self, law: &Self) -> bool {
        self.site.name == law.site.name || self.family() == law.family() && self.covers.contains(&law.site.name)
    }

    /// Whether it is a curve that can do all that a law does: one of its family where it sits.
    pub fn holds(&self, law: &Self) -> bool {
        self.is_free() && !law.is_free() && self.family() == law.family() && self.is_at(law)
    }

    /// What a curve tells where nothing else does as well: at a joint, by the angle of another, its family alone. A joint whose axis tilts as
    /// it turns moves what comes after it as such a curve at the next one does.
    pub fn level_by_driver(&self) -> Level {
        let is_of_another = |value: &NonlinearValue| match value {
            NonlinearValue::Driver(Driver::Angle(variable)) | NonlinearValue::Variable(variable) => {
                self.site.coordinate.is_some_and(|own| own != *variable)
            }
            _ => false,
        };
        match self.family() == Family::Kinematic && self.nonlinear.values().iter().any(is_of_another) {
            true => Level::Family,
            false => self.level(),
        }
    }

    /// What a curve without a law tells: where it holds laws of several sites, their family alone.
    pub fn level(&self) -> Level {
        if self.covers.len() > 1 { Level::Family } else { Level::Site }
    }

    /// Whether another is the same effect at the same site.
    pub fn is_same(&self, other: &Self) -> bool {
        self.effect.name() == other.effect.name() && self.site.name == other.site.name
    }

    /// Whether another frees other constants of the same effect, or is the very same: the two cannot go together.
    pub fn excludes(&self, other: &Self) -> bool {
        self.is_same(other) && (!self.constants.is_empty() || self.nonlinear == other.nonlinear)
    }
}

/// All hypotheses that can be tried on a model at `values`, `nuisance` being what is calibrated with every one of them.
/// Their columns are still empty.
pub fn hypotheses(
    model: &Model,
    values: &[f64],
    nuisance: &[Slot],
    survey: &Survey,
    settings: &Settings,
) -> Vec<Hypothesis> {
    let is_rigid = |slot: &Slot| model.registry[*slot].bounds[0] == 0.0 && values[*slot] == 0.0;
    let mut found = Vec::new();
    for effect in model.catalogue.iter() {
        let is_known = settings.known.iter().any(|name| name == effect.name());
        for site in effect.sites(model) {
            let mut candidates = effect.candidates(model, &site, survey);
            candidates.retain(|nonlinear| effect.is_identifiable(&site, survey, nonlinear));
            let covers = effect.covers(model, &site);
            for nonlinear in &candidates {
                let constants = effect.constants(model, &site, nonlinear);
                let parameters = effect.parameters(model, &site, nonlinear);
                let is_calibrated = !constants.is_empty() && constants.iter().all(|slot| nuisance.contains(slot));
                let is_positive = !constants.is_empty() && constants.iter().all(is_rigid);
                // Known are the compliances that the description has: a joint that it has rigid is not among them.
                if parameters.is_empty() || is_calibrated || is_known && !is_positive {
                    continue;
                }
                // Compliances of what is rigid cannot be negative. Each may be zero: every selection is a hypothesis.
                let selections = if is_positive { (1 << constants.len()) - 1 } else { 1 };
                for selection in 1..=selections {
                    let is_chosen = |k: usize| !is_positive || selection >> k & 1 == 1;
                    let chosen_parameters = parameters.iter().enumerate().filter(|(k, _)| is_chosen(*k));
                    let chosen_constants = constants.iter().enumerate().filter(|(k, _)| is_chosen(*k));
                    found.push(Hypothesis {
                        effect: effect.clone(),
                        site: site.clone(),
                        covers: covers.clone(),
                        nonlinear: nonlinear.clone(),
                        constants: chosen_constants.map(|(_, slot)| *slot).collect(),
                        parameters: chosen_parameters.map(|(_, parameter)| parameter.clone()).collect(),
                        columns: DMatrix::zeros(0, 0),
                        is_positive,
                        variants: candidates.len() * selections,
                        compliance: None,
                    });
                }
            }
        }
    }
    found
}
