//! Equilibrium at the deflected pose, against closed forms and against the linear deflection.

use elastogeo::elastics::{Elastics, Equilibrium, Mechanism, PointLoad, equilibrium};
use elastogeo::model::Model;
use nalgebra::{Point3, Vector3};

use crate::loaded::{deflection, placed};
use crate::support::{bundled, model_of};

fn found(
    model: &Model,
    q: &[f64],
    (frame, local): (&str, [f64; 3]),
    load: [f64; 6],
    weight: bool,
) -> Result<Equilibrium, Mechanism> {
    let values = model.registry.nominal();
    let elastics = Elastics::new(model, &values, &[]);
    let at = placed(model, &values, q);
    let frame = model.frame(frame).expect("a frame");
    let local = Vector3::from(local);
    let point = (at.frames[frame] * Point3::from(local)).coords;
    let vertex = model.structure.carrier(frame, &local);
    let (force, moment) = (Vector3::from_column_slice(&load[..3]), Vector3::from_column_slice(&load[3..]));
    equilibrium(&elastics, &at, &PointLoad::at(vertex, point, force, moment), weight)
}

/// EI = 1e4 in both planes, 2 m long, all but unstretchable.
fn cantilever(elements: usize) -> Model {
    model_of(&format!(
        "units: {{length: m, angle: rad}}
frames: {{1: {{antecedent: 0, joint: revolute, variable: q1, limits: [-3, 3]}}, tip: {{antecedent: 1, d: 2}}}}
tool: {{frame: tip}}
materials: {{steel: {{young: 2e11, shear: 8e10}}}}
sections: {{s: {{area: 1, iy: 5e-8, iz: 5e-8, j: 8e-8}}}}
nodes: {{root: {{body: 1}}, end: {{body: 1, at: tip}}}}
beams: {{b: {{from: root, to: end, section: s, material: steel, elements: {elements}}}}}
joint_stiffness: {{1: {{at: root}}}}
"
    ))
}

/// Tip of the elastica under a dead load across it, P L^2 / (E I) = `a`: sinking, shortening, slope. The slope phi
/// satisfies phi'' = -a cos phi, phi(0) = 0, phi'(1) = 0; by Runge-Kutta from the tip, the slope found by bisection.
fn elastica(a: f64) -> [f64; 3] {
    let run = |tip: f64| -> [f64; 3] {
        let rate = |y: [f64; 4]| [y[1], -a * y[0].cos(), y[0].sin(), 1.0 - y[0].cos()];
        let n = 4000;
        let h = -1.0 / f64::from(n);
        let mut y = [tip, 0.0, 0.0, 0.0];
        for _ in 0..n {
            let add = |y: [f64; 4], k: [f64; 4], f: f64| std::array::from_fn(|i| y[i] + f * k[i]);
            let k1 = rate(y);
            let k2 = rate(add(y, k1, 0.5 * h));
            let k3 = rate(add(y, k2, 0.5 * h));
            let k4 = rate(add(y, k3, h));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        [y[0], -y[2], -y[3]]
    };
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if run(middle)[0] > 0.0 { high = middle } else { low = middle }
    }
    let [_, sinks, shortens] = run(low);
    [sinks, shortens, low]
}

#[test]
fn a_cantilever_under_a_great_load_is_an_elastica() {
    // Tabulated by Mattiasson (1981).
    for (a, tabulated) in [(1.0, [0.30172, 0.05643, 0.46135]), (5.0, [0.71379, 0.38763, 1.21537])] {
        let expected = elastica(a);
        for k in 0..3 {
            assert!((expected[k] - tabulated[k]).abs() < 6e-6, "{a} {expected:?}");
        }
        let (l, p) = (2.0, a * 1e4 / 4.0);
        let errors = [20, 40].map(|n| {
            let found = found(&cantilever(n), &[0.0], ("tip", [0.0; 3]), [0.0, 0.0, -p, 0.0, 0.0, 0.0], false);
            let found = found.unwrap_or_else(|error| panic!("{a} {n}: {error}"));
            let all = [-found.displacement.z / l, -found.displacement.x / l, found.rotation.y];
            std::array::from_fn::<f64, 3, _>(|k| all[k] - expected[k])
        });
        for k in 0..3 {
            // Elements are linear in axes of their first node: the error falls with the square of their length.
            assert!(errors[1][k].abs() < 1e-3 * expected[k], "{a} {k} {errors:?}");
            assert!((errors[0][k] / errors[1][k] - 4.0).abs() < 0.4, "{a} {k} {errors:?}");
        }
    }
}

fn pendulum(stiffness: f64) -> Model {
    model_of(&format!(
        "units: {{length: m, angle: rad}}
frames: {{1: {{antecedent: 0, joint: revolute, variable: q1, alpha: 1.5707963267948966, limits: [-3, 3]}}, E: {{antecedent: 1, d: 0.8}}}}
tool: {{frame: E}}
gravity: [0, 0, -9.81]
bodies: {{1: {{mass: 40, com: [0.8, 0, 0]}}}}
joint_stiffness: {{1: {{kar: {{value: {stiffness}}}}}}}
"
    ))
}

#[test]
fn a_pendulum_on_a_torsional_spring() {
    let (m, g, l) = (40.0, 9.81, 0.8);
    for k in [2000.0, 500.0, 330.0] {
        for start in [0.0_f64, 0.7, -0.5] {
            // k theta = m g l cos(start - theta), downwards.
            let mut theta = 0.0_f64;
            for _ in 0..100 {
                let residual = k * theta - m * g * l * (start - theta).cos();
                theta -= residual / (k - m * g * l * (start - theta).sin());
            }
            let found = found(&pendulum(k), &[start], ("E", [0.0; 3]), [0.0; 6], true);
            let found = found.unwrap_or_else(|error| panic!("{k} {start}: {error}"));
            assert!(
                (found.rotation.norm() - theta.abs()).abs() < 1e-10,
                "{k} {start} {} {theta}",
                found.rotation.norm()
            );
            let end = start - theta;
            let expected = Vector3::new(end.cos() - start.cos(), 0.0, end.sin() - start.sin()) * l;
            assert!((found.displacement - expected).norm() < 1e-10, "{} {expected}", found.displacement);
        }
    }
}

#[test]
fn near_buckling_it_is_reported() {
    // Upright on a spring that holds less than m g l, k theta = m g l sin theta is not stable near 0.
    let upright = std::f64::consts::FRAC_PI_2;
    let push = [5.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let held = found(&pendulum(400.0), &[upright], ("E", [0.0; 3]), push, true).expect("k > m g l");
    assert!(held.displacement.x > 0.0);
    // Fallen over to where the spring holds it.
    let fallen = found(&pendulum(300.0), &[upright], ("E", [0.0; 3]), push, true).expect("an equilibrium");
    let theta = fallen.rotation.norm();
    let turning = 40.0 * 9.81 * 0.8 * theta.sin() + 5.0 * 0.8 * theta.cos();
    assert!(theta > 0.3 && (300.0 * theta - turning).abs() < 1e-8, "{theta} {turning}");
    // A column pressed beyond Euler's load pi^2 E I / (4 L^2), and just below.
    let euler = std::f64::consts::PI.powi(2) * 1e4 / 16.0;
    let pressed = |share: f64| {
        found(&cantilever(40), &[0.0], ("tip", [0.0; 3]), [-share * euler, 0.0, 1.0, 0.0, 0.0, 0.0], false)
    };
    let linear = 8.0 / 3e4;
    let half = pressed(0.5).expect("half the load is held").displacement.z;
    // Amplified by tan(u) - u against u^3 / 3, u = pi / 2 sqrt(share).
    let u = std::f64::consts::FRAC_PI_2 * 0.5_f64.sqrt();
    let expected = linear * 3.0 * (u.tan() - u) / u.powi(3);
    assert!((half / expected - 1.0).abs() < 0.02, "{half} {expected}");
    // Beyond it, bent sideways: the elastica of 1.5 Euler loads (Timoshenko and Gere 1961, table 2-4, interpolated).
    let bent = pressed(1.5).expect("a bent column holds").displacement / 2.0;
    assert!((bent.x + 0.64).abs() < 0.01 && (bent.z - 0.79).abs() < 0.01, "{bent}");
    // Far beyond, no iterations lead there.
    match pressed(100.0) {
        Err(other) => assert!(other.to_string().contains("buckling"), "{other}"),
        Ok(found) => panic!("a column under 100 Euler loads at {}", found.displacement),
    }
}

/// Euler's column, clamped below and free above: P = pi^2 E I / (4 L^2).
#[test]
fn a_straight_column_buckles_at_eulers_load() {
    let euler = std::f64::consts::PI.powi(2) * 1e4 / 16.0;
    let pressed = |elements: usize, share: f64| {
        found(&cantilever(elements), &[0.0], ("tip", [0.0; 3]), [-share * euler, 0.0, 0.0, 0.0, 0.0, 0.0], false)
    };
    let off = [10, 20].map(|elements| {
        let held = pressed(elements, 0.5).expect("half of it is held");
        assert!(held.displacement.z.abs() < 1e-12 && held.displacement.y.abs() < 1e-12, "{}", held.displacement);
        held.load_factor / 2.0 - 1.0
    });
    assert!(off[1].abs() < 2e-3, "{off:?}");
    assert!((off[0] / off[1] - 4.0).abs() < 0.2, "the error falls with the square of the elements' length: {off:?}");
    assert!(pressed(20, 0.99).is_ok());
    for (share, factor) in [(1.01, "0.99"), (1.5, "0.66"), (4.0, "0.25")] {
        match pressed(20, share) {
            Err(other) => {
                let said = other.to_string();
                assert!(
                    said.contains("not stable") && said.contains(&format!("buckling begins at {factor}")),
                    "{said}"
                );
            }
            Ok(found) => panic!("straight under {share} Euler loads: {}", found.displacement),
        }
    }
    // Pulled it only stiffens.
    let pulled = found(&cantilever(20), &[0.0], ("tip", [0.0; 3]), [2.0 * euler, 0.0, 0.0, 0.0, 0.0, 0.0], false);
    assert!(pulled.expect("pulled").load_factor > 100.0);
}

/// A bar upright on a torsional spring falls when k < m g l.
#[test]
fn an_upright_pendulum_falls_when_its_spring_is_too_soft() {
    let upright = std::f64::consts::FRAC_PI_2;
    let weight = 40.0 * 9.81 * 0.8;
    for share in [0.5, 0.9, 0.999] {
        let held = found(&pendulum(weight / share), &[upright], ("E", [0.0; 3]), [0.0; 6], true).expect("held");
        assert!((held.load_factor * share - 1.0).abs() < 1e-6, "{share} {}", held.load_factor);
    }
    match found(&pendulum(weight / 1.25), &[upright], ("E", [0.0; 3]), [0.0; 6], true) {
        Err(other) => assert!(other.to_string().contains("buckling begins at 0.800 of this load"), "{other}"),
        Ok(_) => panic!("it stands"),
    }
    // Hanging it is held by its weight.
    let hanging = found(&pendulum(10.0), &[-upright], ("E", [0.0; 3]), [0.0; 6], true).expect("hangs");
    assert!(hanging.load_factor.is_infinite(), "{}", hanging.load_factor);
}

#[test]
fn small_loads_agree_with_the_linear_deflection() {
    let model = bundled("kuka-ir663");
    let q = [0.3, 0.8276, 0.7852, 0.2, 0.9, -0.4];
    let load = [300.0, -200.0, -500.0, 40.0, -70.0, 90.0];
    let off = |share: f64, weight: bool| {
        let load = load.map(|w| w * share);
        let found = found(&model, &q, ("E", [0.0; 3]), load, weight).expect("settles");
        let linear = deflection(&model, &model.registry.nominal(), &q, ("E", [0.0; 3]), &load, weight);
        let size = linear.fixed_rows::<3>(0).norm();
        ((found.displacement - linear.fixed_rows::<3>(0)).norm(), size)
    };
    let (full, size) = off(1.0, false);
    let (tenth, _) = off(0.1, false);
    assert!(full > 0.0 && full < 1e-2 * size, "{full} of {size}");
    assert!((full / tenth - 100.0).abs() < 5.0, "second order: {full:e} {tenth:e}");
    let (full, size) = off(1.0, true);
    assert!(full < 1e-2 * size, "{full} of {size}");
}

#[test]
fn rigid_turns_of_the_base_turn_the_equilibrium() {
    // The same arm on its side: with own weight turned along, the answer turns along.
    let model = bundled("kuka-ir663");
    let at = |q1: f64| {
        let q = [q1, 0.8276, 0.7852, 0.2, 0.9, -0.4];
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), q1);
        let load = turn * Vector3::new(900.0, 500.0, -2000.0);
        let load = [load.x, load.y, load.z, 0.0, 0.0, 0.0];
        turn.inverse() * found(&model, &q, ("E", [0.0; 3]), load, true).expect("settles").displacement
    };
    let (a, b) = (at(0.0), at(1.1));
    assert!((a - b).norm() < 1e-11, "{a} {b}");
}

/// An upright bar on a joint that gives in all six directions, pulled by a spring to the ground. What it stores is quadratic in
/// slide and rotation vector of the joint, and in the length of the spring.
struct Sprung {
    acts: &'static str,
    /// Slide along and turn about x, y, z of the joint: N/m, N.m/rad.
    stiff: [f64; 6],
}

const SPRUNG: Sprung = Sprung { acts: "full", stiff: [4e5, 6e5, 5e5, 900.0, 2500.0, 1500.0] };
const RATE: f64 = 3000.0;
const FREE: f64 = 0.5;
const ANCHORS: [[f64; 3]; 2] = [[-0.4, 0.2, 0.1], [0.5, 0.1, -0.1]];

impl Sprung {
    fn model(&self) -> Model {
        let Self { acts, stiff: [kx, ky, kz, kax, kay, kaz] } = self;
        let [a, b] = ANCHORS;
        model_of(&format!(
            "units: {{length: m, angle: rad}}
frames: {{1: {{antecedent: 0, joint: revolute, variable: q1, limits: [-3, 3]}}, E: {{antecedent: 1, d: 0.8, r: 0.1}}}}
tool: {{frame: E}}
gravity: [0, 0, -9.81]
bodies: {{1: {{mass: 5, com: [0.4, 0, 0.1]}}}}
joint_stiffness: {{1: {{krx: {{value: {kx}}}, kry: {{value: {ky}}}, ka: {{value: {kz}}}, krrx: {{value: {kax}}}, krry: {{value: {kay}}}, kar: {{value: {kaz}}}}}}}
springs: {{s: {{bodies: [0, 1], anchors: [{a:?}, {b:?}], rate: {{value: {RATE}}}, free_length: {FREE}, acts: {acts}}}}}
"
        ))
    }

    /// Energy at a slide and rotation vector of the body, under a dead force at the tool, with own weight and tension or
    /// without either.
    fn energy(&self, x: &[f64; 6], force: &Vector3<f64>, weight: bool) -> f64 {
        let slide = Vector3::new(x[0], x[1], x[2]);
        let phi = Vector3::new(x[3], x[4], x[5]);
        let turn = nalgebra::Rotation3::new(phi);
        let at = |p: [f64; 3]| slide + turn * Vector3::from(p);
        let length = |at: Vector3<f64>| (at - Vector3::from(ANCHORS[0])).norm();
        let spring = |s: f64| 0.5 * RATE * (s - FREE).powi(2);
        let mut energy: f64 = (0..6).map(|k| 0.5 * self.stiff[k] * x[k].powi(2)).sum();
        energy += spring(length(at(ANCHORS[1])));
        energy -= force.dot(&(at([0.8, 0.0, 0.1]) - Vector3::new(0.8, 0.0, 0.1)));
        if weight {
            return energy + 5.0 * 9.81 * at([0.4, 0.0, 0.1]).z;
        }
        // Its tension at rest is balanced by a load that is dead in slide and rotation vector.
        let b = Vector3::from(ANCHORS[1]);
        let along = (b - Vector3::from(ANCHORS[0])) / length(b);
        let tension = RATE * (length(b) - FREE);
        energy - tension * (along.dot(&slide) + b.cross(&along).dot(&phi))
    }

    /// Slide and rotation vector of least energy, by Newton's method on central differences.
    fn least(&self, force: &Vector3<f64>, weight: bool) -> [f64; 6] {
        let steps = [1e-5, 1e-5, 1e-5, 1e-4, 1e-4, 1e-4];
        let mut x = [0.0; 6];
        for _ in 0..30 {
            let at = |moves: &[(usize, f64)]| {
                let mut moved = x;
                moves.iter().for_each(|&(k, by)| moved[k] += by);
                self.energy(&moved, force, weight)
            };
            // Fourth order, so that rounding and not the difference is what is left.
            let slope = |k: usize| {
                let h = steps[k];
                (8.0 * (at(&[(k, h)]) - at(&[(k, -h)])) - at(&[(k, 2.0 * h)]) + at(&[(k, -2.0 * h)])) / (12.0 * h)
            };
            let bend = |j: usize, k: usize| {
                let (h, g) = (steps[j], steps[k]);
                let all = [(h, g), (-h, -g), (h, -g), (-h, g)].map(|(a, b)| at(&[(j, a), (k, b)]));
                (all[0] + all[1] - all[2] - all[3]) / (4.0 * h * g)
            };
            let gradient = nalgebra::Vector6::from_fn(|k, _| slope(k));
            let hessian = nalgebra::Matrix6::from_fn(bend);
            let step = hessian.lu().solve(&gradient).expect("regular");
            (0..6).for_each(|k| x[k] -= step[k]);
        }
        x
    }
}

#[test]
fn a_joint_and_a_spring_between_bodies_store_what_they_should() {
    for (acts, weight, load) in [
        ("full", true, [0.0, 0.0, 0.0]),
        ("full", true, [60.0, 150.0, -90.0]),
        ("full", false, [60.0, 150.0, -90.0]),
        ("stiffness", false, [60.0, 150.0, -90.0]),
        ("full", false, [6.0, 15.0, -9.0]),
    ] {
        let arm = Sprung { acts, ..SPRUNG };
        let expected = arm.least(&load.into(), weight);
        let [x, y, z] = load;
        let found = found(&arm.model(), &[0.0], ("E", [0.0; 3]), [x, y, z, 0.0, 0.0, 0.0], weight);
        let found = found.unwrap_or_else(|error| panic!("{acts} {weight}: {error}"));
        let phi = Vector3::new(expected[3], expected[4], expected[5]);
        let at = Vector3::new(0.8, 0.0, 0.1);
        let displaced = Vector3::new(expected[0], expected[1], expected[2]) + nalgebra::Rotation3::new(phi) * at - at;
        if load[1] > 100.0 {
            assert!(phi.norm() > 0.04, "{phi}");
        }
        let off =
            ((found.rotation - phi).norm() / phi.norm(), (found.displacement - displaced).norm() / displaced.norm());
        assert!(off.0 < 1e-6 && off.1 < 1e-6, "{acts} {weight} {load:?}: {off:?} of {}", phi.norm());
    }
}
