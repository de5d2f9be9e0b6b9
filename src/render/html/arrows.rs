//! Residuals as arrows of the 3-D view: places in m, errors in mm, base axes.

use indexmap::IndexMap;
use serde::Serialize;

use crate::review::{Review, StageKey};

/// Most arrows that are drawn: every so many readings, where there are more.
const ARROWS: usize = 1500;

/// Arrows by stage.
#[derive(Serialize)]
pub struct Arrows {
    points: Vec<[f64; 3]>,
    rows: Vec<usize>,
    errors: IndexMap<StageKey, Vec<[f64; 3]>>,
    of: usize,
    noise: f64,
}

impl Arrows {
    /// `None` of distances, which have no direction.
    pub fn new(review: &Review) -> Option<Self> {
        let (campaign, readings) = (review.campaign, &review.readings);
        if campaign.readings.iter().all(|reading| reading.observes.length_rows() < 3) {
            return None;
        }
        let count = campaign.readings.len();
        let drawn = |index: &usize| campaign.readings[*index].observes.length_rows() >= 3;
        let order: Vec<usize> = (0..count).step_by(count.div_ceil(ARROWS).max(1)).filter(drawn).collect();
        let errors = readings.stages.iter().map(|stage| {
            let all = order.iter().filter_map(|&index| readings.in_base(campaign, stage, index));
            (stage.key, all.map(|e| [e.x, e.y, e.z].map(|v| (v * 1e7).round() / 1e4)).collect())
        });
        let points = order.iter().map(|&index| readings.points[index]);
        Some(Self {
            points: points.map(|p| [p.x, p.y, p.z].map(|v| (v * 1e5).round() / 1e5)).collect(),
            rows: order.iter().map(|&index| campaign.readings[index].row).collect(),
            errors: errors.collect(),
            of: count,
            noise: review.diagnosis.gap.noise * 1e3,
        })
    }
}
