//! What several tests need.

use std::path::Path;

use elastogeo::compensation::{Desired, Refusal};
use elastogeo::description::campaign::Campaign;
use elastogeo::description::{
    raw::{RawEffect, RawRobot},
    resolve::resolve,
};
use elastogeo::diagnosis::{self, Diagnosis, diagnose};
use elastogeo::effects::Catalogue;
use elastogeo::kinematics::{Geometry, Placements, Transform};
use elastogeo::model::{Model, build};
use elastogeo::observation::POSE;
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{Plan, generator, simulate};

use crate::cli::run;

pub fn model_of(yaml: &str) -> Model {
    let raw: RawRobot = serde_yaml::from_str(yaml).expect("readable");
    let (robot, diagnostics) = resolve(&raw, &|_| None);
    build(&robot.unwrap_or_else(|| panic!("{diagnostics:#?}")), Catalogue::standard()).expect("a model")
}

/// Switches an effect on as an entry of a description does.
pub fn switch_on(model: &mut Model, effect: &str, site: &str, parameters: &[(&str, f64)]) {
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_string(), (*value).into())).collect();
    let raw = RawEffect { effect: Some(effect.into()), site: Some(site.into()), parameters, ..RawEffect::default() };
    let entry = model.resolve_effect(&raw).expect("an effect of this robot");
    model.switch_on(entry);
}

/// The causes of a campaign, every reading fitted, without proposed configurations.
pub fn diagnosed(model: &Model, campaign: &Campaign) -> Diagnosis {
    let asked = diagnosis::Settings { propose: false, ..diagnosis::Settings::new(campaign, 1) };
    diagnose(model, campaign, &vec![false; campaign.readings.len()], &asked, &mut |_| {}).expect("diagnosed")
}

pub fn bundled(name: &str) -> Model {
    model_of(&std::fs::read_to_string(format!("{}/robots/{name}.yaml", env!("CARGO_MANIFEST_DIR"))).expect("a file"))
}

pub fn golden() -> serde_json::Value {
    json("golden/golden.json")
}

/// A file of `tests/data`.
pub fn json(name: &str) -> serde_json::Value {
    let path = format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).expect("a file")).expect("JSON")
}

/// What a command that must succeed prints with `--format json`.
pub fn printed_json(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    let ran = run(folder, &[arguments, &["--format", "json"]].concat());
    assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.err);
    serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{arguments:?}: {error}:\n{}", ran.out))
}

pub fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().expect("a number")
}

pub fn numbers(value: &serde_json::Value) -> Vec<f64> {
    match value {
        serde_json::Value::Array(list) => list.iter().flat_map(numbers).collect(),
        value => vec![value.as_f64().expect("a number")],
    }
}

/// Masses of the KR-270, to stand below its description.
pub const KR270_MASSES: &str = include_str!("../data/kr270-masses.yaml");

/// The KR-270 with more below its description (`heavy.yaml`, its URDF in the same folder); the file's name.
pub fn heavy_kr270(folder: &Path, extra: &str) -> String {
    let root = env!("CARGO_MANIFEST_DIR");
    std::fs::copy(format!("{root}/robots/kuka-kr270.urdf"), folder.join("kuka-kr270.urdf")).expect("copied");
    let text = std::fs::read_to_string(format!("{root}/robots/kuka-kr270.yaml")).expect("a file");
    let path = folder.join("heavy.yaml");
    std::fs::write(&path, text + extra).expect("written");
    path.display().to_string()
}

/// Pose of the tool of the nominal robot, rigid, in its base frame.
pub fn nominal_pose(model: &Model, q: &[f64]) -> Transform {
    let geometry = Geometry::nominal(model).expect("assembled");
    let mut placements = Placements::default();
    geometry.place(q, &mut placements).expect("placed");
    placements.frames[model.tool.0] * geometry.tool()
}

/// Points at given configurations, wanted where the nominal robot is.
pub fn nominal_path(model: &Model, configurations: &[Vec<f64>]) -> (Campaign, Vec<Result<Desired, Refusal>>) {
    let plan = Plan {
        conditions: false,
        wrenches: Vec::new(),
        configurations: configurations.to_vec(),
        markers: vec![None],
        repeats: 1,
        observes: POSE,
        sigma: 0.0,
        sigma_orientation: 0.0,
        estimate: [false, false],
    };
    let mut bare = model.clone();
    bare.effects.clear();
    let campaign = simulate(&bare, &model.registry.nominal(), &plan, &mut generator(1)).expect("simulated");
    let desired = configurations.iter().map(|q| Ok(Desired { nominal: q.clone(), target: nominal_pose(model, q) }));
    (campaign, desired.collect())
}

/// Derivatives of the predictions by `slots` are those of central differences, to 1e-7.
pub fn assert_derivatives_agree(model: &Model, campaign: &Campaign, values: &[f64], slots: &[usize]) {
    let predictor = Predictor::new(model, campaign, slots.to_vec()).expect("a predictor");
    let (mut at, mut up, mut down) = (Linearised::default(), Linearised::default(), Linearised::default());
    predictor.linearise(values, true, &mut at).expect("linearised");
    for (column, &slot) in slots.iter().enumerate() {
        for (step, out) in [(1e-6, &mut up), (-1e-6, &mut down)] {
            let mut moved = values.to_vec();
            moved[slot] += step;
            predictor.linearise(&moved, false, out).expect("predicted");
        }
        for row in 0..predictor.rows() {
            let difference = -(up.residual[row] - down.residual[row]) / 2e-6;
            let ours = at.jacobian[row * slots.len() + column];
            assert!((ours - difference).abs() < 1e-7, "{} row {row}: {ours} {difference}", model.registry[slot].name);
        }
    }
}
