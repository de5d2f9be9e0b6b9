//! Withheld effects: sealed campaigns whose causes are withheld from the diagnosis, and how often it finds them.
//!
//! The generator knows nothing of the catalogue's formulas. It moves joints, points and constants in shapes of its own,
//! exactly and not to first order, as machines do; the catalogue is to recognise the cause all the same.

mod calibrated;
mod causes;
mod design;
mod examine;
mod examined;
mod loads;
mod make;
mod odd;
mod plant;
mod projection;
mod reliability;
mod score;
mod shapes;
mod situation;
mod tied;
mod truth;
pub mod workshop;

pub use calibrated::calibrated;
pub use design::Design;
pub use examine::{Answer, Named, examine, without};
pub use examined::Examined;
pub use make::{Drawn, draw};
pub use odd::Odd;
pub use plant::Plant;
pub use reliability::{Bin, Rate, Rates, Reliability};
pub use score::{Class, Score, score};
pub use shapes::Shape;
pub use situation::Situation;
pub use tied::Signals;
pub use truth::{Instrument, Kind, Truth, TruthCause};

use sha2::{Digest, Sha256};

/// SHA-256 of a text, in hexadecimal digits.
///
/// ```
/// let seal = elastogeo::blind::seal("backlash at joint:2");
/// assert_eq!(seal.len(), 64); // SHA-256, in hexadecimal digits
/// ```
pub fn seal(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}
