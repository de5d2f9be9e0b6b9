//! What several tests need.

use elastogeo::description::{raw::RawRobot, resolve::resolve};
use elastogeo::model::{Model, build};

pub fn model_of(yaml: &str) -> Model {
    let raw: RawRobot = serde_yaml::from_str(yaml).expect("readable");
    let (robot, remarks) = resolve(&raw, &|_| None);
    build(&robot.unwrap_or_else(|| panic!("{remarks:#?}"))).expect("a model")
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

pub fn numbers(value: &serde_json::Value) -> Vec<f64> {
    match value {
        serde_json::Value::Array(list) => list.iter().flat_map(numbers).collect(),
        value => vec![value.as_f64().expect("a number")],
    }
}
