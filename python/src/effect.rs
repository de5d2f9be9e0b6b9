//! Effects that a Python program declares: objects with the attributes of `elastogeo.Effect`.

use std::collections::HashMap;
use std::sync::Arc;

use elastogeo::effects::{Change, Changes, Effect, EffectParameter, Nonlinear, ReadingContext, Site as Own_, SiteKind};
use elastogeo::model::Model;
use elastogeo::parameter::Slot;
use pyo3::prelude::*;

use crate::error::fault;
use crate::faults::Faults;
use crate::words::kept;

/// Where an effect sits.
#[pyclass(frozen, get_all, module = "elastogeo._native")]
pub struct Site {
    /// `joint:5`
    name: String,
    /// Index of the joint's value in `q`: of the variable that moves it, or its own where it follows others; else `None`.
    variable: Option<usize>,
}

/// The state of the robot in one reading, SI.
#[pyclass(frozen, get_all, module = "elastogeo._native")]
pub struct Reading {
    q: Vec<f64>,
    load: Vec<f64>,
    own_load: Vec<f64>,
    side: Vec<f64>,
    last_move: Vec<f64>,
    time: Option<f64>,
    session_time: Option<f64>,
    temperature: Option<f64>,
    position: [f64; 3],
    up: [f64; 3],
    deflection: [f64; 3],
    is_difference: bool,
}

impl Reading {
    fn new(context: &ReadingContext) -> Self {
        Self {
            q: context.q.to_vec(),
            load: context.load.to_vec(),
            own_load: context.own_load.to_vec(),
            side: context.side.to_vec(),
            last_move: context.last_move.to_vec(),
            time: context.time,
            session_time: context.session_time,
            temperature: context.temperature,
            position: context.position.into(),
            up: context.up.into(),
            deflection: context.deflection.into(),
            is_difference: context.is_difference,
        }
    }
}

/// An effect declared in Python.
pub struct PythonEffect {
    name: &'static str,
    sits_at: SiteKind,
    signature: &'static str,
    remedy: &'static str,
    sites: Option<Vec<String>>,
    parameters: Vec<EffectParameter>,
    changes: Arc<Py<PyAny>>,
    faults: Faults,
}

const SITES: [(&str, SiteKind); 7] = [
    ("frame", SiteKind::Frame),
    ("joint", SiteKind::Joint),
    ("link", SiteKind::Link),
    ("actuator", SiteKind::Actuator),
    ("base", SiteKind::Base),
    ("tool", SiteKind::Tool),
    ("instrument", SiteKind::Instrument),
];

impl PythonEffect {
    pub fn new(py: Python<'_>, effect: &Bound<'_, PyAny>, faults: Faults) -> PyResult<Self> {
        let text = |name: &str| -> PyResult<String> { effect.getattr(name)?.extract() };
        let sits_at = text("sits_at")?;
        let Some((_, kind)) = SITES.into_iter().find(|(name, _)| *name == sits_at) else {
            let valid: Vec<&str> = SITES.iter().map(|(name, _)| *name).collect();
            return Err(fault(py, format!("sits_at: `{sits_at}`"), &format!("valid here: {}", valid.join(", "))));
        };
        let declared: Vec<(String, String, f64, bool)> = effect.call_method0("_declared")?.extract()?;
        let parameters = declared.into_iter().map(|(symbol, unit, scale, is_positive)| EffectParameter {
            is_positive,
            ..EffectParameter::new(symbol, kept(&unit), scale)
        });
        Ok(Self {
            name: kept(&text("name")?),
            sits_at: kind,
            signature: kept(&text("signature")?),
            remedy: kept(&text("remedy")?),
            sites: effect.getattr("sites")?.extract()?,
            parameters: parameters.collect(),
            changes: Arc::new(effect.getattr("changes")?.unbind()),
            faults,
        })
    }
}

/// What Python says of a change: the parameter, what changes, of which (joint or parameter of the model), by how much.
type Said = (String, String, String, Vec<f64>);

impl Effect for PythonEffect {
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

    fn sites(&self, model: &Model) -> Vec<Own_> {
        let mut sites = model.sites(self.sits_at());
        let unknown = |own: &&String| !sites.iter().any(|site| site.name == **own);
        if let Some(unknown) = self.sites.iter().flatten().find(unknown) {
            let message = format!("`{unknown}`, a site of the effect `{}`, is none of this robot", self.name);
            let valid: Vec<&str> = sites.iter().map(|site| site.name.as_str()).collect();
            let _ = Python::try_attach(|py| {
                self.faults.keep(fault(py, message, &format!("valid here: {}", valid.join(", "))));
            });
        }
        sites.retain(|site| self.sites.as_ref().is_none_or(|own| own.contains(&site.name)));
        sites
    }

    fn parameters(&self, _: &Model, _: &Own_, _: &Nonlinear) -> Vec<EffectParameter> {
        self.parameters.clone()
    }

    fn changes(&self, model: &Model, site: &Own_, _: &Nonlinear) -> Changes {
        let names: Vec<String> = self.parameters.iter().map(|parameter| parameter.symbol.clone()).collect();
        let variables = model.coordinate_names();
        let all = model.registry.all().iter().enumerate();
        let slots: HashMap<String, Slot> = all.map(|(slot, parameter)| (parameter.name.clone(), slot)).collect();
        let (changes, faults) = (Arc::clone(&self.changes), self.faults.clone());
        let (name, variable) = (site.name.clone(), site.coordinate);
        let change = move |of: &str, which: &str, by: &[f64]| match (of, by) {
            ("joint", [by]) => Some(Change::Joint(variables.iter().position(|known| known == which)?, *by)),
            ("deflection", [by]) => Some(Change::Deflection(variables.iter().position(|known| known == which)?, *by)),
            ("parameter", [by]) => Some(Change::Slot(*slots.get(which)?, *by)),
            ("point", [x, y, z, rx, ry, rz]) => Some(Change::Point([*x, *y, *z].into(), [*rx, *ry, *rz].into())),
            _ => None,
        };
        Arc::new(move |context, out| {
            // Nothing is evaluated once the interpreter ends.
            let _ = Python::try_attach(|py| {
                let site = Site { name: name.clone(), variable };
                let said = changes
                    .call1(py, (site, Reading::new(context)))
                    .and_then(|said| py.import("elastogeo.effects")?.call_method1("_said", (said,))?.extract());
                let said: Vec<Said> = match said {
                    Ok(said) => said,
                    Err(raised) => return faults.keep(raised),
                };
                for (parameter, of, which, by) in said {
                    let index = names.iter().position(|known| *known == parameter);
                    match index.zip(change(&of, &which, &by)) {
                        Some(_) if !by.iter().all(|by| by.is_finite()) => faults.keep(fault(
                            py,
                            format!("the amount of the change `{parameter}: {of} {which}` is not finite"),
                            "return finite numbers; a change of zero where the effect is not there",
                        )),
                        Some(found) => out.push(found),
                        None => faults.keep(fault(
                            py,
                            format!("a change `{parameter}: {of} {which}` is none of this robot and effect"),
                            "name a parameter of the effect, and a variable or parameter of the robot",
                        )),
                    }
                }
            });
        })
    }
}
