//! Information of each station: rows of its readings by the identifiable parameters, made comparable by those of a pool.

use nalgebra::DMatrix;

use super::criterion::{Optimality, Target};
use super::error::PlanningError;
use super::place::Station;
use super::request::Request;
use crate::description::campaign::{Campaign, Conditions, InSession, Reading};
use crate::estimation::{candidates, row_sigmas};
use crate::identifiability::{Column, Identifiability, reduce};
use crate::math::distinct;
use crate::model::Model;
use crate::observation::{DEFLECTION, POSITION};
use crate::parameter::{Group, Parameter, Slot};
use crate::prediction::{Predictor, fill_holding_loads, seated};
use crate::simulation::{Loaded, Plan, unmeasured};

/// Derivatives of readings by identifiable parameters in the coordinates in which the mean candidate's information is
/// the identity: parameters are `unwhiten` times the coordinates.
pub struct Information<'a> {
    model: &'a Model,
    values: Vec<f64>,
    blank: Campaign,
    /// Readings made together at one configuration.
    ways: Vec<Vec<Reading>>,
    repeats: f64,
    /// Parameters by column.
    pub slots: Vec<Slot>,
    /// The reduction on all candidates (and what is measured already).
    pub identifiability: Identifiability,
    /// (p x p).
    pub unwhiten: DMatrix<f64>,
    /// Information of what is measured already, with the ridge (p x p).
    pub known: DMatrix<f64>,
    /// Its rows over their noise, row-major.
    known_rows: Vec<f64>,
    /// As in [`super::Settings`].
    seen: f64,
    nuisance: f64,
    short_list: usize,
}

/// What is known without the readings to come, and from which of its rows on: the readings made already, or the constraints
/// of a design, which hold of `one` reading of it.
fn known_before(
    model: &Model,
    request: &Request,
    values: &[f64],
    one: impl Fn() -> Campaign,
) -> Result<Option<(Campaign, usize)>, PlanningError> {
    let constraints = request.design.as_ref().map(|design| &design.campaign.declared);
    Ok(match (&request.measured, constraints) {
        (Some(measured), _) => Some((seated(model, measured, values)?.into_owned(), 0)),
        (None, Some(constraints)) if !constraints.is_empty() => {
            let before = Campaign { constraints: constraints.clone(), ..one() };
            let first = before.rows() - constraints.len();
            Some((before, first))
        }
        (None, _) => None,
    })
}

impl<'a> Information<'a> {
    pub fn new(model: &'a Model, request: &Request, pool: &[Station]) -> Result<Self, PlanningError> {
        let (blank, ways, values) = match &request.design {
            Some(design) => (bare(&design.campaign), design.ways.clone(), design.values.clone()),
            None => {
                let blank = unmeasured(model, &plan(request));
                let way = way(&blank, &request.markers);
                (blank, vec![way], model.registry.nominal())
            }
        };
        let campaign = measured_at(&blank, &ways, pool);
        let mut slots = candidates(model, &campaign, request.what)?;
        let before = known_before(model, request, &values, || measured_at(&blank, &ways, &pool[..1]))?;
        if let Some((before, _)) = &before {
            let also = candidates(model, before, request.what)?;
            slots.extend(also.into_iter().filter(|slot| !slots.contains(slot)).collect::<Vec<_>>());
        }
        let repeats = request.repeats as f64;
        let mut rows = weighted(model, &values, &campaign, &slots, repeats)?;
        let known_rows = match &before {
            Some((before, first)) => weighted(model, &values, before, &slots, 1.0)?[first * slots.len()..].to_vec(),
            None => Vec::new(),
        };
        let pool_rows = rows.len() / slots.len();
        rows.extend_from_slice(&known_rows);
        let identifiability = reduce(&rows, &about(model, &slots, request), request.scaling, request.tolerance);
        let kept = &identifiability.kept;
        if kept.is_empty() {
            return Err(PlanningError::NothingSeen);
        }
        let (width, p) = (slots.len(), kept.len());
        let all = DMatrix::from_fn(rows.len() / width, p, |i, j| rows[i * width + kept[j]]);
        let unwhiten = unwhitening(&all, pool.len()).ok_or(PlanningError::NothingSeen)?;
        let measured = all.rows(pool_rows, all.nrows() - pool_rows) * &unwhiten;
        let super::settings::Settings { seen, nuisance, short_list, .. } = request.settings;
        let mut known = measured.tr_mul(&measured) + DMatrix::identity(p, p) * request.settings.ridge;
        if request.settings.prior {
            let kept = kept.iter().map(|&column| &model.registry[slots[column]]);
            add_prior(&mut known, &unwhiten, kept);
        }
        Ok(Self {
            model,
            values,
            blank,
            ways,
            repeats,
            slots,
            identifiability,
            unwhiten,
            known,
            known_rows,
            seen,
            nuisance,
            short_list,
        })
    }

    /// Rows of each station's readings over their noise, as columns (p x rows).
    pub fn blocks(&self, stations: &[Station]) -> Result<Vec<DMatrix<f64>>, PlanningError> {
        if stations.is_empty() {
            return Ok(Vec::new());
        }
        let campaign = measured_at(&self.blank, &self.ways, stations);
        let rows = weighted(self.model, &self.values, &campaign, &self.slots, self.repeats)?;
        let whitened = self.whitened(&rows);
        let mut first = 0;
        Ok(stations
            .iter()
            .map(|station| {
                let count = read_at(&self.ways, station).map(|reading| reading.observes.rows()).sum();
                let block = whitened.columns(first, count).into_owned();
                first += count;
                block
            })
            .collect())
    }

    /// The campaign that stations make.
    pub fn campaign(&self, stations: &[Station]) -> Campaign {
        measured_at(&self.blank, &self.ways, stations)
    }

    /// The reduction on planned readings and those already made.
    pub fn reduced(&self, request: &Request, planned: &Campaign) -> Result<Identifiability, PlanningError> {
        let mut rows = weighted(self.model, &self.values, planned, &self.slots, self.repeats)?;
        rows.extend_from_slice(&self.known_rows);
        Ok(reduce(&rows, &about(self.model, &self.slots, request), request.scaling, request.tolerance))
    }

    fn whitened(&self, rows: &[f64]) -> DMatrix<f64> {
        let (width, kept) = (self.slots.len(), &self.identifiability.kept);
        let picked = DMatrix::from_fn(kept.len(), rows.len() / width, |i, j| rows[j * width + kept[i]]);
        self.unwhiten.tr_mul(&picked)
    }

    /// W with which tr(W M^-1) is the mean square position error (m^2) at the tests, in the frame of measurement.
    pub fn tests(&self, tests: &[Loaded]) -> Result<DMatrix<f64>, PlanningError> {
        let observes = if self.blank.observes.is_difference() { DEFLECTION } else { POSITION };
        let blank = Campaign { observes, sigma: Some([1.0; 3]), sigma_orientation: None, ..self.blank.clone() };
        // The points that are read; the tool centre point where it is bodies or joints.
        let places = |reading: &&Reading| !reading.observes.ignores_arrangement();
        let mut points: Vec<(Option<usize>, InSession)> =
            distinct(self.ways.iter().flatten().filter(places).map(|reading| (reading.marker, reading.session)));
        if points.is_empty() {
            points.push((None, InSession::default()));
        }
        let way = points.iter().map(|&(marker, session)| Reading { marker, session, ..blank.blank() }).collect();
        let station = |(q, load): &Loaded| Station {
            q: q.clone(),
            load: *load,
            markers: points.iter().map(|(marker, _)| *marker).collect(),
            at: nalgebra::Point3::origin(),
            way: 0,
        };
        let stations: Vec<Station> = tests.iter().map(station).collect();
        let campaign = measured_at(&blank, &[way], &stations);
        let rows = weighted(self.model, &self.values, &campaign, &self.slots, 1.0)?;
        let whitened = self.whitened(&rows);
        Ok(&whitened * whitened.transpose() / campaign.readings.len() as f64)
    }

    /// The criterion; `tests` as [`Information::tests`].
    pub fn target(&self, criterion: Optimality, tests: &DMatrix<f64>) -> Target {
        let tolerances = self.kept().map(|slot| {
            let tolerance = self.model.registry[slot].tolerance;
            if tolerance > 0.0 && tolerance.is_finite() { tolerance } else { 1.0 }
        });
        let tolerances: Vec<f64> = tolerances.collect();
        match criterion {
            Optimality::TestError => {
                // What test poses do not depend on (the place of a second station, the mount of a sensor) is to be found as well.
                let count = tests.nrows();
                let little = self.nuisance * tests.trace() / count.max(1) as f64;
                Target::Trace(tests + DMatrix::identity(count, count) * little)
            }
            Optimality::D => Target::Determinant,
            Optimality::A => {
                let scaled =
                    DMatrix::from_fn(tolerances.len(), tolerances.len(), |i, j| self.unwhiten[(i, j)] / tolerances[i]);
                Target::Trace(scaled.tr_mul(&scaled))
            }
            other => {
                // The coordinates of one tolerance of each parameter.
                let n = tolerances.len();
                let whiten = self.unwhiten.clone().try_inverse().unwrap_or_else(|| DMatrix::identity(n, n));
                let scale = DMatrix::from_fn(n, n, |i, j| whiten[(i, j)] * tolerances[j]);
                Target::Singular(other, scale, self.short_list)
            }
        }
    }

    /// Kept parameters.
    pub fn kept(&self) -> impl Iterator<Item = Slot> + '_ {
        self.identifiability.kept.iter().map(|&column| self.slots[column])
    }

    /// One sigma of each kept parameter, SI; `None` where some combination of them is not seen.
    pub fn deviations(&self, m: &DMatrix<f64>) -> Option<Vec<f64>> {
        let n = m.nrows();
        let factor = m.clone().cholesky()?;
        let spread = factor.solve(&self.unwhiten.transpose());
        Some((0..n).map(|k| self.unwhiten.row(k).transpose().dot(&spread.column(k)).max(0.0).sqrt()).collect())
    }

    /// Whether every combination of the parameters is seen.
    pub fn is_whole(&self, m: &DMatrix<f64>) -> bool {
        m.symmetric_eigenvalues().min() > self.seen
    }
}

/// Adds to an information that constants of the geometry are known to their tolerances.
fn add_prior<'p>(known: &mut DMatrix<f64>, unwhiten: &DMatrix<f64>, kept: impl Iterator<Item = &'p Parameter>) {
    for (k, parameter) in kept.enumerate() {
        if parameter.group == Group::Geometry && parameter.tolerance > 0.0 {
            let row = unwhiten.row(k).transpose() / parameter.tolerance;
            known.ger(1.0, &row, &row, 1.0);
        }
    }
}

/// What takes the mean information of so many stations, whose rows are `rows`, to the identity (p x p).
fn unwhitening(rows: &DMatrix<f64>, stations: usize) -> Option<DMatrix<f64>> {
    let (count, p) = rows.shape();
    let norms: Vec<f64> = rows.column_iter().map(|column| column.norm()).collect();
    let scaled = DMatrix::from_fn(count.max(p), p, |i, j| if i < count { rows[(i, j)] / norms[j] } else { 0.0 });
    let inverse = (scaled.qr().r() / (stations as f64).sqrt()).try_inverse()?;
    Some(DMatrix::from_fn(p, p, |i, j| inverse[(i, j)] / norms[i]))
}

fn about(model: &Model, slots: &[Slot], request: &Request) -> Vec<Column> {
    slots.iter().map(|slot| Column::about(&model.registry[*slot], request.hold.contains(slot))).collect()
}

/// A campaign's words, without its readings and what holds them together.
pub fn bare(campaign: &Campaign) -> Campaign {
    Campaign {
        constraints: Vec::new(),
        declared: Vec::new(),
        poses: Vec::new(),
        conditions: Conditions::default(),
        ..campaign.select(|_, _| false)
    }
}

fn plan(request: &Request) -> Plan {
    Plan {
        configurations: Vec::new(),
        markers: Vec::new(),
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes: request.observes,
        sigma: request.sigma,
        sigma_orientation: request.sigma_orientation,
        estimate: request.estimate,
    }
}

/// All points, to each of what they are measured from.
fn way(blank: &Campaign, markers: &[Option<usize>]) -> Vec<Reading> {
    let targets = blank.targets_per_point();
    let all = markers.iter().flat_map(|&marker| targets.iter().map(move |&target| (marker, target)));
    all.map(|(marker, target)| Reading { marker, target, ..blank.blank() }).collect()
}

/// What is read at a station: of its way what can be seen.
fn read_at<'w>(ways: &'w [Vec<Reading>], station: &'w Station) -> impl Iterator<Item = &'w Reading> {
    let way = ways.get(station.way).into_iter().flatten();
    way.filter(|reading| station.markers.contains(&reading.marker))
}

fn measured_at(blank: &Campaign, ways: &[Vec<Reading>], stations: &[Station]) -> Campaign {
    let mut campaign = blank.clone();
    let all = || ways.iter().flatten().map(|reading| reading.observes.is_difference());
    let is_mixed = all().any(|is| is) && all().any(|is| !is);
    for (pose, station) in stations.iter().enumerate() {
        campaign.poses.push(format!("p{:03}", pose + 1));
        for reading in read_at(ways, station) {
            let row = campaign.readings.len() + 1;
            // Beside deflections places are read without load.
            let wrench = if is_mixed && !reading.observes.is_difference() { [0.0; 6] } else { station.load };
            campaign.readings.push(Reading { row, line: 0, pose, wrench, ..*reading });
            campaign.joints.extend_from_slice(&station.q);
        }
    }
    campaign
}

/// Derivatives of a campaign's readings over their sigmas, row-major.
fn weighted(
    model: &Model,
    values: &[f64],
    campaign: &Campaign,
    slots: &[Slot],
    repeats: f64,
) -> Result<Vec<f64>, PlanningError> {
    let mut loaded = std::borrow::Cow::Borrowed(campaign);
    if campaign.readings.iter().any(|reading| reading.observes.by_variable().is_some()) {
        fill_holding_loads(model, loaded.to_mut())?;
    }
    let mut found = Predictor::new(model, &loaded, slots.to_vec())?.linearised(values)?;
    for (row, sigma) in found.jacobian.chunks_mut(slots.len()).zip(row_sigmas(campaign)) {
        row.iter_mut().for_each(|value| *value *= repeats.sqrt() / sigma);
    }
    Ok(found.jacobian)
}
