//! What the trait [`super::Effect`] speaks of: sites, reading context and changes, nonlinear parameters; and how an entry
//! of a description is resolved, validated and switched on.

mod nonlinear;
mod reading_context;
mod site;
mod switch_on;
mod tags;

pub use nonlinear::{Nonlinear, NonlinearKind, NonlinearParameter, NonlinearValue};
pub use reading_context::{Change, Changes, Condition, ReadingContext, Survey};
pub use site::{Site, SiteKind};
