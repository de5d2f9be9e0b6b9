//! How every joint moves with the variables and with the parameters that move joints: couplings, actuators, loops.

use super::closure::ClosedLoops;
use super::geometry::{Geometry, Placements};
use super::linear;
use super::linearisation::Linearisation;
use super::slider_crank::slider_crank;
use crate::description::robot::{FrameIndex, Motion};
use crate::model::{Model, Stage};
use crate::parameter::Slot;
use std::collections::BTreeSet;

/// Derivatives of all joint variables by all drivers: first the actuated variables, then the slots that move joints
/// (zeros of joints, parameters of actuators, lengths of loops).
#[derive(Debug, Clone)]
pub struct Rates {
    variables: usize,
    slots: Vec<Slot>,
    /// Frames x drivers, row-major.
    rates: Vec<f64>,
    /// Which of `rates` can differ from zero.
    pattern: Vec<bool>,
    linearisation: Linearisation,
    unknowns: Vec<f64>,
    inverse: Vec<f64>,
    right: Vec<f64>,
}

impl Rates {
    /// Structure of the derivatives; the numbers come with [`Rates::evaluate`].
    pub fn new(model: &Model) -> Self {
        let mut slots = BTreeSet::new();
        for frame in &model.frames {
            if !matches!(frame.motion, Motion::Fixed | Motion::Passive) {
                slots.insert(frame.moving_slot());
            }
        }
        for actuator in &model.actuators {
            slots.extend(actuator.slot..actuator.slot + 5);
        }
        for stage in &model.stages {
            if let Stage::Loops(group) = stage {
                let frames = group.loops.iter().flat_map(|plan| plan.branches.iter().flatten());
                slots.extend(frames.flat_map(|&frame| {
                    let frame = &model.frames[frame];
                    let moving = frame.moves().then(|| frame.moving_slot());
                    frame.slots.into_iter().filter(move |slot| Some(*slot) != moving)
                }));
            }
        }
        let slots: Vec<Slot> = slots.into_iter().collect();
        let variables = model.variables.len();
        let size = model.frames.len() * (variables + slots.len());
        let empty = Vec::new;
        let mut rates = Self {
            variables,
            slots,
            rates: vec![0.0; size],
            pattern: vec![false; size],
            linearisation: Linearisation::default(),
            unknowns: empty(),
            inverse: empty(),
            right: empty(),
        };
        rates.find_pattern(model);
        rates
    }

    fn drivers(&self) -> usize {
        self.variables + self.slots.len()
    }

    /// Index of a slot among the drivers.
    pub fn driver(&self, slot: Slot) -> Option<usize> {
        self.slots.binary_search(&slot).ok().map(|k| self.variables + k)
    }

    /// Derivative of a joint by a driver (an actuated variable's index, or [`Rates::driver`]).
    pub fn rate(&self, joint: FrameIndex, driver: usize) -> f64 {
        self.rates[joint * self.drivers() + driver]
    }

    /// Whether a joint can move with a driver.
    pub fn follows(&self, joint: FrameIndex, driver: usize) -> bool {
        self.pattern[joint * self.drivers() + driver]
    }

    fn find_pattern(&mut self, model: &Model) {
        let n = self.drivers();
        let slots: Vec<Option<usize>> = (0..model.registry.all().len()).map(|slot| self.driver(slot)).collect();
        let mut mark = |joint: FrameIndex, driver: Option<usize>| {
            if let Some(driver) = driver {
                self.pattern[joint * n + driver] = true;
            }
        };
        for (joint, frame) in model.frames.iter().enumerate() {
            match frame.motion {
                Motion::Variable { index, .. } => {
                    mark(joint, Some(index));
                    mark(joint, slots[frame.moving_slot()]);
                }
                Motion::Actuator(which) => {
                    let actuator = &model.actuators[which];
                    mark(joint, Some(actuator.variable));
                    mark(joint, slots[frame.moving_slot()]);
                    (actuator.slot..actuator.slot + 5).for_each(|slot| mark(joint, slots[slot]));
                }
                Motion::Coupling(_) => mark(joint, slots[frame.moving_slot()]),
                _ => {}
            }
        }
        for stage in &model.stages {
            let (targets, sources): (Vec<FrameIndex>, Vec<FrameIndex>) = match stage {
                Stage::Actuator(_) => continue,
                Stage::Coupling(which, joint) => {
                    (vec![*joint], model.couplings[*which].iter().map(|term| term.1).collect())
                }
                Stage::Loops(group) => (group.unknowns.clone(), group.inputs.clone()),
            };
            for &target in &targets {
                for &source in &sources {
                    for driver in 0..n {
                        self.pattern[target * n + driver] |= self.pattern[source * n + driver];
                    }
                }
                if let Stage::Loops(group) = stage {
                    for frame in group.loops.iter().flat_map(|plan| plan.branches.iter().flatten()) {
                        for slot in model.frames[*frame].slots {
                            if let Some(driver) = slots[slot] {
                                self.pattern[target * n + driver] = true;
                            }
                        }
                    }
                }
            }
        }
    }

    /// Derivatives at a placed configuration `q`.
    pub fn evaluate(&mut self, geometry: &Geometry, q: &[f64], placements: &Placements) {
        let model = geometry.model;
        let n = self.drivers();
        self.rates.fill(0.0);
        for (joint, frame) in model.frames.iter().enumerate() {
            if let Motion::Variable { index, direction } = frame.motion {
                self.rates[joint * n + index] = direction;
                self.set(joint, frame.moving_slot(), 1.0);
            }
        }
        let mut loops = geometry.loops.iter();
        for stage in &model.stages {
            match stage {
                Stage::Actuator(which) => {
                    let actuator = &model.actuators[*which];
                    let values = &geometry.values()[actuator.slot..actuator.slot + 5];
                    // Placed, so its triangle closes.
                    let (_, by) = slider_crank(q[actuator.variable], values).unwrap_or((f64::NAN, [f64::NAN; 5]));
                    self.rates[actuator.joint * n + actuator.variable] = by[0];
                    self.set(actuator.joint, model.frames[actuator.joint].moving_slot(), 1.0);
                    for (k, rate) in by.into_iter().enumerate() {
                        self.set(actuator.joint, actuator.slot + k, rate);
                    }
                }
                Stage::Coupling(which, joint) => {
                    for driver in 0..n {
                        let terms = &model.couplings[*which];
                        self.rates[joint * n + driver] =
                            terms.iter().map(|(factor, other)| factor * self.rates[other * n + driver]).sum();
                    }
                    if model.coupled_by_controller[*which] {
                        for &(factor, other) in &model.couplings[*which] {
                            self.take_zeros(model, *joint, other, factor);
                        }
                    }
                    self.set(*joint, model.frames[*joint].moving_slot(), 1.0);
                }
                Stage::Loops(_) => {
                    if let Some(closed) = loops.next() {
                        self.close(closed, geometry, placements);
                    }
                }
            }
        }
    }

    /// Takes out of a joint what the zeros of another, times a factor, would pass on to it.
    fn take_zeros(&mut self, model: &Model, joint: FrameIndex, other: FrameIndex, factor: f64) {
        let frame = &model.frames[other];
        let n = self.drivers();
        if let Some(driver) = self.driver(frame.moving_slot()).filter(|_| frame.motion != Motion::Passive) {
            self.rates[joint * n + driver] -= factor;
        }
        if let Motion::Coupling(which) = frame.motion
            && !model.coupled_by_controller[which]
        {
            for &(own, further) in &model.couplings[which] {
                self.take_zeros(model, joint, further, factor * own);
            }
        }
    }

    fn set(&mut self, joint: FrameIndex, slot: Slot, rate: f64) {
        if let Some(driver) = self.driver(slot) {
            let n = self.drivers();
            self.rates[joint * n + driver] = rate;
        }
    }

    /// Implicit derivative of a loop group's passive joints: unknowns = -(dF/dunknowns)^+ (dF/dinputs dinputs + dF/dslots).
    fn close(&mut self, closed: &ClosedLoops, geometry: &Geometry, placements: &Placements) {
        let n = self.drivers();
        let group = closed.group();
        let (rows, columns) = (group.equations, group.unknowns.len());
        self.unknowns.clear();
        self.unknowns.resize(rows * columns, 0.0);
        self.right.clear();
        self.right.resize(rows * n, 0.0);
        let mut found = std::mem::take(&mut self.linearisation);
        for (at, plan) in group.loops.iter().enumerate() {
            closed.linearise(&geometry.constants, at, &placements.joints, true, &mut found);
            for (frame, column) in &found.joints {
                if let Some(k) = group.unknowns.iter().position(|unknown| unknown == frame) {
                    for (row, value) in column[..found.rows].iter().enumerate() {
                        self.unknowns[(plan.row + row) * columns + k] += value;
                    }
                } else {
                    for driver in 0..n {
                        let rate = self.rates[frame * n + driver];
                        if rate != 0.0 {
                            for (row, value) in column[..found.rows].iter().enumerate() {
                                self.right[(plan.row + row) * n + driver] += value * rate;
                            }
                        }
                    }
                }
            }
            for (slot, column) in &found.slots {
                if let Some(driver) = self.driver(*slot) {
                    for (row, value) in column[..found.rows].iter().enumerate() {
                        self.right[(plan.row + row) * n + driver] += value;
                    }
                }
            }
        }
        self.linearisation = found;
        self.inverse.clear();
        self.inverse.resize(columns * rows, 0.0);
        if linear::invert(&self.unknowns, rows, columns, &mut self.inverse).is_none() {
            self.inverse.fill(f64::NAN);
        }
        for (k, &unknown) in group.unknowns.iter().enumerate() {
            for driver in 0..n {
                if self.pattern[unknown * n + driver] {
                    let sum: f64 =
                        (0..rows).map(|row| self.inverse[k * rows + row] * self.right[row * n + driver]).sum();
                    self.rates[unknown * n + driver] = -sum;
                }
            }
        }
    }
}
