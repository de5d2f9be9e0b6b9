//! Values of what free curves follow over the readings of a campaign, and the knots that curves of them have.

use nalgebra::Vector3;

use crate::description::campaign::Campaign;
use crate::model::{Driver, Follower};
use crate::state::JointLoads;

/// Configurations for each knot, so that a curve is determined several times over; knots at least and at most. Few knots
/// show a shape, and do not follow noise.
const CONFIGURATIONS_PER_KNOT: usize = 12;
const KNOTS: [usize; 2] = [4, 7];
/// Values that differ by less than this share of their range count once.
const SAME: f64 = 1e-3;

/// Values of every driver that a campaign has, by reading.
pub(super) struct DriverValues {
    configurations: usize,
    values: Vec<(Driver, Vec<f64>)>,
}

impl DriverValues {
    /// Drivers of which a campaign may have values, of so many coordinates; last moves only where the order of its readings
    /// is stated: of rows that may have been sorted a curve of any shape would say too much.
    pub fn new(campaign: &Campaign, coordinates: usize) -> Self {
        let conditions = &campaign.conditions;
        let mut drivers: Vec<Driver> = Vec::new();
        for own in 0..coordinates {
            drivers.extend([Driver::Angle(own), Driver::OwnLoad(own), Driver::Load(own)]);
            drivers.extend(conditions.is_order_stated().then_some(Driver::LastMove(own)));
        }
        drivers.extend(conditions.time.as_ref().map(|_| Driver::Time));
        drivers.extend(conditions.session_time.as_ref().map(|_| Driver::SessionTime));
        let has_order_alone = conditions.time.is_none() && conditions.is_order_stated() && !conditions.rank.is_empty();
        drivers.extend(has_order_alone.then_some(Driver::Order));
        drivers.extend(conditions.temperature.as_ref().map(|_| Driver::Temperature));
        drivers.extend([Driver::Range, Driver::Height]);
        let configurations = campaign.configurations().into_iter().max().map_or(0, |last| last + 1);
        Self { configurations, values: drivers.into_iter().map(|driver| (driver, Vec::new())).collect() }
    }

    /// Notes the values of a reading; `seen` is where its point is from the instrument, and the vertical there.
    pub fn note(
        &mut self,
        campaign: &Campaign,
        index: usize,
        followers: &[Follower],
        loads: &JointLoads,
        seen: Option<[Vector3<f64>; 2]>,
    ) {
        let (conditions, q) = (&campaign.conditions, campaign.configuration(index));
        let follower = |own: usize| followers.get(own.checked_sub(q.len())?);
        let last = |variable: usize| conditions.last_move.get(variable)?.get(index).copied();
        let of = |all: &Option<Vec<f64>>| all.as_ref().and_then(|all| all.get(index)).copied();
        for (driver, values) in &mut self.values {
            let value = match *driver {
                Driver::Angle(own) => q.get(own).copied().or_else(|| Some(follower(own)?.of(q))),
                Driver::OwnLoad(own) => loads.own.get(own).copied(),
                Driver::Load(own) => loads.total.get(own).copied(),
                Driver::LastMove(own) => match follower(own) {
                    Some(follower) => {
                        let moved: Option<Vec<f64>> = (0..q.len()).map(last).collect();
                        moved.map(|moved| follower.of(&moved))
                    }
                    None => last(own),
                },
                Driver::Time => of(&conditions.time),
                Driver::SessionTime => of(&conditions.session_time),
                Driver::Order => conditions.rank.get(index).copied(),
                Driver::Temperature => of(&conditions.temperature),
                Driver::Range => seen.map(|[position, _]| position.norm()),
                Driver::Height => seen.map(|[position, up]| up.dot(&position)),
            };
            values.extend(value.filter(|value| value.is_finite()));
        }
    }

    /// Knots at quantiles, of the drivers that have enough different values.
    pub fn knots(self) -> Vec<(Driver, Vec<f64>)> {
        let count = (self.configurations / CONFIGURATIONS_PER_KNOT).clamp(KNOTS[0], KNOTS[1]);
        let of = |(driver, values): (Driver, Vec<f64>)| Some((driver, quantiles(values, count)?));
        self.values.into_iter().filter_map(of).collect()
    }
}

/// Values at so many equal shares of the readings, ends included; `None` where too few differ.
fn quantiles(mut values: Vec<f64>, count: usize) -> Option<Vec<f64>> {
    values.sort_by(f64::total_cmp);
    let range = values.last()? - values.first()?;
    values.dedup_by(|a, b| *a - *b <= SAME * range);
    let last = values.len().checked_sub(1)?;
    let mut knots: Vec<f64> = (0..count).map(|k| values[k * last / (count - 1)]).collect();
    knots.dedup_by(|a, b| *a - *b <= SAME * range);
    (range > 0.0 && knots.len() >= KNOTS[0]).then_some(knots)
}
