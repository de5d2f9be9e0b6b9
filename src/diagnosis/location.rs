//! Where the gap lies: by site, by condition, by direction.

use nalgebra::{DMatrix, DVector, Vector3};

use super::algebra::{orthonormal, rest};
use super::evidence::Evidence;
use super::figures::ends;
use crate::description::campaign::Campaign;
use crate::effects::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind, sites_of};
use crate::model::Model;
use crate::prediction::{PredictionError, Term, effect_columns};

/// Share of the gap that a free local error at a site could carry.
#[derive(Debug, Clone, PartialEq)]
pub struct SiteShare {
    /// Site.
    pub site: String,
    /// Share of the squared gap above the noise, beyond what as many free numbers carry of any motion of the tool.
    pub share: f64,
    /// 95 % interval by configuration.
    pub ci95: [f64; 2],
}

/// A region in which the gap is greatest.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    /// In words.
    pub when: String,
    /// Root mean square error inside, m.
    pub rms: f64,
    /// And outside.
    pub elsewhere: f64,
}

/// Where the gap lies.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Location {
    /// By site, the greatest share first.
    pub sites: Vec<SiteShare>,
    /// By condition.
    pub conditions: Vec<Condition>,
    /// Root mean square error by direction, m, measurement frame.
    pub directions: [f64; 3],
    /// Of deflections: where the robot yields most against what the description predicts.
    pub yielding: Option<Yielding>,
}

/// A region in which the robot yields more than predicted: the description is too stiff there.
#[derive(Debug, Clone, PartialEq)]
pub struct Yielding {
    /// In words.
    pub when: String,
    /// Measured deflections over those predicted, less 1 (least squares over the region).
    pub excess: f64,
    /// The same outside.
    pub elsewhere: f64,
}

/// A local error that is free in every configuration.
struct Probe(SiteKind);

impl Effect for Probe {
    fn name(&self) -> &'static str {
        "probe"
    }

    fn sits_at(&self) -> SiteKind {
        self.0
    }

    fn signature(&self) -> &'static str {
        ""
    }

    fn remedy(&self) -> &'static str {
        ""
    }

    fn parameters(&self, _model: &Model, _site: &Site, _form: &Form) -> Vec<EffectParameter> {
        let count = match self.0 {
            SiteKind::Base => 3,
            _ => 1,
        };
        let parameter = EffectParameter { symbol: "free".into(), unit: "", scale: 1.0, is_positive: false };
        vec![parameter; count]
    }

    fn changes(&self, site: &Site, _form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        match self.0 {
            SiteKind::Joint => out.push((0, Change::Yield(site.variable, 1.0))),
            SiteKind::Link => {
                for (index, frame) in moment.model.frames.iter().enumerate().skip(1) {
                    if frame.antecedent == site.frame && index != site.frame {
                        for slot in [frame.slots[4], frame.slots[6]] {
                            let length = moment.model.registry[slot].nominal;
                            if length.abs() > 1e-3 && Some(slot) != frame.moves().then(|| frame.moving_slot()) {
                                out.push((0, Change::Slot(slot, length)));
                            }
                        }
                    }
                }
            }
            SiteKind::Instrument => out.push((0, Change::Point(moment.position, Vector3::zeros()))),
            _ => {
                for k in 0..3 {
                    let mut axis = Vector3::zeros();
                    axis[k] = 1.0;
                    // It rocks about its foot; free to move in all six ways it could carry anything.
                    out.push((k, Change::Point(axis.cross(&(moment.position - moment.base)), axis)));
                }
            }
        }
    }
}

static JOINT: Probe = Probe(SiteKind::Joint);
static LINK: Probe = Probe(SiteKind::Link);
static BASE: Probe = Probe(SiteKind::Base);
static INSTRUMENT: Probe = Probe(SiteKind::Instrument);

/// Shares of all sites in what calibration leaves (`left`, weighted).
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn sites(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    evidence: &Evidence,
    left: &DVector<f64>,
    noise: f64,
    seed: u64,
) -> Result<Vec<SiteShare>, PredictionError> {
    let mut terms = Vec::new();
    for probe in [&JOINT, &LINK, &BASE, &INSTRUMENT] {
        for site in sites_of(model, probe.0) {
            terms.push(Term::new(model, probe, site, Form::ONLY));
        }
    }
    let names: Vec<(String, usize)> =
        terms.iter().map(|term| (term.site.name.clone(), term.parameters.len())).collect();
    let (all, width) = effect_columns(model, campaign, values, terms)?;
    let mut poses: Vec<Vec<usize>> = Vec::new();
    for row in 0..evidence.rows() {
        match poses.last_mut() {
            Some(rows)
                if evidence.pose[rows[0]] == evidence.pose[row]
                    && campaign.readings[evidence.reading[rows[0]]].wrench
                        == campaign.readings[evidence.reading[row]].wrench =>
            {
                rows.push(row);
            }
            _ => poses.push(vec![row]),
        }
    }
    let mut found = Vec::new();
    let mut first = 0;
    for (name, count) in names {
        // By configuration: squares taken up less those of chance, squares above the noise.
        let shares: Vec<[f64; 2]> = poses
            .iter()
            .map(|rows| {
                let columns = DMatrix::from_fn(rows.len(), count, |i, k| {
                    all[rows[i] * width + first + k] / evidence.sigmas[rows[i]]
                });
                let own = DVector::from_iterator(rows.len(), rows.iter().map(|&row| left[row]));
                let basis = orthonormal(&columns, None);
                let taken = own.norm_squared() - rest(&own, &basis).norm_squared();
                let square = noise * noise;
                let total = own.norm_squared() - rows.len() as f64 * square;
                // What as many directions would carry of any motion of the tool.
                let chance = basis.ncols() as f64 / rows.len().clamp(1, 6) as f64;
                let beyond = taken - basis.ncols() as f64 * square - chance * total;
                [beyond / (1.0 - chance).max(0.1), total]
            })
            .collect();
        first += count;
        let share = |draw: &mut dyn Iterator<Item = usize>| {
            let (mut taken, mut total) = (0.0, 0.0);
            for k in draw {
                taken += shares[k][0];
                total += shares[k][1];
            }
            (taken / total.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
        };
        let value = share(&mut (0..shares.len()));
        let mut random = crate::simulation::generator(seed);
        let mut drawn: Vec<f64> = (0..200)
            .map(|_| {
                use rand::RngExt;
                share(
                    &mut (0..shares.len())
                        .map(|_| random.random_range(0..shares.len()))
                        .collect::<Vec<_>>()
                        .into_iter(),
                )
            })
            .collect();
        found.push(SiteShare { site: name, share: value, ci95: ends(&mut drawn) });
    }
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    Ok(found)
}

/// Name, unit, its size and value at each reading.
type Feature = (String, &'static str, f64, Vec<f64>);

/// What regions are told in: variables, load, conditions.
fn features(model: &Model, campaign: &Campaign) -> Vec<Feature> {
    let count = campaign.readings.len();
    let mut features: Vec<Feature> = Vec::new();
    for (k, variable) in model.variables.iter().enumerate() {
        let (unit, size) = if variable.is_angle { ("deg", 1f64.to_radians()) } else { ("mm", 1e-3) };
        let values = (0..count).map(|i| campaign.configuration(i)[k]).collect();
        features.push((variable.name.clone(), unit, size, values));
    }
    let force = |i: usize| {
        let w = &campaign.readings[i].wrench;
        (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]).sqrt()
    };
    features.push(("|f|".into(), "N", 1.0, (0..count).map(force).collect()));
    for (name, values) in &campaign.conditions {
        let unit = match name.as_str() {
            "time" => "s",
            n if n.starts_with("temperature") => "degC",
            _ => "",
        };
        features.push((name.clone(), unit, 1.0, values.clone()));
    }
    features
}

/// The regions (one condition, then two together) in which the error is greatest against elsewhere.
pub fn conditions(model: &Model, campaign: &Campaign, errors: &[(usize, Vector3<f64>)]) -> Vec<Condition> {
    let count = campaign.readings.len();
    let squares: Vec<f64> = errors.iter().map(|(_, e)| e.norm_squared()).collect();
    let features = features(model, campaign);
    let mut within: Vec<bool> = vec![true; count];
    let mut words: Vec<((usize, bool), String)> = Vec::new();
    let mut found = Vec::new();
    for _ in 0..2 {
        let inside: Vec<usize> = (0..count).filter(|&i| within[i] && squares[i].is_finite()).collect();
        if inside.len() < 12 {
            break;
        }
        let mut best: Option<(f64, usize, f64, bool)> = None;
        for (f, (_, _, _, values)) in features.iter().enumerate() {
            let mut order: Vec<usize> = inside.clone();
            order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
            let total: f64 = order.iter().map(|&i| squares[i]).sum();
            let mut low = 0.0;
            for (k, pair) in order.windows(2).enumerate() {
                low += squares[pair[0]];
                let (n_low, n_high) = ((k + 1) as f64, (order.len() - k - 1) as f64);
                let least = (0.1 * order.len() as f64).max(5.0);
                if n_low < least || n_high < least || values[pair[0]] == values[pair[1]] {
                    continue;
                }
                let (mean_low, mean_high) = (low / n_low, (total - low) / n_high);
                let split = n_low * n_high * (mean_low - mean_high).powi(2);
                if best.is_none_or(|b| split > b.0) {
                    best = Some((split, f, 0.5 * (values[pair[0]] + values[pair[1]]), mean_low > mean_high));
                }
            }
        }
        let Some((_, f, threshold, below)) = best else { break };
        let (name, unit, size, values) = &features[f];
        // A narrower limit on the same side says it all.
        words.retain(|(limit, _)| *limit != (f, below));
        words.push(((f, below), said(name, below, threshold / size, unit)));
        for i in 0..count {
            within[i] &= if below { values[i] < threshold } else { values[i] > threshold };
        }
        let rms = |inside: bool| {
            let chosen =
                (0..count).filter(|&i| within[i] == inside && squares[i].is_finite()).map(|i| squares[i].sqrt());
            crate::math::mean_rms_max(chosen)[1]
        };
        let when = words.iter().map(|(_, said)| said.as_str()).collect::<Vec<_>>().join(" and ");
        found.push(Condition { when, rms: rms(true), elsewhere: rms(false) });
    }
    found.reverse();
    found
}

fn said(name: &str, below: bool, threshold: f64, unit: &str) -> String {
    let sign = if below { "<" } else { ">" };
    format!("{name} {sign} {threshold:.3} {unit}").trim_end().to_string()
}

/// The region (one condition) in which measured deflections exceed those predicted most against elsewhere.
pub fn yielding(model: &Model, campaign: &Campaign, errors: &[(usize, Vector3<f64>)]) -> Option<Yielding> {
    if !campaign.observes.is_difference() {
        return None;
    }
    // Along the prediction, and its square.
    let parts: Vec<[f64; 2]> = errors
        .iter()
        .zip(&campaign.readings)
        .map(|((_, error), reading)| {
            let predicted = Vector3::new(reading.measured[0], reading.measured[1], reading.measured[2]) - error;
            [error.dot(&predicted), predicted.norm_squared()]
        })
        .collect();
    let total = parts.iter().fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
    let least = (0.1 * parts.len() as f64).max(5.0) as usize;
    let mut best: Option<(f64, Yielding)> = None;
    for (name, unit, size, values) in features(model, campaign) {
        let mut order: Vec<usize> = (0..parts.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let mut low = [0.0; 2];
        for (k, pair) in order.windows(2).enumerate() {
            low = [low[0] + parts[pair[0]][0], low[1] + parts[pair[0]][1]];
            let high = [total[0] - low[0], total[1] - low[1]];
            let is_narrow = k + 1 < least || order.len() - k - 1 < least;
            if is_narrow || values[pair[0]] == values[pair[1]] || low[1] <= 0.0 || high[1] <= 0.0 {
                continue;
            }
            let excess = [low[0] / low[1], high[0] / high[1]];
            let split = low[1] * high[1] / total[1] * (excess[0] - excess[1]).powi(2);
            if best.as_ref().is_none_or(|(known, _)| split > *known) {
                let below = excess[0] > excess[1];
                let when = said(&name, below, 0.5 * (values[pair[0]] + values[pair[1]]) / size, unit);
                let [excess, elsewhere] = if below { excess } else { [excess[1], excess[0]] };
                best = Some((split, Yielding { when, excess, elsewhere }));
            }
        }
    }
    best.map(|(_, found)| found)
}
