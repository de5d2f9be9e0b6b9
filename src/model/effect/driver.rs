//! What an effect may follow in a free curve: the angle of a joint, the load on it, its last move, the time.

/// A scalar of the reading context that a curve follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Driver {
    /// The coordinate ([`crate::model::Model::coordinates`]), rad or m: written by its name, `q3`.
    Angle(usize),
    /// Load on its joint under own weight alone, N.m or N: `own-load.q3`.
    OwnLoad(usize),
    /// Load on its joint under own weight and the applied wrench, N.m or N: `load.q3`.
    Load(usize),
    /// Its move from the configuration before, rad or m: `move.q3`.
    LastMove(usize),
    /// s from the start: `time`.
    Time,
    /// s from the first reading of the session: `session-time`.
    SessionTime,
    /// Place in the order of measurement, counted in readings, of campaigns that state an order and no times: `order`.
    Order,
    /// Temperature, degC or K as the campaign has it: `temperature`.
    Temperature,
    /// Distance of the measured point from the instrument, m: `range`.
    Range,
    /// Its height above the instrument, along the vertical, m: `height`.
    Height,
}

impl Driver {
    /// Unit of its values, SI; of angles and loads that of a revolute joint.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Angle(_) | Self::LastMove(_) => "rad",
            Self::OwnLoad(_) | Self::Load(_) => "N.m",
            Self::Time | Self::SessionTime => "s",
            Self::Order => "1",
            Self::Temperature => "K",
            Self::Range | Self::Height => "m",
        }
    }

    /// As it is written, `names` being those of the coordinates.
    pub fn written(self, names: &[impl AsRef<str>]) -> String {
        let name = |coordinate: usize| names.get(coordinate).map_or("?", AsRef::as_ref);
        match self {
            Self::Angle(variable) => name(variable).into(),
            Self::OwnLoad(variable) => format!("own-load.{}", name(variable)),
            Self::Load(variable) => format!("load.{}", name(variable)),
            Self::LastMove(variable) => format!("move.{}", name(variable)),
            Self::Time => "time".into(),
            Self::SessionTime => "session-time".into(),
            Self::Order => "order".into(),
            Self::Temperature => "temperature".into(),
            Self::Range => "range".into(),
            Self::Height => "height".into(),
        }
    }

    /// The one that is written so; `None` of what is unknown.
    pub fn read(written: &str, names: &[impl AsRef<str>]) -> Option<Self> {
        Self::every(names.len()).find(|driver| driver.written(names) == written)
    }

    /// All that can be written.
    pub fn all(names: &[impl AsRef<str>]) -> Vec<String> {
        Self::every(names.len()).map(|driver| driver.written(names)).collect()
    }

    fn every(coordinates: usize) -> impl Iterator<Item = Self> {
        let of = |k| [Self::Angle, Self::OwnLoad, Self::Load, Self::LastMove].map(|driver| driver(k));
        (0..coordinates).flat_map(of).chain([
            Self::Time,
            Self::SessionTime,
            Self::Order,
            Self::Temperature,
            Self::Range,
            Self::Height,
        ])
    }
}
