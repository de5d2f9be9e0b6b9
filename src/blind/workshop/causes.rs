//! Which of them are drawn, and what else the catalogue knows.

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::blind::causes::{Drawing, at_marker, known};
use crate::blind::odd::Odd;
use crate::blind::shapes::Shape;
use crate::model::Model;

/// Share of the known causes of positions that go with the last move.
const OF_MOVES: f64 = 0.12;
/// Waves of a function, of the instrument's wander, and the cycles of the fastest.
const WAVES: usize = 12;
const WANDER: usize = 14;

/// An effect of the catalogue at a site: those of the laboratory, and joints that stop short.
pub fn of_catalogue(model: &Model, is_deflection: bool, random: &mut ChaCha8Rng) -> Drawing {
    if !is_deflection && random.random::<f64>() < OF_MOVES {
        let variable = random.random_range(0..model.variables.len());
        let less = 0.15 * random.random::<f64>();
        let site = format!("joint:{}", model.frames[model.joint_of(variable)?].name);
        return Some(("settling", site, Shape::Odd(Odd::StopsShort { variable, less })));
    }
    known(model, is_deflection, random)
}

/// Something that the catalogue does not know, at a site where that has a name.
pub fn off_catalogue(model: &Model, is_deflection: bool, random: &mut ChaCha8Rng) -> Drawing {
    let count = model.variables.len();
    let variable = random.random_range(0..count);
    let mut within = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let mut along = || Vector3::new(within(-1.0, 1.0), within(-1.0, 1.0), within(-1.0, 1.0));
    let direction = along();
    let waves: Vec<Vector3<f64>> = (0..WANDER).map(|_| along()).collect();
    let other = (variable + 1 + within(0.0, (count - 1) as f64) as usize) % count;
    let by_load = is_deflection;
    let turn = std::f64::consts::TAU;
    let joint = format!("joint:{}", model.frames[model.joint_of(variable)?].name);
    let kinds = if is_deflection { 6 } else { 12 };
    let (name, site, shape) = match within(0.0, f64::from(kinds)) as usize {
        0 => ("product of two joints", joint, Shape::Product { variable, of: [variable, other], by_load }),
        1 => ("hoses", joint, Shape::Hoses { variable, of: [other, variable], by_load }),
        2 => {
            let mut wave =
                |along: &Vector3<f64>| ((0..count).map(|_| within(-1.2, 1.2)).collect(), within(0.0, turn), *along);
            let waves = waves.iter().take(WAVES).map(&mut wave).collect();
            ("smooth function", String::new(), Shape::Smooth { waves, by_force: by_load })
        }
        3 => {
            let marker = within(0.0, model.markers.len().max(1) as f64) as usize;
            ("marker-slip", at_marker(model, marker), Shape::Slip { marker, at: within(0.2, 0.8), by: direction })
        }
        4 => ("dead zone", joint, Shape::Odd(Odd::DeadZone { variable, half: within(0.2, 0.6) })),
        5 => ("stop", joint, Shape::Odd(Odd::Stop { variable, at: within(0.15, 0.6) })),
        6 => {
            let first = within(2.2, 6.0);
            let orders = [first, first + within(0.3, 1.1)];
            let phases = [within(0.0, turn), within(0.0, turn)];
            ("beat of two orders", joint, Shape::Odd(Odd::Beat { variable, orders, phases }))
        }
        7 => {
            let (at, width) = (within(-1.0, 1.0), within(0.1, 0.3));
            ("damaged tooth", joint, Shape::Odd(Odd::Tooth { variable, at, width }))
        }
        8 => {
            let scale = within(0.05, 0.6);
            ("friction by another joint", joint, Shape::Odd(Odd::Friction { variable, other, scale }))
        }
        9 => ("settling foot", "base".into(), Shape::Odd(Odd::Foot { along: direction })),
        10 => {
            let wave = |(k, along): (usize, &Vector3<f64>)| {
                let cycles = (k + 1) as f64;
                (cycles, within(0.0, turn), along / cycles.sqrt())
            };
            let waves = waves.iter().enumerate().map(wave).collect();
            ("wandering instrument", "instrument".into(), Shape::Odd(Odd::Wander { waves }))
        }
        _ => ("circle off its centre", "instrument".into(), Shape::Odd(Odd::Circle { phase: within(0.0, turn) })),
    };
    Some((name, site, shape))
}
