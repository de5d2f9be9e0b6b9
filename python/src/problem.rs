//! A calibration as functions of its parameters, for solvers that are not ours.

use std::collections::HashMap;
use std::sync::Arc;

use elastogeo::description::campaign::Campaign;
use elastogeo::estimation::{row_sigmas, split};
use elastogeo::files::LoadedCampaign;
use elastogeo::model::Model;
use elastogeo::parameter::Slot;
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::results::units::unit;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::arrays::{array, vector};
use crate::campaign;
use crate::error::{fault, raised};
use crate::faults::Faults;
use crate::work::brief;

/// Residuals of the readings to fit, in standard deviations, and their derivatives, as functions of named parameters (SI).
#[pyclass(frozen, module = "elastogeo._native")]
pub struct Problem {
    loaded: Arc<LoadedCampaign>,
    faults: Faults,
    fitted: Campaign,
    sigmas: Vec<f64>,
    slots: Vec<Slot>,
    /// All values, SI.
    values: Vec<f64>,
}

#[pymethods]
impl Problem {
    /// `values` are those of parameters as results report them (mm, deg, stiffnesses), from which the others are taken.
    #[new]
    fn new(
        py: Python<'_>,
        campaign: &campaign::Campaign,
        parameters: Vec<String>,
        values: HashMap<String, f64>,
        check: f64,
        seed: u64,
    ) -> PyResult<Self> {
        let loaded = Arc::clone(&campaign.loaded);
        let model = &loaded.robot.model;
        let slot = |name: &String| {
            model.registry.slot(name).ok_or_else(|| {
                let unknown = elastogeo::diagnostic::Diagnostic::error(format!("unknown parameter `{name}`"));
                let valid = model.registry.all().iter().map(|parameter| parameter.name.as_str());
                raised(py, &unknown.suggest(name, valid).into())
            })
        };
        let slots = parameters.iter().map(slot).collect::<PyResult<Vec<Slot>>>()?;
        let mut all = model.registry.nominal();
        for (name, value) in &values {
            let slot = slot(name)?;
            let parameter = &model.registry[slot];
            let shown = value * unit(parameter.shown_kind()).1;
            let own = if parameter.inverted { 1.0 / shown } else { shown };
            if !own.is_finite() {
                return Err(fault(py, format!("start: `{name}` is {value}"), "give a finite number"));
            }
            if let Some(out) = all.get_mut(slot) {
                *out = own;
            }
        }
        if !(0.0..=0.9).contains(&check) {
            return Err(fault(py, format!("check: {check}"), "give a share from 0 to 0.9"));
        }
        let held_out = split(&loaded.campaign, check, seed);
        let fitted = loaded.campaign.select(|index, _| held_out.get(index) != Some(&true));
        let sigmas = row_sigmas(&fitted);
        Ok(Self { fitted, sigmas, slots, values: all, loaded, faults: campaign.faults.clone() })
    }

    /// Values of the parameters from which they start, SI (of a spring its compliance).
    #[getter]
    fn start(&self) -> Vec<f64> {
        self.slots.iter().filter_map(|&slot| self.values.get(slot)).copied().collect()
    }

    /// Bounds of the parameters, SI.
    #[getter]
    fn bounds(&self) -> Vec<(f64, f64)> {
        let bounds = |slot: &Slot| self.model().registry.all().get(*slot).map(|parameter| parameter.bounds);
        self.slots.iter().filter_map(bounds).map(|[low, high]| (low, high)).collect()
    }

    /// Tolerances of the parameters, SI.
    #[getter]
    fn scale(&self) -> Vec<f64> {
        let own = |slot: &Slot| self.model().registry.all().get(*slot).map(|parameter| parameter.tolerance);
        self.slots.iter().filter_map(own).collect()
    }

    fn residual<'py>(&self, py: Python<'py>, x: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let x = vector(py, x, self.slots.len(), "x")?;
        let found = self.faults.first(brief(py, || self.at(&x, false)))?;
        let all: Vec<f64> = found.residual.iter().zip(&self.sigmas).map(|(residual, sigma)| residual / sigma).collect();
        let shape = [all.len()];
        array(py, all, &shape)
    }

    fn jacobian<'py>(&self, py: Python<'py>, x: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let x = vector(py, x, self.slots.len(), "x")?;
        let found = self.faults.first(brief(py, || self.at(&x, true)))?;
        let own = found.jacobian.chunks(self.slots.len().max(1)).zip(&self.sigmas);
        let all: Vec<f64> = own.flat_map(|(row, sigma)| row.iter().map(move |by| -by / sigma)).collect();
        let shape = [found.residual.len(), self.slots.len()];
        array(py, all, &shape)
    }
}

impl Problem {
    fn model(&self) -> &Model {
        &self.loaded.robot.model
    }

    fn at(&self, x: &[f64], derivatives: bool) -> Result<Linearised, elastogeo::Error> {
        let mut values = self.values.clone();
        for (&slot, x) in self.slots.iter().zip(x) {
            if let Some(value) = values.get_mut(slot) {
                *value = *x;
            }
        }
        let mut found = Linearised::default();
        let predictor = Predictor::new(self.model(), &self.fitted, self.slots.clone())?.with_sag();
        predictor.linearise(&values, derivatives, &mut found)?;
        Ok(found)
    }
}
