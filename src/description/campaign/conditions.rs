//! Conditions under which readings were taken: time (s from the start), temperatures (as the file gives them, usually degC)
//! and the side from which each variable reached the configuration. They are what effects depend on in addition to joints
//! and load.

use indexmap::IndexMap;

/// A condition, as a column of the measurements has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConditionColumn<'a> {
    /// Of the surroundings.
    Temperature,
    /// From the start.
    Time,
    /// Side of approach of a variable, by index.
    Approach(usize),
    /// Of a frame, by name.
    SiteTemperature(&'a str),
}

impl ConditionColumn<'_> {
    /// The column's name; variables by `variable`.
    pub fn column<'v>(&self, variable: impl Fn(usize) -> &'v str) -> String {
        match self {
            Self::Temperature => "temperature".into(),
            Self::Time => "time".into(),
            Self::Approach(index) => format!("approach.{}", variable(*index)),
            Self::SiteTemperature(site) => format!("temperature.{site}"),
        }
    }

    /// Unit in reports; of a side of approach none.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Temperature | Self::SiteTemperature(_) => "degC",
            Self::Time => "s",
            Self::Approach(_) => "",
        }
    }
}

/// Moves before the last one that are kept: friction forgets a path after some moves that are long compared with the lost motion.
pub const EARLIER_MOVES: usize = 7;

/// Conditions of all readings: each is absent, or has one value a reading (NaN where its file has no such column).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Conditions {
    /// From the start, s.
    pub time: Option<Vec<f64>>,
    /// Of the surroundings, as given.
    pub temperature: Option<Vec<f64>>,
    /// Of frames, by name, as given.
    pub site_temperatures: IndexMap<String, Vec<f64>>,
    /// By variable: +1 or -1, the side from which it reached the configuration; 0 where unknown.
    pub approach: Vec<Option<Vec<f64>>>,
    /// By variable: the other value where files give both, the commanded one of readings at recorded joints or the reverse,
    /// rad and m.
    pub other_joints: Vec<Option<Vec<f64>>>,
    /// By variable: what its sensor of torques showed, N.m or N, where that loads the joint instead of what the description
    /// says; NaN where it is not known.
    pub torques: Vec<Option<Vec<f64>>>,
    /// By variable, where torques are given: the load that the description puts on its joint, N.m or N.
    pub described_loads: Vec<Vec<f64>>,
    /// By variable: by how much it moved from the configuration before, rad and m; NaN where that is unknown. Empty where
    /// no order is known.
    pub last_move: Vec<Vec<f64>>,
    /// Of the [`EARLIER_MOVES`] moves before it, the later first, by variable, as `last_move`.
    pub earlier_moves: Vec<Vec<Vec<f64>>>,
    /// What says in which order readings were measured.
    pub order: OrderBy,
    /// Place of each reading in the order of measurement, sessions one after the other: of some readings the others' places are left out.
    /// Empty where the order is unknown.
    pub rank: Vec<f64>,
    /// From the first reading of the session, s.
    pub session_time: Option<Vec<f64>>,
}

/// What says in which order the readings of a session were measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OrderBy {
    /// Their rows, of which nothing is said.
    #[default]
    Rows,
    /// Their rows, as the campaign states (`order: rows`).
    StatedRows,
    /// Nothing: rows have been sorted or mixed since, as the campaign states (`order: unknown`).
    Unknown,
    /// Times, some of which two configurations of a session have in common: these by their rows.
    TimesAndRows,
    /// Times that tell every configuration of a session from the others.
    Times,
    /// The numbers in the column `order`.
    Numbers,
}

impl Conditions {
    /// Whether it is known which configuration came before which.
    pub fn is_ordered(&self) -> bool {
        self.order != OrderBy::Unknown
    }

    /// Whether numbers, times or the campaign say so, and not their rows alone.
    pub fn is_order_stated(&self) -> bool {
        !matches!(self.order, OrderBy::Rows | OrderBy::TimesAndRows | OrderBy::Unknown)
    }

    /// What is given, in the order of reports and files.
    pub fn columns(&self) -> impl Iterator<Item = (ConditionColumn<'_>, &Vec<f64>)> {
        let approach = self.approach.iter().enumerate();
        let sites = self.site_temperatures.iter();
        self.temperature
            .iter()
            .map(|all| (ConditionColumn::Temperature, all))
            .chain(self.time.iter().map(|all| (ConditionColumn::Time, all)))
            .chain(approach.filter_map(|(k, all)| Some((ConditionColumn::Approach(k), all.as_ref()?))))
            .chain(sites.map(|(site, all)| (ConditionColumn::SiteTemperature(site), all)))
    }

    /// The values of what is given.
    pub fn columns_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let approach = self.approach.iter_mut().flatten();
        self.temperature.iter_mut().chain(&mut self.time).chain(approach).chain(self.site_temperatures.values_mut())
    }

    /// All that has one value a reading, derived or given.
    pub fn all_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let approach = self.approach.iter_mut().flatten();
        let given = self.temperature.iter_mut().chain(&mut self.time).chain(approach);
        let loads = self.torques.iter_mut().flatten().chain(&mut self.described_loads);
        let joints = self.other_joints.iter_mut().flatten().chain(&mut self.last_move).chain(loads);
        let joints = joints.chain(self.earlier_moves.iter_mut().flatten());
        let rank = std::iter::once(&mut self.rank).filter(|rank| !rank.is_empty());
        given.chain(self.site_temperatures.values_mut()).chain(joints).chain(&mut self.session_time).chain(rank)
    }

    /// Temperature at a reading, as given; none where it is not.
    pub fn temperature_of(&self, reading: usize) -> Option<f64> {
        self.temperature.as_ref().and_then(|all| all.get(reading)).copied().filter(|value| value.is_finite())
    }

    /// Whether any temperature is given.
    pub fn has_temperature(&self) -> bool {
        self.temperature.is_some() || !self.site_temperatures.is_empty()
    }

    /// Sides of approach of a variable, where given.
    pub fn sides(&self, variable: usize) -> Option<&[f64]> {
        self.approach.get(variable)?.as_deref()
    }

    /// Sets the sides of approach of a variable.
    pub fn set_sides(&mut self, variable: usize, sides: Vec<f64>) {
        if self.approach.len() <= variable {
            self.approach.resize(variable + 1, None);
        }
        self.approach[variable] = Some(sides);
    }

    /// Temperatures of a frame: its own, else those of the surroundings.
    pub fn temperatures_at(&self, site: &str) -> Option<&[f64]> {
        self.site_temperatures.get(site).or(self.temperature.as_ref()).map(Vec::as_slice)
    }

    /// What a site feels that follows its thermometer with a time constant (s), by reading; `None` where no times are known.
    /// Before the first reading it had the temperature of that; NaN where a reading has none.
    pub fn delayed_temperatures(&self, site: &str, time_constant: f64) -> Option<Vec<f64>> {
        let (shown, times) = (self.temperatures_at(site)?, self.time.as_ref()?);
        let mut order: Vec<usize> = (0..shown.len().min(times.len())).filter(|&k| shown[k].is_finite()).collect();
        order.sort_by(|&a, &b| times[a].total_cmp(&times[b]));
        let mut felt = vec![f64::NAN; shown.len()];
        let mut last: Option<(usize, f64)> = None;
        for k in order {
            let own = match last {
                // Between readings the thermometer goes in a straight line, which has a closed solution.
                Some((j, before)) if times[k] > times[j] => {
                    let span = times[k] - times[j];
                    let behind = time_constant * (shown[k] - shown[j]) / span;
                    shown[k] - behind + (before - shown[j] + behind) * (-span / time_constant).exp()
                }
                Some((_, before)) => before,
                None => shown[k],
            };
            felt[k] = own;
            last = Some((k, own));
        }
        Some(felt)
    }

    /// Those of some readings, by index.
    #[must_use]
    pub fn select(&self, kept: &[usize]) -> Self {
        let mut selected = self.clone();
        for all in selected.all_mut() {
            *all = kept.iter().map(|&index| all[index]).collect();
        }
        selected
    }
}
