//! Columns of effects that are not switched on: what one unit of each of their parameters would change in the readings.

use rayon::prelude::*;

use super::batch::{Block, Predictor, loads};
use super::error::PredictionError;
use super::reading::{ReadingAt, by_column};
use super::terms::{Term, Terms};
use crate::description::campaign::Campaign;
use crate::model::Model;
use crate::observation::Twist;
use crate::state::Mechanics;

/// Columns of `terms` over all readings of a campaign at `values`: row-major, rows as
/// [`super::Linearised::residual`], a column for each parameter of each term; and their number.
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
    let mechanics = Mechanics::new(model, values, loads(campaign), &[])?;
    let terms = Terms::new(&mechanics, campaign, terms);
    let chunks = predictor.blocks.par_chunks(8);
    let found: Vec<_> = chunks.map(|blocks| rows_of(&mechanics, campaign, &terms, blocks)).collect();
    let mut all = Vec::with_capacity(predictor.rows() * terms.columns);
    for rows in found {
        all.extend(rows?);
    }
    // Nothing that a robot does changes what is known of the arrangement.
    all.resize(predictor.rows() * terms.columns, 0.0);
    Ok((all, terms.columns))
}

fn rows_of(
    mechanics: &Mechanics,
    campaign: &Campaign,
    terms: &Terms,
    blocks: &[Block],
) -> Result<Vec<f64>, PredictionError> {
    let (mut state, mut workspace) = (mechanics.state(), terms.workspace());
    let width = terms.columns;
    let mut rows = Vec::new();
    for block in blocks {
        let placed = mechanics.place(campaign.configuration(block.start), &mut state);
        placed.map_err(|source| PredictionError::at(campaign, block.start, source))?;
        terms.place(mechanics, &mut state, &mut workspace);
        for index in block.clone() {
            let reading = &campaign.readings[index];
            let point = mechanics.point(&state, reading, &reading.wrench);
            let at = ReadingAt { mechanics, state: &state, campaign, index, point: &point };
            terms.evaluate(&at, &mut workspace);
            let seen = at.predict(&Twist::zero()).point;
            let first = rows.len();
            rows.resize(first + reading.observes.rows() * width, 0.0);
            for (column, by) in workspace.columns.iter().enumerate() {
                let derivative = reading.observes.derivative(&seen, &by_column(by));
                for (row, value) in rows[first..].chunks_exact_mut(width).zip(derivative) {
                    row[column] = value;
                }
            }
        }
    }
    Ok(rows)
}
