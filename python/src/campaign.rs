//! A campaign: what its files say, as a table in SI.

use std::sync::Arc;

use elastogeo::description::campaign::csv_in;
use elastogeo::description::units::Units;
use elastogeo::files::LoadedCampaign;
use pyo3::prelude::*;

use crate::faults::Faults;
use crate::observation::Kind;
use crate::own::{look_for_sites, own};
use crate::work::brief;

#[pyclass(frozen, module = "elastogeo._native")]
pub struct Campaign {
    pub loaded: Arc<LoadedCampaign>,
    pub faults: Faults,
}

#[pymethods]
impl Campaign {
    #[new]
    #[pyo3(signature = (file, robot=None, effects=Vec::new(), kinds=Vec::new()))]
    fn new(
        py: Python<'_>,
        file: String,
        robot: Option<String>,
        effects: Vec<Bound<'_, PyAny>>,
        kinds: Vec<Bound<'_, Kind>>,
    ) -> PyResult<Self> {
        let own = own(py, &effects, &kinds)?;
        let faults = own.faults.clone();
        let loaded = brief(py, move || {
            let loaded = own.reader().campaign(&file, robot.as_deref())?;
            look_for_sites(&own.catalogue, &loaded.robot.model);
            Ok(loaded)
        });
        let loaded = Arc::new(faults.first(loaded)?);
        Ok(Self { loaded, faults })
    }

    #[getter]
    fn name(&self) -> String {
        self.loaded.campaign.name.clone()
    }

    #[getter]
    fn robot(&self) -> Option<String> {
        self.loaded.raw.robot.clone()
    }

    #[getter]
    fn observes(&self) -> &'static str {
        self.loaded.campaign.observes.name()
    }

    #[getter]
    fn readings(&self) -> usize {
        self.loaded.campaign.readings.len()
    }

    #[getter]
    fn poses(&self) -> Vec<String> {
        self.loaded.campaign.poses.clone()
    }

    /// Warnings of the files, one line each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.loaded.diagnostics.iter().map(ToString::to_string).collect()
    }

    /// The readings as a CSV in SI units.
    fn csv(&self, py: Python<'_>) -> PyResult<String> {
        brief(py, || {
            let model = &self.loaded.robot.model;
            let markers: Vec<String> = model.markers.iter().map(|marker| marker.name.clone()).collect();
            Ok(csv_in(&self.loaded.campaign, &model.variables, &markers, &Units::default())?)
        })
    }
}
