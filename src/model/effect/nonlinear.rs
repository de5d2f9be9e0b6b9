//! Nonlinear parameters of effects: what an effect is not linear in, as named and typed values.
//!
//! A prediction is linear in the amounts of an effect, so that they are found by linear least squares. An order, a load, a
//! time or an alternative is not: the effect declares it as a [`NonlinearParameter`], offers several values to the
//! diagnosis, and an entry of a description states one. Numbers are SI unless the declaration says otherwise.

use std::sync::Arc;

use super::driver::Driver;
use crate::description::raw::RawAmount;

/// Declaration of a nonlinear parameter.
#[derive(Debug, PartialEq)]
pub struct NonlinearParameter {
    /// Key in a description.
    pub name: &'static str,
    /// What its value is.
    pub kind: NonlinearKind,
    /// Value where an entry states none; without one it must be stated.
    pub default: Option<NonlinearValue>,
    /// A choice that another parameter must have for this one to exist: its name and value.
    pub only_with: Option<(&'static str, &'static str)>,
    /// One line of documentation.
    pub meaning: &'static str,
}

/// What a nonlinear parameter can be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NonlinearKind {
    /// One of several words.
    Choice(&'static [&'static str]),
    /// A number.
    Real {
        /// Its unit.
        unit: &'static str,
        /// Whether values between those offered make sense, so that the diagnosis refines it.
        is_continuous: bool,
        /// Whether it must be above 0.
        is_positive: bool,
    },
    /// A whole number from 1 to this one.
    Count(usize),
    /// A coordinate, by its name; or by its place among them, counted from 0.
    Variable,
    /// What a curve follows ([`Driver`]).
    Driver,
    /// Increasing values of what a curve follows, two or more.
    Knots,
}

/// Value of a nonlinear parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum NonlinearValue {
    /// The word chosen.
    Choice(&'static str),
    /// A number.
    Real(f64),
    /// A whole number.
    Count(usize),
    /// A coordinate, by its index.
    Variable(usize),
    /// What a curve follows.
    Driver(Driver),
    /// Where a curve has its amounts, SI.
    Knots(Arc<[f64]>),
}

impl NonlinearParameter {
    /// The value that an entry states, `names` being those of the coordinates ([`crate::model::Model::coordinates`]).
    ///
    /// # Errors
    /// What is accepted instead.
    pub(in crate::model) fn read(&self, given: &RawAmount, names: &[String]) -> Result<NonlinearValue, String> {
        let value = match (self.kind, given) {
            (NonlinearKind::Choice(words), RawAmount::Name(name)) => {
                words.iter().find(|word| *word == name).map(|word| NonlinearValue::Choice(word))
            }
            (NonlinearKind::Real { is_positive, .. }, RawAmount::Number(value)) => {
                (!is_positive || *value > 0.0).then_some(NonlinearValue::Real(*value))
            }
            (NonlinearKind::Count(most), RawAmount::Number(value)) => {
                (1..=most).find(|count| *count as f64 == *value).map(NonlinearValue::Count)
            }
            (NonlinearKind::Variable, RawAmount::Number(value)) => {
                (0..names.len()).find(|index| *index as f64 == *value).map(NonlinearValue::Variable)
            }
            (NonlinearKind::Variable, RawAmount::Name(name)) => {
                names.iter().position(|known| known == name).map(NonlinearValue::Variable)
            }
            (NonlinearKind::Driver, RawAmount::Name(name)) => Driver::read(name, names).map(NonlinearValue::Driver),
            (NonlinearKind::Knots, RawAmount::Numbers(at)) => {
                let increases = at.len() > 1 && at.windows(2).all(|pair| pair[0] < pair[1]);
                increases.then(|| NonlinearValue::Knots(at.as_slice().into()))
            }
            _ => None,
        };
        value.ok_or_else(|| match self.kind {
            NonlinearKind::Choice(words) => format!("write one of: {}", words.join(", ")),
            NonlinearKind::Real { unit, is_positive: true, .. } => format!("write a number above 0 ({unit})"),
            NonlinearKind::Real { unit, .. } => format!("write a number ({unit})"),
            NonlinearKind::Count(most) => format!("write a whole number from 1 to {most}"),
            NonlinearKind::Variable => format!("write one of the variables: {}", names.join(", ")),
            NonlinearKind::Driver => format!("write one of: {}", Driver::all(names).join(", ")),
            NonlinearKind::Knots => "write two or more increasing numbers, SI".into(),
        })
    }
}

/// Values of the nonlinear parameters of an effect, in the order of their declarations; empty for an effect without.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Nonlinear(Vec<(&'static NonlinearParameter, NonlinearValue)>);

impl Nonlinear {
    /// These values.
    pub fn new(values: impl IntoIterator<Item = (&'static NonlinearParameter, NonlinearValue)>) -> Self {
        Self(values.into_iter().collect())
    }

    /// The values alone, in order.
    pub fn values(&self) -> Vec<NonlinearValue> {
        self.0.iter().map(|(_, value)| value.clone()).collect()
    }

    /// The number of the parameter that can be refined, if there is one.
    pub fn continuous(&self) -> Option<f64> {
        self.0.iter().find_map(|(parameter, value)| match (parameter.kind, value) {
            (NonlinearKind::Real { is_continuous: true, .. }, NonlinearValue::Real(value)) => Some(*value),
            _ => None,
        })
    }

    /// The number that is taken as it is, the moment of what happens once, if there is one.
    pub fn time_of_change(&self) -> Option<f64> {
        self.0.iter().find_map(|(parameter, value)| match (parameter.kind, value) {
            (NonlinearKind::Real { is_continuous: false, .. }, NonlinearValue::Real(value)) => Some(*value),
            _ => None,
        })
    }

    /// The same with another value of the parameter that can be refined.
    #[must_use]
    pub fn with_continuous(mut self, value: f64) -> Self {
        for (parameter, known) in &mut self.0 {
            if matches!(parameter.kind, NonlinearKind::Real { is_continuous: true, .. }) {
                *known = NonlinearValue::Real(value);
            }
        }
        self
    }

    /// Names, units and values as they are written, `names` being those of the coordinates.
    pub fn written(&self, names: &[impl AsRef<str>]) -> Vec<(&'static str, &'static str, RawAmount)> {
        let one = |(parameter, value): &(&'static NonlinearParameter, NonlinearValue)| {
            let unit = match parameter.kind {
                NonlinearKind::Real { unit, .. } => unit,
                _ => "",
            };
            let value = match *value {
                NonlinearValue::Driver(driver) => RawAmount::Name(driver.written(names)),
                NonlinearValue::Knots(ref at) => RawAmount::Numbers(at.to_vec()),
                NonlinearValue::Choice(word) => RawAmount::Name(word.into()),
                NonlinearValue::Real(value) => RawAmount::Number(value),
                NonlinearValue::Count(count) => RawAmount::Number(count as f64),
                NonlinearValue::Variable(index) => match names.get(index) {
                    Some(name) => RawAmount::Name(name.as_ref().into()),
                    None => RawAmount::Number(index as f64),
                },
            };
            (parameter.name, unit, value)
        };
        self.0.iter().map(one).collect()
    }
}
