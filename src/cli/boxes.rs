//! Boxes on the command line: where points stay, and where no link may be.

use crate::Error;
use crate::description::resolve::GREATEST;
use crate::description::robot::KeepOut;
use crate::files::LoadedRobot;
use crate::kinematics::{Geometry, Placements, always_entered};

/// From and to along x, y, z, in units of `length` (m); an end that is left out is open. Commas or colons separate them.
pub fn space(flag: &str, text: &str, length: f64) -> Result<[[f64; 2]; 3], Error> {
    let open = |k: usize| if k.is_multiple_of(2) { f64::NEG_INFINITY } else { f64::INFINITY };
    let end = |(k, end): (usize, &str)| match end.trim() {
        "" => Some(open(k)),
        end => end.parse::<f64>().ok().map(|v| v * length).filter(|v| v.abs() <= GREATEST),
    };
    let ends: Option<Vec<f64>> = text.split([',', ':']).enumerate().map(end).collect();
    let Some(ends) = ends.filter(|ends| ends.len() == 6 && ends.iter().any(|end| end.is_finite())) else {
        return Err(Error::input(
            format!("{flag} `{text}`"),
            "give from and to along x, y and z, as 800:1400,-500:500,0:700; an end left out is open",
        ));
    };
    if ends.chunks(2).any(|pair| matches!(pair, [low, high] if low >= high)) {
        return Err(Error::input(format!("{flag} `{text}`"), "give least before greatest: x, y, z"));
    }
    Ok(std::array::from_fn(|k| [ends[2 * k], ends[2 * k + 1]]))
}

/// Adds the boxes of `--keep-out` to those that the description declares.
///
/// # Errors
/// What is no box, or one through which a link passes that never moves.
pub fn keep_out(texts: &[String], loaded: &mut LoadedRobot) -> Result<(), Error> {
    let length = loaded.raw.units.length.factor();
    for text in texts {
        let space = space("--keep-out", text, length)?;
        loaded.model.keep_out.push(KeepOut { name: text.clone(), space });
    }
    let geometry = Geometry::nominal(&loaded.model)?;
    let mut placements = Placements::default();
    if loaded.model.keep_out.is_empty() || geometry.place(&loaded.model.middle(), &mut placements).is_err() {
        return Ok(());
    }
    match always_entered(&geometry, &placements) {
        Some(entered) => Err(Error::input(
            format!("{entered}, and does not move"),
            "make the box smaller, so that it leaves out what stands on the base",
        )),
        None => Ok(()),
    }
}
