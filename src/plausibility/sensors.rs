//! Other ways to read directions: reversed, with axes mirrored or exchanged, or, of those that are written as two angles (pitch and roll of an
//! inclinometer, azimuth and elevation of an axis), in other columns or units.

use std::f64::consts::{FRAC_PI_2, PI};

use super::turned::Angles;
use crate::description::campaign::{Campaign, Reading};

/// The angle that goes all the way round within a quarter turn of zero, as the other one was written; the other beyond it instead.
fn within_quarters(first: f64, second: f64) -> [f64; 2] {
    let back = |angle: f64| angle - PI.copysign(angle);
    if first.abs() > FRAC_PI_2 {
        [back(first), PI - second]
    } else if second.abs() > FRAC_PI_2 {
        [PI - first, back(second)]
    } else {
        [first, second]
    }
}

/// How two angles of a direction may be meant instead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SensorAngles {
    /// In the unit before, declared in the one after. The reverse, degrees declared as radians, goes round several times and leaves nothing
    /// to read back.
    Unit(Angles, Angles),
    /// The two columns are exchanged.
    Exchanged,
}

impl SensorAngles {
    /// Those that a campaign's readings admit.
    pub fn all(campaign: &Campaign) -> impl Iterator<Item = Self> + use<> {
        let has_any = campaign.readings.iter().any(|own| own.observes.in_other_columns(&own.measured).is_some());
        let of_units = Angles::MISTAKEN.into_iter().filter(|(meant, read)| meant.size() > read.size());
        let ways = of_units.map(|(meant, read)| Self::Unit(meant, read)).chain([Self::Exchanged]);
        ways.filter(move |_| has_any)
    }

    /// Reads all directions so.
    pub fn apply(self, campaign: &mut Campaign) {
        for reading in &mut campaign.readings {
            let Some([first, second]) = reading.observes.in_other_columns(&reading.measured) else { continue };
            let meant = match self {
                Self::Unit(meant, read) => [first, second].map(|angle| angle * meant.size() / read.size()),
                Self::Exchanged => {
                    let [first, second] = within_quarters(first, second);
                    [second, first]
                }
            };
            reading.measured = reading.observes.of_other_columns(&meant);
        }
    }

    /// Names of the two columns.
    pub fn columns(campaign: &Campaign) -> [&'static str; 2] {
        let of_angles = |columns: &'static [crate::observation::ValueColumn]| match columns {
            [first, second] => Some([first.name, second.name]),
            _ => None,
        };
        campaign.readings.iter().find_map(|own| of_angles(own.observes.other_columns())).unwrap_or(["", ""])
    }
}

/// Reads all directions the other way, or those of one target.
pub(super) fn reverse(campaign: &mut Campaign, target: Option<usize>) {
    for reading in campaign.readings.iter_mut().filter(|reading| target.is_none() || reading.target == target) {
        reading.measured = reading.observes.reversed(&reading.measured).unwrap_or(reading.measured);
    }
}

/// Whether the campaign says how the sensor of a reading is mounted.
pub(super) fn is_mounted(campaign: &Campaign, reading: &Reading) -> bool {
    let target = reading.target.and_then(|target| campaign.targets.get(target));
    target.is_none_or(|target| target.values.iter().all(|value| value.parameter.is_none()))
}

/// Reads otherwise all directions of sensors that are mounted as the campaign says.
pub(super) fn read_directions(campaign: &mut Campaign, way: impl Fn(&mut [f64])) {
    let own: Vec<bool> = campaign.readings.iter().map(|reading| is_mounted(campaign, reading)).collect();
    for (reading, _) in campaign.readings.iter_mut().zip(own).filter(|(_, own)| *own) {
        if reading.observes.reversed(&reading.measured).is_some() {
            way(&mut reading.measured[..3]);
        }
    }
}
