//! Configurations that are drawn, or read from a file.

use rand_chacha::ChaCha8Rng;

use crate::Error;
use crate::cli::args::Simulate;
use crate::cli::commands::pose::loaded_configurations;
use crate::cli::session::Session;
use crate::cli::values::ranges;
use crate::diagnostic::Diagnostic;
use crate::files::LoadedRobot;
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;
use crate::simulation::{draw_configurations_in, joint_box};

/// Configurations, with loads of the rows where they come from a file that has loads, and warnings.
pub type Configurations = (Vec<Vec<f64>>, Vec<[f64; 6]>, Vec<Diagnostic>);

/// As `--poses` asks.
///
/// # Errors
/// Too many or none, or a file that cannot be read.
pub fn configurations(
    command: &Simulate,
    session: &Session,
    loaded: &LoadedRobot,
    geometry: &Geometry,
    random: &mut ChaCha8Rng,
) -> Result<Configurations, Error> {
    match command.poses.parse::<usize>() {
        Ok(0) => Err(Error::input("--poses 0", "give at least one configuration")),
        Ok(count) if count > 100_000 => Err(Error::input(format!("--poses {count}"), "at most 100000 configurations")),
        Ok(count) => {
            let (within, warnings) =
                ranges("--range", loaded, joint_box(&loaded.model, command.share), &command.range)?;
            let drawn = draw_configurations_in(geometry, &within, count, random)?;
            if drawn.is_empty() {
                return Err(Error::input(
                    "no configuration in these ranges keeps the limits of joints, of sums of joints and of boxes kept out of",
                    "widen --range, or look at `limits` and `keep_out` of the description",
                ));
            }
            Ok((drawn, Vec::new(), warnings))
        }
        Err(_) if !command.range.is_empty() => {
            Err(Error::input("--range and a file of configurations", "leave --range out, or give --poses a number"))
        }
        Err(_) => {
            let (rows, warnings) = loaded_configurations(session, loaded, std::path::Path::new(&command.poses))?;
            let (configurations, loads): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
            placed_as_described(command, &loaded.model, &configurations)?;
            let is_loaded = loads.iter().any(|load| *load != [0.0; 6]);
            Ok((configurations, if is_loaded { loads } else { Vec::new() }, warnings))
        }
    }
}

/// Refuses configurations in which the described robot cannot stand: one with errors may pass to another assembly there.
fn placed_as_described(command: &Simulate, model: &Model, configurations: &[Vec<f64>]) -> Result<(), Error> {
    let geometry = Geometry::nominal(model)?;
    let mut placements = Placements::default();
    for (row, q) in configurations.iter().enumerate() {
        if let Err(error) = geometry.place(q, &mut placements) {
            let message = format!("`{}`, configuration {}: {error}", command.poses, row + 1);
            return Err(Error::input(message, "leave the row out: the robot as described cannot stand there"));
        }
    }
    Ok(())
}
