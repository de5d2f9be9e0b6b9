//! Which causes are drawn: effects of the catalogue in shapes of their own, and what no catalogue knows.

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::plant::{joint_of, lengths_of};
use super::shapes::Shape;
use crate::model::Model;

/// Effect, site, shape.
type Named = Option<(&'static str, String, Shape)>;

/// An effect of the catalogue at a site, in a shape of its own.
pub fn known(model: &Model, deflection: bool, random: &mut ChaCha8Rng) -> Named {
    let count = model.variables.len();
    let variable = random.random_range(0..count);
    let joint = joint_of(model, variable);
    let at_joint = format!("joint:{}", model.frames[joint].name);
    let frame = random.random_range(1..model.frames.len());
    let at_link = format!("link:{}", model.frames[frame].name);
    let is_serial = model.actuators.is_empty();
    let mut within = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let slot = |name: String| model.registry.slot(&name);
    let constants = |names: Vec<(String, f64)>| -> Option<Shape> {
        let slots: Vec<_> = names.into_iter().filter_map(|(name, share)| Some((slot(name)?, share))).collect();
        (!slots.is_empty()).then_some(Shape::Constants(slots))
    };
    let name = &model.frames[frame].name;
    let turn = std::f64::consts::TAU;
    let of_load = |draw: usize, within: &mut dyn FnMut(f64, f64) -> f64| -> Named {
        Some(match draw {
            0 => ("joint-stiffening", at_joint.clone(), Shape::WindUp { variable, soft: within(0.06, 0.5) }),
            1 if is_serial => {
                ("bearing-compliance", at_joint.clone(), Shape::Tilt { frame: joint, unequal: within(-0.25, 0.25) })
            }
            1 => {
                let joint = &model.frames[joint].name;
                ("bearing-compliance", at_joint.clone(), constants(vec![(format!("joint{joint}.krr"), 1.0)])?)
            }
            2 => {
                let shares = [within(0.6, 1.4), within(0.6, 1.4)];
                ("base-compliance", "base".into(), Shape::Rocking { shares, more: within(-0.2, 0.3) })
            }
            3 => {
                let bending = [within(0.5, 1.5), within(0.5, 1.5), within(0.0, 1.0)];
                let names = ["bending_y", "bending_z", "torsion"].iter().zip(bending);
                let names = names.map(|(symbol, share)| (format!("link{name}.{symbol}"), share)).collect();
                ("link-compliance", at_link.clone(), constants(names)?)
            }
            _ => ("backlash", at_joint.clone(), Shape::Pressed { variable, soft: within(0.01, 0.03) }),
        })
    };
    if deflection {
        return match within(0.0, 9.0) as usize {
            draw @ 0..=4 => of_load(draw, &mut within),
            5 | 6 if is_serial => {
                let variable = usize::from(within(0.0, 3.0) > 1.0);
                let variable = variable + usize::from(variable == 1 && within(0.0, 3.0) > 2.0);
                let at = format!("joint:{}", model.frames[joint_of(model, variable)].name);
                let (a, b) = (within(0.3, 0.9), within(0.1, 0.3));
                let (angle, free) = (within(0.0, turn), within(0.5, 0.9) * (a - b));
                let compliance = slot(format!("joint{}.kar", model.frames[joint_of(model, variable)].name))
                    .map_or(1e-6, |slot| model.registry[slot].nominal.max(1e-8));
                Some((
                    "gravity-compensator",
                    at,
                    Shape::Spring { variable, compliance, a, b, angle, free, rate: 1e-3 / compliance },
                ))
            }
            5 | 6 => {
                let actuator = model.actuators.get(usize::from(within(0.0, 1.0) > 0.5))?;
                let shape = constants(vec![(format!("{}.axial", actuator.name), 1.0)])?;
                Some(("actuator-compliance", format!("actuator:{}", actuator.name), shape))
            }
            7 => Some(("payload", "tool".into(), Shape::Gain)),
            _ => Some(("instrument-scale", "instrument".into(), Shape::Scale)),
        };
    }
    match within(0.0, 16.0) as usize {
        draw @ 0..=3 => of_load(draw, &mut within),
        4 | 5 => {
            let orders = [1.0, 2.0, 2.0, 3.0, 4.0, 5.0, 7.0];
            let order = orders[(within(0.0, 7.0) as usize).min(6)];
            let second = [within(0.05, 0.3), within(0.0, turn)];
            Some(("transmission-error", at_joint, Shape::Swing { variable, order, phase: within(0.0, turn), second }))
        }
        6 | 7 => Some(("backlash", at_joint, Shape::Play { variable, by_load: within(-0.3, 0.3) })),
        8 => Some(("gear-ratio", at_joint, Shape::Ratio { variable, zero: within(-1.0, 1.0) })),
        9 => {
            let other = (variable + 1 + within(0.0, (count - 1) as f64) as usize) % count;
            (other != variable).then_some(("joint-coupling", at_joint, Shape::Follows { variable, other }))
        }
        10 => Some(("joint-compliance", at_joint, Shape::Gives { variable, less: within(0.0, 0.2) })),
        11 => {
            let names = [("mass", 1.0), ("x", within(-5e-3, 5e-3)), ("y", within(-5e-3, 5e-3))];
            let names = names.map(|(symbol, share)| (format!("body{name}.{symbol}"), share)).to_vec();
            (frame != model.tool.0).then_some(())?;
            Some(("link-weight", at_link, constants(names)?))
        }
        12 => {
            let tool = &model.frames[model.tool.0].name;
            let names = [("mass", 1.0), ("z", within(0.0, 3e-3))];
            let names = names.map(|(symbol, share)| (format!("body{tool}.{symbol}"), share)).to_vec();
            Some(("payload", "tool".into(), constants(names)?))
        }
        13 => {
            let lengths = lengths_of(model, frame);
            (!lengths.is_empty()).then_some(("thermal-expansion", at_link, Shape::Growth(lengths)))
        }
        14 => {
            let jump = within(0.0, 1.0) > 0.5;
            let mut normal = |size: f64| size * (within(0.0, 1.0) + within(0.0, 1.0) + within(0.0, 1.0) - 1.5);
            let mut knot = || [1.0, 1.0, 1.0, 0.4, 0.4, 0.4].map(&mut normal);
            let knots = if jump {
                vec![[0.0; 6], knot()]
            } else {
                // A walk that keeps on in the main, with turns.
                let (trend, mut at) = (knot(), [0.0; 6]);
                (0..5)
                    .map(|_| {
                        let step = knot();
                        let before = at;
                        (0..6).for_each(|k| at[k] += trend[k] + 0.5 * step[k]);
                        before
                    })
                    .collect()
            };
            Some(("frame-drift", "base".into(), Shape::Wanders { knots, jump }))
        }
        _ => Some(("instrument-scale", "instrument".into(), Shape::Scale)),
    }
}

/// Something that the catalogue does not know.
pub fn unknown(model: &Model, deflection: bool, random: &mut ChaCha8Rng) -> Named {
    let count = model.variables.len();
    let variable = random.random_range(0..count);
    let none = String::new;
    let draw = random.random_range(0..4);
    let mut within = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    match draw {
        0 => {
            let a = within(0.0, count as f64) as usize % count;
            let b = (a + 1 + within(0.0, count as f64 - 1.0) as usize) % count;
            Some(("product of two joints", none(), Shape::Product { variable, of: [a, b], yields: deflection }))
        }
        1 => Some(("hoses", none(), Shape::Hoses { variable, of: [0, 3.min(count - 1)], yields: deflection })),
        2 => {
            let waves = (0..12)
                .map(|_| {
                    let w = (0..count).map(|_| within(-1.5, 1.5)).collect();
                    let along = Vector3::new(within(-1.0, 1.0), within(-1.0, 1.0), within(-1.0, 1.0));
                    (w, within(0.0, 6.3), along)
                })
                .collect();
            Some(("smooth function", none(), Shape::Smooth { waves, by_force: deflection }))
        }
        _ => {
            let marker = within(0.0, model.markers.len() as f64) as usize % model.markers.len();
            let by = Vector3::new(within(-1.0, 1.0), within(-1.0, 1.0), within(-1.0, 1.0));
            Some(("slipped marker", none(), Shape::Slip { marker, at: within(0.25, 0.75), by }))
        }
    }
}
