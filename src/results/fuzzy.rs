//! What `identify --what fuzzy` and `--what grey` find. Rules in SI, errors in mm, forces in N.

use serde::Serialize;

use super::errors::ReadingErrors;
use super::units::{half_width_95, mm};
use crate::description::campaign::Campaign;
use crate::description::fuzzy::{Component, Input};
use crate::estimation::fuzzy::{self, FuzzyFit, GreyFit};
use crate::math::mean_rms_max;
use crate::model::Model;

/// Rules of one component of the compliance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComponentRules {
    pub name: String,
    /// Modal values of each input, rad and m.
    pub modes: Vec<Vec<f64>>,
    /// By rule, m/N.
    pub conclusions: Vec<f64>,
    /// By rule: how much data reach it.
    pub support: Vec<f64>,
    /// Rules that no data reach.
    pub unseen: Vec<usize>,
}

/// A step of the growth of rules.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GrowthStep {
    pub components: Vec<String>,
    /// The component that grew; `None` where all did.
    pub component: Option<String>,
    /// Sets of each input.
    pub sets: Vec<usize>,
    pub fit: Option<f64>,
    pub test: f64,
}

/// A ratio with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gain {
    pub gain: f64,
    pub ci95: f64,
}

/// Readings under one size of load.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoadLevel {
    pub force: f64,
    pub readings: usize,
    /// Measured over predicted.
    pub gain: f64,
    pub ci95: f64,
    /// Against loads of other sizes in the same directions; `None` where there are none.
    pub linear: Option<Gain>,
    /// Whether that differs from 1 by more than three sigma and two percent.
    #[serde(skip)]
    pub is_bent: bool,
}

/// Root mean square errors of a rigid robot, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RigidErrors {
    pub fit: f64,
    pub check: f64,
}

/// Errors of the fitted readings and of those held out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AfterFit {
    pub after: Option<ReadingErrors>,
    pub check_after: Option<ReadingErrors>,
}

/// An input of the rules.
#[derive(Debug, Clone, PartialEq)]
pub struct RuleInput {
    pub name: String,
    pub is_angle: bool,
    /// Where it was measured, rad or m.
    pub range: Option<[f64; 2]>,
    pub limits: Option<[f64; 2]>,
}

/// A fuzzy compliance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FuzzyCompliance {
    pub inputs: Vec<String>,
    pub components: Vec<ComponentRules>,
    /// Measured range of each input, rad and m.
    pub range: Vec<[f64; 2]>,
    /// Held-out readings outside that range.
    pub outside: usize,
    pub steps: Vec<GrowthStep>,
    pub levels: Vec<LoadLevel>,
    pub unit: &'static str,
    pub rigid: RigidErrors,
    pub residuals: AfterFit,
    #[serde(skip)]
    pub described: Vec<RuleInput>,
}

impl FuzzyCompliance {
    /// With the names of the fitted model.
    pub fn new(fit: &FuzzyFit) -> Self {
        let (model, grown) = (&fit.model, &fit.grown);
        let inputs: Vec<Input> = model.fuzzy.iter().flat_map(|fuzzy| &fuzzy.inputs).copied().collect();
        let range: Vec<[f64; 2]> = grown.used().into_iter().map(|k| grown.range[k]).collect();
        let components = model.fuzzy.iter().flat_map(|fuzzy| &fuzzy.components).zip(&grown.components);
        let described = inputs.iter().enumerate().map(|(k, &of)| RuleInput::new(model, of, range.get(k).copied()));
        let described: Vec<RuleInput> = described.collect();
        Self {
            inputs: described.iter().map(|input| input.name.clone()).collect(),
            components: components
                .map(|(component, own)| ComponentRules {
                    name: Component::name(component.at),
                    modes: component.modes.clone(),
                    conclusions: component.conclusions.clone(),
                    support: own.support.clone(),
                    unseen: own.unseen.clone(),
                })
                .collect(),
            range,
            outside: grown.beyond,
            steps: grown.steps.iter().map(GrowthStep::new).collect(),
            levels: fit.levels.iter().map(LoadLevel::new).collect(),
            unit: "mm",
            rigid: RigidErrors { fit: mm(fit.rigid[0]), check: mm(fit.rigid[1]) },
            residuals: AfterFit {
                after: ReadingErrors::new(&fit.errors[0]),
                check_after: ReadingErrors::new(&fit.errors[1]),
            },
            described,
        }
    }
}

impl RuleInput {
    fn new(model: &Model, of: Input, range: Option<[f64; 2]>) -> Self {
        let (name, is_angle) = model.input(of);
        let limits = match of {
            Input::Variable(k) => model.variables[k].limits,
            Input::Joint(k) => model.frames[k].limits,
        };
        Self { name: name.to_string(), is_angle, range, limits }
    }
}

impl GrowthStep {
    /// With the names of components.
    pub fn new(step: &fuzzy::Step) -> Self {
        Self {
            components: step.columns.iter().map(|&column| Component::name([step.axis, column])).collect(),
            component: step.column.map(|column| Component::name([step.axis, column])),
            sets: step.sets.clone(),
            fit: step.fitted.map(mm),
            test: mm(step.test),
        }
    }
}

impl LoadLevel {
    fn new(level: &fuzzy::Level) -> Self {
        let bent = |[gain, sigma]: [f64; 2]| (gain - 1.0).abs() > 3.0 * sigma && (gain - 1.0).abs() > 0.02;
        Self {
            force: level.force,
            readings: level.readings,
            gain: level.gain,
            ci95: half_width_95(level.sigma),
            linear: level.linear.map(|[gain, sigma]| Gain { gain, ci95: half_width_95(sigma) }),
            is_bent: level.linear.is_some_and(bent),
        }
    }
}

/// Errors over parts of the fitted readings left out in turns, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CrossValidated {
    pub without: f64,
    pub with: f64,
}

/// Springs with a fuzzy correction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GreyCompliance {
    /// Springs alone.
    pub parametric: AfterFit,
    pub cross_validated: CrossValidated,
    /// Whether the correction is kept.
    pub kept: bool,
    pub correction: Option<FuzzyCompliance>,
    pub unit: &'static str,
}

impl GreyCompliance {
    /// With the names of the fitted model.
    pub fn new(fit: &GreyFit) -> Self {
        let after = &fit.parametric.after;
        let [without, with] = fit.cross_validated.map(mm);
        Self {
            parametric: AfterFit {
                after: ReadingErrors::new(&after.fit),
                check_after: ReadingErrors::new(&after.check),
            },
            cross_validated: CrossValidated { without, with },
            kept: fit.correction.is_some(),
            correction: fit.correction.as_ref().map(FuzzyCompliance::new),
            unit: "mm",
        }
    }
}

/// Errors of a method under one load, mm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodRow {
    /// Force, N; `None` for all readings.
    pub load: Option<i64>,
    pub readings: usize,
    pub rms: f64,
    pub max: f64,
    pub max_x: f64,
    pub max_y: f64,
    pub max_z: f64,
}

/// Errors of a method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodErrors {
    pub method: &'static str,
    pub rows: Vec<MethodRow>,
}

impl MethodErrors {
    /// From residuals, three a reading (m), of the readings held out, or of all where there are none.
    pub fn new(method: &'static str, campaign: &Campaign, held_out: &[bool], residual: &[f64]) -> Self {
        let all = !held_out.contains(&true);
        let force = |k: usize| {
            let w = &campaign.readings[k].wrench;
            w[..3].iter().map(|v| v * v).sum::<f64>().sqrt().round() as i64
        };
        let judged: Vec<(i64, &[f64])> = residual
            .chunks(3)
            .enumerate()
            .filter(|(k, _)| all || held_out[*k])
            .map(|(k, reading)| (force(k), reading))
            .collect();
        let mut sizes: Vec<i64> = judged.iter().map(|(size, _)| *size).collect();
        sizes.sort_unstable();
        sizes.dedup();
        let row = |size: Option<i64>| {
            let of: Vec<&[f64]> =
                judged.iter().filter(|(own, _)| size.is_none_or(|size| *own == size)).map(|(_, r)| *r).collect();
            let [_, rms, max] = mean_rms_max(of.iter().map(|r| r.iter().map(|v| v * v).sum::<f64>().sqrt()));
            let axis = |k: usize| mm(of.iter().map(|r| r[k].abs()).fold(0.0, f64::max));
            let (max_x, max_y, max_z) = (axis(0), axis(1), axis(2));
            MethodRow { load: size, readings: of.len(), rms: mm(rms), max: mm(max), max_x, max_y, max_z }
        };
        Self { method, rows: sizes.iter().map(|size| row(Some(*size))).chain([row(None)]).collect() }
    }
}

/// Methods by load, as Table 5 of the IR663 calibration paper.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodComparison {
    pub unit: &'static str,
    /// Whether held-out readings are judged.
    pub check: bool,
    pub methods: Vec<MethodErrors>,
}

/// A result with the time it took.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Timed<T> {
    #[serde(flatten)]
    pub found: T,
    pub seconds: f64,
}
