//! The types of the trait [`super::Effect`]: sites, reading context and changes, nonlinear parameters; and how an entry
//! of a description is resolved, validated and switched on.

mod calibrated;
mod driver;
mod family;
mod nonlinear;
mod reading_context;
mod site;
mod switch_on;
mod tags;

pub use calibrated::{all_springs, nuisance, usually_calibrated};
pub use driver::Driver;
pub use family::Family;
pub use nonlinear::{Nonlinear, NonlinearKind, NonlinearParameter, NonlinearValue};
pub use reading_context::{CarriedLoad, Change, Changes, Condition, ReadingContext, Survey};
pub use site::{Site, SiteKind};
