//! Effects in a prediction: what each parameter of each switched-on effect adds to a reading, to first order.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};

use super::measured_point;
use crate::description::campaign::{Campaign, Reading};
use crate::elastics::Elastics;
use crate::kinematics::{By, ErrorColumns, Geometry, Placements, Rates, shift};
use crate::model::{
    Change, Changes, Effect, EffectEntry, EffectParameter, Model, Nonlinear, ReadingContext, Site, Survey, SwitchedOn,
};
use crate::parameter::Slot;

/// An effect at a site with its nonlinear values, compiled for a model.
#[derive(Clone)]
pub struct Term {
    /// The effect.
    pub effect: Arc<dyn Effect>,
    /// Where it sits.
    pub site: Site,
    /// Its parameters.
    pub parameters: Vec<EffectParameter>,
    /// What one unit of each changes in a reading.
    changes: Changes,
}

impl std::fmt::Debug for Term {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}@{}", self.effect.name(), self.site.name)
    }
}

impl Term {
    /// Compiles an effect at a site.
    pub fn new(model: &Model, effect: &Arc<dyn Effect>, site: &Site, nonlinear: &Nonlinear) -> Self {
        Self {
            parameters: effect.parameters(model, site, nonlinear),
            changes: effect.changes(model, site, nonlinear),
            effect: effect.clone(),
            site: site.clone(),
        }
    }
}

/// Terms compiled for a campaign; shared between threads.
#[derive(Debug, Clone)]
pub struct Terms {
    /// The terms, in order; columns are theirs, one after the other.
    pub terms: Vec<Term>,
    /// Number of columns.
    pub columns: usize,
    /// First column of each term.
    first: Vec<usize>,
    is_difference: bool,
    /// For each frame that is measured or weighs: its columns by the variables, then by `slots`.
    plans: Vec<(usize, ErrorColumns)>,
    slots: Vec<Slot>,
    /// Masses: plan, kg, point in the frame.
    masses: Vec<(usize, f64, Vector3<f64>)>,
    variables: usize,
}

/// Room for one thread.
#[derive(Debug, Clone, Default)]
pub struct TermWork {
    by: Vec<Vec<[f64; 6]>>,
    own_load: Vec<f64>,
    load: Vec<f64>,
    side: Vec<f64>,
    changes: Vec<(usize, Change)>,
    /// Displacement and rotation of the reading by one unit of each column, measurement frame.
    pub columns: Vec<[f64; 6]>,
}

/// Columns of frames that readings ask for, beside those of the model's constants.
impl Terms {
    /// Compiles terms. `slots` are constants of the model that terms may change in single readings.
    pub fn new(geometry: &Geometry, pattern: &Rates, campaign: &Campaign, terms: Vec<Term>) -> Self {
        let model = geometry.model;
        let variables = model.variables.len();
        let first = terms.iter().scan(0, |sum, term| {
            let first = *sum;
            *sum += term.parameters.len();
            Some(first)
        });
        let first: Vec<usize> = first.collect();
        let columns = terms.iter().map(|term| term.parameters.len()).sum();
        // Which constants the terms change shows in a trial reading with everything known.
        let slots = slots_changed(model, &terms);
        let mut by: Vec<By> = (0..variables).map(By::Variable).collect();
        by.extend(slots.iter().map(|&slot| By::Slot(slot)));
        let mut frames: Vec<usize> =
            campaign.readings.iter().map(|r| r.marker.map_or(model.tool.0, |m| model.markers[m].frame)).collect();
        let masses = masses(model, geometry.values());
        frames.extend(masses.iter().map(|(frame, ..)| *frame));
        frames.sort_unstable();
        frames.dedup();
        let masses =
            masses.into_iter().map(|(frame, mass, at)| (frames.binary_search(&frame).unwrap_or(0), mass, at)).collect();
        let plans = frames.into_iter().map(|frame| (frame, ErrorColumns::new(geometry, pattern, frame, &by))).collect();
        let is_difference = campaign.observes.is_difference();
        Self { terms, columns, first, is_difference, plans, slots, masses, variables }
    }

    /// Room for one thread.
    pub fn work(&self) -> TermWork {
        TermWork {
            by: self.plans.iter().map(|_| vec![[0.0; 6]; self.variables + self.slots.len()]).collect(),
            own_load: vec![0.0; self.variables],
            load: vec![0.0; self.variables],
            side: vec![0.0; self.variables],
            changes: Vec::new(),
            columns: vec![[0.0; 6]; self.columns],
        }
    }

    /// What a configuration's readings share: frames' columns and own weight on the joints.
    pub fn place(
        &self,
        geometry: &Geometry,
        q: &[f64],
        placements: &Placements,
        rates: &mut Rates,
        work: &mut TermWork,
    ) {
        rates.evaluate(geometry, q, placements);
        for ((_, plan), out) in self.plans.iter().zip(&mut work.by) {
            plan.evaluate(geometry, placements, rates, out);
        }
        work.own_load.fill(0.0);
        let gravity = geometry.model.structure.gravity;
        for &(plan, mass, at) in &self.masses {
            let arm = placements.frames[self.plans[plan].0].rotation * at;
            for (load, column) in work.own_load.iter_mut().zip(&work.by[plan]) {
                *load += shift(column, &arm).dot(&gravity) * mass;
            }
        }
        // Loads as torques of the joints: a screw's variable is its length.
        for (variable, load) in work.own_load.iter_mut().enumerate() {
            *load /= joint_rate(geometry.model, rates, variable);
        }
    }

    /// Columns of one reading at the placed configuration `q`, into `work.columns`; `deflection` is the displacement by
    /// the applied wrench alone, base axes.
    #[allow(clippy::too_many_arguments)] // the whole state of one reading
    pub fn evaluate(
        &self,
        geometry: &Geometry,
        campaign: &Campaign,
        index: usize,
        reading: &Reading,
        q: &[f64],
        placements: &Placements,
        rates: &Rates,
        deflection: &Vector3<f64>,
        work: &mut TermWork,
    ) {
        let model = geometry.model;
        let base = geometry.base();
        let (frame, point) = measured_point(geometry, reading);
        let plan = self.plans.iter().position(|(planned, _)| *planned == frame).unwrap_or(0);
        let arm = placements.frames[frame].rotation * point.coords;
        let force = Vector3::new(reading.wrench[0], reading.wrench[1], reading.wrench[2]);
        let moment = Vector3::new(reading.wrench[3], reading.wrench[4], reading.wrench[5]);
        for variable in 0..self.variables {
            let column = &work.by[plan][variable];
            let turn = Vector3::new(column[3], column[4], column[5]);
            let applied = shift(column, &arm).dot(&force) + turn.dot(&moment);
            work.load[variable] = work.own_load[variable] + applied / joint_rate(model, rates, variable);
            work.side[variable] = campaign.conditions.sides(variable).map_or(0.0, |all| all[index]);
        }
        let at: Point3<f64> = base * (placements.frames[frame] * point);
        work.columns.fill([0.0; 6]);
        let is_difference = self.is_difference;
        for (term, &first) in self.terms.iter().zip(&self.first) {
            let temperatures = campaign.conditions.temperatures_at(&model.frames[term.site.frame].name);
            let context = ReadingContext {
                q,
                joints: &placements.joints,
                load: &work.load,
                own_load: &work.own_load,
                side: &work.side,
                time: campaign.conditions.time.as_ref().map(|all| all[index]),
                temperature: temperatures.map(|all| all[index]),
                position: at.coords,
                base: base.translation.vector,
                deflection: base.rotation * deflection,
                is_difference,
            };
            work.changes.clear();
            (term.changes)(&context, &mut work.changes);
            for &(parameter, change) in &work.changes {
                let (column, amount) = match change {
                    Change::Joint(_, _) if is_difference => continue,
                    Change::Joint(variable, amount) | Change::Deflection(variable, amount) => {
                        (work.by[plan][variable], amount / joint_rate(model, rates, variable))
                    }
                    Change::Slot(slot, amount) => match self.slots.binary_search(&slot) {
                        Ok(at) => (work.by[plan][self.variables + at], amount),
                        Err(_) => continue,
                    },
                    Change::Point(moved, turned) => {
                        let out = &mut work.columns[first + parameter];
                        for k in 0..3 {
                            out[k] += moved[k];
                            out[k + 3] += turned[k];
                        }
                        continue;
                    }
                };
                let moved = base.rotation * shift(&column, &arm) * amount;
                let turned = base.rotation * Vector3::new(column[3], column[4], column[5]) * amount;
                let out = &mut work.columns[first + parameter];
                for k in 0..3 {
                    out[k] += moved[k];
                    out[k + 3] += turned[k];
                }
            }
        }
    }

    /// Loads on the joints that the last reading evaluated had: under everything, and under own weight alone.
    pub fn loads<'w>(&self, work: &'w TermWork) -> (&'w [f64], &'w [f64]) {
        (&work.load, &work.own_load)
    }
}

/// Effects that are switched on.
#[derive(Debug, Clone, Default)]
pub struct Declared {
    /// Those that are more than constants of the model.
    pub terms: Vec<Term>,
    /// For each parameter of each term, the slot of its amount; none where it is not given, which is zero.
    pub amounts: Vec<Option<Slot>>,
    /// By how much constants of the model are shifted.
    pub shifts: Vec<(Slot, f64)>,
}

/// Effects that the model has switched on.
pub fn declared(model: &Model) -> Declared {
    let mut declared = Declared::default();
    for SwitchedOn { entry: EffectEntry { effect, site, nonlinear, .. }, slots, shifts, .. } in &model.effects {
        if shifts.is_empty() {
            declared.terms.push(Term::new(model, effect, site, nonlinear));
            declared.amounts.extend(slots);
        }
        declared.shifts.extend(shifts);
    }
    declared
}

/// Amounts by their slots; zero where a parameter is not given.
pub(super) fn amounts_of(slots: &[Option<Slot>], values: &[f64]) -> Vec<f64> {
    slots.iter().map(|slot| slot.and_then(|slot| values.get(slot).copied()).unwrap_or_default()).collect()
}

/// Joint per variable: +1 or -1, or the turn of a joint per stroke of its screw.
fn joint_rate(model: &Model, rates: &Rates, variable: usize) -> f64 {
    use crate::description::robot::Motion;
    let driven = model.frames.iter().position(|frame| match frame.motion {
        Motion::Variable { index, .. } => index == variable,
        Motion::Actuator(_) => false,
        _ => false,
    });
    let joint = driven.or_else(|| model.actuators.iter().find(|a| a.variable == variable).map(|a| a.joint));
    let rate = joint.map_or(1.0, |joint| rates.rate(joint, variable));
    if rate.abs() > 1e-9 { rate } else { 1.0 }
}

/// Masses as frame, kg and point in the frame: bodies, and beams at their middles.
pub(crate) fn masses(model: &Model, values: &[f64]) -> Vec<(usize, f64, Vector3<f64>)> {
    let structure = &model.structure;
    let mut all: Vec<(usize, f64, Vector3<f64>)> = structure
        .masses
        .iter()
        .map(|mass| {
            let v = &values[mass.slot..mass.slot + 4];
            (mass.frame, v[0], Vector3::new(v[1], v[2], v[3]))
        })
        .collect();
    for (ends, per_length) in Elastics::new(model, values, &[]).masses_per_length() {
        let [a, b] = ends.map(|end| structure.at_home(end));
        if let Some(frame) = structure.frame_of(*ends) {
            let middle = structure.home[frame].inverse() * Point3::from(0.5 * (a + b));
            all.push((frame, per_length * (b - a).norm(), middle.coords));
        }
    }
    all.retain(|(_, mass, _)| *mass != 0.0);
    all
}

/// Constants that terms change in single readings, from a reading in which everything is known.
fn slots_changed(model: &Model, terms: &[Term]) -> Vec<Slot> {
    let ones = vec![1.0; model.variables.len()];
    let joints = vec![0.1; model.frames.len()];
    let given = ReadingContext {
        q: &ones,
        joints: &joints,
        load: &ones,
        own_load: &ones,
        side: &ones,
        time: Some(1.0),
        temperature: Some(30.0),
        position: Vector3::repeat(1.0),
        base: Vector3::zeros(),
        deflection: Vector3::repeat(1.0),
        is_difference: false,
    };
    let mut slots = Vec::new();
    let mut changes = Vec::new();
    for term in terms {
        changes.clear();
        (term.changes)(&given, &mut changes);
        slots.extend(changes.iter().filter_map(|(_, change)| match change {
            Change::Slot(slot, _) => Some(*slot),
            _ => None,
        }));
    }
    slots.sort_unstable();
    slots.dedup();
    slots
}

/// What a campaign offers: greatest loads on the joints, times, temperatures, sides of approach.
pub fn survey(geometry: &Geometry, campaign: &Campaign) -> Result<Survey, crate::kinematics::AssemblyError> {
    let model = geometry.model;
    let mut rates = Rates::new(model);
    let terms = Terms::new(geometry, &rates, campaign, Vec::new());
    let mut work = terms.work();
    let mut placements = Placements::default();
    let variables = model.variables.len();
    let mut survey =
        Survey { greatest_load: vec![0.0; variables], greatest_own_load: vec![0.0; variables], ..Survey::default() };
    let mut last = None;
    for (index, reading) in campaign.readings.iter().enumerate() {
        let q = campaign.configuration(index);
        if last != Some(q) {
            geometry.place(q, &mut placements)?;
            terms.place(geometry, q, &placements, &mut rates, &mut work);
            last = Some(q);
        }
        terms.evaluate(geometry, campaign, index, reading, q, &placements, &rates, &Vector3::zeros(), &mut work);
        let (load, own) = terms.loads(&work);
        let difference = campaign.observes.is_difference();
        for (greatest, own) in survey.greatest_own_load.iter_mut().zip(own) {
            *greatest = greatest.max(own.abs());
        }
        for (greatest, (load, own)) in survey.greatest_load.iter_mut().zip(load.iter().zip(own)) {
            *greatest = greatest.max((load - if difference { *own } else { 0.0 }).abs());
        }
    }
    let mut times = campaign.conditions.time.clone().unwrap_or_default();
    times.sort_by(f64::total_cmp);
    times.dedup();
    survey.times = times;
    let varies = |all: &[f64]| all.iter().any(|v| (v - all[0]).abs() > 1e-9);
    let mean = |all: &[f64]| varies(all).then(|| all.iter().sum::<f64>() / all.len() as f64).filter(|v| v.is_finite());
    let conditions = &campaign.conditions;
    let temperatures = model.frames.iter().map(|frame| conditions.temperatures_at(&frame.name).and_then(mean));
    survey.mean_temperatures = temperatures.collect();
    survey.sides = (0..variables).map(|variable| conditions.sides(variable).is_some_and(varies)).collect();
    survey.loaded = campaign.readings.iter().any(|reading| reading.wrench != [0.0; 6]);
    survey.is_difference = campaign.observes.is_difference();
    Ok(survey)
}
