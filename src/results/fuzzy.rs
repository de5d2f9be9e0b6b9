//! What `identify --what fuzzy` and `--what grey` find. Rules in SI, errors in mm, forces in N.

use serde::Serialize;

use super::errors::ReadingErrors;
use super::units::{half_width_95, mm};
use crate::description::campaign::Campaign;
use crate::description::fuzzy::{Branch, Component, Input, Premise, Rules};
use crate::estimation::Errors;
use crate::estimation::fuzzy::{self, FuzzyFit, GreyFit, LocalFit, TreeStep};
use crate::math::{distinct, mean_rms_max, norm};
use crate::model::Model;
use crate::parameter::Slot;

/// A premise of a rule about one input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Condition {
    /// About a modal value, rad or m.
    About(usize, f64),
    /// At the lower (`false`) or upper end of a range, rad or m.
    Towards(usize, [f64; 2], bool),
}

/// A split of a tree of rules, rad or m.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RuleSplit {
    /// Name of the input that it splits.
    pub input: String,
    /// Value up to which only `below` holds.
    pub from: f64,
    /// Value from which only `above` holds.
    pub to: f64,
    /// Where small values of the input lead.
    pub below: RuleBranch,
    /// Where great values of the input lead.
    pub above: RuleBranch,
}

/// What a split leads to, by number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RuleBranch {
    /// Another split, by its position in `splits`.
    Split(usize),
    /// A rule, by its position in `conclusions`.
    Rule(usize),
}

/// Rules of one component of the compliance, or of a spring.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComponentRules {
    /// Component as displacement and load (`z.fz`), or the name of the spring.
    pub name: String,
    /// Modal values of each input, rad and m; empty for a tree.
    pub modes: Vec<Vec<f64>>,
    /// Splits of a tree, the first one the root.
    pub splits: Vec<RuleSplit>,
    /// By rule, m/N; of springs their stiffness, N/m or N.m/rad, `null` where rigid.
    pub conclusions: Vec<f64>,
    /// By rule: how much data reach it.
    pub support: Vec<f64>,
    /// Rules that no data reach.
    pub unseen: Vec<usize>,
    /// Conditions of each rule, in the order of `conclusions`.
    #[serde(skip)]
    pub premises: Vec<Vec<Condition>>,
    /// Unit of the conclusions as text shows them, and how many of them are one in SI.
    #[serde(skip)]
    pub shown_in: (&'static str, f64),
}

impl ComponentRules {
    /// Of named inputs; `conclusions` as shown.
    fn new(name: String, rules: &Rules, inputs: &[String], shown_in: (&'static str, f64)) -> Self {
        let (mut modes, mut splits) = (Vec::new(), Vec::new());
        let branch = |branch: Branch| match branch {
            Branch::Split(split) => RuleBranch::Split(split),
            Branch::Rule(rule) => RuleBranch::Rule(rule),
        };
        match &rules.premise {
            Premise::Grid(own) => modes.clone_from(own),
            Premise::Tree(tree) => {
                splits.extend(tree.splits.iter().map(|split| RuleSplit {
                    input: inputs.get(split.input).cloned().unwrap_or_default(),
                    from: split.between[0],
                    to: split.between[1],
                    below: branch(split.branches[0]),
                    above: branch(split.branches[1]),
                }));
            }
        }
        Self {
            name,
            modes,
            splits,
            conclusions: rules.conclusions.clone(),
            support: Vec::new(),
            unseen: Vec::new(),
            premises: premises(&rules.premise),
            shown_in,
        }
    }
}

/// Conditions of each rule, in the order of rules.
fn premises(premise: &Premise) -> Vec<Vec<Condition>> {
    match premise {
        Premise::Grid(modes) => modes.iter().enumerate().fold(vec![Vec::new()], |rules, (input, own)| {
            let about = |rule: &Vec<Condition>, mode: &f64| {
                let mut rule = rule.clone();
                if own.len() > 1 {
                    rule.push(Condition::About(input, *mode));
                }
                rule
            };
            rules.iter().flat_map(|rule| own.iter().map(move |mode| about(rule, mode))).collect()
        }),
        Premise::Tree(tree) => {
            let mut found = vec![Vec::new(); tree.splits.len() + 1];
            let mut open = if tree.splits.is_empty() { Vec::new() } else { vec![(Branch::Split(0), Vec::new())] };
            while let Some((branch, above)) = open.pop() {
                match branch {
                    Branch::Rule(rule) => found[rule] = above,
                    Branch::Split(index) => {
                        let split = &tree.splits[index];
                        for (upper, next) in split.branches.into_iter().enumerate() {
                            // The innermost split of an input says where the rule is.
                            let of_others =
                                |of: &&Condition| !matches!(of, Condition::Towards(own, ..) if *own == split.input);
                            let mut conditions: Vec<Condition> = above.iter().filter(of_others).copied().collect();
                            conditions.push(Condition::Towards(split.input, split.between, upper == 1));
                            open.push((next, conditions));
                        }
                    }
                }
            }
            found
        }
    }
}

/// A step of the growth of rules.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GrowthStep {
    /// Components of the compliance that are fitted together; empty for springs.
    pub components: Vec<String>,
    /// Whether all components are rotations, so that errors are in mrad.
    #[serde(skip)]
    pub of_rotations: bool,
    /// The component that grew; `None` where all did.
    pub component: Option<String>,
    /// Sets of each input; empty for a tree.
    pub sets: Vec<usize>,
    /// Number of rules.
    pub rules: usize,
    /// mm; mrad where all components are rotations.
    pub fit: Option<f64>,
    /// The same when parts of the configurations are left out in turns.
    pub test: f64,
}

/// A ratio with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gain {
    /// Measured over predicted displacement, relative to loads of other sizes; 1 where deflections are linear in the load.
    pub gain: f64,
    /// Half width of its 95 % interval.
    pub ci95: f64,
}

/// Readings under one size of load.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoadLevel {
    /// Magnitude of the force, N.
    pub force: f64,
    /// Number of readings.
    pub readings: usize,
    /// Measured over predicted.
    pub gain: f64,
    /// Half width of the gain's 95 % interval.
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
    /// Of the fitted readings: the displacement that was measured.
    pub fit: f64,
    /// Of the readings held out.
    pub check: f64,
}

/// Errors of the fitted readings and of those held out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AfterFit {
    /// Errors of the fitted readings; `None` where there are none.
    pub after: Option<ReadingErrors>,
    /// Errors of the readings held out; `None` where there are none.
    pub check_after: Option<ReadingErrors>,
}

impl AfterFit {
    fn new(fitted: &Errors, check: &Errors) -> Self {
        Self { after: ReadingErrors::new(fitted), check_after: ReadingErrors::new(check) }
    }
}

/// An input of the rules.
#[derive(Debug, Clone, PartialEq)]
pub struct RuleInput {
    /// Name of the joint or variable.
    pub name: String,
    /// Whether it is an angle, in rad; else a length, in m.
    pub is_angle: bool,
    /// Where it was measured, rad or m.
    pub range: Option<[f64; 2]>,
    /// Limits of the description, rad or m.
    pub limits: Option<[f64; 2]>,
}

/// A fuzzy compliance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FuzzyCompliance {
    /// Names of the joints and variables on which the compliance depends.
    pub inputs: Vec<String>,
    /// Frame whose axes the components have; `null`: the base.
    pub axes: Option<String>,
    /// Rules of each component.
    pub components: Vec<ComponentRules>,
    /// Measured range of each input, rad and m.
    pub range: Vec<[f64; 2]>,
    /// Held-out readings outside that range.
    pub outside: usize,
    /// How the rules grew, step by step.
    pub steps: Vec<GrowthStep>,
    /// Measured over predicted displacement by size of load, which shows whether deflections are linear in the load.
    pub levels: Vec<LoadLevel>,
    /// Unit of errors.
    pub unit: &'static str,
    /// Errors that a rigid robot would have.
    pub rigid: RigidErrors,
    /// Errors with the rules.
    pub residuals: AfterFit,
    /// The inputs with their ranges and limits.
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
        let names: Vec<String> = inputs.iter().map(|&of| model.input(of).0.to_string()).collect();
        let described = inputs.iter().enumerate().map(|(k, &of)| RuleInput::new(model, of, range.get(k).copied()));
        let described: Vec<RuleInput> = described.collect();
        Self {
            inputs: described.iter().map(|input| input.name.clone()).collect(),
            axes: grown.axes.map(|frame| model.frames[frame].name.clone()),
            components: components
                .map(|(component, own)| ComponentRules {
                    support: own.support.clone(),
                    unseen: own.unseen.clone(),
                    ..ComponentRules::new(
                        Component::name(component.at),
                        &component.rules,
                        &names,
                        per_load(component.at),
                    )
                })
                .collect(),
            range,
            outside: grown.beyond,
            steps: grown.steps.iter().map(GrowthStep::new).collect(),
            levels: fit.levels.iter().map(LoadLevel::new).collect(),
            unit: "mm",
            rigid: RigidErrors { fit: mm(fit.rigid[0]), check: mm(fit.rigid[1]) },
            residuals: AfterFit::new(&fit.errors[0], &fit.errors[1]),
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
            components: step.components.iter().map(|&at| Component::name(at)).collect(),
            of_rotations: step.components.iter().all(|[row, _]| *row >= 3),
            component: step.component.map(Component::name),
            sets: step.sets.clone(),
            rules: step.rules,
            fit: step.fitted.map(mm),
            test: mm(step.cross_validated),
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
    /// Root mean square error without the correction.
    pub without: f64,
    /// Root mean square error with the correction.
    pub with: f64,
}

/// Springs with a fuzzy correction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GreyCompliance {
    /// Springs alone.
    pub parametric: AfterFit,
    /// Errors of configurations left out, by which the correction is judged.
    pub cross_validated: CrossValidated,
    /// Whether the correction is kept.
    pub kept: bool,
    /// The correction; `None` where it does not help configurations left out.
    pub correction: Option<FuzzyCompliance>,
    /// Unit of errors.
    pub unit: &'static str,
}

impl GreyCompliance {
    /// With the names of the fitted model.
    pub fn new(fit: &GreyFit) -> Self {
        let after = &fit.parametric.after;
        let [without, with] = fit.cross_validated.map(mm);
        Self {
            parametric: AfterFit::new(&after.fit, &after.check),
            cross_validated: CrossValidated { without, with },
            kept: fit.correction.is_some(),
            correction: fit.correction.as_ref().map(FuzzyCompliance::new),
            unit: "mm",
        }
    }
}

/// Unit in which a component is shown, and how many of it are one in SI: mm or mrad by kN or kN.m.
fn per_load([row, column]: [usize; 2]) -> (&'static str, f64) {
    let unit = match (row < 3, column < 3) {
        (true, true) => "mm/kN",
        (true, false) => "mm/kN.m",
        (false, true) => "mrad/kN",
        (false, false) => "mrad/kN.m",
    };
    (unit, 1e6)
}

/// Local springs blended by fuzzy rules.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LocalSpringsFound {
    /// The same springs at all configurations.
    pub parametric: AfterFit,
    /// Whether rules are kept: whether springs that differ by configuration help in cross-validation.
    pub kept: bool,
    /// Names of the joints and variables on which the springs depend.
    pub inputs: Vec<String>,
    /// Rules of each spring; empty where they are not kept.
    pub springs: Vec<ComponentRules>,
    /// How the tree of rules grew, step by step.
    pub steps: Vec<GrowthStep>,
    /// Measured over predicted displacement by size of load, which shows whether deflections are linear in the load.
    pub levels: Vec<LoadLevel>,
    /// Unit of errors.
    pub unit: &'static str,
    /// Errors with the rules, or with the same springs everywhere where they are not kept.
    pub residuals: AfterFit,
    /// The inputs with their limits; their ranges are not given here.
    #[serde(skip)]
    pub described: Vec<RuleInput>,
}

impl LocalSpringsFound {
    /// With the names of the fitted model.
    pub fn new(fit: &LocalFit) -> Self {
        let (model, after) = (&fit.model, &fit.parametric.after);
        let local = model.local_springs.as_ref();
        let described: Vec<RuleInput> =
            local.iter().flat_map(|local| &local.inputs).map(|&of| RuleInput::new(model, of, None)).collect();
        let inputs: Vec<String> = described.iter().map(|input| input.name.clone()).collect();
        let spring = |(slot, rules): &(Slot, Rules)| {
            let parameter = &model.registry[*slot];
            let stiff = rules.conclusions.iter().map(|compliance| parameter.shown(*compliance)).collect();
            let rules = Rules { conclusions: stiff, ..rules.clone() };
            let support = fit.support.clone();
            let unit = (parameter.shown_kind().unit(), 1.0);
            ComponentRules { support, ..ComponentRules::new(parameter.name.clone(), &rules, &inputs, unit) }
        };
        let step = |step: &TreeStep| GrowthStep {
            components: Vec::new(),
            of_rotations: false,
            component: None,
            sets: Vec::new(),
            rules: step.rules,
            fit: Some(mm(step.fitted)),
            test: mm(step.cross_validated),
        };
        Self {
            parametric: AfterFit::new(&after.fit, &after.check),
            kept: local.is_some(),
            springs: local.iter().flat_map(|local| &local.springs).map(spring).collect(),
            inputs,
            steps: fit.steps.iter().map(step).collect(),
            levels: fit.levels.iter().map(LoadLevel::new).collect(),
            unit: "mm",
            residuals: AfterFit::new(&fit.errors[0], &fit.errors[1]),
            described,
        }
    }
}

/// Errors of a method under one load, mm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodRow {
    /// Force, N; `None` for all readings.
    pub load: Option<i64>,
    /// Number of readings.
    pub readings: usize,
    /// Root mean square position error.
    pub rms: f64,
    /// Greatest position error.
    pub max: f64,
    /// Greatest magnitude of the error along x of the measurement frame.
    pub max_x: f64,
    /// The same along y.
    pub max_y: f64,
    /// The same along z.
    pub max_z: f64,
}

/// Errors of a method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodErrors {
    /// Name of the method.
    pub method: &'static str,
    /// By size of the force, then over all readings.
    pub rows: Vec<MethodRow>,
}

impl MethodErrors {
    /// From residuals, three a reading (m), of the readings held out, or of all where there are none.
    pub fn new(method: &'static str, campaign: &Campaign, held_out: &[bool], residual: &[f64]) -> Self {
        let all = !held_out.contains(&true);
        let force = |k: usize| {
            let w = &campaign.readings[k].wrench;
            norm(&w[..3]).round() as i64
        };
        let judged: Vec<(i64, &[f64])> = residual
            .chunks(campaign.observes.rows())
            .enumerate()
            .filter(|(k, _)| all || held_out[*k])
            .map(|(k, reading)| (force(k), &reading[..3]))
            .collect();
        let sizes: Vec<i64> = distinct(judged.iter().map(|(size, _)| *size));
        let row = |size: Option<i64>| {
            let of: Vec<&[f64]> =
                judged.iter().filter(|(own, _)| size.is_none_or(|size| *own == size)).map(|(_, r)| *r).collect();
            let [_, rms, max] = mean_rms_max(of.iter().map(|r| norm(*r)));
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
    /// Unit of errors.
    pub unit: &'static str,
    /// Whether held-out readings are judged.
    pub check: bool,
    /// Errors of each method.
    pub methods: Vec<MethodErrors>,
}

/// A result with the time it took.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Timed<T> {
    /// The result.
    #[serde(flatten)]
    pub found: T,
    /// Time that it took, s.
    pub seconds: f64,
}
