//! An effect of the standard catalogue as data: its words are values, what depends on model, site or reading are functions.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::model::{
    Change, Changes, Condition, Effect, EffectParameter, Family, Model, Nonlinear, NonlinearParameter, ReadingContext,
    Site, SiteKind, Survey,
};
use crate::parameter::Slot;

/// The parameters of an effect at a site.
type ParametersOf = fn(&Model, &Site, &Nonlinear) -> Vec<EffectParameter>;
/// What one unit of each parameter adds to the compliance of its joint where the joints of the frames stand so.
type ComplianceOf = fn(&Site, &Nonlinear, &[f64]) -> Vec<f64>;

/// What [`Effect`] asks, field by field; `None` stands for the default there.
pub struct Law {
    pub name: &'static str,
    pub sits_at: SiteKind,
    pub family: Option<fn(&Nonlinear) -> Family>,
    pub signature: &'static str,
    pub remedy: &'static str,
    pub reads: &'static [Condition],
    pub nonlinear: &'static [&'static NonlinearParameter],
    pub is_of_the_measurement: bool,
    pub is_free_form: bool,
    /// Whether it comes again in every session, although it goes with time.
    pub recurs: bool,
    /// As [`Effect::remains`].
    pub remains: Option<&'static str>,
    /// As [`Effect::cancels_in_differences`].
    pub cancels_in_differences: bool,
    pub sites: Option<fn(&Model) -> Vec<Site>>,
    /// As [`Effect::misplaced`].
    pub misplaced: fn(&Site, &Nonlinear) -> Option<(&'static str, &'static str)>,
    pub candidates: fn(&Model, &Site, &Survey) -> Vec<Nonlinear>,
    pub is_identifiable: fn(&Site, &Survey, &Nonlinear) -> bool,
    pub covers: Option<fn(&Model, &Site) -> Vec<String>>,
    pub is_another_at_ends: fn(&Nonlinear) -> [bool; 2],
    pub constants: fn(&Model, &Site, &Nonlinear) -> Vec<Slot>,
    pub parameters: Option<ParametersOf>,
    /// As [`Effect::greatest_amount`].
    pub greatest_amount: Option<f64>,
    /// As [`Effect::compliance`].
    pub compliance: Option<ComplianceOf>,
    pub thermal_delay: fn(&Nonlinear) -> Option<f64>,
    /// As [`Effect::period`].
    pub period: fn(&Nonlinear) -> Option<f64>,
    pub changes: fn(&Model, &Site, &Nonlinear) -> Changes,
}

impl Law {
    /// One that is tried in one form and changes nothing: what a law leaves out.
    pub const NOTHING: Self = Self {
        name: "",
        sits_at: SiteKind::Joint,
        family: None,
        signature: "",
        remedy: "",
        reads: &[],
        nonlinear: &[],
        is_of_the_measurement: false,
        is_free_form: false,
        recurs: false,
        remains: None,
        cancels_in_differences: false,
        sites: None,
        misplaced: |_, _| None,
        candidates: |_, _, _| vec![Nonlinear::default()],
        is_identifiable: |_, _, _| true,
        covers: None,
        is_another_at_ends: |_| [false; 2],
        constants: |_, _, _| Vec::new(),
        parameters: None,
        greatest_amount: None,
        compliance: None,
        thermal_delay: |_| None,
        period: |_| None,
        changes: |_, _, _| nothing(),
    };
}

/// Changes nothing, whatever the reading.
pub fn nothing() -> Changes {
    Arc::new(|_, _| {})
}

/// The base moves by this amount along each axis of the measurement frame, and turns by it about each: parameters from the
/// `first` on.
pub fn base_moves(context: &ReadingContext, amount: f64, first: usize, out: &mut Vec<(usize, Change)>) {
    for k in 0..3 {
        let axis = Vector3::ith(k, amount);
        out.push((first + k, Change::Point(axis, Vector3::zeros())));
        out.push((first + k + 3, Change::Point(axis.cross(&(context.position - context.base)), axis)));
    }
}

/// The measured point moves by this amount along each axis of the body that carries it: parameters from the `first` on.
pub fn tool_moves(context: &ReadingContext, amount: f64, first: usize, out: &mut Vec<(usize, Change)>) {
    let moved = |k| context.body * Vector3::ith(k, amount);
    out.extend((0..3).map(|k| (first + k, Change::Point(moved(k), Vector3::zeros()))));
}

impl Effect for &'static Law {
    fn name(&self) -> &'static str {
        self.name
    }

    fn sits_at(&self) -> SiteKind {
        self.sits_at
    }

    fn signature(&self) -> &'static str {
        self.signature
    }

    fn remedy(&self) -> &'static str {
        self.remedy
    }

    fn sites(&self, model: &Model) -> Vec<Site> {
        self.sites.map_or_else(|| model.sites(self.sits_at), |sites| sites(model))
    }

    fn is_of_the_measurement(&self, site: &Site) -> bool {
        self.is_of_the_measurement || site.kind == SiteKind::Instrument
    }

    fn recurs(&self) -> bool {
        self.recurs
    }

    fn remains(&self) -> Option<&'static str> {
        self.remains
    }

    fn family(&self, nonlinear: &Nonlinear) -> Family {
        self.family.map_or_else(|| Family::by_default(self.reads, self.sits_at), |family| family(nonlinear))
    }

    fn is_free_form(&self) -> bool {
        self.is_free_form
    }

    fn cancels_in_differences(&self) -> bool {
        self.cancels_in_differences
    }

    fn covers(&self, model: &Model, site: &Site) -> Vec<String> {
        self.covers.map_or_else(|| vec![site.name.clone()], |covers| covers(model, site))
    }

    fn is_another_at_ends(&self, nonlinear: &Nonlinear) -> [bool; 2] {
        (self.is_another_at_ends)(nonlinear)
    }

    fn period(&self, nonlinear: &Nonlinear) -> Option<f64> {
        (self.period)(nonlinear)
    }

    fn reads(&self) -> &'static [Condition] {
        self.reads
    }

    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        self.nonlinear.to_vec()
    }

    fn misplaced(&self, site: &Site, nonlinear: &Nonlinear) -> Option<(&'static str, &'static str)> {
        (self.misplaced)(site, nonlinear)
    }

    fn is_identifiable(&self, site: &Site, survey: &Survey, nonlinear: &Nonlinear) -> bool {
        (self.is_identifiable)(site, survey, nonlinear)
    }

    fn candidates(&self, model: &Model, site: &Site, survey: &Survey) -> Vec<Nonlinear> {
        if self.cancels_in_differences && survey.is_difference {
            return Vec::new();
        }
        (self.candidates)(model, site, survey)
    }

    fn constants(&self, model: &Model, site: &Site, nonlinear: &Nonlinear) -> Vec<Slot> {
        (self.constants)(model, site, nonlinear)
    }

    fn parameters(&self, model: &Model, site: &Site, nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        match self.parameters {
            Some(parameters) => parameters(model, site, nonlinear),
            None => model.shifts_of(&self.constants(model, site, nonlinear)),
        }
    }

    fn greatest_amount(&self) -> Option<f64> {
        self.greatest_amount
    }

    fn compliance(&self, site: &Site, nonlinear: &Nonlinear, joints: &[f64]) -> Option<Vec<f64>> {
        self.compliance.map(|compliance| compliance(site, nonlinear, joints))
    }

    fn thermal_delay(&self, nonlinear: &Nonlinear) -> Option<f64> {
        (self.thermal_delay)(nonlinear)
    }

    fn changes(&self, model: &Model, site: &Site, nonlinear: &Nonlinear) -> Changes {
        (self.changes)(model, site, nonlinear)
    }
}
