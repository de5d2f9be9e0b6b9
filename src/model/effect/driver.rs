//! What an effect may follow in a free curve: the angle of a joint, the load on it, its last move, the time.

/// A scalar of the reading context that a curve follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Driver {
    /// The variable, rad or m: written by its name, `q3`.
    Angle(usize),
    /// Load on the variable's joint under own weight alone, N.m or N: `own-load.q3`.
    OwnLoad(usize),
    /// Load on the variable's joint under own weight and the applied wrench, N.m or N: `load.q3`.
    Load(usize),
    /// Move of the variable from the configuration before, rad or m: `move.q3`.
    LastMove(usize),
    /// s from the start: `time`.
    Time,
    /// s from the first reading of the session: `session-time`.
    SessionTime,
    /// Temperature, degC or K as the campaign has it: `temperature`.
    Temperature,
}

impl Driver {
    /// Unit of its values, SI; of angles and loads that of a revolute joint.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Angle(_) | Self::LastMove(_) => "rad",
            Self::OwnLoad(_) | Self::Load(_) => "N.m",
            Self::Time | Self::SessionTime => "s",
            Self::Temperature => "K",
        }
    }

    /// As it is written, `variables` being the names of the actuated variables.
    pub fn written(self, variables: &[&str]) -> String {
        let name = |variable: usize| variables.get(variable).copied().unwrap_or("?");
        match self {
            Self::Angle(variable) => name(variable).into(),
            Self::OwnLoad(variable) => format!("own-load.{}", name(variable)),
            Self::Load(variable) => format!("load.{}", name(variable)),
            Self::LastMove(variable) => format!("move.{}", name(variable)),
            Self::Time => "time".into(),
            Self::SessionTime => "session-time".into(),
            Self::Temperature => "temperature".into(),
        }
    }

    /// The one that is written so; `None` of what is unknown.
    pub fn read(written: &str, variables: &[&str]) -> Option<Self> {
        Self::every(variables.len()).find(|driver| driver.written(variables) == written)
    }

    /// All that can be written.
    pub fn all(variables: &[&str]) -> Vec<String> {
        Self::every(variables.len()).map(|driver| driver.written(variables)).collect()
    }

    fn every(variables: usize) -> impl Iterator<Item = Self> {
        let of = |variable| [Self::Angle, Self::OwnLoad, Self::Load, Self::LastMove].map(|driver| driver(variable));
        (0..variables).flat_map(of).chain([Self::Time, Self::SessionTime, Self::Temperature])
    }
}
