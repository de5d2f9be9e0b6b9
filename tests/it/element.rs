//! The family of elastic elements: a kind of this file alone deforms in the tree and closes a loop, is differentiated by its
//! parameter and by the joints, and is reported under its name.

use std::sync::Arc;

use elastogeo::elastics::{Elastics, shares, spatial};
use elastogeo::elements::{
    BodyPoint, Configuration, Direction, ElasticElement, Flexibility, MotionRate, ParameterUse, PerLength, Placed,
    Rate, VertexIndex, VertexMotion,
};
use elastogeo::kinematics::By;
use elastogeo::model::{Edge, Model};
use elastogeo::parameter::Slot;
use elastogeo::state::{ColumnMotion, Loads, Mechanics};
use nalgebra::Vector3;

use crate::loaded::respond;
use crate::support::model_of;

/// A rubber pad: softer by 1, 2 and 3 along x, y and z of its frame, each by the same compliance.
#[derive(Debug)]
struct Pad {
    at: BodyPoint,
    compliance: Slot,
    /// How it holds rotations.
    turns: Direction,
}

impl ElasticElement for Pad {
    fn directions(&self) -> [Direction; 6] {
        std::array::from_fn(|k| if k < 3 { Direction::Flexible } else { self.turns })
    }

    fn parameters(&self) -> Vec<ParameterUse> {
        (0..3).map(|part| ParameterUse { slot: self.compliance, part }).collect()
    }

    fn is_active(&self, values: &[f64]) -> bool {
        values[self.compliance] != 0.0
    }

    fn place(&self, at: &Configuration, ends: [VertexIndex; 2], _: &PerLength) -> Placed {
        let c = at.values[self.compliance];
        let rotation = at.turned(ends[0]) * at.frames[self.at.frame].rotation.matrix();
        let origin = at.carried(ends[0], &self.at.place(at.frames));
        Placed::new(&rotation, &origin, Flexibility::Diagonal([c, 2.0 * c, 3.0 * c, 0.0, 0.0, 0.0]))
    }

    fn by_parameter(&self, part: usize, _: &Configuration) -> Rate {
        Rate::Flexibility(Flexibility::Single(part, (part + 1) as f64))
    }

    fn by_motion(&self, at: &Configuration, _: [VertexIndex; 2], moves: &VertexMotion) -> MotionRate {
        let origin = self.at.place(at.frames);
        let (moved, turn) = moves.point(self.at.frame, &origin);
        MotionRate::of(&origin, moved, turn)
    }
}

const LENGTHS: [f64; 2] = [1.1, 0.7];

fn robot() -> Model {
    model_of(&format!(
        "units: {{length: m, angle: rad}}
frames:
  1: {{antecedent: 0, joint: revolute, variable: q1, limits: [-3, 3]}}
  2: {{antecedent: 1, joint: revolute, variable: q2, limits: [-3, 3], d: {}}}
  tip: {{antecedent: 2, d: {}}}
tool: {{frame: tip}}
joint_stiffness: {{1: {{ka: {{value: 4e5}}}}, 2: {{kar: {{value: 3e4}}}}}}
",
        LENGTHS[0], LENGTHS[1]
    ))
}

fn pad(model: &Model, frame: &str, turns: Direction) -> Arc<Pad> {
    let at = BodyPoint { frame: model.frame(frame).expect("a frame"), point: Vector3::zeros() };
    Arc::new(Pad { at, compliance: model.registry.slot("joint1.ka").expect("a slot"), turns })
}

/// With the first joint's springs replaced by a pad.
fn in_the_tree() -> Model {
    let mut model = robot();
    let pad = pad(&model, "1", Direction::Flexible);
    let edge = model.structure.tree.iter_mut().find(|edge| edge.name == "joint:1").expect("the joint");
    edge.element = pad;
    edge.name = "pad".into();
    model
}

/// With a pad between the ground and the tip.
fn in_a_loop() -> Model {
    let mut model = robot();
    let element = pad(&model, "tip", Direction::Released(None));
    let tip = model.structure.carrier(model.tool.0, &Vector3::zeros());
    model.structure.closures.push(Edge { name: "pad".into(), ends: [0, tip], element });
    model
}

const Q: [f64; 2] = [0.4, -0.9];
const FORCE: [f64; 3] = [120.0, -310.0, 70.0];

fn deflection(model: &Model, values: &[f64], q: &[f64]) -> Vector3<f64> {
    let mechanics = Mechanics::new(model, values, Loads { weight: false, wrench: true }, &[]).expect("assembled");
    let mut state = mechanics.state();
    mechanics.place(q, &mut state).expect("placed");
    let [x, y, z] = FORCE;
    let point = mechanics.point(&state, None, &[x, y, z, 0.0, 0.0, 0.0]);
    mechanics.deflection(&state, &point).displacement
}

/// Across the last link: unit vector, and position of the tip against the second joint.
fn last_link() -> (Vector3<f64>, Vector3<f64>) {
    let angle: f64 = Q.iter().sum();
    let (sine, cosine) = angle.sin_cos();
    (Vector3::new(-sine, cosine, 0.0), Vector3::new(cosine, sine, 0.0) * LENGTHS[1])
}

#[test]
fn in_the_tree_it_deforms_as_it_says() {
    let model = in_the_tree();
    let found = deflection(&model, &model.registry.nominal(), &Q);
    let (sine, cosine) = Q[0].sin_cos();
    let turn = nalgebra::Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
    let force = Vector3::from(FORCE);
    let by_pad = turn * nalgebra::Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0)) * turn.transpose() * force / 4e5;
    let (across, _) = last_link();
    let by_joint = across * (across.dot(&force) * LENGTHS[1].powi(2) / 3e4);
    assert!((found - by_pad - by_joint).norm() < 1e-12 * found.norm(), "{found}");
}

#[test]
fn in_a_loop_it_shares_the_load() {
    let model = in_a_loop();
    let (across, _) = last_link();
    let values = model.registry.nominal();
    let found = deflection(&model, &values, &Q);
    // Along the links the joint is rigid; across the last one the pad (2 of its compliance) is parallel to the joint.
    let stiffness = 3e4 / LENGTHS[1].powi(2) + 4e5 / 2.0;
    let expected = across.dot(&Vector3::from(FORCE)) / stiffness;
    assert!((across.dot(&found) / expected - 1.0).abs() < 1e-12, "{found}");
}

#[test]
fn derivatives_are_those_of_differences() {
    for model in [in_the_tree(), in_a_loop()] {
        let values = model.registry.nominal();
        let slot = model.registry.slot("joint1.ka").expect("a slot");
        let mechanics =
            Mechanics::new(&model, &values, Loads { weight: false, wrench: true }, &[slot]).expect("assembled");
        let mut state = mechanics.state();
        mechanics.place(&Q, &mut state).expect("placed");
        let [x, y, z] = FORCE;
        let point = mechanics.point(&state, None, &[x, y, z, 0.0, 0.0, 0.0]);
        let by_compliance = mechanics.deflection_by_parameters(&mut state, &point).next().expect("one").displacement;
        let step = 1e-4 * values[slot];
        let at = |sign: f64| {
            let mut values = values.clone();
            values[slot] += sign * step;
            deflection(&model, &values, &Q)
        };
        let difference = (at(1.0) - at(-1.0)) / (2.0 * step);
        assert!((by_compliance - difference).norm() < 1e-7 * difference.norm(), "{by_compliance} {difference}");
        let plan = mechanics.twist_plan((0..model.frames.len()).collect(), &[By::Variable(0), By::Variable(1)]);
        let mut twists = plan.twists();
        mechanics.evaluate_twists(&mut state, &plan, None, &mut twists);
        for variable in 0..2 {
            let column = twists.of(model.tool.0)[variable];
            let moved = Vector3::new(column[0], column[1], column[2]);
            let motion = ColumnMotion { twists: &twists, column: variable, by: None, driver: Some(variable) };
            let found = mechanics.deflection_by_motion(&mut state, &point, &moved, Some(motion)).displacement;
            let at = |step: f64| {
                let mut q = Q;
                q[variable] += step;
                deflection(&model, &values, &q)
            };
            let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
            let size = difference.norm().max(1e-3 * deflection(&model, &values, &Q).norm());
            assert!((found - difference).norm() < 1e-6 * size, "variable {variable}: {found} {difference}");
        }
    }
}

#[test]
fn reports_have_its_name() {
    for model in [in_the_tree(), in_a_loop()] {
        let values = model.registry.nominal();
        let tip = model.structure.carrier(model.tool.0, &Vector3::zeros());
        let (elastics, statics, response): (Elastics, _, _) =
            respond(&model, &values, &Q, tip, false).expect("no mechanism");
        let (sine, cosine) = Q[0].sin_cos();
        let at = Vector3::new(cosine, sine, 0.0) * LENGTHS[0] + last_link().1;
        let wrench = spatial(&at, &Vector3::from(FORCE), &Vector3::zeros());
        let found = shares(&elastics, &statics, &response, &wrench, false);
        assert!(found.energy["pad"] > 0.01, "{:?}", found.energy);
        assert!((found.energy.values().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}
