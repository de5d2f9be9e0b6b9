//! What the competition is held on: residuals after calibration, the columns of what was calibrated, and those of every
//! hypothesis.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::algebra::{independent, orthonormal};
use super::verdict::Settings;
use crate::description::campaign::Campaign;
use crate::effects::{Effect, Nonlinear, Site, Survey};
use crate::estimation::row_sigmas;
use crate::model::Model;
use crate::parameter::Slot;
use crate::prediction::{Linearised, PredictionError, Predictor, Term, effect_columns};

/// An effect at a site in a form, and its columns in the evidence.
#[derive(Clone)]
pub struct Hypothesis {
    /// The effect.
    pub effect: Arc<dyn Effect>,
    /// The site.
    pub site: Site,
    /// Values of its nonlinear parameters.
    pub nonlinear: Nonlinear,
    /// Constants of the model that it frees, if it is nothing else.
    pub constants: Vec<Slot>,
    /// Names, units and scales of its parameters.
    pub parameters: Vec<crate::effects::EffectParameter>,
    /// Weighted columns.
    pub columns: DMatrix<f64>,
    /// Its parameters can only be positive: compliances of what the description has rigid.
    pub is_positive: bool,
    /// How many forms the effect has at this site: they were tried too.
    pub forms: usize,
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

    /// Leaves out what the nuisance or its own other parameters take up entirely.
    fn prune(&mut self, nuisance: &DMatrix<f64>) {
        let (kept, _) = independent(&self.columns, Some(nuisance));
        if kept.len() == self.columns.ncols() {
            return;
        }
        // Parameters of a form go together: columns of none are struck out only from constants.
        if self.constants.is_empty() {
            if kept.is_empty() {
                self.parameters.clear();
            }
            return;
        }
        self.columns = self.columns.select_columns(&kept);
        self.constants = kept.iter().map(|&k| self.constants[k]).collect();
        self.parameters = kept.iter().map(|&k| self.parameters[k].clone()).collect();
    }

    /// Whether another says the same in another selection of constants, or is the very same: the two cannot go together.
    pub fn excludes(&self, other: &Self) -> bool {
        self.is_same(other) && (!self.constants.is_empty() || self.nonlinear == other.nonlinear)
    }

    /// Whether another is the same effect at the same site.
    pub fn is_same(&self, other: &Self) -> bool {
        self.effect.name() == other.effect.name() && self.site.name == other.site.name
    }
}

/// Weighted rows of all readings.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// Residuals over their sigmas.
    pub residual: DVector<f64>,
    /// Derivatives by what is re-fitted whatever is tried.
    pub nuisance: DMatrix<f64>,
    /// Sigma of each row, m or rad.
    pub sigmas: Vec<f64>,
    /// Configuration of each row.
    pub pose: Vec<usize>,
    /// Reading of each row.
    pub reading: Vec<usize>,
    /// Hypotheses.
    pub hypotheses: Vec<Hypothesis>,
}

impl Evidence {
    /// Gathers the evidence at calibrated `values`, `nuisance` being what was calibrated.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn gather(
        model: &Model,
        campaign: &Campaign,
        values: &[f64],
        nuisance: &[Slot],
        survey: &Survey,
        settings: &Settings,
    ) -> Result<Self, PredictionError> {
        let mut hypotheses: Vec<Hypothesis> = Vec::new();
        for effect in model.catalogue.iter() {
            let is_known = settings.known.iter().any(|name| name == effect.name());
            for site in effect.sites(model) {
                let forms = effect.candidates(model, &site, survey);
                for form in &forms {
                    let constants = effect.constants(model, &site, form);
                    let parameters = effect.parameters(model, &site, form);
                    // What is re-fitted anyway cannot be the cause.
                    if parameters.is_empty() || !constants.is_empty() && constants.iter().all(|s| nuisance.contains(s))
                    {
                        continue;
                    }
                    // Compliances of what is rigid cannot be negative: each may be there or not, which makes one
                    // hypothesis of every selection.
                    let rigid = |slot: &Slot| model.registry[*slot].bounds[0] == 0.0 && values[*slot] == 0.0;
                    let is_positive = !constants.is_empty() && constants.iter().all(rigid);
                    // Calibrated is what the description says to give: a joint that it has rigid is not.
                    if is_known && !is_positive {
                        continue;
                    }
                    let selections = if is_positive { (1 << constants.len()) - 1 } else { 1 };
                    for selection in 1..=selections {
                        let chosen = |k: usize| !is_positive || selection >> k & 1 == 1;
                        let pick = |slots: &[Slot]| -> Vec<Slot> {
                            slots.iter().enumerate().filter(|(k, _)| chosen(*k)).map(|(_, s)| *s).collect()
                        };
                        let parameters = parameters.iter().enumerate().filter(|(k, _)| chosen(*k));
                        hypotheses.push(Hypothesis {
                            effect: effect.clone(),
                            site: site.clone(),
                            nonlinear: form.clone(),
                            constants: pick(&constants),
                            parameters: parameters.map(|(_, p)| p.clone()).collect(),
                            columns: DMatrix::zeros(0, 0),
                            is_positive,
                            forms: forms.len() * selections,
                        });
                    }
                }
            }
        }
        let mut slots: Vec<Slot> = nuisance.to_vec();
        slots.extend(hypotheses.iter().flat_map(|h| h.constants.iter().copied()).filter(|s| !nuisance.contains(s)));
        slots.sort_unstable();
        slots.dedup();
        let mut found = Linearised::default();
        Predictor::new(model, campaign, slots.clone())?.linearise(values, true, &mut found)?;
        let sigmas = row_sigmas(campaign);
        let rows = sigmas.len();
        let column = |slot: Slot| -> DVector<f64> {
            let at = slots.binary_search(&slot).unwrap_or(0);
            DVector::from_iterator(rows, (0..rows).map(|row| found.jacobian[row * slots.len() + at] / sigmas[row]))
        };
        let gather = |slots: &[Slot]| -> DMatrix<f64> {
            if slots.is_empty() {
                DMatrix::zeros(rows, 0)
            } else {
                DMatrix::from_columns(&slots.iter().map(|&slot| column(slot)).collect::<Vec<_>>())
            }
        };
        let moving: Vec<usize> = (0..hypotheses.len()).filter(|&h| hypotheses[h].constants.is_empty()).collect();
        let terms: Vec<Term> = moving
            .iter()
            .map(|&h| &hypotheses[h])
            .map(|h| Term::new(model, &h.effect, &h.site, &h.nonlinear))
            .collect();
        let (all, width) = effect_columns(model, campaign, values, terms)?;
        let mut first = 0;
        for &h in &moving {
            let count = hypotheses[h].parameters.len();
            hypotheses[h].columns = DMatrix::from_fn(rows, count, |row, k| all[row * width + first + k] / sigmas[row]);
            first += count;
        }
        for hypothesis in hypotheses.iter_mut().filter(|h| !h.constants.is_empty()) {
            hypothesis.columns = gather(&hypothesis.constants);
        }
        let components = campaign.components();
        let fitted = gather(nuisance);
        let basis = orthonormal(&fitted, None);
        for hypothesis in &mut hypotheses {
            hypothesis.prune(&basis);
        }
        hypotheses.retain(|hypothesis| !hypothesis.parameters.is_empty());
        Ok(Self {
            residual: DVector::from_iterator(rows, found.residual.iter().zip(&sigmas).map(|(r, s)| r / s)),
            nuisance: fitted,
            sigmas,
            pose: (0..rows).map(|row| campaign.readings[row / components].pose).collect(),
            reading: (0..rows).map(|row| row / components).collect(),
            hypotheses,
        })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.residual.len()
    }
}
