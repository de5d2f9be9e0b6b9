//! Columns of effects that are not switched on: what one unit of each of their parameters would change in the readings.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::deflection::Deflections;
use super::terms::{Term, Terms};
use super::{PredictionError, Predictor, mechanism, rest};
use crate::description::campaign::{Campaign, Observes};
use crate::kinematics::{Geometry, Placements, Rates};
use crate::model::Model;

/// Columns of `terms` over all readings of a campaign at `values`: row-major, rows as
/// [`super::Linearised::residual`], a column for each parameter of each term.
///
/// # Errors
/// The first configuration that cannot be assembled.
pub fn effect_columns(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    terms: Vec<Term>,
) -> Result<(Vec<f64>, usize), PredictionError> {
    let predictor = Predictor::new(model, campaign, Vec::new())?;
    let geometry = Geometry::new(model, values)?;
    let pattern = Rates::new(model);
    let terms = Terms::new(&geometry, &pattern, campaign, terms);
    let deflections = Deflections::new(model, values, campaign, &[]);
    let (components, width) = (campaign.components(), terms.columns);
    let blocks: Vec<Result<Vec<f64>, PredictionError>> = predictor
        .blocks
        .par_chunks(8)
        .map(|blocks| {
            let (mut placements, mut rates) = (Placements::default(), pattern.clone());
            let (mut work, mut loaded) = (terms.work(), deflections.work());
            let mut rows = Vec::new();
            for block in blocks {
                let q = campaign.configuration(block.start);
                geometry.place(q, &mut placements).map_err(|source| predictor.assembly(block.start, source))?;
                deflections
                    .place(&geometry, q, &placements, &mut loaded)
                    .map_err(|source| mechanism(campaign, block.start, source))?;
                terms.place(&geometry, q, &placements, &mut rates, &mut work);
                for index in block.clone() {
                    let reading = &campaign.readings[index];
                    let point = rest(&geometry, &placements, reading);
                    let applied = deflections.by_wrench(&loaded, reading, &point);
                    terms.evaluate(&geometry, campaign, index, reading, q, &placements, &rates, &applied, &mut work);
                    let direction = direction_to_anchor(campaign, reading, &(geometry.base() * point));
                    for component in 0..components {
                        rows.extend(work.columns.iter().map(|column| match campaign.observes {
                            Observes::Distance => Vector3::new(column[0], column[1], column[2]).dot(&direction),
                            _ => column[component],
                        }));
                    }
                }
            }
            Ok(rows)
        })
        .collect();
    let mut all = Vec::with_capacity(campaign.readings.len() * components * width);
    for block in blocks {
        all.extend(block?);
    }
    Ok((all, width))
}

fn direction_to_anchor(
    campaign: &Campaign,
    reading: &crate::description::campaign::Reading,
    at: &nalgebra::Point3<f64>,
) -> Vector3<f64> {
    match campaign.anchors.get_index(reading.anchor) {
        Some((_, anchor)) if campaign.observes == Observes::Distance => {
            let arm = at.coords - anchor;
            arm / arm.norm().max(f64::MIN_POSITIVE)
        }
        _ => Vector3::zeros(),
    }
}
