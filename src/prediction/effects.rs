//! Columns of effects that are not switched on: what one unit of each of their parameters would change in the readings.

use rayon::prelude::*;

use super::deflection::Deflections;
use super::terms::{Term, Terms};
use super::{Deflected, PredictionError, Predictor, by_column, mechanism, predict, rest};
use crate::description::campaign::Campaign;
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
                    let at = predict(&geometry, campaign, &placements, reading, &Deflected::default()).point;
                    let first = rows.len();
                    rows.resize(first + components * width, 0.0);
                    for (column, by) in work.columns.iter().enumerate() {
                        let derivative = campaign.observes.derivative(&at, &by_column(by));
                        for (row, value) in rows[first..].chunks_exact_mut(width).zip(derivative) {
                            row[column] = value;
                        }
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
